# SPDX-License-Identifier: Apache-2.0
"""The plot of ``bluenoise spectrum``; needs Matplotlib."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt

from ._files import needed
from ._measure import power_spectrum, radial_power


def plot_spectrum(mask: npt.ArrayLike, path: Path) -> None:
    """Writes a plot of the power spectrum, frequency 0 in the middle, and of its radial average."""
    Figure = needed("matplotlib.figure", "plots need Matplotlib", "plot").Figure
    power = np.fft.fftshift(power_spectrum(mask))
    frequency, radial = radial_power(mask)
    figure = Figure(figsize=(9, 4), dpi=150, layout="constrained")
    plane, curve = figure.subplots(1, 2)
    # The power of a single mask is exponentially distributed; three times the mean covers nearly all of it.
    top = 3 * max(float(radial.max()), 1.0)
    height, width = power.shape
    edges = (-0.5 - 0.5 / width, 0.5 - 0.5 / width, 0.5 - 0.5 / height, -0.5 - 0.5 / height)
    shown = plane.imshow(power, cmap="gray", vmin=0, vmax=top, extent=edges, interpolation="nearest")
    plane.set(title="power spectrum", xlabel="cycles per texel", ylabel="cycles per texel")
    figure.colorbar(shown, ax=plane, shrink=0.8)
    curve.plot(frequency, radial, color="tab:blue", label="radial average")
    curve.axhline(1, color="0.6", linewidth=1, linestyle="--", label="white noise")
    curve.axvline(0.5, color="0.8", linewidth=1)
    curve.set(title="radial average", xlabel="cycles per texel", ylabel="power", xlim=(0, 0.71))
    curve.set_ylim(bottom=0)
    curve.legend(loc="upper left", frameon=False)
    figure.savefig(path)
