# SPDX-License-Identifier: Apache-2.0
"""Argument checks: every error message contains the argument's name and value; nothing is truncated or wrapped."""

from __future__ import annotations

import math
import operator
import reprlib
import secrets
from typing import Any, Callable, Literal, NoReturn, Optional, Sequence, SupportsIndex, Union

import numpy as np
import numpy.typing as npt

MaskMethod = Literal["auto", "void-and-cluster", "relax", "anneal", "neural", "white", "builtin"]
NeuralProvider = Literal["cpu", "cuda"]
PointsMethod = Literal["best-candidate", "poisson-disk", "mask"]
SamplerKind = Literal["blue", "sobol", "white", "zorder", "mask"]
Seed = Union[SupportsIndex, np.random.Generator, None]
Shape = Union[SupportsIndex, Sequence[SupportsIndex]]
Progress = Callable[[float], Any]
Ranks = npt.NDArray[np.uint32]

INT32 = (-(2**31), 2**31 - 1)
UINT32 = (0, 2**32 - 1)
UINT64 = (0, 2**64 - 1)


def _out_of_range(name: str, value: object, low: float, high: float) -> NoReturn:
    raise ValueError(f"{name} must be in {low} .. {high}, not {value}")


def integer(name: str, value: object, low: int, high: int) -> int:
    """An integer of any type, except bool, in low .. high."""
    if isinstance(value, (bool, np.bool_)):
        raise TypeError(f"{name} must be an integer, not {value!r}")
    try:
        number = operator.index(value)  # type: ignore[arg-type]
    except TypeError:
        raise TypeError(f"{name} must be an integer, not {reprlib.repr(value)}") from None
    if not low <= number <= high:
        _out_of_range(name, number, low, high)
    return number


def real(name: str, value: object, low: float, high: float, low_included: bool = True) -> float:
    """A finite real number in [low, high] or (low, high]."""
    if isinstance(value, (bool, np.bool_, str, bytes)):
        raise TypeError(f"{name} must be a number, not {value!r}")
    try:
        number = float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        raise TypeError(f"{name} must be a number, not {reprlib.repr(value)}") from None
    if not (math.isfinite(number) and low <= number <= high and (low_included or number != low)):
        bracket = "[" if low_included else "("
        raise ValueError(f"{name} must be in {bracket}{low}, {high}], not {number}")
    return number


def seed(value: object) -> int:
    """A seed as an integer: one draw from a Generator, fresh entropy for None."""
    if value is None:
        return secrets.randbits(64)
    if isinstance(value, np.random.Generator):
        return int(value.integers(UINT64[1], dtype=np.uint64, endpoint=True))
    return integer("seed", value, *UINT64)


def callback(name: str, value: Optional[Progress]) -> Optional[Progress]:
    if value is not None and not callable(value):
        raise TypeError(f"{name} must be callable or None, not {reprlib.repr(value)}")
    return value


def integers(name: str, value: object, dtype: npt.DTypeLike, low: int, high: int) -> npt.NDArray[Any]:
    """An array of integers in low .. high as dtype; any integer type is accepted if its values fit."""
    if type(value) is int and low <= value <= high:
        return np.array(value, dtype)
    try:
        array = np.asarray(value)
    except ValueError:
        raise TypeError(f"{name} must be an array of integers, not {reprlib.repr(value)}") from None
    if array.size == 0 and not isinstance(value, (np.ndarray, np.generic)):
        array = array.astype(dtype)
    if array.dtype.kind == "O" and all(isinstance(v, int) for v in array.flat):
        pass  # Python integers beyond 64 bits: the range check below reports one
    elif array.dtype.kind not in "iu":
        raise TypeError(f"{name} must hold integers, not {array.dtype} ({reprlib.repr(value)})")
    if array.size:
        for extreme in (int(array.min()), int(array.max())):
            if not low <= extreme <= high:
                _out_of_range(name, extreme, low, high)
    return np.require(array, dtype, ["ALIGNED"])


def shape(value: object, max_ndim: int) -> tuple[int, ...]:
    """The extents of a mask: an integer or a sequence of 1 to max_ndim integers, each at least 1."""
    if isinstance(value, (str, bytes)):
        raise TypeError(f"shape must be a tuple of integers, not {value!r}")
    try:
        extents: tuple[object, ...] = tuple(value)  # type: ignore[arg-type]
    except TypeError:
        extents = (value,)
    if not 1 <= len(extents) <= max_ndim:
        raise ValueError(f"shape must have 1 to {max_ndim} extents, not {reprlib.repr(value)}")
    return tuple(integer("shape", extent, 1, UINT32[1]) for extent in extents)


def is_permutation(flat: npt.NDArray[Any]) -> bool:
    """Whether a flat array of integers contains each of 0 .. size - 1 exactly once."""
    if flat.size == 0 or flat.min() != 0 or flat.max() != flat.size - 1:
        return False
    seen = np.zeros(flat.size, bool)
    seen[flat] = True
    return bool(seen.all())


def permutation(name: str, flat: npt.NDArray[Any]) -> None:
    """Raises ValueError with the first rank that does not occur exactly once."""
    if is_permutation(flat):
        return
    counts = np.bincount(flat[flat < flat.size], minlength=flat.size)
    rank = int(np.flatnonzero(counts != 1)[0])
    raise ValueError(
        f"{name} must contain every rank 0 .. {flat.size - 1} exactly once, but contains {rank} {counts[rank]} times"
    )


def ranks(name: str, value: object) -> Ranks:
    """A two-dimensional mask as uint32 in C order."""
    array = integers(name, value, np.uint32, *UINT32)
    if array.ndim != 2 or array.size == 0:
        raise ValueError(f"{name} must have shape (height, width), not {array.shape}")
    permutation(name, array.reshape(-1))
    return np.ascontiguousarray(array)
