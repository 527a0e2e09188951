# SPDX-License-Identifier: Apache-2.0
"""Reads tests/c/draw_hashes.txt and computes hashes as tests/c/test_draw_hashes.c does."""

from pathlib import Path

import numpy as np

TABLE = Path(__file__).resolve().parents[1] / "c" / "draw_hashes.txt"


def table():
    """Returns {name: hash}."""
    rows = (line.split() for line in TABLE.read_text().splitlines()[1:])
    return {name: int(digits, 16) for name, digits in rows}


def mix64(v):
    v = (v ^ (v >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    v = (v ^ (v >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return v ^ (v >> np.uint64(31))


def random_u64(counter):
    """SplitMix64."""
    return mix64((counter.astype(np.uint64) + np.uint64(1)) * np.uint64(0x9E3779B97F4A7C15))


def hash_of(words):
    """The FNV-1a hash of 32-bit little-endian words."""
    digest = 0xCBF29CE484222325
    for byte in np.asarray(words, "<u4").tobytes():
        digest = (digest ^ byte) * 0x100000001B3 & (2**64 - 1)
    return digest
