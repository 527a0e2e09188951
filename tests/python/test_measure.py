# SPDX-License-Identifier: Apache-2.0
"""Spectra and errors of masks match the NumPy references."""

import numpy as np
import pytest
import reference
from helpers import progress_of
from reference import white

import bluenoise
from bluenoise import anisotropy, dithering_error, mask, measure, power_spectrum, radial_power

SIGMAS = (0.75, 1, 1.5, 2)


def test_measure_reports_the_dithering_errors():
    ranks = mask((17, 40), seed=2)
    assert measure(ranks).dithering_error == {sigma: dithering_error(ranks, sigma) for sigma in SIGMAS}


def test_low_frequency_matches_the_reference():
    ranks = mask((48, 64), seed=3)
    found = measure(ranks).low_frequency
    assert list(found) == sorted(found) and {1 / 16, 1 / 4, 1 / 2} <= set(found)
    for level, power in found.items():
        assert power == pytest.approx(reference.low_frequency(ranks, level), rel=1e-9)
    of_white = measure(white((128, 128), seed=1)).low_frequency
    assert all(0.8 < power < 1.2 for power in of_white.values())  # each is a mean over about 400 or more frequencies
    assert all(power < 0.5 for power in found.values())


@pytest.mark.parametrize("shape", [(1, 2), (5, 1), (8, 8), (11, 7), (10, 12), (9, 16), (24, 20)])
def test_spectra_and_errors_match_the_reference(shape):
    ranks = white(shape, seed=5)
    power = power_spectrum(ranks)
    np.testing.assert_allclose(power, reference.power_spectrum(ranks), rtol=1e-6, atol=1e-6)
    assert power[0, 0] == 0
    np.testing.assert_array_equal(power_spectrum(bluenoise.to_float(ranks)), power)
    for sigma in (0, 0.75, 1.5):
        assert dithering_error(ranks, sigma) == pytest.approx(reference.mask_error(ranks, sigma), abs=1e-9)


@pytest.mark.parametrize("shape", [(64, 64), (40, 17), (1, 30)])
def test_radial_power_matches_the_reference(shape):
    ranks = mask(shape, seed=6)
    frequency, radial = radial_power(ranks)
    assert frequency.dtype == radial.dtype == np.float64
    expected = reference.power_spectrum(ranks).ravel()
    rings = reference.rings(shape)
    np.testing.assert_allclose(frequency, np.array(sorted(rings)) / max(shape))
    np.testing.assert_allclose(
        radial, [expected[rings[ring]].mean() for ring in sorted(rings)], rtol=1e-4, atol=1e-5
    )


def test_anisotropy_matches_the_reference():
    masks = [mask((40, 32), seed=seed) for seed in range(4)]
    assert anisotropy(masks) == pytest.approx(reference.anisotropy(masks), abs=1e-4)
    assert anisotropy(np.stack(masks)) == anisotropy(masks)
    assert measure(masks[0]).anisotropy == pytest.approx(reference.anisotropy(masks[:1]), abs=1e-4)


def test_anisotropy_decreases_with_the_number_of_masks():
    masks = [white((64, 64), seed=seed) for seed in range(16)]
    assert -1.5 < anisotropy(masks[:1]) < 0.5
    assert -13.5 < anisotropy(masks) < -10.5
    keeps_horizontal = np.fft.fftfreq(64)[None, :] ** 2
    oriented = [np.fft.ifft2(np.fft.fft2(m.astype(float)) * keeps_horizontal).real for m in masks]
    assert anisotropy(oriented) > -3


def test_exact_requires_distinct_values():
    ranks = mask((32, 32), seed=1)
    figures = measure(ranks)
    assert figures.exact is True
    for same in (ranks.astype(np.int16), bluenoise.to_float(ranks), 4 * ranks + 2, ranks.tolist()):
        assert measure(same) == figures
    eight_bit = (ranks // 4).astype(np.uint8)
    coarse = measure(eight_bit)
    assert coarse.exact is False
    assert coarse.dithering_error[1] == pytest.approx(figures.dithering_error[1], rel=0.1)
    assert measure(np.zeros((8, 8))).exact is False


def test_anisotropy_of_a_tiny_mask_is_nan():
    figures = measure([[0, 1], [2, 3]])
    assert np.isnan(figures.anisotropy) and figures.exact
    assert np.isfinite(list(figures.dithering_error.values())).all()


def test_progress():
    _, fractions = progress_of(lambda progress: measure(mask((32, 32)), progress=progress), cancel_at=0.3)
    assert len(fractions) >= 5 and fractions.count(1) == 1


def test_rows_channels_and_volumes():
    row = mask((64,), seed=1)
    assert dithering_error(row) == dithering_error(row[None]) and measure(row).low_frequency == measure(row[None]).low_frequency
    np.testing.assert_array_equal(power_spectrum(row), power_spectrum(row[None]))
    for several in (bluenoise.anneal((24, 20), channels=3, sweeps=2), mask((3, 24, 20))):
        power = power_spectrum(several)
        assert power.shape == (3, 24, 20)
        frequency, radial = radial_power(several)
        for own, spectrum, mean in zip(several, power, radial):
            np.testing.assert_array_equal(spectrum, power_spectrum(own))
            np.testing.assert_array_equal((frequency, mean), radial_power(own))
    assert anisotropy(memoryview(np.stack([mask((16, 16))] * 2))) == anisotropy([mask((16, 16))] * 2)
