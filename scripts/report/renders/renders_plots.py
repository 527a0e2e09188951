# SPDX-License-Identifier: Apache-2.0
"""The plots and the contact sheet of `scripts/bench renders`."""

import numpy as np

from ..base.contact_sheet import grey, preview, sheet
from ..base.files import write_image
from ..base.palette import style
from ..base.plots import finish, plt, save
from ..measure.gains import BEST_PEER, HEADLINE_MEASURES
from ..measure.image_error import blurred, error_image, luminance_error, measure_name
from .views import EXPOSURES

PICTURE_COUNT = 4


def draw_all(report, folder, large):
    """Writes the plots to `folder` and the contact sheet to `large`."""
    plot_gains(report.gains, report.counts, folder / "renders_gain.png")
    plot_views(report, folder / "renders_views.png")
    # 256 colours suffice for a contact sheet, at a third of the size.
    write_image(large / "renders_pictures.png", picture_sheet(report).quantize(256, dither=0))


def plot_gains(gains, counts, path):
    """Error reduction of every sampler over white noise, as displayed and raw, with the interval of blue."""
    figure, axes = plt.subplots(1, len(HEADLINE_MEASURES), figsize=(12, 4.4), sharey=True)
    for axis, measure in zip(axes, HEADLINE_MEASURES):
        for label in gains.labels:
            found = {spp: gains.gain(label, spp, measure, "white") for spp in counts}
            found = {spp: gain for spp, gain in found.items() if gain}
            if found:
                own = style(label, gains.labels)
                axis.plot(list(found), [gain.value for gain in found.values()], **own)
                if label == "blue":
                    axis.fill_between(list(found), [gain.low for gain in found.values()],
                                      [gain.high for gain in found.values()], color=own["color"], alpha=.15, linewidth=0)
        finish(axis, measure_name(measure), "samples per pixel")
    axes[0].set_ylabel("error reduction over white (times)")
    axes[0].legend(fontsize="small")
    save(figure, path)


def plot_views(report, path):
    """Error reduction of blue over the other samplers in every view, as displayed."""
    measure, thans = "displayed_2.1", report.gains.thans()
    figure, axes = plt.subplots(len(thans), len(report.scenes), figsize=(2.3 * len(report.scenes) + 1, 2.4 * len(thans)),
                                sharex=True, sharey="row", squeeze=False)
    for row, than in zip(axes, thans):
        for axis, scene in zip(row, report.scenes):
            curves = {}
            for spp in report.counts:
                for view, value in report.spread(scene, "blue", spp, measure, than).items():
                    curves.setdefault(view, {})[spp] = value
            for curve in curves.values():
                axis.plot(list(curve), list(curve.values()), marker="o", markersize=2.5, linewidth=.8,
                          color="#0050b0")
            axis.axhline(1, color="0.3", linewidth=.8)
        row[0].set_ylabel(f"{'OpenQMC' if than == BEST_PEER else than} / blue")
    for axis, scene in zip(axes[0], report.scenes):
        axis.set_title(scene)
    for axis in axes.flat:
        finish(axis, axis.get_title(), "")
    for axis in axes[-1]:
        axis.set_xlabel("samples per pixel")
    figure.suptitle(f"{measure_name(measure)}: one line per crop", fontsize=10)
    save(figure, path)


def shown(image):
    return image.resize((2 * image.width, 2 * image.height), 0)


def picture_sheet(report):
    """Each scene with white, sobol and blue: the picture, and its error after a blur."""
    spp = PICTURE_COUNT if PICTURE_COUNT in report.counts else report.counts[0]
    labels = [label for label in ("white", "sobol", "blue") if label in report.labels]
    rows = []
    for scene in report.scenes:
        view = report.first_view(scene)
        reference = report.references[view].picture
        errors = {label: blurred(luminance_error(report.cells.pictures[view, label, spp], reference), 1.0)
                  for label in labels}
        scale = max(float(np.quantile(np.abs(errors["white"]), 0.95)), 1e-12)
        rows.append([[shown(preview(report.cells.pictures[view, label, spp], EXPOSURES.get(scene, 0.0))),
                      shown(grey(error_image(errors[label], scale)))] for label in labels])
    return sheet(rows, report.scenes, labels, f"{spp} samples per pixel, and the error after sigma 1.0 (grey is zero)")
