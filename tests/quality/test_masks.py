# SPDX-License-Identifier: Apache-2.0
"""Compares the masks of every method with the limits in masks.csv, and tests for seams. Masks are bit-identical on every machine, so
there are no false alarms.

Each row of masks.csv lists a method, extents, the method's sigma, the number of seeds (0, 1, ...) to average, and upper limits for
measures. ``e_S`` is the error after a blur (sigma = S texels). ``low_A/B`` is the mean power (1 for white noise) below half the principal
frequency, after thresholding the mask at grey level A / B. ``anisotropy`` is the anisotropy of the mean spectrum over all seeds, in dB.
"""

import csv
import functools
import sys
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

import bluenoise

HERE = Path(__file__).resolve().parent
sys.path.append(str(HERE.parent / "python"))
import reference  # noqa: E402

ndimage = pytest.importorskip("scipy.ndimage")

ROWS = list(csv.DictReader((HERE / "masks.csv").open(encoding="utf-8")))


@functools.cache
def masks(method, width, height, sigma, seeds):
    options = {"void-and-cluster": {"sigma": sigma}, "anneal": {"sigma": sigma, "sweeps": 4000}}.get(method, {})
    make = reference.white if method == "white" else getattr(bluenoise, method.replace("-", "_"))
    made = [make((height, width), **({} if method == "builtin" else {"seed": seed}), **options) for seed in range(seeds)]
    assert all((np.sort(ranks, axis=None) == np.arange(ranks.size)).all() for ranks in made)
    return made


@pytest.mark.parametrize(("row", "measure"), [(row, name) for row in ROWS for name in list(row)[5:] if row[name]],
                         ids=lambda it: it if isinstance(it, str) else "-".join(list(it.values())[:5]))
def test_masks_keep_their_limits(row, measure):
    made = masks(row["method"], int(row["width"]), int(row["height"]), float(row["sigma"]), int(row["seeds"]))
    kind, _, argument = measure.partition("_")
    if kind == "anisotropy":
        value = bluenoise.anisotropy(made)
    elif kind == "e":
        value = np.mean([bluenoise.dithering_error(ranks, float(argument)) for ranks in made])
    else:
        value = np.mean([reference.low_frequency(ranks, float(Fraction(argument))) for ranks in made])
    assert value <= float(row[measure])


def errors(ranks, levels):
    """Each texel's squared error after dithering and a toroidal blur (sigma = 1.5 texels), summed over `levels` out of 16."""
    values, total = (ranks + 0.5) / ranks.size, 0
    for level in (np.asarray(levels) + 0.5) / 16:
        total += (ndimage.gaussian_filter((values < level).astype(float), 1.5, mode="wrap") - level) ** 2
    return total


@pytest.mark.parametrize("levels", [(0, 15), range(1, 15)], ids=["ends", "middle"])
@pytest.mark.parametrize("shape", [(64, 64), (45, 61), (72, 40)])
@pytest.mark.parametrize("method", ["void-and-cluster", "relax", "anneal", "builtin"])
def test_masks_tile_without_seams(method, shape, levels):
    """The error within two texels of a border is the same as inside. Levels at both ends, whose texels are far apart, are tested
    separately."""
    if method == "builtin" and shape != (64, 64):
        return
    total = 0
    for seed in range(1 if method == "builtin" else 6):
        # Annealing starts from white noise, so that only annealing makes the mask blue.
        options = {"sweeps": 30, "start_from_ranks": reference.white(shape, seed)} if method == "anneal" else {}
        options |= {} if method == "builtin" else {"seed": seed}
        total = total + errors(getattr(bluenoise, method.replace("-", "_"))(shape, **options), levels)
    near_y, near_x = (np.minimum(np.arange(extent), np.arange(extent)[::-1]) < 2 for extent in shape)
    inside = total[np.ix_(~near_y, ~near_x)].mean()
    limit = 1.2 if method == "builtin" else 1.1
    for seam in (total[np.ix_(near_y, ~near_x)], total[np.ix_(~near_y, near_x)]):
        assert 1 / limit < seam.mean() / inside < limit
