# SPDX-License-Identifier: Apache-2.0
"""The measures that tables and reports are made of, against what is known of them without code."""

import math

import numpy as np
import pytest
from report.image_error import blurred, error_image, luminance_error, radial_spectrum, rmse, spectrum_image


def noise(shape, seed=1):
    return np.random.default_rng(seed).standard_normal(shape)


def test_rmse_is_the_root_mean_square_over_pixels_and_channels():
    reference = noise((5, 4, 3))
    image = reference.copy()
    image[2, 1, 0] += 3
    image[0, 3, 2] -= 4
    assert rmse(image, reference) == pytest.approx(5 / math.sqrt(60))
    assert rmse(reference, reference, 2.1) == 0


@pytest.mark.parametrize("edge", ["mirror", "toroidal"])
@pytest.mark.parametrize("sigma", [0.5, 1.0, 2.1])
def test_a_constant_error_survives_every_blur(sigma, edge):
    reference = noise((9, 14, 3))
    assert rmse(reference + 0.25, reference, sigma, edge) == pytest.approx(0.25)


def test_blur_of_a_point_is_a_gaussian():
    image = np.zeros((41, 41))
    image[20, 20] = 1
    y, x = np.mgrid[-20:21, -20:21]
    expected = np.exp(-(x * x + y * y) / (2 * 2.1**2))
    # The tails beyond four sigma are cut off: a share of 6e-5 in each direction.
    np.testing.assert_allclose(blurred(image, 2.1), expected / expected.sum(), atol=1e-5)


def test_edges():
    image = np.zeros((32, 32))
    image[0, 7] = 1
    mirrored, wrapped = blurred(image, 1.0), blurred(image, 1.0, "toroidal")
    assert mirrored[-1, 7] == 0 and wrapped[-1, 7] == pytest.approx(wrapped[1, 7])
    assert mirrored.sum() == pytest.approx(1) and wrapped.sum() == pytest.approx(1)
    # The point is repeated on the other side of the border, one pixel away.
    np.testing.assert_allclose(mirrored[0, 7], wrapped[0, 7] + wrapped[1, 7])


@pytest.mark.parametrize("sigma, expected", [(1.0, 1 / (2 * math.sqrt(math.pi))),
                                             (2.1, 1 / (2 * 2.1 * math.sqrt(math.pi)))])
def test_white_noise_falls_by_the_norm_of_the_gaussian(sigma, expected):
    # 2^18 texels, blur correlates about 30 of them: a relative standard error of 0.8 %, five of which are given.
    error = noise((512, 512))
    assert rmse(error, 0 * error, sigma, "toroidal") == pytest.approx(expected, rel=0.04)


def test_channels_are_blurred_apart():
    image = np.zeros((16, 16, 3))
    image[8, 8, 1] = 1
    result = blurred(image, 1.0)
    assert result[..., 0].max() == 0 and result[..., 2].max() == 0
    np.testing.assert_array_equal(result[..., 1], blurred(image[..., 1], 1.0))


def test_error_image_is_grey_where_there_is_no_error():
    error = np.array([[0.0, 1.0, -1.0, 9.0, -9.0, 0.5]])
    np.testing.assert_array_equal(error_image(error, 1.0), [[128, 255, 0, 255, 0, 191]])


def test_luminance_of_grey_is_grey():
    reference = np.zeros((2, 3, 3))
    np.testing.assert_allclose(luminance_error(reference + 0.5, reference), np.full((2, 3), 0.5))


def test_spectrum_of_white_noise_is_its_variance():
    frequency, power = radial_spectrum(3 * noise((256, 256)))
    assert np.all(np.diff(frequency) > 0) and 0 < frequency[0] and frequency[-1] < 0.5
    # Rings beyond the first few hold hundreds of bins; five standard errors of the smallest taken are 0.35.
    np.testing.assert_allclose(power[4:], 9, rtol=0.35)
    assert power.mean() == pytest.approx(9, rel=0.05)


def test_spectrum_finds_a_wave_where_it_is():
    y, x = np.mgrid[0:128, 0:128]
    frequency, power = radial_spectrum(np.sin(2 * np.pi * 0.3 * x) + 0 * y)
    assert frequency[np.argmax(power)] == pytest.approx(0.3, abs=1 / 64)


@pytest.mark.parametrize("image, reference", [(np.zeros((3, 4)), np.zeros((4, 3))), (np.zeros(5), np.zeros(5)),
                                              (np.zeros((0, 4)), np.zeros((0, 4)))])
def test_wrong_shapes_are_refused(image, reference):
    with pytest.raises(ValueError):
        rmse(image, reference)


def test_wrong_arguments_are_refused():
    image = np.zeros((4, 4))
    with pytest.raises(ValueError):
        rmse(image, image, -1)
    with pytest.raises(ValueError):
        rmse(image, image, float("nan"))
    with pytest.raises(ValueError):
        rmse(image, image, 1, "clamp")
    with pytest.raises(ValueError):
        error_image(image, 0)


def test_spectrum_image_is_dark_where_there_is_no_power():
    error = noise((96, 128))
    image = spectrum_image(error - blurred(error, 2.0, "toroidal"), 1.0)
    assert image.shape == error.shape and image.dtype == np.uint8
    # The middle has lost its low frequencies, the corner has kept what it had: three quarters of the way up.
    assert image[46:51, 62:67].max() < 100 and abs(float(image[:8, :8].mean()) - 0.75 * 255) < 12
    with pytest.raises(ValueError):
        spectrum_image(error, 0)
