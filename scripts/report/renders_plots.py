# SPDX-License-Identifier: Apache-2.0
"""The plots, the sheet of pictures and the page of `scripts/bench renders`, from its report."""

import io
import math
import statistics

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from PIL import Image

from . import comparison, page
from .contact_sheet import grey, preview, sheet
from .files import write_image
from .image_error import blurred, error_image, luminance_error, radial_spectrum
from .palette import plain_numbers, style
from .renders_report import AIMS, MEASURE_NAMES

PAGE_COUNTS = (1, 4, 16, 64)
PICTURE_COUNT = 4
# Stops by which the pictures, not the figures, are brighter.
EXPOSURES = {"cornell": 1.0, "interior": 1.0}


def draw_all(report, folder):
    plot_ratios(report, folder / "renders_blurred.png", 2.1)
    plot_ratios(report, folder / "renders_unblurred.png", 0.0)
    plot_spectra(report, folder / "renders_spectra.png")
    if len(report.direct) > 1:
        plot_mean(report, folder / "renders_mean.png")
    if report.times and report.times["runs"]:
        plot_times(report, folder / "renders_time.png")
    # 256 colours are enough for a sheet like this, and a third of the bytes.
    write_image(folder / "renders_pictures.png", picture_sheet(report).quantize(256, dither=0))


def line(report, axis, label, points):
    points = [(spp, value) for spp, value in points if value is not None]
    if points:
        axis.plot(*zip(*points), **style(label, report.labels))


def plot_ratios(report, path, measure):
    rows = (len(report.scenes) + 2) // 3
    figure, axes = plt.subplots(rows, 3, figsize=(12, 3.4 * rows), sharex=True, squeeze=False)
    for axis, scene in zip(axes.flat, report.scenes):
        for label in report.labels:
            found = [(spp, report.ratio(scene, label, spp, measure, "white")) for spp in report.counts]
            line(report, axis, label, [(spp, 1 / r.value if r else None) for spp, r in found])
        finish(axis, scene, "samples per pixel")
    for axis in list(axes.flat)[len(report.scenes):]:
        axis.set_axis_off()
    for axis in axes[:, 0]:
        axis.set_ylabel(f"{MEASURE_NAMES[measure]}, white = 1")
    axes[0, 0].legend(fontsize="small")
    save(figure, path)


def plot_mean(report, path):
    figure, axes = plt.subplots(1, 4, figsize=(15, 4))
    for axis, measure in zip(axes, (0.0, 1.0, 2.1, "flip")):
        for label in report.labels:
            found = [(spp, report.mean_ratio(label, spp, measure, "white")) for spp in report.counts]
            line(report, axis, label, [(spp, r.value if r else None) for spp, r in found])
        if measure == 2.1:
            aims = {spp: aim for spp, aim in AIMS["white"].items() if spp in report.counts}
            axis.plot(list(aims), list(aims.values()), "_", color="black", markersize=14, label="_aim")
            if aims:
                axis.text(max(aims), aims[max(aims)], "aim of blue  ", fontsize="small", verticalalignment="center",
                          horizontalalignment="right")
        finish(axis, MEASURE_NAMES[measure], "samples per pixel")
    axes[0].set_ylabel("times less than white")
    axes[0].legend(fontsize="small")
    save(figure, path)


def plot_times(report, path):
    runs = report.times["runs"]
    figure, axes = plt.subplots(1, len(runs), figsize=(3.75 * len(runs), 3.8), squeeze=False)
    for axis, (scene, samplers) in zip(axes[0], runs.items()):
        for label, rows in samplers.items():
            axis.loglog([row["seconds"] for row in rows], [row["rmse_2.1"] for row in rows], **style(label, report.labels))
        last = samplers["white"][-1]
        axis.axhline(last["rmse_2.1"], color="0.4", linewidth=.8, linestyle=":")
        axis.set(title=scene, xlabel="seconds, one thread")
        axis.grid(True, which="both", alpha=.25)
        plain_numbers(axis.xaxis, axis.yaxis)
    axes[0][0].set_ylabel(MEASURE_NAMES[2.1])
    axes[0][0].legend(fontsize="small")
    save(figure, path)


def plot_spectra(report, path):
    counts = [spp for spp in PAGE_COUNTS if spp in report.counts]
    figure, axes = plt.subplots(len(counts), len(report.scenes), figsize=(2.4 * len(report.scenes) + 1, 2.3 * len(counts)),
                                sharex=True, sharey=True, squeeze=False)
    for axis, scene in zip(axes[0], report.scenes):
        axis.set_title(scene)
    for row, spp in zip(axes, counts):
        for axis, scene in zip(row, report.scenes):
            level = np.mean(report.cells.values[scene, "white", spp]["spectrum"])
            frequency = radial_spectrum(np.eye(*report.options.size[::-1]))[0]
            for label in report.labels:
                cell = report.cells.values.get((scene, label, spp))
                if cell:
                    power = np.mean(cell["spectrum"], axis=0) / level
                    axis.semilogy(frequency, power, **{**style(label, report.labels), "marker": None})
            axis.grid(True, alpha=.25)
        row[0].set_ylabel(f"{spp} spp\npower, white = 1")
    for axis in axes[-1]:
        axis.set_xlabel("cycles per pixel")
    axes[0][0].legend(fontsize=6)
    save(figure, path)


TICKS = (.05, .1, .2, .3, .5, .7, .8, .9, 1, 1.1, 1.25, 1.5, 2, 3, 4, 6, 8, 12, 16)


def finish(axis, title, label):
    axis.set(title=title, xlabel=label, xscale="log", yscale="log")
    axis.set_xscale("log", base=2)
    for which in (axis.xaxis, axis.yaxis):
        which.set_major_formatter(lambda value, _: f"{value:g}")
        which.set_minor_formatter(lambda value, _: "")
    low, high = axis.get_ylim()
    axis.set_yticks([tick for tick in TICKS if low <= tick <= high])
    axis.grid(True, which="major", alpha=.25)


def shown(report, scene, label, spp):
    picture = report.references[scene][1] if label is None else report.cells.pictures[scene, label, spp]
    return preview(picture, EXPOSURES.get(scene, 0.0))


def picture_sheet(report):
    """Each scene with white, sobol and blue: the picture, and what a blur leaves of its error."""
    spp = PICTURE_COUNT if PICTURE_COUNT in report.counts else report.counts[0]
    labels = [label for label in ("white", "sobol", "blue") if label in report.labels]
    rows = []
    for scene in report.scenes:
        reference = report.references[scene][1]
        errors = {label: blurred(luminance_error(report.cells.pictures[scene, label, spp], reference), 1.0)
                  for label in labels}
        scale = max(float(np.quantile(np.abs(errors["white"]), 0.95)), 1e-12)
        rows.append([[enlarged(shown(report, scene, label, spp)),
                      enlarged(grey(error_image(errors[label], scale)))] for label in labels])
    return sheet(rows, report.scenes, labels, f"{spp} samples per pixel, and the error after sigma 1.0 (grey is none)")


def enlarged(image):
    factor = max(1, 160 // max(image.size))
    return image.resize((image.width * factor, image.height * factor), 0)


def html_page(report):
    counts = [spp for spp in PAGE_COUNTS if spp in report.counts]
    scenes = {}
    for scene in report.scenes:
        cells = {spp: {label: (comparison.data_uri(shown(report, scene, label, spp)),
                               math.sqrt(statistics.mean(e * e for e in report.cells.values[scene, label, spp][2.1])))
                       for label in report.labels if (scene, label, spp) in report.cells.pictures} for spp in counts}
        scenes[scene] = {"size": report.options.size, "reference": comparison.data_uri(shown(report, scene, None, None)),
                         "counts": cells}
    size = "x".join(map(str, report.options.size))
    parts = [page.paragraph(f"Built-in scenes of libbn's example path tracer, {size} pixels. Drag the divider, or move it with the arrow keys. A blur stands for distance: what blue noise "
                            "leaves there is what an eye far off still sees."), comparison.widget(scenes)]
    aims = report.aims()
    measured = [page.table(("what", "aim", "measured", ""), aims, [i for i, row in enumerate(aims) if row[3] != "met"]),
                page.paragraph(f"Measured by {report.options.command}; all figures are in renders.md and renders.csv beside "
                               "this page. Bold: missed.")]
    return page.page("Samplers in rendered scenes", [("Two samplers side by side", parts), ("Aims", measured)])


def save(figure, path):
    """As a PNG of few colours: plots have few, and are a third as large so."""
    figure.tight_layout()
    data = io.BytesIO()
    figure.savefig(data, format="png", dpi=80)
    plt.close(figure)
    write_image(path, Image.open(data).convert("RGB").quantize(96, dither=0))
