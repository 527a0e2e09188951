# SPDX-License-Identifier: Apache-2.0
"""Tests that images rendered with BLUE show no pattern, and that a choice is stratified together with the pair that follows it. Everything
is seeded. Run with -s to print figures."""

import numpy as np
import pytest
from conftest import blur_gain, part

import bluenoise

ndimage = pytest.importorskip("scipy.ndimage")

SIZE, COUNTS = 64, np.array([1, 4, 16])
Y, X = np.mgrid[:SIZE, :SIZE]


def planes(seed, period):
    """Half-planes a x + b y < c, and their mean in each pixel. If `period` is not 0, c drifts across the screen."""
    random = np.random.default_rng(seed)
    for _ in range(8):
        angle, (x, y), way = 2 * np.pi * random.random(), random.uniform(.3, .7, 2), 2 * np.pi * random.random()
        waves = np.round(SIZE / max(period, 1) * np.array([np.cos(way), np.sin(way)]))
        shift = 0.35 * np.sin(2 * np.pi * (waves[0] * X + waves[1] * Y) / SIZE) if period else np.zeros((SIZE, SIZE))
        a, b = np.cos(angle), np.sin(angle)
        c = a * x + b * y + shift
        yield a, b, c[..., None], part(a, b, c)


def peaks(image):
    """The mean of the largest 1% of a spectrum's powers, relative to the mean of all powers. White noise has 5.6."""
    powers = np.sort((np.abs(np.fft.fft2(image - image.mean())) ** 2).ravel())
    return powers[-len(powers) // 100:].mean() / powers.mean()


def peaks_of(samples, period, seed):
    """The mean of peaks() at each of COUNTS, over many half-planes. The samples of one pair are (SIZE, SIZE, COUNTS[-1], 2)."""
    found = []
    for a, b, c, mean in planes(seed, period):
        inside = (a * samples[..., 0] + b * samples[..., 1] < c).cumsum(-1)[..., COUNTS - 1] / COUNTS
        found.append([peaks(inside[..., k] - mean) for k in range(len(COUNTS))])
    return np.mean(found, 0)


@pytest.mark.parametrize("period", [0, 64])
@pytest.mark.parametrize("member", range(4))
def test_images_show_no_pattern(member, period):
    """Global Sobol' has peaks of 25 to 45. The mean over 32 white-noise images varies by 0.05."""
    for pair in (0, 1):
        found = 0
        for seed in range(4):
            drawn = bluenoise.Sampler("blue", seed=seed).block(0, 0, SIZE, SIZE, 0, COUNTS[-1], bluenoise.domain(seed, member))
            found = found + peaks_of(drawn[..., 2 * pair:][..., :2], period, seed) / 4
        print(f"\nmember {member}, pair {pair}, period {period}: {found.round(1)}")
        assert (found < 8).all()


def test_peaks_distinguish_a_pattern_from_white_noise():
    """Compares one Sobol' sequence over the screen, pixel by pixel along rows, with white noise."""
    qmc = pytest.importorskip("scipy.stats.qmc")
    points = qmc.Sobol(4, seed=1).random(SIZE * SIZE * COUNTS[-1])
    order = np.lexsort((np.arange(len(points)), (points[:, 0] * SIZE).astype(int), (points[:, 1] * SIZE).astype(int)))
    samples = points[order, 2:].reshape(SIZE, SIZE, COUNTS[-1], 2)
    assert (peaks_of(samples, 0, 1) > 15).all()
    white = peaks_of(np.random.default_rng(1).random(samples.shape), 0, 1)
    assert (abs(white - 5.6) < 0.5).all()


def forms(ray):
    """{how a number and a pair are drawn: the three numbers (..., 3)}."""
    drawn, four = ray.draw(), ray.draw_4d(0)
    return {"draw": drawn[..., [2, 0, 1]], "draw_4d": four[..., [2, 0, 1]],
            "draw_1d beside draw": np.concatenate([ray.draw_1d(0)[..., None], drawn[..., :2]], -1),
            "draw_1d beside draw_2d": np.concatenate([ray.draw_1d(0)[..., None], ray.draw_2d(0)], -1)}


@pytest.mark.parametrize("number", range(5))
def test_a_choice_is_stratified_together_with_a_pair(number):
    """If a number is below 1/2, it selects a ramp in each coordinate of a pair, otherwise the ramp's mirror image. Errors are relative to
    white noise. At 8 samples, the error in single pixels would be 1.8 if the number's first digit followed that of a coordinate. At 2 and
    4 samples, no stratified number avoids this (1.4), and neighbouring errors cancel after a blur. A number from another domain is not
    stratified together with the pair, so draw_4d() returns both."""
    counts, squares = np.array([2, 4, 8]), {}
    for seed in range(6):
        path = bluenoise.PathSampler(bluenoise.Sampler("blue", seed=seed), X[..., None], Y[..., None], np.arange(8))
        for form, u in forms(path.ray(number)).items():
            for d in (1, 2):
                errors = np.where(u[..., 0] < .5, u[..., d], 1 - u[..., d]).cumsum(-1)[..., counts - 1] / counts - .5
                after = ndimage.gaussian_filter(errors, (2.1, 2.1, 0), mode="wrap")
                # The sum over 12 images is relative to white noise, whose variance is 1 / 12.
                both = np.array([(errors**2).mean((0, 1)), (after**2).mean((0, 1)) / blur_gain(2.1)]) * counts
                squares[form] = squares.get(form, 0) + both
    for form, both in squares.items():
        raw, blurred = np.sqrt(both)
        print(f"\nray {number}, {form}: {raw.round(2)} in single pixels, {blurred.round(2)} after a blur")
        if "beside" in form:
            assert (both < 2**2).all(), form
        else:
            assert (blurred < 1).all() and raw[2] < 1.1, form
