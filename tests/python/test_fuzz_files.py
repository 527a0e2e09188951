# SPDX-License-Identifier: Apache-2.0
"""Damaged masks and pictures end in ValueError, whatever is wrong with them: NPY and PNG files with random edits.

Edits come from a fixed seed. BN_FUZZ_RUNS is the number of files per test, for longer runs by hand.
"""

import io
import os
import random

import numpy as np
import pytest

import bluenoise
from bluenoise import _files

Image = pytest.importorskip("PIL.Image")

RUNS = int(os.environ.get("BN_FUZZ_RUNS", "2000"))


def npy(array):
    stream = io.BytesIO()
    np.save(stream, array, allow_pickle=True)
    return stream.getvalue()


def png(array):
    stream = io.BytesIO()
    Image.fromarray(array).save(stream, "PNG")
    return stream.getvalue()


RANKS = bluenoise.mask((8, 8))
NPY_SEEDS = [npy(RANKS), npy(RANKS.astype(float)), npy(np.zeros(3)), npy(np.array([None])), npy(np.zeros((2, 2), "i4,f8"))]
PNG_SEEDS = [png((RANKS * 4).astype(np.uint8)), png((RANKS * 1000).astype(np.uint16)), png(np.zeros((4, 4, 3), np.uint8)),
             _files.png(np.stack([RANKS * 1000] * 3, axis=-1).astype(np.uint16), [])]
TOKENS = [b"(", b")", b"'", b",", b"9" * 30, b"-1", b"{", b"}", b"None", b"\0", b"\xff", b"O8", b"<f8", b"\x93NUMPY", b"IHDR"]


def damaged(seeds, rng):
    """A file with a few edits: bytes replaced, tokens inserted, parts removed, the end cut off."""
    data = bytearray(rng.choice(seeds))
    for _ in range(rng.randrange(5)):
        at = rng.randrange(len(data) + 1)
        kind = rng.randrange(8)
        if kind < 4 and at < len(data):
            data[at] = rng.randrange(256)
        elif kind < 6:
            data[at:at] = rng.choice(TOKENS)
        elif kind == 6:
            del data[at : at + rng.randrange(1, 9)]
        else:
            del data[at:]
    return bytes(data)


def only_value_errors(path, data):
    path.write_bytes(data)
    try:
        array = _files.load_values(path)
        array = array[0] if array.ndim == 3 else array
    except ValueError as error:
        assert str(path) in str(error) and "Traceback" not in str(error)
        return False
    assert array.nbytes <= 64 * 1024
    return True


@pytest.mark.parametrize(("name", "seeds"), [("mask.npy", NPY_SEEDS), ("mask.png", PNG_SEEDS)])
def test_damaged_files(name, seeds, tmp_path):
    rng, read = random.Random(1), 0
    for _ in range(RUNS):
        read += only_value_errors(tmp_path / name, damaged(seeds, rng))
    assert 0.05 * RUNS < read < 0.95 * RUNS, "the edits should neither spoil every file nor spare them all"


def test_arbitrary_bytes(tmp_path):
    for data in (b"", b"\x93NUMPY", b"\x93NUMPY\x01\x00\xff\xff", b"\x93NUMPY\x09\x00", bytes(100), b"P6 9 9 255 "):
        for name in ("mask.npy", "mask.png"):
            with pytest.raises(ValueError, match="mask"):
                _files.load_mask(tmp_path / name if (tmp_path / name).write_bytes(data) >= 0 else None)
