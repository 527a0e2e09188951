# SPDX-License-Identifier: Apache-2.0
"""Scenes and samplers: the means are those of an independent run, and nothing is negative or not finite.

Seeds are fixed, so a test fails always or never on one machine; the rates stated are the chances of a false alarm had
the seeds been drawn anew.
"""

import itertools

import numpy as np
import pytest
from pathtracer_driver import OPENQMC, SAMPLERS, SCENES, assert_equal_means, part_means
from scene_files import write_exr
from scipy import stats
from scipy.ndimage import gaussian_filter

SEEDS = 12
REFERENCES = {}  # of scenes: so many seeds of sobol with 32 samples per pixel
SIZE = ["--size", "24x24", "--threads", 1]


def means_over_seeds(pathtracer, first_seed, count, *arguments):
    images = [pathtracer.image(*SIZE, *arguments, "--seed", first_seed + i) for i in range(count)]
    assert np.isfinite(images).all()
    assert np.min(images) >= 0
    return np.array([part_means(image) for image in images])


def assert_the_mean_is_the_reference(pathtracer, scene, *arguments, least=0.2):
    """Welch's t-tests of the means of the picture and its quarters over 12 seeds. The smallest of the 15 p-values is allowed a
    chance of one in ten thousand; a bias of `least` would be seen."""
    if scene not in REFERENCES:
        REFERENCES[scene] = means_over_seeds(pathtracer, 5000, SEEDS, "--scene", scene, "--sampler", "sobol", "--spp", 32)
    expected = REFERENCES[scene]
    means = means_over_seeds(pathtracer, 0, SEEDS, "--scene", scene, *arguments)
    assert_equal_means(means, expected, 1e-4)
    deviation = np.hypot(means[:, 1].std(ddof=1), expected[:, 1].std(ddof=1)) / np.sqrt(SEEDS)
    assert 6 * deviation < least * expected[:, 1].mean()


@pytest.mark.parametrize("depth", [0, 1, 2, 8, 40])
def test_furnace(pathtracer, depth):
    """Walls that emit 1/2 and reflect 1/2: n bounces see 1 - 2^-(n + 1) everywhere. The image mean over seeds passes a t-test
    with a false-alarm rate of 0.1 % for each depth; no corner, edge or wall is off, nor any block of 8 x 8 pixels."""
    expected = 1 - 0.5 ** (depth + 1)
    common = ["--scene", "furnace", "--size", "32x32", "--spp", 32, "--max-depth", depth]
    images = np.array([pathtracer.image(*common, "--seed", seed) for seed in range(SEEDS)], np.float64)
    means = images.mean(axis=(1, 2, 3))
    assert (images == 0.5).all() if depth == 0 else stats.ttest_1samp(means, expected).pvalue > 0.001
    assert abs(means.mean() / expected - 1) < 0.001
    np.testing.assert_allclose(images.reshape(SEEDS, 4, 8, 4, 8, 3).mean(axis=(0, 2, 4)), expected, rtol=0.01)


@pytest.mark.parametrize("scene", SCENES)
def test_the_mean_is_the_reference(pathtracer, scene):
    assert_the_mean_is_the_reference(pathtracer, scene, "--spp", 4)


@pytest.mark.parametrize("sampler", SAMPLERS[1:])
@pytest.mark.parametrize("scene", ["lens", "motion", "fog"])
def test_the_mean_of_other_samplers(pathtracer, scene, sampler):
    assert_the_mean_is_the_reference(pathtracer, scene, "--sampler", sampler, "--spp", 4)


@pytest.mark.parametrize("scene", ["cornell", "lens", "motion", "fog"])
def test_light_samples_leave_the_mean(pathtracer, scene):
    assert_the_mean_is_the_reference(pathtracer, scene, "--sampler", "sobol", "--spp", 16, "--light-samples", 4, least=0.1)


def test_the_environment_is_the_right_way_round(pathtracer):
    """The camera of lens looks along -z, which is the seam of the map; +x is to its right, +y up."""
    texels = np.zeros((64, 128, 3), np.float32)
    texels[:, :64, 0] = 1  # the left half of the map: +x
    texels[:, 64:, 1] = 1  # the right half: -x
    write_exr(pathtracer.folder / "sides.exr", RGB=texels)
    image = pathtracer.image("--scene", "lens", "--size", "32x32", "--spp", 4, "--env", "sides.exr", "--max-depth", 0)
    assert (image[0, 20:, 0] > 0.9).all() and (image[0, 20:, 1] < 0.1).all()
    assert (image[0, :12, 1] > 0.9).all() and (image[0, :12, 0] < 0.1).all()


def test_light_cut_off_at_max_depth_is_reported(pathtracer):
    """Half of what is left goes on at each bounce of furnace, and roulette keeps the mean of that."""
    for depth, expected in ((0, 100), (1, 50), (3, 12.5)):
        arguments = ["--scene", "furnace", "--size", "16x16", "--spp", 4, "--max-depth", depth, "-o", "out.exr"]
        text = pathtracer.run(*arguments).stdout
        assert f"{expected:.2f} % cut off at depth {depth}" in text


# ---- The samplers for comparison: right, split, OpenQMC's blue, and what is said where they are not

PENUMBRA = ("--scene", "penumbra", "--size", "64x64", "--max-depth", 1)


def error_images(pathtracer, expected, sampler, *options):
    """Differences from `expected` in the mean of the channels, one picture for each of six seeds."""
    pictures = [pathtracer.image(*PENUMBRA, "--sampler", sampler, "--seed", seed, *options) for seed in range(6)]
    return np.array([(picture - expected).mean(axis=2) for picture in pictures])


def test_without_openqmc_the_message_lists_the_samplers(pathtracer):
    if OPENQMC[0] in pathtracer.run("--list").stdout:
        pytest.skip("the path tracer is built with OpenQMC")
    pathtracer.failure("--sampler", OPENQMC[0], "-o", "out.exr", said=["'openqmc-pmjbn'; the samplers are blue, sobol, white"])


@pytest.mark.parametrize(("name", "more"), [
    ("sobol-global", ("--light-samples", 3)), ("sobol-global", ("--scene", "motion")),
    *itertools.product(OPENQMC, [(), ("--light-samples", 3)])])
def test_means_of_peers(pathtracer, name, more):
    """Against sobol: Welch's t-test of the image mean over seeds, false-alarm rate 0.1 % for each."""
    pathtracer.needs(name)
    means = [[pathtracer.image("--size", "24x24", "--spp", 8, *more, "--sampler", sampler, "--seed", seed).mean(
        dtype=np.float64) for seed in range(12)] for sampler in (name, "sobol")]
    assert_equal_means(*means, 0.001)


@pytest.mark.parametrize("name", OPENQMC)
def test_noise_of_openqmc_is_blue_and_seeds_and_splits_are_spread(pathtracer, name):
    pathtracer.needs(name)
    penumbra = pathtracer.image(*PENUMBRA, "--sampler", "sobol", "--seed", 99, "--spp", 512)
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


def test_options_that_peers_do_not_take_are_refused(pathtracer):
    pathtracer.needs("sobol-global")
    for options, said in ((["--declare", 4], "--declare is for the samplers of libbn"),
                          (["--first-sample", 2147483640, "--spp", 9], "2147483647")):
        pathtracer.failure("--sampler", "sobol-global", *options, "-o", "out.exr", said=[said, "sobol-global"])
