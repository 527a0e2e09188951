# SPDX-License-Identifier: Apache-2.0
"""Tests how BLUE's pixels differ: all pixels in a copy of the tile share one sample order, and each copy has its own order. Each sample is
therefore as blue as the first. False-alarm rates are for fresh seeds."""

import numpy as np
import pytest
from conftest import blur_gain, plane_at_angle

import bluenoise

ndimage = pytest.importorskip("scipy.ndimage")

TILE, SEED = 64, 21


def look(x, y, domain, count=64):
    """Returns the digits of sample 0, and the order of the first samples, relative to sample 0 so that each pixel's own digits cancel."""
    samples = bluenoise.Sampler("blue", seed=SEED).sample(x[..., None], y[..., None], np.arange(count), domain)
    digits = (samples * 2.0**24).astype(np.uint32)
    return digits[..., 0, :], digits[..., 1:, 0] ^ digits[..., :1, 0]


def is_chance(equal, expected):
    """Whether a count is at most six deviations plus six above the expected count. By chance, the probability of more is below 1e-7."""
    return equal <= expected + 6 * np.sqrt(expected) + 6


@pytest.mark.parametrize("i", range(4))
def test_pixels_of_a_copy_share_the_order_but_not_the_low_digits(i):
    """Over 128 x 128 pixels, the order changes at two columns and at two rows. The two columns and the two rows are one tile apart."""
    y, x = np.mgrid[:2 * TILE, :2 * TILE]
    first, order = look(x + 77 * i - 200, y + 777 * i * i - 1000, bluenoise._core.domain_child(4, i))
    for axis in (0, 1):
        changes = (np.diff(order.astype(np.int64), axis=axis) != 0).any(-1)
        along = changes.any(1 - axis)
        assert (changes.all(1 - axis) == along).all()
        (at,) = np.nonzero(along)
        assert len(at) == 2 and at[1] - at[0] == TILE or len(at) == 1 and at[0] == TILE - 1
    low = first & 255
    differ = low[:, 1:] ^ low[:, :-1]
    pairs = differ[..., 0].size
    assert is_chance((differ == 0).sum(), 4 * pairs / 256)
    for digit in range(8):
        assert (abs((differ >> digit & 1).sum((0, 1)) - pairs / 2) < 6 * np.sqrt(pairs) / 2).all()


@pytest.mark.parametrize("domain", [0, bluenoise._core.domain_child(3, 6)])
def test_copies_share_an_order_only_by_chance(domain):
    """There are 2^9 orders of 16 samples and 2^20 orders of 64 samples."""
    y, x = TILE * (np.mgrid[:192, :192] - 96)
    _, order = look(x, y, domain)
    for dy, dx in ((0, 1), (1, 0), (1, 1), (1, -1), (1, 2), (1, -2), (2, 1), (2, -1), (0, 2), (2, 0)):
        here, there = order[:192 - dy, max(-dx, 0):192 - max(dx, 0)], order[dy:, max(dx, 0):192 + min(dx, 0)]
        for count, orders in ((16, 2**9), (64, 2**20)):
            equal = (here[..., :count - 1] == there[..., :count - 1]).all(-1)
            assert is_chance(equal.sum(), equal.size / orders)


@pytest.mark.parametrize("family", range(3))
def test_copies_add_random_digits(family):
    """Each copy adds random digits to the first eight digits of every coordinate in every member. Over the copies, each random digit is
    uniform, and so is the sum of any two. For each of 25,000 sums, six deviations have a probability of 2e-9."""
    y, x = TILE * (np.mgrid[:64, :64] - 32)
    first = np.stack([look(x, y, bluenoise.domain(3, 4 * family + member), 1)[0] for member in range(4)], -2) >> 16
    signs = 1 - 2 * ((first ^ first[0, 0]).reshape(64 * 64, 16, 1) >> np.arange(8, dtype=np.uint32) & 1).astype(int).reshape(64 * 64, 128)
    sums = signs.T @ signs
    np.fill_diagonal(sums, signs.sum(0))
    assert abs(sums).max() < 6 * 64


@pytest.mark.parametrize("index", [0, 1, 2, 3, 5, 6, 11, 23, 47, 100, 200, 255])
def test_every_single_sample_is_blue(index):
    """A sample in the middle of an octave is as blue as the first, even across copies with different orders. The figure is the error for
    half-planes after a blur, relative to white noise. If each pixel had its own order, the figure would be 1."""
    y, x = np.mgrid[:128, :128]
    square = 0
    for f in range(12):
        angle, near = 2.4 * f + 0.1, 0.15 * np.sin(12 * f)  # the edge's distance from the centre
        a, b, c, mean = plane_at_angle(0.5 + near * np.cos(angle), 0.5 + near * np.sin(angle), angle)
        u = bluenoise.Sampler("blue", seed=SEED).sample(x, y, index, bluenoise._core.domain_child(11, f), pair=f // 2 % 2)
        error = (a * u[..., 0] + b * u[..., 1] < c) - mean
        error = ndimage.gaussian_filter(error, 2.1, truncate=7 / 2.1)[7:-7, 7:-7]
        square += (error**2).mean() / (mean * (1 - mean) * blur_gain(2.1)) / 12
    print(f"\nsample {index} alone: {np.sqrt(square):.3f} times white noise's error after a blur")
    assert np.sqrt(square) < 0.65
