# SPDX-License-Identifier: Apache-2.0
"""Plots of error and of its spectrum, one small figure each: a page puts as many side by side as its window takes."""

import numpy as np

from .image_error import radial_spectrum
from .palette import plain_numbers, style

SIZE = (4.7, 3.4)  # inches of a figure, of which a page makes what fits


def _figure():
    import matplotlib

    matplotlib.use("svg")
    matplotlib.rcParams.update({"axes.spines.top": False, "axes.spines.right": False, "axes.titlelocation": "left",
                                "axes.titlesize": "medium", "axes.titleweight": "bold", "legend.frameon": False,
                                "svg.hashsalt": "libbn"})
    from matplotlib import pyplot

    return pyplot.subplots(figsize=SIZE)


def _finish(figure, axis, title, label, ylabel=""):
    from matplotlib import pyplot

    axis.set(title=title, xlabel=label, ylabel=ylabel)
    axis.grid(True, which="both", alpha=.22)
    axis.legend(fontsize="small")
    figure.tight_layout()
    # Off pyplot's list: the figure lives as long as somebody holds it.
    pyplot.close(figure)
    return figure


def error_curve(rows, samplers, key, measure, title, band=True):
    """Error against "spp" or "seconds". rows: dicts with sampler, key, measure and, for the band from the least to the
    largest over seeds, "each": {measure: [errors]}."""
    figure, axis = _figure()
    for sampler in samplers:
        own = sorted((row for row in rows if row["sampler"] == sampler), key=lambda row: row[key])
        look = style(sampler, samplers)
        axis.loglog([row[key] for row in own], [row[measure] for row in own], **look)
        each = [row.get("each", {}).get(measure, ()) for row in own]
        if band and all(len(errors) > 1 for errors in each):
            axis.fill_between([row[key] for row in own], [min(e) for e in each], [max(e) for e in each],
                              color=look["color"], alpha=.14, linewidth=0)
    if key == "spp":
        axis.set_xscale("log", base=2)
    plain_numbers(axis.xaxis, axis.yaxis)
    return _finish(figure, axis, title, {"spp": "samples per pixel", "seconds": "seconds of rendering"}[key])


def gain_curve(rows, samplers, measure, title):
    """Times less error than the first sampler, against samples: the differences that error_curve squeezes together."""
    figure, axis = _figure()
    beaten = {row["spp"]: row[measure] for row in rows if row["sampler"] == samplers[0]}
    for sampler in samplers:
        own = sorted((row for row in rows if row["sampler"] == sampler and row["spp"] in beaten), key=lambda row: row["spp"])
        axis.loglog([row["spp"] for row in own], [beaten[row["spp"]] / row[measure] for row in own],
                    **style(sampler, samplers))
    axis.set_xscale("log", base=2)
    plain_numbers(axis.xaxis, axis.yaxis)
    low, high = axis.get_ylim()
    ticks = [tick for tick in (.25, .5, .7, .8, .9, 1, 1.2, 1.5, 2, 3, 4, 6, 8, 12, 16) if low <= tick <= high]
    axis.set_yticks(ticks)
    return _finish(figure, axis, title, "samples per pixel", f"times less than {samplers[0]}")


def spectrum_curve(errors, samplers, title):
    """Radial power spectra of signed errors {sampler: array}, the mean of the first sampler's = 1."""
    figure, axis = _figure()
    level = max(float(np.mean(radial_spectrum(errors[samplers[0]])[1])), 1e-30)
    for sampler in samplers:
        frequency, power = radial_spectrum(errors[sampler])
        axis.semilogy(frequency, np.maximum(power, 1e-30) / level, **{**style(sampler, samplers), "marker": None})
    plain_numbers(axis.yaxis)
    return _finish(figure, axis, title, "cycles per pixel", f"power, mean of {samplers[0]} = 1")
