# SPDX-License-Identifier: Apache-2.0
"""A colour and a marker for each sampler, so that plots also work without colour, and plain numbers on logarithmic
axes."""

# Okabe and Ito's palette, which is safe for colour-blind readers.
STYLES = {
    "white": ("#767676", "o"),
    "pcg": ("#a0a0a0", "d"),
    "sobol": ("#d55e00", "s"),
    "sobol4d": ("#a03000", "P"),
    "sobol-global": ("#e08214", "D"),
    "zorder": ("#009e73", "^"),
    "mask": ("#cc79a7", "v"),
    "blue": ("#0050b0", "o"),
    "openqmc-pmjbn": ("#e69f00", "X"),
    "openqmc-sobolbn": ("#8c564b", "*"),
    "openqmc-latticebn": ("#17becf", "h"),
}
MORE = (("#9467bd", "p"), ("#bcbd22", "<"), ("#d62728", ">"), ("#2ca02c", "d"), ("#000000", "x"))


def style(name, names):
    """Keyword arguments for a Matplotlib line of one of `names`."""
    others = [other for other in names if other not in STYLES]
    colour, marker = STYLES.get(name) or MORE[others.index(name) % len(MORE)]
    return {"color": colour, "marker": marker, "markersize": 4, "label": name,
            "linewidth": 2.2 if name == "blue" else 1.3}


def plain_numbers(*axes):
    """Labels at decades and their middles only; the other lines of a logarithmic axis have no room."""
    for axis in axes:
        axis.set_major_formatter(lambda value, _: f"{value:g}")
        axis.set_minor_formatter(lambda value, _: f"{value:g}" if f"{value:e}"[0] == "3" else "")
