# SPDX-License-Identifier: Apache-2.0
"""Scenes and samplers: the means are those of an independent run, and nothing is negative or not finite.

Seeds are fixed, so a test fails always or never on one machine; the rates stated are the chances of a false alarm had the seeds
been drawn anew.
"""

import itertools

import numpy as np
import pytest
from pathtracer_driver import OPENQMC, PEERS, SAMPLERS, SCENES, assert_equal_means, block_means, read_layers
from scene_files import write_exr
from scipy.ndimage import gaussian_filter

SPLIT = ("--light-samples", 4)
REFERENCES = {}  # of scenes: layers of white noise


def rendered(pathtracer, *arguments):
    layers = read_layers(pathtracer.render(*arguments))
    assert all(np.isfinite(layers[c]).all() and layers[c].min() >= 0 for c in "RGB")
    return layers


@pytest.mark.parametrize(("scene", "sampler", "more"), [
    *((scene, "blue", ()) for scene in SCENES), *itertools.product(["lens", "motion", "fog"], SAMPLERS[1:], [()]),
    *((scene, "sobol", SPLIT) for scene in ("cornell", "lens", "motion", "fog")),
    ("motion", "sobol-global", ()), *itertools.product(["cornell"], PEERS, [(), SPLIT])])
def test_the_mean_is_the_reference(pathtracer, scene, sampler, more):
    pathtracer.needs(sampler)
    common = ["--scene", scene, "--size", "96x96"]
    if scene not in REFERENCES:
        REFERENCES[scene] = rendered(pathtracer, *common, "--sampler", "white", "--spp", 16, "--seed", 9)
    assert_equal_means(rendered(pathtracer, *common, "--sampler", sampler, "--spp", 4, *more), REFERENCES[scene], 0.15)


@pytest.mark.parametrize("depth", [0, 1, 2, 40])
def test_furnace(pathtracer, depth):
    """Walls that emit 1/2 and reflect 1/2: n bounces see 1 - 2^-(n + 1) everywhere, and half of what is left goes on at each."""
    expected = 1 - 0.5 ** (depth + 1)
    done = pathtracer.success("--scene", "furnace", "--size", "64x64", "--spp", 16, "--max-depth", depth, "-o", "out.exr")
    assert f"{100 * 0.5**depth:.2f}% cut off at depth {depth}" in done.stdout
    layers = read_layers(pathtracer.folder / "out.exr")
    for blocks, error in ((1, 0.001), (4, 0.01)):  # five standard deviations or more
        np.testing.assert_allclose(block_means(layers, blocks)[0], expected, rtol=error if depth else 0)


def test_adaptive_images_have_the_same_means(pathtracer):
    """In dark and in bright places, as an independent image finds them: a bias of one percent of the light is found 99 times in 100."""
    common = ["--scene", "penumbra", "--max-depth", 1, "--size"]
    places = pathtracer.image(*common, "30x25", "--sampler", "sobol", "--spp", 64).sum(axis=2)
    dark = np.kron(places < np.median(places), np.ones((8, 8), bool))
    plain = rendered(pathtracer, *common, "240x200", "--sampler", "white", "--spp", 12, "--seed", 9)
    for sampler in ("white", "blue"):
        adaptive = rendered(pathtracer, *common, "240x200", "--sampler", sampler, "--noise", 0.25, "--min-spp", 4, "--spp", 64)
        assert len(np.unique(adaptive["count"])) > 2
        for where in (dark, ~dark):
            cut = [{name: values[where][None] for name, values in layers.items()} for layers in (adaptive, plain)]
            assert_equal_means(*cut, 0.01, blocks=1)


def test_the_environment_is_the_right_way_round(pathtracer):
    """The camera of lens looks along -z, which is the seam of the map; +x is to its right, +y up."""
    texels = np.zeros((64, 128, 3), np.float32)
    texels[:, :64, 0] = texels[:, 64:, 1] = 1  # the left half of the map is +x, the right one -x
    write_exr(pathtracer.folder / "sides.exr", RGB=texels)
    image = pathtracer.image("--scene", "lens", "--size", "32x32", "--spp", 4, "--env", "sides.exr", "--max-depth", 0)
    assert (image[0, 20:, 0] > 0.9).all() and (image[0, 20:, 1] < 0.1).all()
    assert (image[0, :12, 1] > 0.9).all() and (image[0, :12, 0] < 0.1).all()


PENUMBRA = ("--scene", "penumbra", "--size", "64x64", "--max-depth", 1)


def error_images(pathtracer, expected, sampler, *options):
    """Differences from `expected` in the mean of the channels, one picture for each of six seeds."""
    pictures = [pathtracer.image(*PENUMBRA, "--sampler", sampler, "--seed", seed, *options) for seed in range(6)]
    return np.array([(picture - expected).mean(axis=2) for picture in pictures])


def test_without_openqmc_the_message_lists_the_samplers(pathtracer):
    if OPENQMC[0] in pathtracer.run("--list").stdout:
        pytest.skip("the path tracer is built with OpenQMC")
    pathtracer.failure("--sampler", OPENQMC[0], said=["'openqmc-pmjbn'; the samplers are blue, sobol, white"])


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
        pathtracer.failure("--sampler", "sobol-global", *options, said=[said, "sobol-global"])
