# SPDX-License-Identifier: Apache-2.0
"""Plots for docs/report: Matplotlib without a display, common axes, and small PNG files."""

import io

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from PIL import Image

from .files import write_image

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


def save(figure, path, colours=96, laid_out=False):
    """Writes a PNG with a palette, a third of the size of one in full colour, and closes the figure."""
    if not laid_out:
        figure.tight_layout()
    data = io.BytesIO()
    figure.savefig(data, format="png", dpi=80)
    plt.close(figure)
    write_image(path, Image.open(data).convert("RGB").quantize(colours, dither=0))
