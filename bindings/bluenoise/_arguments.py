# SPDX-License-Identifier: Apache-2.0
"""Argument checks and callback calls. Every error message contains the argument's name and value; no value is truncated or wrapped."""

from __future__ import annotations

import importlib
import math
import operator
import os
import reprlib
import secrets
import sys
from typing import Any, Callable, Iterable, Literal, NoReturn, Optional, Sequence, SupportsIndex, Union

import numpy as np
import numpy.typing as npt

from . import _core

NeuralProvider = Literal["cpu", "cuda"]
PointsMethod = Literal["best-candidate", "poisson-disk", "mask"]
SamplerType = Literal["blue", "sobol", "white", "zorder", "mask"]
Seed = Union[SupportsIndex, np.random.Generator, np.random.SeedSequence, None]
Shape = Sequence[SupportsIndex]
Progress = Callable[[float], Any]
Ranks = npt.NDArray[np.uint32]

INT32 = (-(2**31), 2**31 - 1)
UINT32 = (0, 2**32 - 1)
UINT64 = (0, 2**64 - 1)
MAX_TEXELS = 2**31 - 1


def said(value: object) -> str:
    """A short form of a value for messages, on one line."""
    return " ".join(reprlib.repr(value).split())


def _out_of_range(name: str, value: object, low: float, high: float) -> NoReturn:
    raise ValueError(f"{name} must be in {low} .. {high}, not {said(value)}")


def together(names: str, *shapes: tuple[int, ...]) -> tuple[int, ...]:
    """The common shape to which shapes broadcast."""
    try:
        return np.broadcast_shapes(*shapes)
    except ValueError:
        raise ValueError(f"{names} do not broadcast: shapes {', '.join(map(str, shapes))}") from None


def flag(name: str, value: object) -> bool:
    if not isinstance(value, (bool, np.bool_)):
        raise TypeError(f"{name} must be True or False, not {said(value)}")
    return bool(value)


def integer(name: str, value: object, low: int, high: int) -> int:
    """An integer of any type except bool, in low .. high."""
    if isinstance(value, (bool, np.bool_)):
        raise TypeError(f"{name} must be an integer, not {said(value)}")
    try:
        number = operator.index(value)  # type: ignore[arg-type]
    except TypeError:
        raise TypeError(f"{name} must be an integer, not {said(value)}") from None
    if not low <= number <= high:
        _out_of_range(name, number, low, high)
    return number


def real(name: str, value: object, low: float, high: float, low_included: bool = True) -> float:
    """A finite real number in [low, high] or (low, high]."""
    if isinstance(value, (bool, np.bool_, str, bytes)) or getattr(value, "ndim", 0) != 0:
        raise TypeError(f"{name} must be a number, not {said(value)}")
    try:
        number = float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError, OverflowError):
        raise TypeError(f"{name} must be a number, not {said(value)}") from None
    if not (math.isfinite(number) and low <= number <= high and (low_included or number != low)):
        bracket = "[" if low_included else "("
        raise ValueError(f"{name} must be in {bracket}{low}, {high}], not {number}")
    return number


def one_of(name: str, value: object, known: Iterable[str]) -> None:
    """Raises unless the value is one of the known strings."""
    if not isinstance(value, str):
        raise TypeError(f"{name} must be a string, not {said(value)}")
    if value not in known:
        raise ValueError(f"{name} must be one of {', '.join(known)}, not {said(value)}")


def seed(value: object) -> int:
    """A seed as an integer: one draw from a Generator, the first word of a SeedSequence, fresh entropy for None."""
    if value is None:
        return secrets.randbits(64)
    if isinstance(value, np.random.SeedSequence):
        return int(value.generate_state(1, np.uint64)[0])
    if isinstance(value, np.random.Generator):
        return int(value.integers(UINT64[1], dtype=np.uint64, endpoint=True))
    return integer("seed", value, *UINT64)


def callback(name: str, value: Optional[Progress]) -> Optional[Progress]:
    if value is not None and not callable(value):
        raise TypeError(f"{name} must be callable or None, not {said(value)}")
    return value


def report(progress: Optional[Progress], fraction: float) -> None:
    """Calls a callback, if there is one. Raises CancelledError if it returns a true value."""
    if progress is not None and progress(fraction):
        raise _core.CancelledError(f"progress asked to stop at {fraction:.3f}")


def array(name: str, value: object) -> npt.NDArray[Any]:
    """Converts an array-like value to an array. Other values, such as GPU tensors, raise TypeError with the reason."""
    if isinstance(value, np.ma.MaskedArray) and np.ma.is_masked(value):
        raise ValueError(f"{name} has masked elements; fill them, for example with {name}.filled(0)")
    try:
        return np.asarray(value)
    except MemoryError:
        raise
    except Exception as error:  # __array__ may raise any type
        hint = "; for a tensor, give .detach().cpu().numpy()" if hasattr(value, "detach") else ""
        raise TypeError(f"{name} must be an array, not {said(value)}: {' '.join(str(error).split())}{hint}") from None


def integers(name: str, value: object, dtype: npt.DTypeLike, low: int, high: int) -> npt.NDArray[Any]:
    """An array of integers in low .. high, as dtype. Any integer type is accepted if its values fit."""
    if type(value) is int and low <= value <= high:
        return np.array(value, dtype)
    given = array(name, value)
    if given.size == 0 and not isinstance(value, (np.ndarray, np.generic)):
        given = given.astype(dtype)
    if given.dtype.kind == "O" and all(isinstance(v, int) for v in given.flat):
        pass  # Python integers beyond 64 bits: the range check below reports one
    elif given.dtype.kind not in "iu":
        raise TypeError(f"{name} must hold integers, not {given.dtype} ({said(value)})")
    if given.size:
        for extreme in (int(given.min()), int(given.max())):
            if not low <= extreme <= high:
                _out_of_range(name, extreme, low, high)
    return np.require(given, dtype, ["ALIGNED"])


def reals(name: str, value: object) -> npt.NDArray[np.float64]:
    """An array of real numbers."""
    given = array(name, value)
    if given.dtype.kind not in "fiu" and given.size:
        raise TypeError(f"{name} must hold numbers, not {given.dtype} ({said(value)})")
    return given.astype(np.float64)


def output(out: object, extents: Sequence[int], dtype: npt.DTypeLike) -> npt.NDArray[Any]:
    """The array for a result: ``out`` if it fits, or a new array if it is None."""
    extents, kind = tuple(extents), np.dtype(dtype)
    if out is None:
        if math.prod(extents) * kind.itemsize > sys.maxsize:
            raise MemoryError(f"an array of {' x '.join(map(str, extents))} is too large for memory")
        return np.empty(extents, kind)
    if not isinstance(out, np.ndarray) or isinstance(out, (np.matrix, np.ma.MaskedArray)):
        raise TypeError(f"out must be an array, not {said(out)}")
    if out.shape != extents or out.dtype != kind:
        raise ValueError(f"out must have shape {extents} and dtype {kind}, not {out.shape} and {out.dtype}")
    if not out.flags.carray:
        raise ValueError(f"out must be writable, aligned and in C order, not with strides {out.strides}"
                         + ("" if out.flags.writeable else ", read-only"))
    return out


def shape(value: object, max_ndim: int) -> tuple[int, ...]:
    """The extents of a mask: a sequence of 1 to max_ndim integers, each at least 1."""
    try:
        extents: tuple[object, ...] = () if isinstance(value, (str, bytes)) else tuple(value)  # type: ignore[arg-type]
    except (TypeError, NotImplementedError):  # the latter from memoryview
        extents = ()
        if isinstance(value, (int, np.integer)):
            n = said(int(value))
            raise TypeError(f"shape must be a tuple, not {n}: ({n}, {n}) is a square, ({n},) a row") from None
    if not extents and not isinstance(value, (tuple, list)):
        raise TypeError(f"shape must be a tuple of integers, not {said(value)}")
    if not 1 <= len(extents) <= max_ndim:
        raise ValueError(f"shape must have 1 to {max_ndim} extents, not {said(value)}")
    whole = tuple(integer("shape", extent, -sys.maxsize, sys.maxsize) for extent in extents)
    if min(whole) < 1:
        raise ValueError(f"shape must have extents of at least 1, not {whole}")
    if math.prod(whole) > MAX_TEXELS:
        raise MemoryError(f"shape must have at most 2**31 - 1 texels, not {whole}")
    return whole


def memory() -> float:
    """The memory available to the process, in bytes, as reported for the machine or its container."""
    try:
        machine = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, ValueError, OSError):
        return math.inf
    try:
        with open("/sys/fs/cgroup/memory.max", encoding="ascii") as file:
            return min(machine, int(file.read()))
    except (OSError, ValueError):
        return machine


def enough_memory(what: str, size: int) -> None:
    """Raises MemoryError at once if work that needs this many bytes would fail later."""
    if size > memory():
        raise MemoryError(f"{what} needs about {size / 1e9:.1f} GB of memory, but at most {memory() / 1e9:.1f} GB can be used")


def needed(module: str, words: str, package: str) -> Any:
    """A module that only some functions need."""
    try:
        return importlib.import_module(module)
    except ImportError:
        raise ImportError(f"{words}; run: pip install {package}") from None


def is_permutation(flat: npt.NDArray[Any]) -> bool:
    """Whether a flat array of integers contains each of 0 .. size - 1 exactly once."""
    if flat.size == 0 or flat.min() != 0 or flat.max() != flat.size - 1:
        return False
    seen = np.zeros(flat.size, bool)
    seen[flat] = True
    return bool(seen.all())


def has_channels(ranks: npt.NDArray[Any]) -> bool:
    """Whether an array of two or three dimensions consists of masks along its first axis, like the result of mask(..., channels=2)."""
    if ranks.ndim not in (2, 3) or len(ranks) < 2 or ranks.dtype.kind not in "iu":
        return False
    return all(is_permutation(channel.flatten()) for channel in ranks)


def permutation(name: str, flat: npt.NDArray[Any]) -> None:
    """Raises ValueError with the first rank that does not occur exactly once."""
    if is_permutation(flat):
        return
    if flat.size == 0:
        raise ValueError(f"{name} must have at least one texel")
    counts = np.bincount(flat[flat < flat.size], minlength=flat.size)
    rank = int(np.flatnonzero(counts != 1)[0])
    raise ValueError(
        f"{name} must contain every rank 0 .. {flat.size - 1} exactly once, but contains {rank} {counts[rank]} times"
        + ("; load(file, rank=True) ranks the values of a texture" if len(counts) > 1 and (counts > 1).mean() > 0.01 else "")
    )


def ranks(name: str, value: object) -> Ranks:
    """A checked copy of a mask of shape (height, width), or (n,) as (1, n). No other thread can change the copy."""
    given = integers(name, value, np.uint32, *UINT32)
    texels = np.atleast_2d(np.array(given, order="C"))
    if texels.ndim != 2 or texels.size == 0:
        hint = f"; choose one channel, as in {name}[0]" if texels.ndim == 3 else ""
        raise ValueError(f"{name} must have shape (height, width), not {given.shape}{hint}")
    permutation(name, texels.reshape(-1))
    return texels
