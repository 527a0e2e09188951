# SPDX-License-Identifier: Apache-2.0
"""Compares the losses with their definitions and with the library, and tests ranks()."""

import numpy as np
import pytest
import torch
from bn_trainer.losses import Direction, DitheringError, VectorEnergy, ranks

import bluenoise


def uniform(shape, seed, make=None, **options):
    white = np.random.default_rng(seed).permutation(shape[0] * shape[1]).reshape(shape)
    made = make(shape, seed=seed, **options) if make else white
    return made, (made.astype(np.float64) + 0.5) / (shape[0] * shape[1])


def error(values, *sigmas):
    return DitheringError(*values.shape, list(sigmas))(torch.from_numpy(values)[None])[:, 0].tolist()


@pytest.mark.parametrize("make", [None, bluenoise.void_and_cluster])
def test_error_matches_the_library(make):
    made, values = uniform((64, 64), 5, make)
    figures = bluenoise.measure(made)
    # The library uses 64 levels, and the loss uses all levels.
    for sigma, closed in zip((1.0, 1.5, 2.0), error(values, 1.0, 1.5, 2.0)):
        assert closed**0.5 == pytest.approx(figures.dithering_error[sigma], rel=0.02)


def test_batched_errors_match_single_errors():
    sigmas, images = (1.5, 0.75, 1.0), [uniform((20, 28), seed, bluenoise.void_and_cluster)[1] for seed in (1, 2)]
    # Training also uses float32.
    both = DitheringError(20, 28, list(sigmas))(torch.from_numpy(np.stack(images)).float())
    assert both.shape == (3, 2)
    alone = [[error(values, sigma)[0] for values in images] for sigma in sigmas]
    np.testing.assert_allclose(both.numpy(), alone, rtol=1e-3)


def test_energy_matches_brute_force():
    height, width = 13, 14
    values = torch.rand(1, 2, height, width, dtype=torch.float64, generator=torch.Generator().manual_seed(1))
    flat, place = values[0].reshape(2, -1).numpy(), np.indices((height, width)).reshape(2, -1)
    way = abs(place[:, :, None] - place[:, None])
    square = (np.minimum(way, np.array([height, width])[:, None, None] - way) ** 2).sum(0)
    weights = np.where((square > 0) & (square <= 36), np.exp(-square / 4), 0)
    energy = np.average(np.exp(-np.hypot(*(flat[:, :, None] - flat[:, None]))), weights=weights)
    assert VectorEnergy()(values).tolist() == pytest.approx([energy], rel=1e-9)


def test_energy_is_lower_for_better_vector_masks():
    white = np.stack([uniform((64, 64), seed)[1] for seed in (1, 2)])
    blue = np.stack([uniform((64, 64), seed, bluenoise.void_and_cluster)[1] for seed in (1, 2)])
    _, joint = uniform((64, 64), 1, bluenoise.anneal, channels=2, sweeps=20)
    energies = VectorEnergy()(torch.from_numpy(np.stack([white, blue, joint]))).tolist()
    assert energies[0] == pytest.approx(0.612, abs=0.005)
    # Channels generated together have lower energy than channels that are blue only separately.
    assert energies[0] - 0.01 > energies[1] > energies[2] + 0.003


def direction(masks):
    """The definition: for eight rings, how far the power near the axes differs from the power near the diagonals, above a tolerance."""
    power = np.mean(np.abs(np.fft.fft2(masks - 0.5)) ** 2, axis=0)
    f = np.fft.fftfreq(masks.shape[1])
    radius, angle = np.hypot(f[:, None], f), np.degrees(np.arctan2(*np.abs(np.meshgrid(f, f, indexing="ij"))))
    axis, parts = np.minimum(angle, 90 - angle) < 22.5, []
    for low in 0.25 + np.arange(8) / 32:
        ring = (radius >= low) & (radius < low + 1 / 32)
        a, d = power[ring & axis].mean(), power[ring & ~axis].mean()
        parts.append(max(abs(a - d) / (a + d) - 0.1, 0) ** 2)
    return np.mean(parts)


def test_direction_loss_matches_its_definition():
    white = np.random.default_rng(3).random((2, 64, 64))
    rings, f = [], np.fft.fftfreq(64)
    for low in np.arange(8) / 32 + 0.25:  # add power along the rows, in one ring at a time
        ring = (abs(f[:, None]) < 0.05) & (np.hypot(f[:, None], f) >= low) & (np.hypot(f[:, None], f) < low + 1 / 32)
        masks = 0.5 + np.fft.ifft2(np.fft.fft2(white - 0.5) * np.where(ring, 4, 1)).real
        rings.append(float(Direction(64)(torch.from_numpy(masks).float())))
        assert rings[-1] == pytest.approx(direction(masks), rel=1e-3)
    assert min(rings) > 4 * float(Direction(64)(torch.from_numpy(white).float()))
    blue = np.stack([uniform((64, 64), seed, bluenoise.void_and_cluster)[1] for seed in range(4)])
    assert float(Direction(64)(torch.from_numpy(blue).float())) < 0.01


def test_ranks_are_exact_and_ties_keep_their_order():
    values = torch.randint(0, 40, (2, 2, 9, 11), generator=torch.Generator().manual_seed(2)).float()
    made = ranks(values)
    assert made.shape == values.shape and made.dtype == values.dtype
    for image, found in zip(values.reshape(4, -1).numpy(), made.reshape(4, -1).numpy()):
        np.testing.assert_allclose(found[np.argsort(image, kind="stable")], (np.arange(99) + 0.5) / 99, atol=1e-7)
