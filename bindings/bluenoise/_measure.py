# SPDX-License-Identifier: Apache-2.0
"""Quality measures for masks. The C library computes errors and spectra; this module handles rings and thresholds."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Optional, Sequence, Union

import numpy as np
import numpy.typing as npt

from . import _arguments as arguments
from . import _core

_GREY_LEVELS = (1 / 16, 1 / 8, 1 / 4, 1 / 2, 3 / 4, 7 / 8, 15 / 16)
_SIGMAS = (0.75, 1.0, 1.5, 2.0)
_MIN_RING_TEXELS = 32


@dataclass(frozen=True)
class MaskMeasures:
    """The result of `measure`.

    Attributes
    ----------
    dithering_error : dict of float to float
        Root mean square error of dithering after blurs with standard deviations of 0.75, 1, 1.5 and 2 texels; see
        `dithering_error`.
    anisotropy : float
        In dB: the mean, over rings of at least 32 texels, of 10 log10(variance of the power on the ring / squared mean power).
        It is about 0 for a single mask, whose spectrum is noisy (for sets of masks, see `anisotropy`), and NaN for small masks.
    low_frequency : dict of float to float
        For each grey level, the thresholded mask's mean power below half the principal frequency; it is 1 for white noise. The
        principal frequency is sqrt(g) cycles per texel for a grey level g of up to 1/2, and sqrt(1 - g) above that. NaN
        if the mask has no frequencies below half the principal frequency.
    exact : bool
        Whether all texels have different values, so every rank occurs exactly once. Measures always use ranks; ties are ordered
        by position.
    """

    dithering_error: dict[float, float]
    anisotropy: float
    low_frequency: dict[float, float]
    exact: bool


def ranks_of(name: str, value: npt.ArrayLike) -> tuple[arguments.Ranks, bool]:
    """Returns a copy of a mask's ranks, and True if no two values are tied. The mask has shape (height, width) or (n,) and contains
    ranks or values. Other threads cannot change the copy."""
    given = arguments.array(name, value)
    if given.dtype.kind not in "iuf":
        raise TypeError(f"{name} must hold integers or floats, not {given.dtype} ({arguments.said(value)})")
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


def measure(mask: npt.ArrayLike, *, progress: Optional[arguments.Progress] = None) -> MaskMeasures:
    """Measure the quality of a mask.

    Parameters
    ----------
    mask : array_like
        Ranks, or values of any integer or float type, of shape ``(height, width)`` or ``(n,)``. For multiple channels, use
        ``[measure(channel) for channel in mask]``.
    progress : callable, optional
        See `bluenoise.mask`.

    Returns
    -------
    MaskMeasures
        A frozen dataclass.

    Raises
    ------
    ValueError
        The shape is not supported, or a value is NaN.
    TypeError
        The elements are not numbers.
    MemoryError
        There is not enough memory.

    Notes
    -----
    Computes 136 Fourier transforms of the mask's size, which takes 0.1 s for 128 x 128 texels and several seconds for 1024 x
    1024.
    """
    arguments.callback("progress", progress)
    ranks, exact = ranks_of("mask", mask)
    errors: dict[float, float] = {}
    for sigma in _SIGMAS:
        errors[sigma] = _core.mask_error(ranks, sigma)
        arguments.report(progress, 0.24 * len(errors))
    levels = {level: _low_frequency(ranks, level) for level in _GREY_LEVELS}
    found = MaskMeasures(errors, _anisotropy([ranks]), levels, exact)
    arguments.report(progress, 1.0)
    return found


def dithering_error(mask: npt.ArrayLike, sigma: float = 1.0) -> float:
    """Compute the error of dithering with a mask, as seen through a blur.

    The mask is thresholded at 64 grey levels and blurred with a toroidal Gaussian; the error is the root mean square difference
    from the grey level.

    Parameters
    ----------
    mask : array_like
        See `measure`.
    sigma : float, default 1
        Standard deviation of the blur in texels, from 0 to 1000.

    Returns
    -------
    float
        Smaller is better. White noise has errors of 0.152, 0.115, 0.076 and 0.057 after blurs of 0.75, 1, 1.5 and 2 texels,
        respectively.
    """
    return _core.mask_error(ranks_of("mask", mask)[0], arguments.real("sigma", sigma, 0, 1000))


def anisotropy(masks: Union[npt.ArrayLike, Sequence[npt.ArrayLike]]) -> float:
    """Compute the anisotropy of the mean power spectrum of a set of masks.

    Parameters
    ----------
    masks : sequence of array_like
        Masks of the same shape, or an array ``(k, height, width)``.

    Returns
    -------
    float
        In dB: the mean, over rings of at least 32 texels, of 10 log10(variance of the power on the ring / squared mean power).
        Rings are one frequency step wide. NaN if no ring is large enough. An isotropic generator gives about -10 log10 k, for
        example -12 dB for 16 masks.

    References
    ----------
    Robert Ulichney, "Dithering with blue noise", 1988.
    """
    if isinstance(masks, (np.ndarray, memoryview)):
        masks = np.asarray(masks)
        if masks.ndim != 3:
            raise ValueError(f"masks must have shape (k, height, width), not {masks.shape}; for one mask, give [mask]")
    try:
        each = iter(masks)  # type: ignore[arg-type]
    except TypeError:
        raise TypeError(f"masks must be a sequence of masks, not {arguments.said(masks)}") from None
    return _anisotropy(each)


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
    """Compute the power spectrum of a mask's ranks.

    Parameters
    ----------
    mask : array_like
        Ranks or values of shape ``(height, width)`` or ``(n,)``, or ``(k, height, width)`` for channels or slices, each of which
        gets its own spectrum.

    Returns
    -------
    ndarray of float32
        The power, as an array of the mask's shape, or ``(1, n)`` for a row. White noise has a mean power of 1. Frequencies are
        ordered as in `numpy.fft.fftfreq`; the power at frequency 0 is 0.
    """
    given = arguments.array("mask", mask)
    if given.ndim == 3 and given.size:
        return np.stack([_core.power_spectrum(ranks_of("mask", channel)[0]) for channel in given])
    return _core.power_spectrum(ranks_of("mask", given)[0])


def radial_power(mask: npt.ArrayLike) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Compute the radially averaged power spectrum of a mask.

    Parameters
    ----------
    mask : array_like
        See `power_spectrum`.

    Returns
    -------
    frequency : ndarray of float64
        Centres of the rings in cycles per texel, from one ring width to at most sqrt(1/2). Each ring is 1 / max(height, width)
        wide. Frequency 0 and empty rings are omitted.
    power : ndarray of float64
        The mean power on each ring. If there are multiple channels or slices, each has its own row.
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
    """The frequency of each element of a spectrum with shape (height, width), in cycles per texel."""
    f_y, f_x = np.fft.fftfreq(shape[0]), np.fft.fftfreq(shape[1])
    frequency: npt.NDArray[np.float64] = np.hypot(f_y[:, None], f_x[None, :])
    return frequency


def _rings(shape: tuple[int, ...]) -> tuple[npt.NDArray[np.intp], float]:
    """The ring of each element, flattened, and the width of a ring in cycles per texel; frequency 0 is ring 0."""
    width = 1 / max(shape)
    ring = np.floor(frequencies(shape).reshape(-1) / width + 0.5).astype(np.intp)
    return ring, width


def _power(ranks: npt.NDArray[Any]) -> npt.NDArray[np.float64]:
    """The power spectrum without frequency 0, divided by the variance, which makes it 1 for white noise."""
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
