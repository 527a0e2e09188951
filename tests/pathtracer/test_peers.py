# SPDX-License-Identifier: Apache-2.0
"""The samplers for comparison: right, the same in parts, split; OpenQMC's blue; and what is said where they are not.

Statistical tests use fixed seeds; the rates stated are the chances of a false alarm had they been drawn anew.
"""

import itertools

import numpy as np
import pytest
from pathtracer_driver import OPENQMC, assert_equal_means
from scipy.ndimage import gaussian_filter

PENUMBRA = ("--scene", "penumbra", "--size", "64x64", "--max-depth", 1)


def needs(pathtracer, name):
    """Skips the test if the path tracer is built without a sampler that may be left out."""
    if name not in ("pcg", "sobol4d") and name not in pathtracer.run("--list").stdout.split():
        pytest.skip(f"the path tracer is built without {name}")


def error_images(pathtracer, expected, sampler, *options):
    """Differences from `expected` in the mean of the channels, one picture for each of six seeds."""
    pictures = [pathtracer.image(*PENUMBRA, "--sampler", sampler, "--seed", seed, *options) for seed in range(6)]
    return np.array([(picture - expected).mean(axis=2) for picture in pictures])


@pytest.fixture
def penumbra(pathtracer):
    return pathtracer.image(*PENUMBRA, "--sampler", "sobol", "--seed", 99, "--spp", 512)


def test_without_openqmc_the_samplers_there_are_get_named(pathtracer):
    if OPENQMC[0] in pathtracer.run("--list").stdout:
        pytest.skip("the path tracer is built with OpenQMC")
    pathtracer.failure("--sampler", OPENQMC[0], "-o", "out.exr", said=["'openqmc-pmjbn'; the samplers are blue, sobol, white"])


@pytest.mark.parametrize(("name", "more"), [
    ("pcg", ()), ("pcg", ("--scene", "fog")), ("sobol4d", ()), ("sobol4d", ("--light-samples", 3)), ("sobol4d", ("--scene", "lens")),
    ("sobol-global", ("--light-samples", 3)), ("sobol-global", ("--scene", "motion")),
    *itertools.product(OPENQMC, [(), ("--light-samples", 3)])])
def test_the_means_are_right(pathtracer, name, more):
    """Against sobol: Welch's t-test of the image mean over seeds, false-alarm rate 0.1 % for each."""
    needs(pathtracer, name)
    means = [[pathtracer.image("--size", "24x24", "--spp", 8, *more, "--sampler", sampler, "--seed", seed).mean(
        dtype=np.float64) for seed in range(12)] for sampler in (name, "sobol")]
    assert_equal_means(*means, 0.001)


def test_noise_of_pcg_is_that_of_white(pathtracer, penumbra):
    """In single pixels, after a blur, and in the mean over seeds: samples, pixels and seeds are independent."""
    pcg, white = (error_images(pathtracer, penumbra, sampler, "--spp", 16) for sampler in ("pcg", "white"))
    for of in (lambda errors: errors, lambda errors: gaussian_filter(errors, (0, 2.1, 2.1)), lambda errors: errors.mean(axis=0)):
        # The blurred ratio, the least certain, scatters by 5 %.
        assert 0.75 < np.sqrt(np.mean(of(pcg) ** 2) / np.mean(of(white) ** 2)) < 1.33


@pytest.mark.parametrize("name", OPENQMC)
def test_noise_of_openqmc_is_blue_and_seeds_and_splits_are_spread(pathtracer, name, penumbra):
    needs(pathtracer, name)
    peers, white = (error_images(pathtracer, penumbra, sampler, "--spp", 1) for sampler in (name, "white"))
    # The error of white noise after the blur, against theirs: 1 where noise has no colour, 1.4 to 1.6 here.
    blurred = [np.sqrt(np.mean([gaussian_filter(error, 2.1) ** 2 for error in errors])) for errors in (white, peers)]
    assert blurred[0] > 1.25 * blurred[1]
    # Of uncorrelated pictures r scatters by 1/64: six times that has a chance of one in 30 million for 15 pairs.
    correlations = [np.corrcoef(a.ravel(), b.ravel())[0, 1] for a, b in itertools.combinations(peers, 2)]
    assert np.abs(correlations).max() < 6 / 64
    # Sixteen light samples of one path: independent ones have the error of white noise, stratified ones a part of it.
    error = {sampler: np.sqrt(np.mean(error_images(pathtracer, penumbra, sampler, "--spp", 1, "--light-samples", 16) ** 2))
             for sampler in (name, "white", "sobol")}
    assert error[name] < 0.85 * error["white"] and error[name] < 1.1 * error["sobol"]


@pytest.mark.parametrize(("options", "said"), [
    (["--declare", 4], "--declare is for the samplers of libbn"),
    (["--mask", "builtin"], "--mask is for the samplers of libbn"),
    (["--first-sample", 2147483640, "--spp", 9], "2147483648"),
])
def test_what_they_do_not_take_is_refused(pathtracer, options, said):
    pathtracer.failure("--sampler", "sobol4d", *options, "-o", "out.exr", said=[said, "sobol4d"])
