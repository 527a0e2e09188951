# SPDX-License-Identifier: Apache-2.0
"""Sampler.qmc() is a SciPy engine whose points are the samples of one pixel."""

import numpy as np
import pytest

from bluenoise import Sampler, domain

qmc, integrate = (pytest.importorskip(f"scipy.{name}") for name in ("stats.qmc", "integrate"))


def test_points_match_a_pixels_samples():
    sampler = Sampler("blue", seed=4)
    engine = sampler.qmc(6, pixel=(3, -2))
    assert isinstance(engine, qmc.QMCEngine) and engine.d == 6
    points = engine.random(10)
    assert points.shape == (10, 6) and points.dtype == np.float64
    index = np.arange(10)
    truncated = np.floor(points * 2**24) / 2**24
    np.testing.assert_array_equal(truncated[:, :4], sampler.sample(3, -2, index, domain(0)))
    np.testing.assert_array_equal(truncated[:, 4:], sampler.sample(3, -2, index, domain(1), 2))


def test_points_continue_reset_and_skip():
    engine = Sampler(seed=1).qmc(3)
    whole = engine.random(16)
    np.testing.assert_array_equal(engine.reset().random(16), whole)
    engine.reset()
    np.testing.assert_array_equal(np.concatenate([engine.random(5), engine.random(11)]), whole)
    np.testing.assert_array_equal(engine.reset().fast_forward(7).random(9), whole[7:])
    assert engine.random(0).shape == (0, 3)


def test_scipy_integrates_with_independent_samplers():
    found = [integrate.qmc_quad(lambda x: x[0] * x[1], [0, 0], [1, 2], n_estimates=6, n_points=256, qrng=Sampler(seed=seed).qmc(2))
             for seed in (1, 1, 2)]
    assert found[0] == found[1] != found[2]
    assert all(0 < each.standard_error < 1e-3 and abs(each.integral - 1) < 6 * each.standard_error for each in found)


def test_qmc_quad_keeps_the_sampler_and_repeats_after_a_reset():
    sampler = Sampler("zorder", seed=3, samples_per_pixel=16)
    engine = sampler.qmc(2, pixel=(5, 1))
    child = type(engine)(**engine._init_quad, seed=7)
    expected = Sampler("zorder", seed=7, samples_per_pixel=16).qmc(2, pixel=(5, 1))
    np.testing.assert_array_equal(child.random(16), expected.random(16))
    first, again = (integrate.qmc_quad(lambda x: x[0] * x[1], [0, 0], [1, 1], n_points=16, qrng=engine.reset()) for _ in range(2))
    assert first == again


def test_integrals_are_unbiased():
    """Truncation to 24 bits would cause a bias of 6e-8, which is 200 standard errors for this integrand and 2^16 points."""
    found = integrate.qmc_quad(lambda x: np.exp(x.sum(0)), [0, 0], [1, 1], n_points=2**16, n_estimates=8, qrng=Sampler(seed=1).qmc(2))
    assert abs(found.integral - (np.e - 1) ** 2) < 6 * found.standard_error < 1e-7
    assert (abs(Sampler(seed=2).qmc(4).random(2**16).mean(0) - 0.5) < 1e-9).all()


def test_last_index_and_bad_arguments():
    engine = Sampler().qmc(1).fast_forward(2**32 - 1)
    assert engine.random(1).shape == (1, 1)
    with pytest.raises(ValueError, match="n .* 1"):
        engine.random(1)
    with pytest.raises(ValueError, match="d .* 0"):
        Sampler().qmc(0)
    with pytest.raises(TypeError, match=r"d .* 2\.0"):
        Sampler().qmc(2.0)
    with pytest.raises(ValueError, match="pixel"):
        Sampler().qmc(2, pixel=3)


def test_repr_shows_the_sampler_and_index():
    engine = Sampler("sobol", seed=3).qmc(5, pixel=(-1, 2)).fast_forward(7)
    assert repr(engine) == "<Sampler('sobol', seed=3).qmc(5, pixel=(-1, 2)) at index 7>"
