# SPDX-License-Identifier: Apache-2.0
"""Relaxation follows the formula in libbn/tools/make_relax.py, and the header with its learned schedule is up to date."""

import copy
import importlib.util
import json
from pathlib import Path

import numpy as np
import pytest
from hashes import mix64

import bluenoise

LIBBN = Path(__file__).resolve().parents[2] / "libbn"
SCHEDULE = json.loads((LIBBN / "data" / "relax.json").read_text(encoding="utf-8"))
spec = importlib.util.spec_from_file_location("make_relax", LIBBN / "tools" / "make_relax.py")
make_relax = importlib.util.module_from_spec(spec)
spec.loader.exec_module(make_relax)


def reference(shape, seed):
    """The mask in double precision, before the first and last ranks are reordered."""
    texels = np.arange(1, np.prod(shape) + 1, dtype=np.uint64).reshape(shape)
    v = 8 * ((mix64(np.uint64(seed) ^ mix64(texels)) >> np.uint64(48)) / 2**16 - 0.5)
    for step in SCHEDULE:
        moved = step["keep"] * v
        for weight, group in zip(step["weights"], step["groups"]):
            for y, x in group:
                moved += weight * np.clip(v - np.roll(v, (-y, -x), (0, 1)), -1, 1)
        v = moved
    ranks = np.empty(v.size, np.uint32)
    ranks[np.argsort(v, axis=None, kind="stable")] = np.arange(v.size)
    return ranks.reshape(shape)


@pytest.mark.parametrize("shape", [(128, 96), (4, 500), (2, 2)])
def test_mask_matches_the_formula(shape):
    # The first and last tenth of the ranks are reordered. Rounding changes the other ranks by about a thousandth on average.
    expected, found = (ranks / ranks.size for ranks in (reference(shape, 5), bluenoise.relax(shape, seed=5)))
    middle = abs(expected - 0.5) < 0.38
    different = np.abs(expected - found)
    assert different[middle].mean() < 0.002
    # Border rows and columns, whose neighbours lie on the opposite side of the torus, are as accurate as the others.
    for edge in (slice(0, 3), slice(-3, None)):
        assert different[edge][middle[edge]].mean() < 0.004 and different[:, edge][middle[:, edge]].mean() < 0.004


@pytest.mark.slow
def test_header_is_up_to_date():
    text = make_relax.HEADER.read_text(encoding="utf-8")
    assert make_relax.header(SCHEDULE, text) == text, "run libbn/tools/make_relax.py"


@pytest.mark.parametrize("group", [[[0, 1]], [[0, 0]], [[0, 1], [1, 0], [0, -1], [-1, 1]]])
def test_asymmetric_offsets_are_rejected(group):
    steps = copy.deepcopy(SCHEDULE)
    steps[0]["groups"][0] = group
    with pytest.raises(SystemExit, match="symmetries"):
        make_relax.quantise(steps)
