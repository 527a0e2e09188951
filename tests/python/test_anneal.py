# SPDX-License-Identifier: Apache-2.0
"""Annealing ends in a local minimum of its energy, and vector masks are blue in every direction."""

import numpy as np
import pytest
from reference import white

import bluenoise


@pytest.mark.parametrize(("seed", "shape"), list(enumerate([(8, 8), (10, 6), (7, 9), (16, 4), (5, 5)])))
def test_cold_annealing_reaches_a_local_minimum(seed, shape):
    """After annealing to almost zero temperature, none of the swaps that annealing tries reduces the energy. The test uses exact integer
    arithmetic on tori so small that the Gaussian window wraps around. A pair's weight is the sum of both Gaussians at the toroidal
    distance. Each texel's weights are scaled to a sum of 32,000 and rounded; a pair exactly half an extent apart has weight 0."""
    options = bluenoise._core.AnnealOptions()
    ranks = bluenoise.anneal(shape, seed=seed, sweeps=4000, start_temperature=1e-2, end_temperature=1e-12, order_ends=False)
    r, count = ranks.ravel().astype(np.int64), ranks.size
    place = np.stack(np.unravel_index(np.arange(count), shape))
    way = abs(place[:, :, None] - place[:, None])
    extent = np.array(shape)[:, None, None]
    way = np.minimum(way, extent - way)
    square = (way**2).sum(0)
    weight = np.exp(-square / (4 * options.sigma**2)) / options.sigma**2
    weight += options.far_weight * np.exp(-square / (4 * options.far_sigma**2)) / options.far_sigma**2
    weight[~((2 * way < extent) & (way <= 7)).all(0) | (square == 0)] = 0
    weight = np.floor(weight * 32000 / weight[0].sum() + 0.5).astype(np.int64)
    tried = ((way <= 3).all(0) | (abs(r[:, None] - r) <= count // 32 + 1)) & (square > 0)
    for i, j in np.argwhere(tried):
        others = np.setdiff1d(np.arange(count), (i, j))
        assert ((weight[i] - weight[j]) * (abs(r[j] - r) - abs(r[i] - r)))[others].sum() <= 0


@pytest.mark.parametrize("channels", [2, 4])
def test_vector_masks_reduce_the_half_plane_error(channels):
    """Measures the error of half-plane patterns after a Gaussian blur, averaged over directions of the last two channels and over all
    offsets. For one direction, the average over offsets is the mask error of the ranks along that direction."""
    def error(vectors):
        found = []
        for angle in np.pi * np.arange(12) / 12 + 0.1:
            values = np.cos(angle) * vectors[-2] + np.sin(angle) * vectors[-1]
            order = np.argsort(np.argsort(values.astype(np.float32), axis=None, kind="stable")).astype(np.uint32).reshape(values.shape)
            found.append(bluenoise._core.mask_error(order, 1.0))
        return np.sqrt(np.mean(np.square(found)))

    start = np.stack([white((32, 32), seed) for seed in range(1, channels + 1)])
    assert error(bluenoise.anneal((32, 32), channels=channels, sweeps=150, start_from_ranks=start)) < 0.62 * error(start)
