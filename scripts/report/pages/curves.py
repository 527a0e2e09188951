# SPDX-License-Identifier: Apache-2.0
"""Plots of error and of its spectrum, one small figure each, which a page lays out side by side."""

import numpy as np

from ..base.palette import plain_numbers, style
from ..measure.image_error import radial_spectrum

SIZE = (4.7, 3.4)  # of a figure, in inches; the page scales it
TICKS = (.25, .5, .7, .8, .9, 1, 1.2, 1.5, 2, 3, 4, 6, 8, 12, 16)
LOOK = {"axes.spines.top": False, "axes.spines.right": False, "axes.titlelocation": "left", "axes.titlesize": "medium",
        "axes.titleweight": "bold", "legend.frameon": False}


def _figure():
    import matplotlib
    from matplotlib.figure import Figure

    # Without pyplot, so that other plots of the program keep their backend and style.
    with matplotlib.rc_context(LOOK):
        figure = Figure(figsize=SIZE)
        return figure, figure.subplots()


def _finish(figure, axis, title, label, ylabel=""):
    import matplotlib

    with matplotlib.rc_context(LOOK):
        axis.set_title(title)
        axis.set(xlabel=label, ylabel=ylabel)
        axis.grid(True, which="both", alpha=.22)
        # Many samplers need two columns, or the legend covers the lines.
        many = len(axis.lines) > 5
        axis.legend(fontsize="xx-small" if many else "small", ncols=2 if many else 1)
        figure.tight_layout()
    return figure


def error_curve(rows, samplers, key, measure, title):
    """Error against "spp" or "seconds". rows: dicts with sampler, key, measure and, for a band from the smallest to the
    largest error over seeds, "each": {measure: [errors]}."""
    figure, axis = _figure()
    for sampler in samplers:
        own = sorted((row for row in rows if row["sampler"] == sampler), key=lambda row: row[key])
        look = style(sampler, samplers)
        axis.loglog([row[key] for row in own], [row[measure] for row in own], **look)
        each = [row.get("each", {}).get(measure, ()) for row in own]
        if all(len(errors) > 1 for errors in each):
            axis.fill_between([row[key] for row in own], [min(e) for e in each], [max(e) for e in each],
                              color=look["color"], alpha=.14, linewidth=0)
    if key == "spp":
        axis.set_xscale("log", base=2)
    plain_numbers(axis.xaxis, axis.yaxis)
    return _finish(figure, axis, title, {"spp": "samples per pixel", "seconds": "seconds of rendering"}[key])


def gain_curve(rows, samplers, measure, title):
    """Error reduction over the first sampler, against samples; shows differences that error_curve compresses."""
    figure, axis = _figure()
    beaten = {row["spp"]: row[measure] for row in rows if row["sampler"] == samplers[0]}
    for sampler in samplers:
        own = sorted((row for row in rows if row["sampler"] == sampler and row["spp"] in beaten), key=lambda row: row["spp"])
        axis.loglog([row["spp"] for row in own], [beaten[row["spp"]] / row[measure] for row in own], **style(sampler, samplers))
    axis.set_xscale("log", base=2)
    plain_numbers(axis.xaxis, axis.yaxis)
    low, high = axis.get_ylim()
    axis.set_yticks([tick for tick in TICKS if low <= tick <= high])
    return _finish(figure, axis, title, "samples per pixel", f"error reduction over {samplers[0]} (times)")


def spectrum_curve(errors, samplers, title):
    """Radial power spectra of signed errors {sampler: array}; the first sampler's mean is 1."""
    figure, axis = _figure()
    level = max(float(np.mean(radial_spectrum(errors[samplers[0]])[1])), 1e-30)
    for sampler in samplers:
        frequency, power = radial_spectrum(errors[sampler])
        axis.semilogy(frequency, np.maximum(power, 1e-30) / level, **{**style(sampler, samplers), "marker": None})
    plain_numbers(axis.yaxis)
    return _finish(figure, axis, title, "cycles per pixel", f"power, mean of {samplers[0]} = 1")
