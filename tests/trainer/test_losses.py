# SPDX-License-Identifier: Apache-2.0
"""The closed form of the loss against its definition and the library, and its gradients."""

import bluenoise
import numpy as np
import pytest
import torch

from bn_trainer.losses import DitheringError, rank_and_ramp


def uniform(shape, seed, method="white"):
    ranks = bluenoise.mask(shape, method=method, seed=seed)
    return ranks, (ranks.astype(np.float64) + 0.5) / ranks.size


def by_definition(values, sigma, levels=256):
    """E_sigma^2: blurred thresholded mask minus the level, squared, averaged over texels and levels."""
    fy, fx = np.fft.fftfreq(values.shape[0]), np.fft.fftfreq(values.shape[1])
    blur = np.exp(-2 * np.pi**2 * sigma**2 * (fy[:, None] ** 2 + fx[None, :] ** 2))
    total = 0.0
    for level in (np.arange(levels) + 0.5) / levels:
        pattern = np.fft.fft2((values < level).astype(float))
        total += ((np.fft.ifft2(blur * pattern).real - level) ** 2).mean()
    return total / levels


@pytest.mark.parametrize("shape", [(24, 24), (17, 20), (16, 9)])
@pytest.mark.parametrize("sigma", [0.75, 1.0, 1.5])
def test_closed_form_is_the_definition(shape, sigma):
    _, values = uniform(shape, 3)
    closed = float(DitheringError(*shape, [sigma], [1.0])(torch.from_numpy(values)[None]))
    # What is left: the closed form takes all levels, the definition 256; small tori feel it most.
    assert closed == pytest.approx(by_definition(values, sigma), rel=1e-2)


@pytest.mark.parametrize("method", ["white", "void-and-cluster"])
def test_the_library_is_the_referee(method):
    ranks, values = uniform((64, 64), 5, method)
    figures = bluenoise.measure(ranks)
    for sigma in (1.0, 1.5, 2.0):
        closed = float(DitheringError(64, 64, [sigma], [1.0])(torch.from_numpy(values)[None])) ** 0.5
        # 64 levels against all of them.
        assert closed == pytest.approx(figures[f"e_{sigma:g}"], rel=0.02)


def test_a_mixture_is_the_sum_of_its_parts():
    _, values = uniform((20, 28), 1)
    image = torch.from_numpy(values)[None]
    parts = [float(DitheringError(20, 28, [sigma], [1.0])(image)) for sigma in (1.0, 1.5)]
    both = float(DitheringError(20, 28, [1.0, 1.5], [0.3, 0.7])(image))
    assert both == pytest.approx(0.3 * parts[0] + 0.7 * parts[1], rel=1e-4)


@pytest.mark.parametrize("shape", [(8, 8), (5, 12)])
def test_gradient_of_the_error(shape):
    values = torch.rand(2, *shape, dtype=torch.float64, generator=torch.Generator().manual_seed(1), requires_grad=True)
    assert torch.autograd.gradcheck(DitheringError(*shape, [1.0, 1.5], [0.5, 0.5]), (values,))


def test_ranks_are_exact_and_only_differences_have_a_gradient():
    values = torch.rand(1, 32, 32, dtype=torch.float64, generator=torch.Generator().manual_seed(2), requires_grad=True)
    ranks, _ = rank_and_ramp(values)
    expected = (values.detach().reshape(-1).argsort().argsort() + 0.5) / 1024
    assert torch.equal(ranks.detach().reshape(-1), expected)
    # A gradient that depends on the rank alone is one of a monotone change, which changes no rank. Near the ends
    # the moving average is one of fewer values.
    (gradient,) = torch.autograd.grad((ranks**2).sum(), values)
    middle = (ranks > 0.1) & (ranks < 0.9)
    assert gradient[middle].abs().max() < 0.02 * 2
    noise = torch.randn(ranks.shape, dtype=torch.float64, generator=torch.Generator().manual_seed(3))
    ranks, _ = rank_and_ramp(values)
    (gradient,) = torch.autograd.grad((ranks * noise).sum(), values)
    assert torch.corrcoef(torch.stack([gradient.reshape(-1), noise.reshape(-1)]))[0, 1] > 0.95


def test_the_ramp_term_is_least_for_uniform_values():
    _, values = uniform((32, 32), 1)
    image = torch.from_numpy(values)[None]
    assert float(rank_and_ramp(image)[1]) < 1e-12
    assert float(rank_and_ramp(0.5 + 0.8 * (image - 0.5))[1]) > 1e-3
