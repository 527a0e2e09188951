# SPDX-License-Identifier: Apache-2.0
"""The phases of void-and-cluster, checked rank by rank with an independently computed Gaussian: the initial pattern is stable, its ranks
descend from the tightest cluster, each later rank fills the largest void, and the first and last ranks are evenly spread."""

import numpy as np
import pytest

import bluenoise

TIE = 1e-4  # the library breaks ties with noise of 2^-16 times the kernel's central value


def squares(shape):
    """Squared toroidal distances from the first texel."""
    y, x = (np.minimum(np.arange(extent), extent - np.arange(extent)) for extent in shape)
    return y[:, None] ** 2 + x[None, :] ** 2


def evenness(apart, texels, shape):
    """The smallest distance between two texels, relative to their mean spacing (the square root of the area per texel). The result is 1
    for a square grid and 1.07 for a triangular grid."""
    y, x = np.divmod(texels, shape[1])
    square = apart[y[:, None] - y, x[:, None] - x]
    return np.sqrt(square[np.triu_indices(len(texels), 1)].min() * len(texels) / apart.size)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(("shape", "sigma", "fraction"), [
    ((32, 32), 1.5, 0.1), ((32, 32), 1.5, 0.3), ((27, 37), 1.5, 0.2), ((24, 40), 1.9, 0.3)])
def test_phases(shape, sigma, fraction, seed):
    ranks = bluenoise.void_and_cluster(shape, sigma=sigma, initial_fraction=fraction, seed=seed)
    at, apart = np.argsort(ranks, axis=None), squares(shape)
    kernel = np.where(apart > np.ceil(10 / 3 * sigma) ** 2, 0, np.exp(-apart / (2 * sigma**2)))

    def around(texel):
        return np.roll(kernel, divmod(texel, shape[1]), (0, 1)).ravel()

    # The first and last texels are too far apart for this Gaussian, so other rules determine their order.
    initial = int(at.size * fraction)
    sparse = min(int(at.size * (0.45 / sigma) ** 2), initial)
    energy = np.zeros(at.size)
    for rank, texel in enumerate(at[:at.size - sparse]):
        if rank == initial:  # removing the tightest cluster leaves the largest void
            cluster = at[energy[at[:initial]].argmax()]
            assert ((energy - around(cluster))[at[initial:]] >= energy[cluster] - 1 - TIE).all()
        if rank >= initial:
            assert energy[texel] <= energy[at[rank:]].min() + TIE
        energy += around(texel)
        if sparse <= rank < initial:
            assert energy[texel] >= energy[at[:rank + 1]].max() - TIE
    for end in (at, at[::-1]):
        assert min(evenness(apart, end[:points], shape) for points in range(2, sparse + 1)) > 0.5
