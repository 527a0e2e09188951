# SPDX-License-Identifier: Apache-2.0
"""Radiance against what is known without rendering, and samplers against each other.

Statistical tests use fixed seeds, so they fail always or never on one machine; the rates stated are the
chances of a false alarm had the seeds been drawn anew.
"""

import numpy as np
import pytest
from scipy import stats

SEEDS = 12


def block_means(image, blocks=4):
    """Means of blocks x blocks equal parts of the picture, all channels: (blocks * blocks,)."""
    h, w, _ = image.shape
    parts = image.astype(np.float64).reshape(blocks, h // blocks, blocks, w // blocks, 3)
    return parts.mean(axis=(1, 3, 4)).ravel()


@pytest.mark.parametrize("depth", [0, 1, 2, 8, 40])
def test_furnace(pathtracer, depth):
    """Walls that emit 1/2 and reflect 1/2: n bounces see 1 - 2^-(n + 1) everywhere. The image mean over
    seeds passes a t-test with a false-alarm rate of 0.1 % for each depth."""
    expected = 1 - 0.5 ** (depth + 1)
    common = ["--scene", "furnace", "--size", "32x32", "--spp", 32, "--max-depth", depth]
    images = np.array([pathtracer.image(*common, "--seed", seed) for seed in range(SEEDS)])
    if depth == 0:
        assert (images == 0.5).all()
        return
    means = images.mean(axis=(1, 2, 3), dtype=np.float64)
    assert stats.ttest_1samp(means, expected).pvalue > 0.001
    assert abs(means.mean() / expected - 1) < 0.001
    # No corner, edge or wall is off: averages over 8 x 8 pixels and all seeds.
    blocks = np.mean([block_means(image) for image in images], axis=0)
    np.testing.assert_allclose(blocks, expected, rtol=0.01)


def irradiance_factor(points, normal, polygon):
    """Lambert's formula: irradiance at points from a polygon of radiance 1, wholly visible."""
    to_corner = polygon[None, :, :] - points[:, None, :]
    to_corner /= np.linalg.norm(to_corner, axis=2, keepdims=True)
    total = np.zeros(len(points))
    for i in range(len(polygon)):
        a, b = to_corner[:, i], to_corner[:, (i + 1) % len(polygon)]
        axis = np.cross(a, b)
        sine = np.linalg.norm(axis, axis=1)
        angle = np.arctan2(sine, np.einsum("ij,ij->i", a, b))
        total += angle / sine * (axis @ normal)
    return np.abs(total) / 2


def wall_radiance(size, axis, plane, normal, albedo, low, high):
    """Direct radiance of the pixels whose whole footprint lies on an unshadowed part of a wall of the
    Cornell box: `low` to `high` in the two other axes. Returns a mask and the radiance there."""
    eye = np.array([278.0, 273.0, -800.0])
    lamp = np.array([[213, 548.8, 227], [343, 548.8, 227], [343, 548.8, 332], [213, 548.8, 332.0]])
    sub = 4
    at = (np.arange(size * sub) + 0.5) / sub
    x, y = np.meshgrid(at, at)
    scale = 0.025 / 0.035 / size
    # The camera looks along +z with +y up, so that +x is to the left.
    direction = np.stack([-(x - size / 2) * scale, (size / 2 - y) * scale, np.ones_like(x)], axis=-1)
    t = (plane - eye[axis]) / direction[..., axis]
    points = eye + t[..., None] * direction
    others = [i for i in range(3) if i != axis]
    inside = (points[..., others] > low).all(axis=-1) & (points[..., others] < high).all(axis=-1)
    inside &= t > 0
    factor = irradiance_factor(points.reshape(-1, 3), np.array(normal), lamp).reshape(x.shape)
    factor = factor.reshape(size, sub, size, sub).mean(axis=(1, 3))
    mask = inside.reshape(size, sub, size, sub).all(axis=(1, 3))
    return mask, factor[mask, None] / np.pi * np.array(albedo) * np.array([17, 12, 4.0])


WALLS = {
    "back": (2, 559.2, (0, 0, -1), (0.725, 0.71, 0.68), (60, 360), (500, 540)),
    "right": (0, 0.0, (1, 0, 0), (0.14, 0.45, 0.091), (360, 60), (540, 500)),
}


@pytest.mark.parametrize("wall", WALLS)
def test_direct_light_is_analytic(pathtracer, wall):
    """One bounce on walls that see all of the lamp, against the closed form. t-tests of the means of the
    patch per channel over seeds, false-alarm rate 0.1 % for each wall."""
    size = 96
    mask, expected = wall_radiance(size, *WALLS[wall])
    assert mask.sum() > 100
    rows, columns = np.nonzero(mask)
    crop = [columns.min(), rows.min(), columns.max() + 1, rows.max() + 1]
    mask = mask[crop[1] : crop[3], crop[0] : crop[2]]
    common = ["--size", f"{size}x{size}", "--crop", ",".join(map(str, crop)), "--spp", 32]
    common += ["--max-depth", 1, "--sampler", "sobol"]
    images = np.array([pathtracer.image(*common, "--seed", seed)[mask] for seed in range(SEEDS)], dtype=np.float64)
    means = images.mean(axis=1)
    p_values = stats.ttest_1samp(means, expected.mean(axis=0)).pvalue
    assert np.nanmin(p_values) * np.size(p_values) > 0.001
    np.testing.assert_allclose(means.mean(axis=0), expected.mean(axis=0), rtol=0.002)
    # Pixel by pixel: the shape is right, not only the sum.
    noise = images.std(axis=0) / np.sqrt(SEEDS) + 1e-3 * expected
    assert (np.abs(images.mean(axis=0) - expected) < 6 * noise).all()
