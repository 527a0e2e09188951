# SPDX-License-Identifier: Apache-2.0
"""Annealing: once it is cold, no swap reduces the energy, and vectors are blue in every direction."""

import numpy as np
import pytest
from referee import white

import bluenoise


@pytest.mark.parametrize(("seed", "shape"), list(enumerate([(8, 8), (10, 6), (7, 9), (16, 4), (5, 5)])))
def test_cold_annealing_reaches_a_local_minimum(seed, shape):
    """No swap of the type that annealing tries reduces the energy, which is summed anew for each swap. Tori have even, odd and narrow
    extents, so small that windows wrap around them. The test is exact. The weight of a pair of texels is the sum of both blurs' Gaussians
    over the shorter way around the torus, scaled to 32,000 over all pairs of a texel and rounded; it is 0 at exactly half an extent."""
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
    """Vector masks serve to sample half-planes. The test measures the error of half-plane patterns after a Gaussian blur, over
    directions of the last two channels and over offsets. The mask error of the ranks along a direction is its mean over all offsets."""
    def error(vectors):
        found = []
        for angle in np.pi * np.arange(12) / 12 + 0.1:
            values = np.cos(angle) * vectors[-2] + np.sin(angle) * vectors[-1]
            order = np.argsort(np.argsort(values.astype(np.float32), axis=None, kind="stable")).astype(np.uint32).reshape(values.shape)
            found.append(bluenoise._core.mask_error(order, 1.0))
        return np.sqrt(np.mean(np.square(found)))

    start = np.stack([white((32, 32), seed) for seed in range(1, channels + 1)])
    assert error(bluenoise.anneal((32, 32), channels=channels, sweeps=150, start_from_ranks=start)) < 0.62 * error(start)
