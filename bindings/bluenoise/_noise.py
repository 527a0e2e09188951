# SPDX-License-Identifier: Apache-2.0
"""Visible noise of renders, and a picture of it."""

from __future__ import annotations

from typing import Any, Optional

import numpy as np
import numpy.typing as npt

from . import _arguments as arguments
from . import _core

# The colours of a map at 1/4, 1/2, 1, 2, 4 and 8 steps, and their names.
COLOURS = {0.25: ("black", (0, 0, 16)), 0.5: ("blue", (40, 60, 170)), 1.0: ("green", (40, 150, 90)), 2.0: ("yellow", (240, 210, 50)),
           4.0: ("red", (225, 60, 30)), 8.0: ("white", (255, 255, 255))}


def _image(name: str, value: npt.ArrayLike) -> npt.NDArray[np.float32]:
    given = arguments.array(name, value)
    if given.dtype.kind != "f":
        raise TypeError(f"{name} must hold linear light as floats, not {given.dtype} ({arguments.said(value)})")
    if given.ndim not in (2, 3) or given.size == 0:
        raise ValueError(f"{name} must have shape (height, width) or (height, width, channels), not {given.shape}")
    with np.errstate(over="ignore"):
        return np.ascontiguousarray(given, np.float32)


def visible_noise(
    first: npt.ArrayLike,
    second: npt.ArrayLike,
    *,
    sigma: float = 2.1,
    exposure: float = 1.0,
    first_share: float = 0.5,
    window: int = 33,
    progress: Optional[arguments.Progress] = None,
) -> npt.NDArray[np.float32]:
    """Estimate how much noise a viewer sees in a render, without a reference.

    Parameters
    ----------
    first, second : array_like of float
        The means of two disjoint sets of samples, such as the first and the second half, as linear light of shape ``(height,
        width)`` or ``(height, width, channels)``. Values are clipped to [0, 1] after exposure, as on a display.
    sigma : float, default 2.1
        Standard deviation of the eye's blur in pixels, 0 to 16. The default is a display with 96 pixels per inch seen from
        75 cm; it is proportional to pixels per inch times distance.
    exposure : float, default 1
        Factor from image values to linear light with white at 1, 1e-30 to 1e30.
    first_share : float, default 0.5
        Fraction of all samples that are in `first`, 0.001 to 0.999.
    window : int, default 33
        Side in pixels of the square over which the noise is pooled, centred on each pixel: odd, 1 to 1023. Smaller squares are
        more local and less certain.
    progress : callable, optional
        See `bluenoise.mask`.

    Returns
    -------
    ndarray of float32, shape (height, width)
        The root mean square error of the mean of all samples, in steps of an 8-bit sRGB display, as seen through the blur.
        Below 1, noise is hard to see; at 3, it is obvious. Channels are measured separately, and their squares averaged.

    Raises
    ------
    ValueError
        The shapes differ, a value is NaN, or an option is out of range.
    TypeError
        The images are not floats.

    Notes
    -----
    Samplers with a net in each pixel, such as ``blue`` and ``sobol``, have about 10% lower noise than estimated (up to 40% in
    single scenes), because the errors of their halves partly cancel. Features that no sample has found are missing from the
    estimate. Takes 13 ns per value and core.

    Examples
    --------
    >>> halves = np.random.default_rng(1).uniform(0, 1, (2, 64, 64))  # white noise at one sample per half
    >>> noise = visible_noise(*halves)
    >>> noise.shape, bool(np.percentile(noise, 95) < 1)
    ((64, 64), False)
    """
    a, b = _image("first", first), _image("second", second)
    if a.shape != b.shape:
        raise ValueError(f"first and second must have equal shapes, not {a.shape} and {b.shape}")
    side = arguments.integer("window", window, 1, 1023)
    if side % 2 == 0:
        raise ValueError(f"window must be odd, not {side}")
    options = (arguments.real("sigma", sigma, 0, 16), arguments.real("exposure", exposure, 1e-30, 1e30),
               arguments.real("first_share", first_share, 0.001, 0.999), side, arguments.callback("progress", progress))
    try:
        return _core.visible_noise(np.atleast_3d(a), np.atleast_3d(b), *options)
    except ValueError:
        for name, image in (("first", a), ("second", b)):
            if np.isnan(image).any():
                at = tuple(int(i) for i in np.argwhere(np.isnan(image))[0])
                raise ValueError(f"{name} must not contain NaN, but element {at} is NaN") from None
        raise


def false_colour(noise: npt.NDArray[np.float32]) -> npt.NDArray[np.uint8]:
    """A map of visible noise as an RGB image, from COLOURS by the logarithm of the noise."""
    levels = np.log2(list(COLOURS))
    at = np.log2(np.maximum(noise, 2.0**-9))
    planes: list[Any] = [np.interp(at, levels, [colour[c] for _, colour in COLOURS.values()]) for c in range(3)]
    return np.stack(planes, axis=-1).round().astype(np.uint8)
