# SPDX-License-Identifier: Apache-2.0
"""Compares the error measures used in tables and reports with known values."""

import math

import numpy as np
import pytest

from evidence.measure.image_error import blurred, displayed_rmse, own_errors, relative_rmse, rmse


def test_pixels_are_clipped_before_the_blur():
    """A blurred checkerboard of 0 and 2 has a mean of 1, but displays clip it to a mean of 0.5 first."""
    y, x = np.mgrid[0:32, 0:32]
    image = np.repeat(2.0 * ((x + y) % 2)[..., None], 3, axis=2)
    assert displayed_rmse(image, np.full_like(image, 0.5), 0.0, 2.1) < 0.01
    assert displayed_rmse(image, np.full_like(image, 0.5), -1.0, 2.1) == pytest.approx(0.25, abs=1e-3)  # nothing to clip
    assert rmse(image, np.full_like(image, 0.5), 2.1) == pytest.approx(0.5, abs=1e-3)


def test_relative_rmse_divides_by_the_reference_plus_a_tenth_of_its_mean():
    """For a reference of 0 and 2, errors of 0.2 and 0.42 are divided by 0.1 and 2.1."""
    assert relative_rmse(np.array([[0.2, 2.42]]), np.array([[0.0, 2.0]])) == pytest.approx(math.sqrt((2**2 + 0.2**2) / 2))


def test_error_of_a_reference_is_estimated_from_its_halves():
    """The mean of two halves with independent errors of 1 has an error of sqrt(1/2)."""
    truth = np.full((128, 128, 3), 5.0)
    halves = truth + np.random.default_rng(1).standard_normal((2, 128, 128, 3))
    found = own_errors(halves.mean(0), halves[0])
    # For 49152 numbers, five relative standard errors are 1.6%.
    assert found["rmse"] == pytest.approx(math.sqrt(0.5), rel=0.016)


@pytest.mark.parametrize("mode, pad", [("reflect", "symmetric"), ("wrap", "wrap")])
def test_blur_pads_the_image_at_its_edges(mode, pad):
    """A blur matches the blur of a padded image. Images are padded by mirroring, and tiles by wrapping around."""
    image = np.random.default_rng(1).standard_normal((24, 30, 3))
    whole = blurred(np.pad(image, ((12, 12), (12, 12), (0, 0)), pad), 2.1)[12:-12, 12:-12]
    np.testing.assert_allclose(blurred(image, 2.1, mode), whole, rtol=0, atol=1e-12)
