# SPDX-License-Identifier: Apache-2.0
"""OpenQMC's samplers in the path tracer: right, blue, seeded, split; and what is said where they are not.

Statistical tests use fixed seeds; the rates stated are the chances of a false alarm had they been drawn anew.
"""

import itertools

import numpy as np
import pytest
from pathtracer_driver import assert_equal_means, read_exr
from scipy.ndimage import gaussian_filter

PEERS = ("openqmc-pmjbn", "openqmc-sobolbn", "openqmc-latticebn")
PENUMBRA = ("--scene", "penumbra", "--size", "64x64", "--max-depth", 1)


def listed(pathtracer):
    return set(PEERS) & set(pathtracer.run("--list").stdout.split())


@pytest.fixture(params=PEERS)
def peer(request, pathtracer):
    found = listed(pathtracer)
    if not found:
        pytest.skip("the path tracer is built without OpenQMC (-DBN_OPENQMC=DIR)")
    assert found == set(PEERS)
    return request.param


def error_images(pathtracer, expected, sampler, seeds, *options):
    """Differences from `expected` in the mean of the channels, one picture for each seed."""
    pictures = [pathtracer.image(*PENUMBRA, "--sampler", sampler, "--seed", seed, *options) for seed in range(seeds)]
    return np.array([(picture - expected).mean(axis=2) for picture in pictures])


@pytest.fixture
def penumbra(pathtracer):
    return pathtracer.image(*PENUMBRA, "--sampler", "sobol", "--seed", 99, "--spp", 512)


def test_without_it_the_samplers_there_are_get_named(pathtracer):
    if listed(pathtracer):
        pytest.skip("the path tracer is built with OpenQMC")
    message = pathtracer.failure("--sampler", "openqmc-pmjbn", "-o", "out.exr")
    assert "'openqmc-pmjbn'; the samplers are blue, sobol, white, zorder, mask" in message


@pytest.mark.parametrize("more", [(), ("--light-samples", 3)])
def test_the_means_are_right(pathtracer, peer, more):
    """Against sobol: Welch's t-test of the image mean over seeds, false-alarm rate 0.1 % for each."""
    means = [[pathtracer.image("--size", "24x24", "--spp", 8, *more, "--sampler", sampler, "--seed", seed).mean(
        dtype=np.float64) for seed in range(12)] for sampler in (peer, "sobol")]
    assert_equal_means(*means, 0.001)


def test_their_noise_is_blue_and_seeds_are_independent(pathtracer, peer, penumbra):
    peers = error_images(pathtracer, penumbra, peer, 6, "--spp", 1)
    white = error_images(pathtracer, penumbra, "white", 6, "--spp", 1)
    # The error of white noise after the blur, against theirs: 1 where noise has no colour, 1.4 to 1.6 here.
    blurred = [np.sqrt(np.mean([gaussian_filter(error, 2.1) ** 2 for error in errors])) for errors in (white, peers)]
    assert blurred[0] > 1.25 * blurred[1]
    # Of uncorrelated pictures r scatters by 1/64: six times that has a chance of one in 30 million for 15 pairs.
    correlations = [np.corrcoef(a.ravel(), b.ravel())[0, 1] for a, b in itertools.combinations(peers, 2)]
    assert np.abs(correlations).max() < 6 / 64


def test_light_samples_of_a_path_are_spread_out_together(pathtracer, peer, penumbra):
    """Sixteen of one path: independent ones have the error of white noise, stratified ones a part of it."""
    options = ("--spp", 1, "--light-samples", 16)
    error = {sampler: np.sqrt(np.mean(error_images(pathtracer, penumbra, sampler, 6, *options) ** 2))
             for sampler in (peer, "white", "sobol")}
    assert error[peer] < 0.85 * error["white"]
    assert error[peer] < 1.1 * error["sobol"]


def test_pictures_do_not_depend_on_crops_and_parts(pathtracer, peer):
    common = ("--size", "40x30", "--sampler", peer, "--seed", 7)
    whole = pathtracer.render(*common, "--spp", 4)
    image, header = read_exr(whole)
    assert header["sampler"] == peer
    crop = pathtracer.image(*common, "--spp", 4, "--crop", "5,9,21,30", "--threads", 1)
    assert (crop == image[9:30, 5:21]).all()
    late = pathtracer.image(*common, "--spp", 2, "--first-sample", 2)
    early = pathtracer.image(*common, "--spp", 2)
    np.testing.assert_allclose((early + late) / 2, image, rtol=1e-5, atol=1e-6)


@pytest.mark.parametrize(("options", "said"), [
    (["--declare", 4], "--declare is for the samplers of libbn"),
    (["--mask", "builtin"], "--mask is for the samplers of libbn"),
    (["--first-sample", 2147483640, "--spp", 9], "2147483648"),
])
def test_what_they_do_not_take_is_refused(pathtracer, peer, options, said):
    pathtracer.failure("--sampler", peer, *options, "-o", "out.exr", said=[said, peer])
