# SPDX-License-Identifier: Apache-2.0
"""Measures of masks. The C library computes errors and spectra; rings and thresholds are handled here."""

from __future__ import annotations

import math
import reprlib
from typing import Any, Callable, Optional, Sequence, TypedDict, TypeVar, Union

import numpy as np
import numpy.typing as npt

from . import _arguments as arguments
from . import _core
from ._interrupt import interruptible

_T = TypeVar("_T")

_SIGMAS = (0.75, 1.0, 1.5, 2.0)
_GREY_LEVELS = (1 / 16, 1 / 8, 1 / 4, 1 / 2, 3 / 4, 7 / 8, 15 / 16)
_MIN_RING_TEXELS = 32
_QUICK_TEXELS = 2**15  # smaller masks take a fraction of a second

MaskMeasures = TypedDict(
    "MaskMeasures",
    {
        "e_0.75": float,
        "e_1": float,
        "e_1.5": float,
        "e_2": float,
        "anisotropy": float,
        "low_frequency": dict[float, float],
        "exact": bool,
    },
)
MaskMeasures.__doc__ = "The result of ``measure``, which describes the keys."


def ranks_of(name: str, value: npt.ArrayLike) -> tuple[arguments.Ranks, bool]:
    """The ranks of a two-dimensional mask given as ranks or values, and whether there are no ties."""
    array = np.asarray(value)
    if array.dtype.kind not in "iuf":
        raise TypeError(f"{name} must hold integers or floats, not {array.dtype} ({reprlib.repr(value)})")
    if array.ndim != 2 or array.size == 0:
        raise ValueError(f"{name} must have shape (height, width), not {array.shape}")
    flat = array.reshape(-1)
    if array.dtype.kind != "f" and arguments.is_permutation(flat):
        return np.ascontiguousarray(array, np.uint32), True
    if array.dtype.kind == "f" and np.isnan(flat).any():
        raise ValueError(f"{name} must not contain NaN, but element {int(np.isnan(flat).argmax())} is NaN")
    order = np.argsort(flat, kind="stable")
    ordered = flat[order]
    exact = bool((ordered[1:] != ordered[:-1]).all())
    ranks = np.empty(flat.size, np.uint32)
    ranks[order] = np.arange(flat.size, dtype=np.uint32)
    return ranks.reshape(array.shape), exact


def measure(mask: npt.ArrayLike) -> MaskMeasures:
    """Measures a mask of shape (height, width), given as ranks or as values of any integer or float type.

    Returns a dict with these keys:

    - ``e_0.75``, ``e_1``, ``e_1.5``, ``e_2``: the dithering error E_sigma; lower is better. The mask is thresholded at 64
      grey levels and blurred with a toroidal Gaussian of sigma texels; the error is the root mean square difference from
      the level. White noise has .152, .115, .076 and .057.
    - ``anisotropy``: in dB, 10 log10 of the variance over the squared mean of the power on a ring, averaged over rings of
      at least 32 texels. About 0 for a single mask, whose spectrum is noisy; see ``anisotropy`` for several. NaN for small
      masks.
    - ``low_frequency``: maps each grey level to the mean power of the thresholded mask below half the principal frequency;
      white noise has 1. The principal frequency is sqrt(g) cycles per texel for a grey level g up to 1/2 and sqrt(1 - g)
      above. NaN if the mask has no such frequency.
    - ``exact``: True if all texels have different values, so that every rank occurs exactly once. The measures always use
      ranks, with ties ordered by position.

    Raises ``ValueError`` (shape, NaN), ``TypeError`` and ``MemoryError``. Ctrl-C interrupts. Cost: 136 transforms of the
    mask's size, 0.1 s for 128 x 128.
    """
    return _run(mask, _measure, mask)


def _measure(mask: npt.ArrayLike) -> MaskMeasures:
    ranks, exact = ranks_of("mask", mask)
    e_075, e_1, e_15, e_2 = (_core.mask_error(ranks, sigma) for sigma in _SIGMAS)
    return {
        "e_0.75": e_075,
        "e_1": e_1,
        "e_1.5": e_15,
        "e_2": e_2,
        "anisotropy": _anisotropy([ranks]),
        "low_frequency": {level: _low_frequency(ranks, level) for level in _GREY_LEVELS},
        "exact": exact,
    }


def _run(values: Any, work: Callable[..., _T], *given: Any) -> _T:
    """Returns work(*given). Ctrl-C can interrupt it, unless there are only a few values."""
    if getattr(values, "size", _QUICK_TEXELS) < _QUICK_TEXELS:
        return work(*given)
    return interruptible(work, *given)


def anisotropy(masks: Union[npt.ArrayLike, Sequence[npt.ArrayLike]]) -> float:
    """The anisotropy, in dB, of the mean power spectrum of masks of equal shape: a sequence, or an array (k, height, width).

    This is 10 log10 of the variance over the squared mean of the power on rings one frequency step wide, averaged over
    rings of at least 32 texels; NaN if there are none. An isotropic method gives about -10 log10 k for k masks, so -12 dB
    for 16 (Ulichney, "Dithering with blue noise", 1988). Ctrl-C interrupts.
    """
    return _run(None, _anisotropy, masks)


def _anisotropy(masks: Any) -> float:
    total: Any = 0.0
    shape: Optional[tuple[int, ...]] = None
    for mask in masks:
        power = _core.power_spectrum(ranks_of("masks", mask)[0])
        if shape is not None and power.shape != shape:
            raise ValueError(f"masks must have equal shapes, not {shape} and {power.shape}")
        shape = power.shape
        total = total + power.astype(np.float64)
    if shape is None:
        raise ValueError("masks must contain at least one mask, not 0")
    ring, _ = _rings(shape)
    texels = np.bincount(ring)
    usable = texels >= _MIN_RING_TEXELS
    usable[0] = False
    texels = texels[usable]
    mean = np.bincount(ring, total.reshape(-1))[usable] / texels
    square = np.bincount(ring, total.reshape(-1) ** 2)[usable] / texels
    variance = (square - mean**2) * texels / (texels - 1)
    uneven = (mean > 0) & (variance > 0)
    return float(np.mean(10 * np.log10(variance[uneven] / mean[uneven] ** 2))) if uneven.any() else math.nan


def power_spectrum(mask: npt.ArrayLike) -> npt.NDArray[np.float32]:
    """The power spectrum of a mask of shape (height, width): float32 of the same shape; white noise has mean 1.

    Frequencies are in the order of ``numpy.fft.fftfreq``; the power of frequency 0, at [0, 0], is 0. The mask may be
    given as ranks or as values of any integer or float type; the spectrum is that of the ranks. Raises the same
    exceptions as ``measure``. Ctrl-C interrupts.
    """
    return _run(mask, _power_spectrum, mask)


def _power_spectrum(mask: npt.ArrayLike) -> npt.NDArray[np.float32]:
    return _core.power_spectrum(ranks_of("mask", mask)[0])


def radial_power(mask: npt.ArrayLike) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """The radially averaged power spectrum: (frequency, power), two float64 arrays of equal length.

    Rings are 1 / max(height, width) cycles per texel wide; the frequencies are their centres, from one width to at most
    sqrt(1/2). Frequency 0 and empty rings are omitted. Raises the same exceptions as ``measure``. Ctrl-C interrupts.
    """
    power = power_spectrum(mask)
    ring, width = _rings(power.shape)
    texels = np.bincount(ring)
    texels[0] = 0
    present = np.flatnonzero(texels)
    total = np.bincount(ring, power.reshape(-1).astype(np.float64))
    return present.astype(np.float64) * width, total[present] / texels[present]


def frequencies(shape: tuple[int, ...]) -> npt.NDArray[np.float64]:
    """The frequency of each element of a spectrum of shape (height, width), in cycles per texel."""
    f_y, f_x = np.fft.fftfreq(shape[0]), np.fft.fftfreq(shape[1])
    frequency: npt.NDArray[np.float64] = np.hypot(f_y[:, None], f_x[None, :])
    return frequency


def _rings(shape: tuple[int, ...]) -> tuple[npt.NDArray[np.intp], float]:
    """The ring of each element, flattened, and the width of a ring in cycles per texel; frequency 0 is ring 0."""
    width = 1 / max(shape)
    ring = np.floor(frequencies(shape).reshape(-1) / width + 0.5).astype(np.intp)
    return ring, width


def _power(ranks: npt.NDArray[Any]) -> npt.NDArray[np.float64]:
    """The power spectrum divided by the variance, so that white noise has 1, without frequency 0."""
    values = ranks.astype(np.float64)
    values -= values.mean()
    power: npt.NDArray[np.float64] = np.abs(np.fft.fft2(values)) ** 2
    total = float((values**2).sum())
    return power / total if total > 0 else power


def _low_frequency(ranks: arguments.Ranks, level: float) -> float:
    pattern = ranks < level * ranks.size
    frequency = frequencies(ranks.shape)
    low = (frequency > 0) & (frequency < math.sqrt(min(level, 1 - level)) / 2)
    if not low.any() or pattern.all() or not pattern.any():
        return math.nan
    return float(_power(pattern)[low].mean())
