# SPDX-License-Identifier: Apache-2.0
"""The network follows its formula, gives the same results padded and toroidal, and commutes with shifts and symmetries."""

import math

import numpy as np
import pytest
import torch
from bn_trainer.model import MOST_SCALE, Relaxation, Step, wrap

CHANNELS = pytest.mark.parametrize("channels", [1, 2])


def network(channels, seed=1):
    model = Relaxation([4, 9, 2], channels)
    # The initial parameters are symmetric and could hide errors, so the tests use random ones.
    generator = torch.Generator().manual_seed(seed)
    model.load_vector(model.vector() + 0.3 * torch.randn(model.vector().shape, dtype=torch.float64, generator=generator))
    model.calibrate(rand(1, 1, 64, 64))
    return model


def rand(*shape, seed=0):
    """24-bit noise in float64, because the steps amplify rounding errors, which these tests should not depend on."""
    return torch.rand(*shape, generator=torch.Generator().manual_seed(seed)).double()


def same(a, b):
    assert a.shape == b.shape
    return float((a - b).abs().max()) < 1e-8


def step_by_hand(step, values):
    """Computes a step on a torus from its formula, one offset at a time."""
    half = math.isqrt(step.reach)
    offsets = [(y, x) for y in range(-half, half + 1) for x in range(-half, half + 1) if 0 < y * y + x * x <= step.reach]
    square = np.square(offsets).sum(1)
    inner = math.exp(min(max(step.inner, -1.5), 1.5))
    outer = inner * (1.2 + math.exp(min(max(step.outer, -2), 1.5)))
    weights = np.exp(-square / (2 * inner) ** 2) - float(step.surround) * np.exp(-square / (2 * outer) ** 2)
    weights *= min(math.exp(float(step.scale)), MOST_SCALE) / np.abs(weights).sum()
    sharpness = np.exp(np.clip(float(step.sharpness) + float(step.sharpness_slope) * (square - 1) / 10, -3, 3))
    made = float(step.keep) * values
    for (y, x), weight, sharp in zip(offsets, weights, sharpness):
        d = sharp * (values - np.roll(values, (-y, -x), (1, 2)))
        made += weight * d / np.maximum(np.linalg.norm(d, axis=0), 1)
    return made


@CHANNELS
@pytest.mark.parametrize(("reach", "scale"), [(1, 3.0), (5, 20.0), (25, 1e4)])
@pytest.mark.parametrize("beyond", [0, 1, -1])
def test_step_matches_the_formula(channels, reach, scale, beyond):
    step = Step(reach, sigma=0.8, scale=scale, keep=0.3).requires_grad_(False)
    generator = torch.Generator().manual_seed(reach)
    for parameter in (step.inner, step.outer, step.surround, step.sharpness, step.sharpness_slope):
        parameter.add_(0.5 * torch.randn((), generator=generator))
        if beyond and parameter is not step.surround:
            parameter.fill_(4.0 * beyond)  # outside the range to which a step clamps
    values = 4 * (rand(1, channels, 7, 6) - 0.5)
    made = step(wrap(values, step.margin))[0].numpy()
    np.testing.assert_allclose(made, step_by_hand(step, values[0].numpy()), atol=1e-9 * scale)


@CHANNELS
@pytest.mark.parametrize("shape", [(16, 16), (64, 64), (17, 31), (40, 24), (5, 3)])
def test_padding_once_matches_padding_at_every_step(channels, shape):
    model = network(channels)
    assert model.receptive_radius == 2 + 3 + 1
    noise = rand(2, 1, *shape)
    once = model(wrap(noise, model.receptive_radius))
    assert once.shape == (2, channels, *shape)
    assert same(once, model.torus(noise))


@CHANNELS
def test_receptive_radius_is_tight(channels):
    model = network(channels)
    # Differences this small are not clipped, so every step propagates them.
    noise, n = 0.5 + 1e-8 * rand(1, 1, 20, 20), 10
    changed = noise.clone()
    changed[0, 0, n, n] += 1e-8
    ys, xs = (model.torus(changed) - model.torus(noise)).abs().amax((0, 1)).nonzero().T
    assert (n - ys).max() == (ys - n).max() == (n - xs).max() == (xs - n).max() == model.receptive_radius


@CHANNELS
@pytest.mark.parametrize("change", [
    *(lambda t, shift=shift: t.roll(shift, (2, 3)) for shift in ((1, 0), (0, 7), (13, 5))),
    lambda t: t.flip(2), lambda t: t.flip(3), lambda t: t.transpose(2, 3)])
def test_network_commutes_with_shifts_and_symmetries(channels, change):
    """Tests shifts and generators of the eight symmetries."""
    model, noise = network(channels), rand(1, 1, 33, 20)
    assert same(model.torus(change(noise)), change(model.torus(noise)))


@CHANNELS
def test_all_parameters_are_in_the_vector(channels):
    model, other = network(channels), network(channels, seed=2)
    noise = rand(1, 1, 16, 16)
    vector = model.vector()
    assert vector.dtype == torch.float64 and vector.shape == model.spreads().shape
    other.load_vector(vector)
    other.gain.copy_(model.gain)
    assert torch.equal(other.vector(), vector) and torch.equal(other.torus(noise), model.torus(noise))
    # spreads() uses the same order.
    other.load_vector(vector + model.spreads())
    for step, before in zip(other.steps, model.steps):
        for name, spread in (("scale", 0.5), ("keep", 0.05), ("inner", 0.15), ("outer", 0.3), ("surround", 0.15),
                             ("sharpness", 0.3), ("sharpness_slope", 0.3)):
            assert torch.allclose(getattr(step, name), getattr(before, name) + spread, atol=1e-6), name


@CHANNELS
def test_calibrated_values_have_the_variance_of_uniform_values(channels):
    model = network(channels)
    for seed in (0, 7):
        assert float((model.torus(rand(4, 1, 64, 64, seed=seed)) - 0.5).square().mean()) == pytest.approx(1 / 12, rel=0.03)
    gain = float(model.gain)
    model.calibrate(rand(1, 1, 64, 64))
    assert float(model.gain) == gain
