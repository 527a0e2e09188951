# SPDX-License-Identifier: Apache-2.0
"""Tests that BLUE's error falls with nearly every sample. After a blur (sigma = 2.1), the mean error rises by less than 15% from n to
n + 1 samples, for n = 1 to 63. Integrands are half-planes, discs, and products over a domain's pairs and over two members of a family. If
each pixel had its own sample order, half-plane errors would rise by a third to a half from 2 to 3, 4 to 5 and 8 to 9 samples. Everything
is seeded."""

import numpy as np
import pytest
from conftest import plane_at_angle, well_spread

import bluenoise

ndimage = pytest.importorskip("scipy.ndimage")

SIZE, COUNTS, PARENTS, MEMBERS, INTEGRANDS = 64, 64, 2, 4, 12
SAMPLES = {}  # samples (height, width, count, 4) by parent and member, across two blocks of 32 x 32 pixels in each direction


def samples(parent, member):
    if (parent, member) not in SAMPLES:
        domain = bluenoise.domain(parent, member)
        SAMPLES[parent, member] = bluenoise.Sampler("blue", seed=41).block(0, 0, SIZE, SIZE, 0, COUNTS, domain)
    return SAMPLES[parent, member]


def shape(number, disc=False):
    """Returns a half-plane or disc at a well-spread point, as a function of x and y, and its mean."""
    u, v = well_spread(number)
    if disc:
        r = 0.1 + 0.35 * (0.618033988749895 * number % 1)
        x0, y0 = r + (1 - 2 * r) * u, r + (1 - 2 * r) * v
        return lambda x, y: (x - x0) ** 2 + (y - y0) ** 2 < r * r, np.pi * r * r
    a, b, c, mean = plane_at_angle(u, v, 2.3999632297286533 * (number + 0.3))
    return lambda x, y: a * x + b * y < c, mean


@pytest.mark.parametrize("what", ["half-planes", "discs", "products of pairs", "products of members"])
def test_the_error_falls_with_nearly_every_sample(what):
    rmse = np.zeros(COUNTS)
    for run in range(PARENTS * MEMBERS * INTEGRANDS):
        parent, member, k = run // (MEMBERS * INTEGRANDS), run // INTEGRANDS % MEMBERS, run % INTEGRANDS
        u = samples(parent, member)
        inside, mean = shape(run, what == "discs")
        first = 0 if what == "products of pairs" else k % 2 * 2
        values = inside(u[..., first], u[..., first + 1])
        if what.startswith("products"):
            other = samples(parent, (member + 1) % MEMBERS) if what.endswith("members") else u
            second = 2 if what.endswith("pairs") else k // 2 % 2 * 2
            inside, factor = shape(run + 997)
            values, mean = values & inside(other[..., second], other[..., second + 1]), mean * factor
        error = values.cumsum(axis=2) / np.arange(1, COUNTS + 1) - mean
        error = ndimage.gaussian_filter(error.astype(np.float32), (2.1, 2.1, 0), mode="wrap", truncate=7 / 2.1)
        rmse += np.sqrt((error**2).mean((0, 1)))
    rise, at = (rmse[1:] / rmse[:-1]).max(), 1 + (rmse[1:] / rmse[:-1]).argmax()
    print(f"\n{what}: largest rise {100 * (rise - 1):.1f}%, from {at} to {at + 1} samples")
    assert rise < 1.15


@pytest.mark.parametrize("count", [1, 4, 16])
def test_zorder_improves_only_at_its_sample_count(count):
    """After a blur, ZORDER has the same error as padded Sobol' if it stops before its sample count, and half the error at that count."""
    def error(sampler):
        squares = []
        for run in range(24):
            inside, mean = shape(run)
            u = sampler.block(0, 0, 2 * SIZE, 2 * SIZE, 0, count, bluenoise.domain(run // 4), dims=2)
            squares.append((ndimage.gaussian_filter(inside(u[..., 0], u[..., 1]).mean(2) - mean, 2.1, mode="wrap") ** 2).mean())
        return np.sqrt(np.mean(squares))

    padded = error(bluenoise.Sampler("sobol", seed=41))
    stopped, tuned = (error(bluenoise.Sampler("zorder", seed=41, samples_per_pixel=spp)) / padded for spp in (64, count))
    print(f"\n{count} samples, error over padded Sobol': tuned for 64 {stopped:.2f}, for {count} {tuned:.2f}")
    assert 0.9 < stopped < 1.1 and tuned < 0.65
