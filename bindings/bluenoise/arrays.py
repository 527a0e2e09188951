# SPDX-License-Identifier: Apache-2.0
"""Draws on the arrays of any library that follows the Python array API, such as PyTorch, JAX and CuPy.

bn_draw.glsl contains the same code and explains every step. Words are int32, because JAX has no 64-bit integers by default and
PyTorch cannot multiply unsigned ones. Sums and products wrap. The draws use only operators, so Dr.Jit arrays can take part
(mitsuba.py).
"""

from __future__ import annotations

from typing import Any, Callable, Literal, Optional, Sequence

import numpy as np
import numpy.typing as npt

from . import _arguments as arguments
from ._sampler import Sampler, tables

__all__ = ["sample"]

_Word = Callable[[Any], Any]  # reads words of words()
_Seed = tuple[int, int]
# Where the parts of the table begin, in words.
_BLOCKS, _PLACES, _POINTS, _LATER = 4096, 6144, 6272, 10368


def sample(
    xp: Any, sampler: Sampler, x: Any, y: Any, index: Any, domain: Any = 0, dims: int = 4, *, pair: Optional[Literal[0, 1]] = None
) -> Any:
    """Draw samples as arrays of another library, on their device. They are bit-identical to those of `Sampler.sample`.

    Parameters
    ----------
    xp : module
        The array library: ``torch``, ``jax.numpy``, ``cupy``, ``numpy`` or another that follows the array API.
    sampler : Sampler
        Of type ``"blue"``, ``"sobol"`` or ``"white"``.
    x, y, index, domain : array of int
        See `Sampler.sample`. Arrays of `xp` may have any integer dtype; their values are taken modulo 2**32, since a range check would wait
        for the device. Integers and NumPy arrays are checked, then copied to the device of the others.
    dims : int, default 4
        Number of dimensions, 1 to 4.
    pair : {0, 1}, optional
        Draw only dimensions (0, 1) or (2, 3). Do not pass `dims` as well.

    Returns
    -------
    array of float32
        Numbers in [0, 1) of shape ``(..., dims)``, as an array of `xp`. They carry no gradient.

    Raises
    ------
    ValueError
        The sampler has another type, or an integer is out of range. Shapes that do not broadcast raise the error of `xp`.
    TypeError
        An argument does not hold integers.

    Notes
    -----
    Made of a few hundred elementwise operations without branches, which ``jax.jit`` and ``torch.compile`` fuse. If the index is an
    integer or a NumPy array and below 256, a quarter of them are left out. On the CPU, `Sampler.sample` is faster.

    Examples
    --------
    >>> sample(np, Sampler("blue", seed=1), np.arange(3), 5, index=0).shape
    (3, 4)
    """
    if not isinstance(sampler, Sampler):
        raise TypeError(f"sampler must be a Sampler, not {sampler!r}")
    draw = _DRAWS.get(sampler.type)
    if draw is None:
        raise ValueError(f"sampler must have type {', '.join(_DRAWS)}, not {sampler.type!r}")
    dims = arguments.integer("dims", dims, 1, 4)
    pairs = (0, 1)[: (dims + 1) // 2]
    if pair is not None:
        pairs, dims = (arguments.integer("pair", pair, 0, 1),), 2
    given = {"x": x, "y": y, "index": index, "domain": domain}
    host = {name for name, value in given.items() if isinstance(value, (np.ndarray, np.generic)) or not hasattr(value, "dtype")}
    devices = [value.device for name, value in given.items() if name not in host and "torch" in xp.__name__]
    place = {"device": devices[0]} if devices else {}  # other libraries find the device themselves
    last = 2**32 - 1
    for name, value in given.items():
        if name in host:
            dtype, limits = (np.int32, arguments.INT32) if name in "xy" else (np.uint32, arguments.UINT32)
            if type(value) is int:  # needs no NumPy, which torch.compile would trace
                highest = arguments.integer(name, value, *limits)
                value = _c(value & 0xFFFFFFFF)
            else:
                value = arguments.integers(name, value, dtype, *limits)
                highest = int(value.max(initial=0))
                value = value.view(np.int32)
            last = highest if name == "index" else last
        elif "int" not in str(value.dtype):
            raise TypeError(f"{name} must hold integers, not {value.dtype}")
        given[name] = xp.asarray(value, dtype=xp.int32, **place)
    scalar = all(value.ndim == 0 for value in given.values())
    spread = [xp.reshape(value, (1,)) if value.ndim == 0 else value for value in given.values()]  # NumPy warns if scalars wrap
    table = xp.asarray(WORDS, **place)
    found = draw(lambda at: table[at], sampler._words, *spread, pairs, rounds_of(last))
    numbers = [xp.asarray(_right(word, 8), dtype=xp.float32) * 2.0**-24 for word in found[:dims]]
    stacked = xp.stack(numbers, axis=-1)
    return xp.reshape(stacked, (dims,)) if scalar else stacked


# The table of blue(): tables(), except that entries for index bits 8 to 31 stand for eight bits at a time, not four. They are laid out
# like the first 256 points.
_table = tables().view(np.int32)
_four = _table[_LATER:].reshape(3, 2, 16, 16)
WORDS: npt.NDArray[np.int32] = np.concatenate([_table[:_LATER], (_four[:, 0, :, None] ^ _four[:, 1, None, :]).reshape(-1)])


def rounds_of(last: int) -> int:
    """The number of rounds of blue() for indices up to `last`."""
    return min(max(1, -(-last.bit_length() // 8)), 4)


# ---- The draws. Each returns two words for each pair of dimensions.


def _c(word: int) -> int:
    """A constant as int32."""
    return word - (word >> 31 << 32)


def _right(v: Any, bits: int) -> Any:
    """Shifts right, filling with zeros."""
    return v >> bits & (1 << 32 - bits) - 1


def _reversed(v: Any) -> Any:
    v = _right(v, 16) | v << 16
    for bits, mask in ((8, 0x00FF00FF), (4, 0x0F0F0F0F), (2, 0x33333333), (1, 0x55555555)):
        v = v >> bits & mask | (v & mask) << bits
    return v


def _hash(v: Any) -> Any:
    v = (v ^ _right(v, 16)) * 0x21F0AAAD
    v = (v ^ _right(v, 15)) * _c(0xD35A2D97)
    return v ^ _right(v, 15)


def domain_child(domain: Any, key: Any) -> Any:
    v = (domain + _right(key, 2) * 0x121658BD + _c(0x9E3779B9)) * 0x21F0AAAD
    v = (v ^ _right(v, 16)) & -4 | key & 3
    return _right(v, 2) | v << 30


def blue(word: _Word, seed: _Seed, x: Any, y: Any, index: Any, domain: Any, pairs: Sequence[Any], rounds: int) -> list[Any]:
    # The pixel's position in the tile of its domain's family.
    turned = domain << 2 | _right(domain, 30)
    member = turned & 3
    start = turned & -4 ^ seed[0]
    family = start * 0x21F0AAAD
    family = (family ^ _right(family, 16)) * _c(0xD35A2D97) + seed[1]
    column = (x ^ family >> 31) + _right(start, 26)
    row = (y ^ 0 - (family >> 19 & 1)) + _right(family, 20)
    shuffle = _right(column, 6) + _right(row, 6) * _c(0x9E3779B1) + family
    shuffle = (shuffle ^ _right(shuffle, 16)) * 0x21F0AAAD
    shuffle = shuffle ^ _right(shuffle, 15)
    at = (row & 63) << 6 | column & 63
    place = _PLACES + ((word(at) >> 8 * member & 15) + member * 16) * 2
    block = _BLOCKS + (((at & 0xF00) >> 2) + (at & 0x3C) + member) * 2
    keys = shuffle * (member * 0x0BD794D6 + _c(0xD35A2D97))
    keys = keys ^ _right(keys, 16)
    low = (_hash(x + y * _c(0x9E3779B1)) ^ keys) * 0x21F0AAAD

    # The digits of the index.
    t = ((index & 255) >> 1) - 1
    flip = 2 << (t & 15)
    for bit, turn in ((5, 5), (6, 11), (7, 2)):
        flip = flip | (index >> bit & 1) << ((t + turn & 15) + 1)
    backwards = _reversed(index)
    digits = backwards ^ backwards * (shuffle << 1) ^ shuffle * (flip & ~(t >> 31)) & _c(0x80000000)

    found = []
    for pair in pairs:
        second = 0 - pair
        high = word(place + pair) ^ word(block + pair) ^ keys ^ (keys ^ (keys << 8 | _right(keys, 24))) & second
        rest = low ^ keys & second
        two = [high << 16 | rest & 0xFFFF, high & _c(0xFFFF0000) | _right(rest, 16)]
        for later in range(rounds):
            entry = ((digits >> 24 - 8 * later & 255) + (256 * later)) * 16 + (_POINTS + member * 4 + pair * 2)
            two = [two[0] ^ word(entry), two[1] ^ word(entry + 1)]
        found += two
    return found


def _owen_reversed(v: Any, seed: Any) -> Any:
    v = v ^ v * 0x3D20ADEA
    v = (v + seed) * (_right(seed, 16) | 1)
    v = v ^ v * 0x05526C56
    return v ^ v * 0x53A22864


def _sobol(word: _Word, seed: _Seed, x: Any, y: Any, index: Any, domain: Any, pairs: Sequence[int], rounds: int) -> list[Any]:
    key = _hash(y ^ _hash(domain + seed[0]))
    keys = [_hash(x ^ _hash(key + seed[1]))]
    for _ in range(3 * max(pairs) + 2):
        keys.append(_hash(keys[-1] + _c(0x9E3779B9)))
    found = []
    for pair in pairs:
        first = second = _owen_reversed(_reversed(index), keys[3 * pair])
        for shift, mask in ((1, 0xAAAAAAAA), (2, 0xCCCCCCCC), (4, 0xF0F0F0F0), (8, 0xFF00FF00), (16, 0xFFFF0000)):
            second = second ^ second << shift & _c(mask)
        for digits, key in zip((first, second), keys[3 * pair + 1 :]):
            found.append(_reversed(_owen_reversed(_reversed(digits), key)))
    return found


def _white(word: _Word, seed: _Seed, x: Any, y: Any, index: Any, domain: Any, pairs: Sequence[int], rounds: int) -> list[Any]:
    x, y, z, w = x + seed[0], y, index, domain + seed[1]
    w = (w ^ _right(w, 16)) * 0x21F0AAAD
    x, y, z, w = (v * 1664525 + 1013904223 for v in (x, y, z, w))
    for last in (False, True):
        x = x + y * w
        y = y + z * x
        z = z + x * y
        w = w + y * z
        if not last:
            x, y, z, w = (v ^ _right(v, 16) for v in (x, y, z, w))
    return [v for pair in pairs for v in ((x, y), (z, w))[pair]]


_DRAWS: dict[str, Callable[..., list[Any]]] = {"blue": blue, "sobol": _sobol, "white": _white}
