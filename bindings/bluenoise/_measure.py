# SPDX-License-Identifier: Apache-2.0
"""Measures of masks. The C library computes errors and spectra; rings and thresholds are handled here."""

from __future__ import annotations

import math
import reprlib
from typing import Any, Literal, Optional, Sequence, TypedDict, Union, get_args, overload

import numpy as np
import numpy.typing as npt

from . import _arguments as arguments
from . import _core

MeasureName = Literal["e_0.75", "e_1", "e_1.5", "e_2", "anisotropy", "low_frequency", "exact"]

_GREY_LEVELS = (1 / 16, 1 / 8, 1 / 4, 1 / 2, 3 / 4, 7 / 8, 15 / 16)
_MIN_RING_TEXELS = 32
# Transforms that each measure takes.
_COST = {name: 32.0 for name in get_args(MeasureName)} | {"anisotropy": 1.0, "low_frequency": 7.0, "exact": 0.0}

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
    """The ranks of a mask of shape (height, width) or (n,), given as ranks or values, and whether there are no ties; a copy,
    which no other thread can change."""
    given = arguments.array(name, value)
    if given.dtype.kind not in "iuf":
        raise TypeError(f"{name} must hold integers or floats, not {given.dtype} ({reprlib.repr(value)})")
    if given.ndim not in (1, 2) or given.size == 0:
        hint = f"; take one {name} at a time, as in {name}[0]" if given.ndim == 3 else ""
        raise ValueError(f"{name} must have shape (height, width) or (n,), not {given.shape}{hint}")
    shape = np.atleast_2d(given).shape
    flat = given.flatten()
    if flat.dtype.kind != "f" and arguments.is_permutation(flat):
        return flat.astype(np.uint32).reshape(shape), True
    if flat.dtype.kind == "f" and np.isnan(flat).any():
        raise ValueError(f"{name} must not contain NaN, but element {int(np.isnan(flat).argmax())} is NaN")
    order = np.argsort(flat, kind="stable")
    ordered = flat[order]
    exact = bool((ordered[1:] != ordered[:-1]).all())
    ranks = np.empty(flat.size, np.uint32)
    ranks[order] = np.arange(flat.size, dtype=np.uint32)
    return ranks.reshape(shape), exact


@overload
def measure(mask: npt.ArrayLike, measures: None = None, *, progress: Optional[arguments.Progress] = None) -> MaskMeasures: ...
@overload
def measure(
    mask: npt.ArrayLike, measures: Sequence[MeasureName], *, progress: Optional[arguments.Progress] = None
) -> dict[str, Any]: ...


def measure(
    mask: npt.ArrayLike,
    measures: Optional[Sequence[MeasureName]] = None,
    *,
    progress: Optional[arguments.Progress] = None,
) -> Any:
    """Measures a mask of shape (height, width), given as ranks or as values of any integer or float type; (n,) is a row. For
    a mask of several channels: ``[measure(channel) for channel in mask]``.

    Returns a dict with these keys, or those named by ``measures``, as in ``measures=["e_1"]``:

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

    ``progress`` is called with the fraction done, at last with 1; if it returns a true value, the work stops with
    ``CancelledError``. Raises ``ValueError`` (shape, NaN, unknown measure), ``TypeError`` and ``MemoryError``. Ctrl-C
    interrupts. Cost: 136 transforms of the mask's size, 32 of them for each error; 0.1 s for 128 x 128, some seconds for
    1024 x 1024.
    """
    arguments.callback("progress", progress)
    names = _names(measures)
    ranks, exact = ranks_of("mask", mask)
    found: dict[str, Any] = {}
    total, done = sum(_COST[name] for name in names) or 1.0, 0.0
    for name in names:
        if name == "exact":
            found[name] = exact
        elif name == "anisotropy":
            found[name] = _anisotropy([ranks])
        elif name == "low_frequency":
            found[name] = {level: _low_frequency(ranks, level) for level in _GREY_LEVELS}
        else:
            found[name] = _core.mask_error(ranks, float(name[2:]))
        done += _COST[name]
        if done < total:
            arguments.report(progress, done / total)
    arguments.report(progress, 1.0)
    return found


def _names(measures: Any) -> Sequence[str]:
    known = get_args(MeasureName)
    if measures is None:
        return known
    if isinstance(measures, str) or not hasattr(measures, "__iter__"):
        raise TypeError(f"measures must be a list of names, not {measures!r}")
    names = list(measures)
    for name in names:
        if name not in known:
            raise ValueError(f"measures must be among {', '.join(known)}, not {name!r}")
    return names


def anisotropy(masks: Union[npt.ArrayLike, Sequence[npt.ArrayLike]]) -> float:
    """The anisotropy, in dB, of the mean power spectrum of masks of equal shape: a sequence, or an array (k, height, width).

    This is 10 log10 of the variance over the squared mean of the power on rings one frequency step wide, averaged over
    rings of at least 32 texels; NaN if there are none. An isotropic method gives about -10 log10 k for k masks, so -12 dB
    for 16 (Ulichney, "Dithering with blue noise", 1988). Ctrl-C interrupts.
    """
    if isinstance(masks, (np.ndarray, memoryview)):
        masks = np.asarray(masks)
        if masks.ndim != 3:
            raise ValueError(f"masks must have shape (k, height, width), not {masks.shape}; for one mask, give [mask]")
    return _anisotropy(masks)


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
    """The power spectrum of a mask of shape (height, width): float32 of the same shape; white noise has mean 1. That of a row,
    (n,), has shape (1, n). Of three dimensions, the first counts channels or slices, each of which gets its own spectrum.

    Frequencies are in the order of ``numpy.fft.fftfreq``; the power of frequency 0, at [0, 0], is 0. The mask may be
    given as ranks or as values of any integer or float type; the spectrum is that of the ranks. Raises the same
    exceptions as ``measure``. Ctrl-C interrupts.
    """
    given = arguments.array("mask", mask)
    if given.ndim == 3 and given.size:
        return np.stack([_core.power_spectrum(ranks_of("mask", channel)[0]) for channel in given])
    return _core.power_spectrum(ranks_of("mask", given)[0])


def radial_power(mask: npt.ArrayLike) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """The radially averaged power spectrum: (frequency, power), two float64 arrays of equal length; for several channels or
    slices, power has a row for each.

    Rings are 1 / max(height, width) cycles per texel wide; the frequencies are their centres, from one width to at most
    sqrt(1/2). Frequency 0 and empty rings are omitted. Raises the same exceptions as ``measure``. Ctrl-C interrupts.
    """
    power = power_spectrum(mask)
    ring, width = _rings(power.shape[-2:])
    texels = np.bincount(ring)
    texels[0] = 0
    present = np.flatnonzero(texels)
    channels = power.reshape(-1, ring.size).astype(np.float64)
    means = np.stack([np.bincount(ring, channel)[present] / texels[present] for channel in channels])
    return present.astype(np.float64) * width, means[0] if power.ndim == 2 else means


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
