# SPDX-License-Identifier: Apache-2.0
"""Tests BLUE's errors across copies of the tile (64 x 64 pixels): the mean error of a whole image, and the correlation between errors 64
pixels apart. Everything is seeded. Run with -s to print all figures."""

import numpy as np
import pytest
from conftest import plane_at_angle

import bluenoise

# Products of half-planes: (factor, integrand k) -> (family, member, pair).
WHATS = {
    "one pair": lambda i, k: (0, k % 4, k % 2),
    "both pairs": lambda i, k: (0, k % 4, (k + i) % 2),
    "two members": lambda i, k: (0, (k + i) % 4, (k + i) % 2),
    "three members": lambda i, k: (0, (k + i) % 4, (k + i) % 2),
    "two families": lambda i, k: (i * (1 + k % 3), (k // 2 if i else k) % 4, (k + i) % 2),
    "a single number": lambda i, k: (0, k % 4, k % 2),
}
FACTORS = {"one pair": 1, "three members": 3, "a single number": 1}


def half_plane(random, single):
    """A random half-plane a x + b y < c, and its mean over the unit square."""
    angle, x, y = 2 * np.pi * random.random(), *random.random(2)
    return (1.0, 0.0, x, x) if single else plane_at_angle(x, y, angle)


def errors(what, k, size, count, seed):
    """Returns each pixel's sum of samples minus the expected sum, and the variance of the image's total for white noise."""
    random, mean = np.random.default_rng([k, len(what)]), 1.0
    y, x, index = np.ogrid[:size, :size, :count]
    inside = True
    for i in range(FACTORS.get(what, 2)):
        a, b, c, share = half_plane(random, what == "a single number")
        family, member, pair = WHATS[what](i, k)
        domain = bluenoise.domain(1, 4 * (k + family) + member)
        u = bluenoise.Sampler("blue", seed=seed).sample(x, y, index, domain, pair=pair)
        inside, mean = inside & (a * u[..., 0] + b * u[..., 1] < c), mean * share
    return inside.sum(2) - count * mean, size**2 * count * mean * (1 - mean)


@pytest.mark.parametrize("what", WHATS)
@pytest.mark.parametrize(("size", "count", "integrands"), [(64, 1, 96), (256, 1, 32), (256, 16, 12), (1024, 1, 12)])
def test_image_means_have_lower_errors_than_white_noise(what, size, count, integrands):
    """The RMS error of an image's mean over many integrands, relative to white noise. If every copy of the tile had the same digits,
    products over two members would have an error of 12.8 at 1024 x 1024."""
    found = [errors(what, k, size, count, 5) for k in range(integrands)]
    ratio = np.sqrt(np.mean([error.sum() ** 2 / variance for error, variance in found]))
    print(f"\n{what}, {size} x {size} pixels, {count} samples: {ratio:.3f}")
    assert ratio < 1


@pytest.mark.parametrize("what", WHATS)
def test_errors_64_pixels_apart_are_not_correlated(what):
    products = squares = 0
    for k in range(100, 124):
        error, _ = errors(what, k, 512, 1, 6)
        here = error[:-64, :-64]
        products += (here * (error[:-64, 64:] + error[64:, :-64])).sum()
        squares += 2 * (here**2).sum()
    print(f"\n{what}, correlation: {products / squares:.4f}")
    assert abs(products / squares) < 0.05
