# SPDX-License-Identifier: Apache-2.0
"""The samplers sobol4d and sobol-global in the path tracer: listed, right, the same in parts; what it does not take is refused."""

import pytest
from pathtracer_driver import assert_equal_means, read_exr, read_layers


def test_it_is_listed_and_written_into_the_picture(pathtracer):
    assert "sobol4d" in pathtracer.run("--list").stdout.split()
    path = pathtracer.render("--size", "8x8", "--sampler", "sobol4d", "--spp", 2)
    assert read_exr(path)[1]["sampler"] == "sobol4d"


@pytest.mark.parametrize(("name", "more"), [("sobol4d", ()), ("sobol4d", ("--light-samples", 3)), ("sobol4d", ("--scene", "lens")),
                                           ("sobol-global", ("--light-samples", 3)), ("sobol-global", ("--scene", "motion"))])
def test_the_means_are_right(pathtracer, name, more):
    """Against sobol: Welch's t-test of the image mean over fixed seeds, false-alarm rate 0.1 % for each."""
    means = [[pathtracer.image("--size", "24x24", "--spp", 8, *more, "--sampler", sampler, "--seed", seed).mean(
        dtype=float) for seed in range(12)] for sampler in (name, "sobol")]
    assert_equal_means(*means, 0.001)


def test_pictures_do_not_depend_on_crops_threads_and_stops(pathtracer):
    common = ("--size", "40x30", "--sampler", "sobol4d", "--seed", 7)
    whole = read_layers(pathtracer.render(*common, "--spp", 5))
    crop = read_layers(pathtracer.render(*common, "--spp", 5, "--crop", "5,9,21,30", "--threads", 1))
    assert all((crop[name] == values[9:30, 5:21]).all() for name, values in whole.items())
    resumed = read_layers(pathtracer.render("--resume", pathtracer.render(*common, "--spp", 3), "--spp", 5))
    assert abs(resumed["R"] - whole["R"]).max() < 1e-5 * whole["R"].max() and (resumed["count"] == 5).all()


@pytest.mark.parametrize(("options", "said"), [(["--declare", 4], "--declare is for"), (["--mask", "builtin"], "--mask is for"),
                                               (["--first-sample", 2147483640, "--spp", 9], "2147483648")])
def test_what_it_does_not_take_is_refused(pathtracer, options, said):
    pathtracer.failure("--sampler", "sobol4d", *options, "-o", "out.exr", said=[said, "sobol4d"])
