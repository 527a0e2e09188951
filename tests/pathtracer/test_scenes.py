# SPDX-License-Identifier: Apache-2.0
"""Tests that all scenes and samplers have the same means as an independent render, and no negative or infinite pixels.

Seeds are fixed, so on one machine a test always fails or never fails. The stated false-alarm rates are for fresh seeds.
"""

import itertools

import numpy as np
import pytest
from pathtracer_driver import PLUGINS, SAMPLERS, SCENES, assert_equal_means, block_means, read_exr, read_layers
from scene_files import write_exr

SPLIT = ("--light-samples", 4)
REFERENCES = {}  # by scene: layers rendered with white noise


def rendered(pathtracer, *arguments):
    layers = read_layers(pathtracer.render(*arguments))
    assert all(np.isfinite(layers[c]).all() and layers[c].min() >= 0 for c in "RGB")
    return layers


@pytest.mark.parametrize(("scene", "sampler", "more"), [
    *((scene, "blue", ()) for scene in SCENES), *itertools.product(["lens", "motion", "fog"], SAMPLERS[1:], [()]),
    *itertools.product(["cornell", "lens", "motion", "fog"], ["sobol"], [SPLIT]), *itertools.product(["motion"], PLUGINS, [(), SPLIT])])
def test_means_equal_the_reference(pathtracer, scene, sampler, more):
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
    layers, header = read_layers(pathtracer.folder / "out.exr"), read_exr(pathtracer.folder / "out.exr")[1]
    shadow_rays = int(header["rays"]) / (64 * 64 * 16) - (depth + 1)  # per path; most bounces cast one
    assert depth > 2 or 0.7 * depth <= shadow_rays <= depth
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
    """A block that misses the rare bright paths of the caustics must not darken the image. The bias of the displayed mean is the
    covariance, over seeds, of a block's error and its decision to stop, here at 4 samples; the other seeds give the expected value. It is
    -0.06% with a standard error of 0.03%, so the false-alarm rate is 1 in 1,000. With blocks of 4 x 4 pixels it is -0.36%."""
    common = ["--scene", "glass", "--sampler", "white", "--size", "64x48", "--exposure", 0]
    found = [pathtracer.layers(*common, "--visible-noise", 0.01, "--spp", 4, "--seed", seed) for seed in range(40)]
    shown = np.array([np.clip([layers[c] for c in "RGB"], 0, 1).mean(0, dtype=float) for layers in found])
    stops = np.array([layers["noise"] for layers in found]) < 2
    error = shown - (shown.sum(0) - shown) / (len(shown) - 1)
    assert abs((stops * error).mean() / shown.mean()) < 0.0016
    # Blocks have 16 x 16 pixels, and stop if they have little noise.
    blocks = found[0]["noise"].reshape(3, 16, 4, 16).swapaxes(1, 2).reshape(12, 256)
    assert (blocks == blocks[:, :1]).all() and len(np.unique(blocks)) == 12
    counts = pathtracer.layers(*common, "--visible-noise", 2, "--spp", 8, "--seed", 0)["count"]
    assert np.array_equal(counts, np.where(stops[0], 4, 8)) and 0 < stops[0].mean() < 1


def test_orientation_of_the_environment(pathtracer):
    """The camera of the `lens` scene looks along -z, at the map's seam, with +x to its right and +y up."""
    texels = np.zeros((64, 128, 3), np.float32)
    texels[:, :64, 0] = texels[:, 64:, 1] = 1  # the map's left half is +x, its right half -x
    write_exr(pathtracer.folder / "sides.exr", RGB=texels)
    image = pathtracer.image("--scene", "lens", "--size", "32x32", "--spp", 4, "--env", "sides.exr", "--max-depth", 0)
    assert (image[0, 20:, 0] > 0.9).all() and (image[0, 20:, 1] < 0.1).all()
    assert (image[0, :12, 1] > 0.9).all() and (image[0, :12, 0] < 0.1).all()


@pytest.mark.parametrize("plugin", PLUGINS)
def test_plugins_have_fewer_samples(pathtracer, plugin):
    pathtracer.failure("--sampler", plugin, "--first-sample", 2147483640, "--spp", 9, said=["2147483647", plugin])
