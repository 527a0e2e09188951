# SPDX-License-Identifier: Apache-2.0
"""Compares the samplers' errors after a blur with the limits in sampler_limits.csv.

Each row limits one figure of one sampler after one blur, with one column per sample count. A figure is the mean RMSE of the blurred errors
of 64 x 64 pixels over 24 integrands and 4 domains, relative to white noise (in closed form). The figures are:

    half-planes-01, half-planes-23   half-planes in a pair of dimensions
    products                         half-planes in both pairs of a domain, multiplied
    siblings                         half-planes in two domains of a family, multiplied
    steps                            edges parallel to the image's sides: x < c, blurred along columns only, and y < c, blurred along rows
                                     only, in pair (0,1) of domains with keys 4 k
    leaning                          edges tilted from a row or a column by slopes of .03 to .1, in every pair in turn: linear scramblings
                                     suit some slopes but not others
    drifting                         half-planes whose edges move back and forth across the screen once per 64 pixels, in every pair in turn
    singles                          x < c, in turn in each of the four numbers of domains with keys 4 k
    axes                             the ratio of low-frequency powers along the two axes, for the errors of steps in all other pairs

Steps are at irrational positions. At multiples of 1/16, nets are exact. Figures that are zero by construction would hide defects, so every
figure must also be above 0.02. Everything is seeded. Run this module as a program to print the CSV file with limits 3% above the measured
figures.
"""

import csv
import functools
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from conftest import blur_gain, part, plane_at_angle, plane_through, well_spread

import bluenoise

ndimage = pytest.importorskip("scipy.ndimage")

LIMITS = Path(__file__).with_name("sampler_limits.csv")
ROWS = list(csv.DictReader(LIMITS.open(encoding="utf-8")))
COUNTS = list(ROWS[0])[4:]
PLANES, DOMAINS, MEMBERS = 24, 4, 4
RADIUS, INNER = 8, 64  # images have a margin as wide as the blur
SIZE = INNER + 2 * RADIUS
SIBLINGS = list(combinations(range(MEMBERS), 2))


def plane(k, second=0):
    """A half-plane. Angles are evenly spread, and `second` selects a second set of angles."""
    angle = 2 * np.pi * ((k * (7 if second else 1) + 11 * second) % PLANES + 0.41) / PLANES
    return plane_at_angle(*well_spread(k + 100 * second), angle)


def leaning(k):
    slope = (-1 if k & 2 else 1) * 0.03 * (0.1 / 0.03) ** ((k + 0.5) / PLANES)
    return plane_through(*well_spread(k), *((1, slope) if k & 1 else (slope, 1)))


def drifting(k):
    """A half-plane (a, b, c, mean), in which every pixel has its own c and mean."""
    a, b, c, _ = plane(k)
    y, x = np.mgrid[:SIZE, :SIZE]
    c = c + 0.35 * np.sin(2 * np.pi * ((x, y, x + y, x - y)[k % 4] / INNER + k / PLANES))
    return a, b, c[..., None], part(a, b, c)[..., None]


def step(k):
    """A step in x for even k, in y for odd k."""
    c = (0.2 + 0.6180339887498949 * (k // 2)) % 1
    return (1.0, 0.0, c, c) if k % 2 == 0 else (0.0, 1.0, c, c)


def integrand(figure, member, k):
    """An integrand's factors: half-planes, each with its member and pair."""
    if figure == "steps":
        return [(step(k), 0, 0)]
    if figure == "axes":
        return [(step(k), member, 1 if member == 0 or k // 2 % 2 == 0 else 0)]
    if figure == "singles":
        return [(step(k), 0, k // 2 % 2)]
    if figure == "drifting":
        return [(drifting(k), member, k // 4 % 2)]
    if figure == "leaning":
        return [(leaning(k), member, k // 4 % 2)]
    if figure == "products":
        return [(plane(k), member, 0), (plane(k, 1), member, 1)]
    if figure == "siblings":
        first, second = SIBLINGS[k % 6]
        return [(plane(k), first, 0), (plane(k, 1), second, 0)]
    return [(plane(k), member, {"half-planes-01": 0, "half-planes-23": 1}[figure])]


def blurred(errors, sigma, axes):
    """The mean square of blurred images, and the factor by which the blur scales the variance of white noise."""
    for axis in axes if sigma else ():
        errors = ndimage.gaussian_filter1d(errors, sigma, axis, truncate=RADIUS / sigma)
    inner = slice(RADIUS, -RADIUS)
    return (errors[inner, inner] ** 2).mean((0, 1)), blur_gain(sigma, RADIUS) ** (len(axes) / 2) if sigma else 1.0


@functools.lru_cache(1)  # rows for the same figure with different blurs are adjacent
def error_images(kind, declared, figure, counts):
    """For each integrand: its number, its errors at each sample count, and its variance at one sample."""
    sampler, found = bluenoise.Sampler(kind, samples_per_pixel=declared), []
    for member in range(DOMAINS):
        integrands = [integrand(figure, member, k) for k in range(PLANES)]
        samples = {m: sampler.block(0, 0, SIZE, SIZE, 0, counts[-1], bluenoise.domain(4 * member + 400, m))
                   for m in {m for f in integrands for _, m, _ in f}}
        for k, factors in enumerate(integrands):
            inside, mean = True, 1.0
            for (a, b, c, share), m, pair in factors:
                inside = inside & (a * samples[m][..., 2 * pair] + b * samples[m][..., 2 * pair + 1] < c)
                mean *= share
            sums = np.add.reduceat(inside, [0, *counts[:-1]], axis=2, dtype=np.int32).cumsum(2)
            found.append((k, sums / np.array(counts) - mean, np.mean(mean * (1 - mean))))
    return found


def measured(kind, declared, figure, sigma, counts):
    """The figure at each sample count."""
    error = white = 0
    for k, errors, variance in error_images(kind, declared, figure, counts):
        if figure == "axes":
            ratio = np.log(blurred(errors, sigma, [0])[0] / blurred(errors, sigma, [1])[0])
            error, white = error + (ratio if k % 2 == 0 else -ratio), white + 1
        else:
            square, gain = blurred(errors, sigma, [k % 2] if figure == "steps" else [0, 1])
            error, white = error + np.sqrt(square), white + np.sqrt(gain * variance / np.array(counts))
    return np.exp(abs(error / white)) if figure == "axes" else error / white


def figures(row):
    """{count: figure} of a row."""
    counts = [count for count in COUNTS if row[count]]
    found = measured(row["sampler"], int(row["declared"]), row["figure"], float(row["sigma"]), tuple(map(int, counts)))
    return dict(zip(counts, found))


@pytest.mark.parametrize("row", ROWS, ids=lambda row: "-".join(list(row.values())[:4]))
def test_samplers_keep_their_limits(row):
    found = figures(row)
    assert all(0.02 < figure <= float(row[count]) for count, figure in found.items()), found


if __name__ == "__main__":
    print(",".join(ROWS[0]))
    for row in ROWS:
        found = figures(row)
        limits = (f"{1.03 * found[count]:.3f}" if count in found else "" for count in COUNTS)
        print(",".join([*list(row.values())[:4], *limits]))
