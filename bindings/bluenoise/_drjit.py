# SPDX-License-Identifier: Apache-2.0
"""The "blue" sampler's draws on Dr.Jit arrays. bn_draw.glsl and bn_path.glsl contain the same code and explain every step."""

from __future__ import annotations

from typing import Any

import drjit
import mitsuba

# The types in both modules depend on the variant.
dr: Any = drjit
mi: Any = mitsuba

# Where the parts of the table begin, in words.
_BLOCKS, _PLACES, _POINTS, _LATER = 4096, 6144, 6272, 10368
_CAMERA_KEY, _STREAMS_KEY = 3, 0x80000000


def _hash(v: Any) -> Any:
    v = (v ^ v >> 16) * 0x21F0AAAD
    v = (v ^ v >> 15) * 0xD35A2D97
    return v ^ v >> 15


def domain_child(domain: Any, key: Any) -> Any:
    v = (domain + (key >> 2) * 0x121658BD + 0x9E3779B9) * 0x21F0AAAD
    v = (v ^ v >> 16) & 0xFFFFFFFC | key & 3
    return v >> 2 | v << 30


def stream_domain(stream: Any) -> Any:
    below = domain_child(domain_child(mi.UInt32(0), mi.UInt32(_STREAMS_KEY)), stream)
    return dr.select(stream == 0, mi.UInt32(0), below)


def ray_domain(domain: Any, ray: Any) -> Any:
    return domain_child(domain, dr.select(ray >= _CAMERA_KEY, ray + 1, ray))


def single_domain(ray: Any, k: Any) -> Any:
    """The domain of single number k of a ray; the pair there is `k >> 1 & 1`."""
    return domain_child(ray, k & 0xFFFFFFFC)


def pair_bits(words: Any, seed: tuple[Any, Any], x: Any, y: Any, index: Any, rounds: int, domain: Any, pair: Any) -> tuple[Any, Any]:
    """Two 32-bit numbers: dimensions (0, 1) for pair 0, (2, 3) for pair 1. `words` is bn_tables(), and `rounds` is the number of
    four-bit groups in an index above its lowest eight bits."""
    def word(at: Any) -> Any:
        return dr.gather(mi.UInt32, words, at)

    # The pixel's position in the tile of its domain's family.
    turned = domain << 2 | domain >> 30
    member, pair = turned & 3, pair & 1
    start = (turned & 0xFFFFFFFC) ^ seed[0]
    family = start * 0x21F0AAAD
    family = (family ^ family >> 16) * 0xD35A2D97 + seed[1]
    column = (x ^ (0 - (family >> 31))) + (start >> 26)
    row = (y ^ (0 - (family >> 19 & 1))) + (family >> 20)
    shuffle = (column >> 6) + (row >> 6) * 0x9E3779B1 + family
    shuffle = (shuffle ^ shuffle >> 16) * 0x21F0AAAD
    shuffle ^= shuffle >> 15
    at = (row & 63) << 6 | column & 63
    place = _PLACES + ((word(at) >> (8 * member) & 15) + member * 16) * 2
    block = _BLOCKS + (((at & 0xF00) >> 2) + (at & 0x3C) + member) * 2
    keys = shuffle * (member * 0x0BD794D6 + 0xD35A2D97)
    keys ^= keys >> 16
    low = (_hash(x + y * 0x9E3779B1) ^ keys) * 0x21F0AAAD

    # The digits of the index.
    t = ((index & 255) >> 1) - 1
    flip = mi.UInt32(2) << (t & 15)
    for bit, turn in ((5, 5), (6, 11), (7, 2)):
        flip |= (index >> bit & 1) << ((t + turn & 15) + 1)
    flip &= (t >> 31) - 1
    backwards = dr.brev(index)
    digits = backwards ^ backwards * (shuffle << 1) ^ shuffle * flip & 0x80000000

    # The sample.
    high = word(place + pair) ^ word(block + pair) ^ dr.select(pair == 0, keys, keys << 8 | keys >> 24)
    low ^= dr.select(pair == 0, mi.UInt32(0), keys)
    first = high << 16 | low & 0xFFFF
    second = high & 0xFFFF0000 | low >> 16
    entry = _POINTS + (digits >> 24) * 16
    for later in range(rounds + 1):
        row = entry + member * 4 + pair * 2
        first ^= word(row)
        second ^= word(row + 1)
        digits <<= 8 if later == 0 else 4
        entry = _LATER + 256 * later + (digits >> 28) * 16
    return first, second
