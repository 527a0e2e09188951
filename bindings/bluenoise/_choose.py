# SPDX-License-Identifier: Apache-2.0
"""Choices by the numbers of a draw, and the unused part of those numbers: bn_choose.h on arrays, bit for bit."""

from __future__ import annotations

import reprlib

import numpy as np
import numpy.typing as npt

from . import _arguments as arguments

_STEPS = 2**24
_Floats = npt.NDArray[np.float32]


def _reals(name: str, value: npt.ArrayLike) -> npt.NDArray[np.float64]:
    array = arguments.array(name, value)
    if array.dtype.kind not in "fiu" and array.size:
        raise TypeError(f"{name} must hold numbers, not {array.dtype} ({reprlib.repr(value)})")
    return array.astype(np.float64)


def _bad(name: str, interval: str, values: npt.NDArray[np.float64], bad: npt.NDArray[np.bool_]) -> None:
    if bad.any():
        raise ValueError(f"{name} must be in {interval}, not {values[bad].flat[0]}")


def _steps(u: npt.ArrayLike) -> npt.NDArray[np.float64]:
    values = _reals("u", u)
    _bad("u", "[0, 1)", values, ~((values >= 0) & (values < 1)))
    return np.floor(values * _STEPS)


def _limits(name: str, value: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """The number of steps below probabilities, which are rounded to float32 first, as in C."""
    values = _reals(name, value)
    _bad(name, "[0, 1]", values, ~((values >= 0) & (values <= 1)))
    return np.ceil(values.astype(np.float32).astype(np.float64) * _STEPS)


def _stretched(place: npt.NDArray[np.float64], width: npt.NDArray[np.float64]) -> _Floats:
    return np.asarray(np.floor((2 * place + 1) * (_STEPS / 2) / width) / _STEPS, np.float32)


def choose(probability: npt.ArrayLike, u: npt.ArrayLike) -> tuple[npt.NDArray[np.bool_], _Floats]:
    """Chooses with a probability, and returns ``(chosen, rest)``.

    ``chosen`` is ``u < probability``. ``rest`` is the unused part of ``u``, rescaled to [0, 1) as float32: use it for
    whatever follows the choice. Both have the shape to which the arguments broadcast. Probabilities are in [0, 1],
    numbers in [0, 1), in multiples of 2**-24 like the draws of a ``Sampler``; finer digits are dropped. ``bn_choose.h``
    has the details; the bits are those of C.

    Examples
    --------
    >>> chosen, rest = choose(0.25, [0.125, 0.625])
    >>> chosen.tolist(), rest.round(3).tolist()
    ([True, False], [0.5, 0.5])
    """
    limit, step = np.broadcast_arrays(_limits("probability", probability), _steps(u))
    chosen = np.asarray(step < limit)
    return chosen, _stretched(np.where(chosen, step, step - limit), np.where(chosen, limit, _STEPS - limit))


def choose_u32(count: npt.ArrayLike, u: npt.ArrayLike) -> tuple[npt.NDArray[np.uint32], _Floats]:
    """Chooses one of ``count`` equally likely items, and returns ``(index, rest)``: uint32 from 0 to count - 1, and the
    unused part of ``u``, as from ``choose``. Counts are 1 to 2**24.

    Examples
    --------
    >>> index, rest = choose_u32(4, [0.125, 0.8125])
    >>> index.tolist(), rest.round(3).tolist()
    ([0, 3], [0.5, 0.25])
    """
    items = arguments.integers("count", count, np.uint32, 1, _STEPS).astype(np.uint64)
    # The middle of the step times count: the whole part chooses, the fraction is the rest.
    middle = (2 * _steps(u).astype(np.uint64) + np.uint64(1)) * items
    rest = (middle & np.uint64(2 * _STEPS - 1)) >> np.uint64(1)
    return np.asarray(middle >> np.uint64(25), np.uint32), np.asarray(rest / _STEPS, np.float32)


def _steps_of(unit: np.float32, limits: npt.NDArray[np.float32]) -> npt.NDArray[np.float64]:
    """The number of steps whose place, in the units of a table, lies below a limit; products are rounded as in C."""
    place = np.minimum(np.ceil(limits.astype(np.float64) / np.float64(unit)), _STEPS)
    for _ in range(4):
        place -= (place > 0) & ~((place - 1).astype(np.float32) * unit < limits)
        place += (place < _STEPS) & (place.astype(np.float32) * unit < limits)
    return place


def choose_cdf(cdf: npt.ArrayLike, u: npt.ArrayLike) -> tuple[npt.NDArray[np.uint32], _Floats]:
    """Chooses by a table of cumulative weights, and returns ``(index, rest)``: the first item for which
    ``u * cdf[-1] < cdf[index]``, as uint32, and the unused part of ``u``, as from ``choose``.

    ``cdf`` is one-dimensional, not empty and ascending, from 0 or more to any sum from 1e-30 to 1e30: probabilities, or
    powers as they are.

    Examples
    --------
    >>> index, rest = choose_cdf([0.5, 0.5, 1.0], [0.25, 0.75])
    >>> index.tolist(), rest.round(3).tolist()
    ([0, 2], [0.5, 0.5])
    """
    values = _reals("cdf", cdf)
    if values.ndim != 1 or values.size == 0:
        raise ValueError(f"cdf must have shape (count,) with at least one entry, not {values.shape}")
    _bad("cdf", "[0, 1e30]", values, ~((values >= 0) & (values <= 1e30)))
    if (np.diff(values) < 0).any():
        raise ValueError(f"cdf must be in ascending order, not {reprlib.repr(cdf)}")
    if values[-1] < 1e-30:
        raise ValueError(f"cdf must end in a sum of 1e-30 or more, not {values[-1]}")
    limits = values.astype(np.float32)
    unit = np.float32(limits[-1] * np.float32(1 / _STEPS)) if limits.size > 1 else np.float32(1 / _STEPS)
    step = _steps(u)
    index = np.asarray(np.searchsorted(limits[:-1], step.astype(np.float32) * unit, side="right"))
    ends = np.concatenate([[0.0], _steps_of(unit, limits[:-1]), [_STEPS]])
    return index.astype(np.uint32), _stretched(step - ends[index], ends[index + 1] - ends[index])
