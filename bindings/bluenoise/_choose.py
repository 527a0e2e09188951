# SPDX-License-Identifier: Apache-2.0
"""Discrete choices with random numbers, whose remainders can be reused: bn_choose.h on arrays."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from . import _arguments as arguments
from . import _core

_STEPS = 2**24
_Floats = npt.NDArray[np.float32]


def _bad(name: str, interval: str, values: npt.NDArray[np.float64], bad: npt.NDArray[np.bool_]) -> None:
    if bad.any():
        raise ValueError(f"{name} must be in {interval}, not {values[bad].flat[0]}")


def _numbers(u: npt.ArrayLike) -> _Floats:
    values = arguments.reals("u", u)
    _bad("u", "[0, 1)", values, ~((values >= 0) & (values < 1)))
    return np.asarray(np.floor(values * _STEPS) / _STEPS, np.float32)


def _parts(packed: object) -> tuple[npt.NDArray[np.uint32], _Floats]:
    """Splits packed words into choices (upper half) and remainders (lower half)."""
    words = np.asarray(packed, np.uint64)
    return (words >> np.uint64(32)).astype(np.uint32), np.asarray(words & np.uint64(0xFFFFFFFF)).astype(np.uint32).view(np.float32)


def choose(probability: npt.ArrayLike, u: npt.ArrayLike) -> tuple[npt.NDArray[np.bool_], _Floats]:
    """Choose with a given probability and return the rescaled remainder of `u`.

    Parameters
    ----------
    probability : array_like of float
        In [0, 1]. Broadcasts with `u`.
    u : array_like of float
        Numbers in [0, 1). `Sampler` draws multiples of 2**-24; finer digits are discarded.

    Returns
    -------
    chosen : ndarray of bool
        ``u < probability``, where the probability is rounded to float32, then up to a multiple of 2**-24.
    rest : ndarray of float32
        The remainder of `u`, rescaled to [0, 1). Use it for the next decision.

    Raises
    ------
    ValueError
        A number is out of range, or shapes do not broadcast.
    TypeError
        An argument is not numeric.

    Notes
    -----
    The results are bit-identical to those of ``bn_choose.h``.

    Examples
    --------
    >>> chosen, rest = choose(0.25, [0.125, 0.625])
    >>> chosen.tolist(), rest.round(3).tolist()
    ([True, False], [0.5, 0.5])
    """
    values = arguments.reals("probability", probability)
    _bad("probability", "[0, 1]", values, ~((values >= 0) & (values <= 1)))
    numbers = _numbers(u)
    arguments.together("probability and u", values.shape, numbers.shape)
    chosen, rest = _parts(_core.choose(values.astype(np.float32), numbers))
    return chosen.astype(bool), rest


def choose_u32(count: npt.ArrayLike, u: npt.ArrayLike) -> tuple[npt.NDArray[np.uint32], _Floats]:
    """Choose one of `count` equally likely items and return the rescaled remainder of `u`.

    Parameters
    ----------
    count : array_like of int
        Number of items, 1 to 2**24. Broadcasts with `u`.
    u : array_like of float
        See `choose`.

    Returns
    -------
    index : ndarray of uint32
        From 0 to ``count - 1``.
    rest : ndarray of float32
        The unused part of `u`; see `choose`.

    Examples
    --------
    >>> index, rest = choose_u32(4, [0.125, 0.8125])
    >>> index.tolist(), rest.round(3).tolist()
    ([0, 3], [0.5, 0.25])
    """
    items = arguments.integers("count", count, np.uint32, 1, _STEPS)
    numbers = _numbers(u)
    arguments.together("count and u", items.shape, numbers.shape)
    return _parts(_core.choose_u32(items, numbers))


def choose_cdf(cdf: npt.ArrayLike, u: npt.ArrayLike) -> tuple[npt.NDArray[np.uint32], _Floats]:
    """Choose an item by cumulative weights and return the rescaled remainder of `u`.

    Parameters
    ----------
    cdf : array_like of float
        Cumulative sums of weights, one-dimensional and ascending. The last sum must be between 1e-30 and 1e30, but need not be 1.
    u : array_like of float
        See `choose`.

    Returns
    -------
    index : ndarray of uint32
        The first item for which ``u * cdf[-1] < cdf[index]``.
    rest : ndarray of float32
        The unused part of `u`; see `choose`.

    Examples
    --------
    >>> index, rest = choose_cdf([0.5, 0.5, 1.0], [0.25, 0.75])
    >>> index.tolist(), rest.round(3).tolist()
    ([0, 2], [0.5, 0.5])
    """
    values = arguments.reals("cdf", cdf)
    if values.ndim != 1 or values.size == 0:
        raise ValueError(f"cdf must have shape (count,) with at least one entry, not {values.shape}")
    _bad("cdf", "[0, 1e30]", values, ~((values >= 0) & (values <= 1e30)))
    if (np.diff(values) < 0).any():
        raise ValueError(f"cdf must be in ascending order, not {arguments.said(cdf)}")
    if values[-1] < 1e-30:
        raise ValueError(f"cdf must end in a sum of 1e-30 or more, not {values[-1]}")
    return _parts(_core.choose_cdf(values.astype(np.float32), _numbers(u)))
