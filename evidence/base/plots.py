# SPDX-License-Identifier: Apache-2.0
"""Plots for evidence/results: plain numbers on the axes, and small PNG files. Each sampler has its own colour and
marker, so plots are readable without colour."""

import io

import matplotlib.pyplot as plt
from PIL import Image

from .files import write_image

TICKS = (.05, .1, .2, .3, .5, .7, .8, .9, 1, 1.1, 1.25, 1.5, 2, 3, 4, 6, 8, 12, 16)

# Okabe and Ito's palette, which is safe for colour-blind readers.
STYLES = {
    "white": ("#767676", "o"),
    "sobol": ("#d55e00", "s"),
    "sobol-global": ("#e08214", "D"),
    "zorder": ("#009e73", "^"),
    "mask": ("#cc79a7", "v"),
    "blue": ("#0050b0", "o"),
    "heitz": ("#9467bd", "P"),
    "openqmc-pmjbn": ("#e69f00", "X"),
    "openqmc-sobolbn": ("#8c564b", "*"),
    "openqmc-latticebn": ("#17becf", "h"),
}
MORE = (("#9467bd", "p"), ("#bcbd22", "<"), ("#d62728", ">"), ("#2ca02c", "d"), ("#000000", "x"))


def style(name, names):
    """Matplotlib keyword arguments for the line of one of `names`."""
    others = [other for other in names if other not in STYLES]
    colour, marker = STYLES.get(name) or MORE[others.index(name) % len(MORE)]
    return {"color": colour, "marker": marker, "markersize": 4, "label": name,
            "linewidth": 2.2 if name == "blue" else 1.3}


def plain_numbers(*axes, minor="3"):
    """Labels only decades and their middles; a logarithmic axis has no room for more labels."""
    for axis in axes:
        axis.set_major_formatter(lambda value, _: f"{value:g}")
        axis.set_minor_formatter(lambda value, _: f"{value:g}" if f"{value:e}"[0] == minor else "")


def finish(axis, title, label):
    axis.set(title=title, xlabel=label, xscale="log", yscale="log")
    axis.set_xscale("log", base=2)
    plain_numbers(axis.xaxis, axis.yaxis, minor="")
    low, high = axis.get_ylim()
    axis.set_yticks([tick for tick in TICKS if low <= tick <= high])
    axis.grid(True, which="major", alpha=.25)


def save(figure, path):
    """Writes a palette PNG, a third of the size of a full-colour one, and closes the figure."""
    if figure.get_layout_engine() is None:
        figure.tight_layout()
    data = io.BytesIO()
    figure.savefig(data, format="png", dpi=80)
    plt.close(figure)
    write_image(path, Image.open(data).convert("RGB").quantize(96, dither=0))
