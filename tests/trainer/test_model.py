# SPDX-License-Identifier: Apache-2.0
"""The network: padded and toroidal forms agree, it commutes with shifts and symmetries, gradients are right."""

import pytest
import torch

from bn_trainer.model import Relaxation, _Depthwise, orbit_map, wrap


def network(seed=1):
    torch.manual_seed(seed)
    model = Relaxation([4, 6, 8], [5, 7, 3])
    # Away from where it starts, so that nothing is right by symmetry of the start alone.
    with torch.no_grad():
        for parameter in model.parameters():
            parameter.add_(0.02 * torch.randn_like(parameter))
    return model.eval().requires_grad_(False)


def rand(*shape, seed=0):
    return torch.rand(*shape, generator=torch.Generator().manual_seed(seed))


@pytest.mark.parametrize("shape", [(16, 16), (64, 64), (17, 31), (40, 24)])
def test_padded_once_or_at_every_step(shape):
    model = network()
    assert model.receptive_radius == 2 + 3 + 1
    noise = rand(2, 1, *shape)
    once = model(wrap(noise, model.receptive_radius))
    assert once.shape == noise.shape
    assert torch.allclose(once, model.torus(noise)[-1], atol=1e-5)


def test_rolling_the_noise_rolls_the_values():
    model = network()
    noise = rand(1, 1, 33, 20)
    values = model.torus(noise)[-1]
    for shift in ((1, 0), (0, 7), (13, 5)):
        rolled = model.torus(noise.roll(shift, (2, 3)))[-1]
        assert torch.allclose(rolled, values.roll(shift, (2, 3)), atol=1e-5)


def test_the_eight_symmetries():
    model = network()
    noise = rand(1, 1, 24, 24)
    values = model.torus(noise)[-1]
    for change in (lambda t: t.flip(2), lambda t: t.flip(3), lambda t: t.transpose(2, 3)):
        assert torch.allclose(model.torus(change(noise))[-1], change(values), atol=1e-5)


def test_a_window_does_not_depend_on_what_is_beyond_the_radius():
    model = network()
    r = model.receptive_radius
    noise = rand(1, 1, 60, 50)
    whole = model(noise)
    part = model(noise[:, :, 10 : 10 + 20 + 2 * r, 5 : 5 + 16 + 2 * r])
    assert torch.allclose(part, whole[:, :, 10:30, 5:21], atol=1e-5)


def test_margins_wider_than_the_torus():
    noise = rand(1, 1, 5, 7)
    padded = wrap(noise, 18)
    ys, xs = (torch.arange(-18, 5 + 18) % 5), (torch.arange(-18, 7 + 18) % 7)
    assert torch.equal(padded, noise[:, :, ys][:, :, :, xs])


def test_gradients_of_the_symmetric_convolution():
    generator = torch.Generator().manual_seed(2)
    values = torch.rand(2, 3, 9, 10, dtype=torch.float64, generator=generator, requires_grad=True)
    taps = torch.rand(3, int(orbit_map(5).max()) + 1, dtype=torch.float64, generator=generator, requires_grad=True)
    assert torch.autograd.gradcheck(lambda v, t: _Depthwise.apply(v, t, orbit_map(5)), (values, taps))


def test_damping_leaves_values_and_fades_gradients():
    model = network().requires_grad_(True)
    noise = rand(1, 1, 16, 16)
    norms = []
    for damping in (1.0, 0.5):
        model.zero_grad()
        values = model.torus(noise, damping)[-1]
        (values**3).sum().backward()
        norms.append([step.taps.grad.norm() for step in model.steps])
        assert torch.allclose(values, model.torus(noise)[-1], atol=1e-5)
    for k, (full, faded) in enumerate(zip(*norms)):
        assert faded == pytest.approx(float(full) * 0.5 ** (2 - k), rel=1e-3)
