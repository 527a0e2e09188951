# SPDX-License-Identifier: Apache-2.0
"""Tests that all scenes and samplers have the same means as an independent render, and no negative or infinite pixels.

Seeds are fixed, so on one machine a test always fails or never fails. The stated false-alarm rates are for fresh seeds.
"""

import itertools

import numpy as np
import pytest
from pathtracer_driver import OPENQMC, PEERS, SAMPLERS, SCENES, assert_equal_means, block_means, read_layers
from scene_files import write_exr
from scipy.ndimage import gaussian_filter

SPLIT = ("--light-samples", 4)
REFERENCES = {}  # by scene: layers rendered with white noise


def rendered(pathtracer, *arguments):
    layers = read_layers(pathtracer.render(*arguments))
    assert all(np.isfinite(layers[c]).all() and layers[c].min() >= 0 for c in "RGB")
    return layers


@pytest.mark.parametrize(("scene", "sampler", "more"), [
    *((scene, "blue", ()) for scene in SCENES), *itertools.product(["lens", "motion", "fog"], SAMPLERS[1:], [()]),
    *((scene, "sobol", SPLIT) for scene in ("cornell", "lens", "motion", "fog")),
    ("motion", "sobol_global.so", ()), *itertools.product(["cornell"], PEERS, [(), SPLIT])])
def test_means_equal_the_reference(pathtracer, scene, sampler, more):
    sampler = pathtracer.needs(sampler)
    common = ["--scene", scene, "--size", "96x96"]
    if scene not in REFERENCES:
        REFERENCES[scene] = rendered(pathtracer, *common, "--sampler", "white", "--spp", 16, "--seed", 9)
    assert_equal_means(rendered(pathtracer, *common, "--sampler", sampler, "--spp", 4, *more), REFERENCES[scene], 0.15)


@pytest.mark.parametrize("depth", [0, 1, 2, 40])
def test_furnace(pathtracer, depth):
    """The walls emit 1/2 and reflect 1/2, so n bounces give 1 - 2^-(n + 1) everywhere, and each bounce halves the throughput."""
    expected = 1 - 0.5 ** (depth + 1)
    done = pathtracer.success("--scene", "furnace", "--size", "64x64", "--spp", 16, "--max-depth", depth, "-o", "out.exr")
    assert f"{100 * 0.5**depth:.2f}% cut off at depth {depth}" in done.stdout
    layers = read_layers(pathtracer.folder / "out.exr")
    for blocks, error in ((1, 0.001), (4, 0.01)):  # five standard deviations or more
        np.testing.assert_allclose(block_means(layers, blocks)[0], expected, rtol=error if depth else 0)


def test_adaptive_sampling_is_unbiased(pathtracer):
    """Compares dark and bright regions, chosen by an independent image. A bias of 1.5% is detected 99 times in 100."""
    common = ["--scene", "penumbra", "--max-depth", 1, "--size"]
    places = pathtracer.image(*common, "20x17", "--sampler", "sobol", "--spp", 64).sum(axis=2)
    dark = np.kron(places < np.median(places), np.ones((8, 8), bool))
    plain = rendered(pathtracer, *common, "160x136", "--sampler", "white", "--spp", 12, "--seed", 9)
    for sampler in ("white", "blue"):
        adaptive = rendered(pathtracer, *common, "160x136", "--sampler", sampler, "--noise", 0.25, "--min-spp", 4, "--spp", 64)
        assert len(np.unique(adaptive["count"])) > 2
        for where in (dark, ~dark):
            cut = [{name: values[where][None] for name, values in layers.items()} for layers in (adaptive, plain)]
            assert_equal_means(*cut, 0.015, blocks=1)


def test_stopping_by_visible_noise_is_unbiased(pathtracer):
    """A block that misses the rare bright paths of the caustics must not darken the image. The standard error of the difference of the
    displayed means is 0.2%, so a bias of 1% is detected 99 times in 100."""
    common = ["--scene", "glass", "--sampler", "white", "--size", "64x48", "--exposure", 0]
    def shown(seed, *more):
        return np.clip(pathtracer.image(*common, "--seed", seed, *more), 0, 1).mean()

    plain = [shown(seed, "--spp", 64) for seed in (100, 101)]
    stopped = [shown(seed, "--visible-noise", 2, "--spp", 64) for seed in range(8)]
    assert abs(np.mean(stopped) / np.mean(plain) - 1) < 0.006


def test_orientation_of_the_environment(pathtracer):
    """The camera of the `lens` scene looks along -z, at the map's seam, with +x to its right and +y up."""
    texels = np.zeros((64, 128, 3), np.float32)
    texels[:, :64, 0] = texels[:, 64:, 1] = 1  # the map's left half is +x, its right half -x
    write_exr(pathtracer.folder / "sides.exr", RGB=texels)
    image = pathtracer.image("--scene", "lens", "--size", "32x32", "--spp", 4, "--env", "sides.exr", "--max-depth", 0)
    assert (image[0, 20:, 0] > 0.9).all() and (image[0, 20:, 1] < 0.1).all()
    assert (image[0, :12, 1] > 0.9).all() and (image[0, :12, 0] < 0.1).all()


PENUMBRA = ("--scene", "penumbra", "--size", "64x64", "--max-depth", 1)


def error_images(pathtracer, expected, sampler, *options):
    """Returns differences from `expected`, averaged over the channels: one image for each of six seeds."""
    pictures = [pathtracer.image(*PENUMBRA, "--sampler", sampler, "--seed", seed, *options) for seed in range(6)]
    return np.array([(picture - expected).mean(axis=2) for picture in pictures])


@pytest.mark.parametrize("name", OPENQMC)
def test_openqmc_is_blue_its_seeds_are_uncorrelated_and_its_splits_stratified(pathtracer, name):
    name = pathtracer.needs(name)
    penumbra = pathtracer.image(*PENUMBRA, "--sampler", "sobol", "--seed", 99, "--spp", 512)
    peers, white = (error_images(pathtracer, penumbra, sampler, "--spp", 1) for sampler in (name, "white"))
    # After a blur, the ratio of white noise's error to theirs is 1 for noise without colour and 1.4 to 1.6 here.
    blurred = [np.sqrt(np.mean([gaussian_filter(error, 2.1) ** 2 for error in errors])) for errors in (white, peers)]
    assert blurred[0] > 1.25 * blurred[1]
    # For uncorrelated images, r has a standard deviation of 1/64. In 15 pairs, chance exceeds six deviations once in 30 million.
    correlations = [np.corrcoef(a.ravel(), b.ravel())[0, 1] for a, b in itertools.combinations(peers, 2)]
    assert np.abs(correlations).max() < 6 / 64
    # Sixteen light samples of one path: if they are independent, the error is that of white noise; if stratified, it is lower.
    error = {sampler: np.sqrt(np.mean(error_images(pathtracer, penumbra, sampler, "--spp", 1, "--light-samples", 16) ** 2))
             for sampler in (name, "white", "sobol")}
    assert error[name] < 0.85 * error["white"] and error[name] < 1.1 * error["sobol"]


def test_plugins_have_fewer_samples(pathtracer):
    options = ["--first-sample", 2147483640, "--spp", 9]
    pathtracer.failure("--sampler", pathtracer.needs("sobol_global.so"), *options, said=["2147483647", "sobol_global.so"])
