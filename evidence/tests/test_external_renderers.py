# SPDX-License-Identifier: Apache-2.0
"""The comparisons in pbrt-v4 and Cycles. If BN_PBRT_PROGRAM names a patched pbrt, or BN_CYCLES_PROGRAM and BN_CYCLES name a patched
Cycles and its sources, the tests also render: crops, threads, seeds and the wavefront integrator."""

import dataclasses
import os
import subprocess
from types import SimpleNamespace

import numpy as np
import pytest

from evidence.base.files import read_exr
from evidence.external_renderers import cycles, other_renderer, pbrt, pbrt_scenes


def test_crop_positions_are_fixed():
    """The crops were chosen before any image was rendered."""
    assert [view.crop[:2] for view in pbrt_scenes.crops("room")] == [(887, 210), (864, 581)]


class Made:
    """Synthetic cells: `blue` has half the error of the other samplers, and a sample takes one or two microseconds."""

    def get(self, view, label, spp, measure):
        if measure == "seconds":
            return [0.1 + spp * pbrt_scenes.CROP[0] * pbrt_scenes.CROP[1] * 1e-6 * (1 if label == "independent" else 2)] * 4
        return [(0.5 if label == "blue" else 1.0) / np.sqrt(spp)] * 4


def test_page_states_errors_relative_to_blue(tmp_path):
    options = SimpleNamespace(name="pbrt", out=tmp_path, seeds=4, counts=pbrt.COUNTS, command="scripts/bench pbrt --program FILE")
    views = [view for scene in ("kitchen", "kitchen-fixed") for view in pbrt_scenes.crops(scene)]
    references = {view: other_renderer.Reference(np.zeros((2, 2, 3)), dict.fromkeys(other_renderer.MEASURES, 0.001), 4096, 1.0) for view in views}
    thans = {name: f"`{name}`" for name in pbrt.SAMPLERS if name != "blue"}
    made = other_renderer.OtherReport(options, Made(), references, thans, pbrt.SETS, {view.scene: pbrt_scenes.OWN["skin"] for view in views})
    assert list(made.sets) == ["Fixed wavelengths", "Four random wavelengths"] and {view.scene for view in made.compared.views} == {"kitchen-fixed"}
    own = made.compared.over("zsobol", 6, "rmse_2.1")
    assert (own.value, own.low, own.high) == pytest.approx((2, 2, 2))
    summary = made.summary(thans)
    assert summary.count("| `zsobol` |" + " 2.00 (2.00) |" * 6) == 2 and summary.startswith("Fixed wavelengths (4 seeds; 1 scenes, 2 crops rendered):")
    assert not made.write(vars(pbrt), summary) and (tmp_path / "pbrt.csv").is_file()
    text = (tmp_path / "pbrt.md").read_text()
    assert "| **2.00** |" in text and "None" not in text and " nan" not in text and "Exposed and" in text
    assert "| `independent` | 1.00 | 1.00 |" in text and "| `blue` | 2.00 | 2.00 |" in text


# ---- With pbrt

@pytest.fixture
def picture(tmp_path):
    def picture(scene="penumbra", bounds=(600, 640, 400, 430), spp=4, seed=1, threads=1, sampler="blue", flags=(), **changed):
        path = pbrt_scenes.write_files(tmp_path, dataclasses.replace(pbrt_scenes.OWN[scene], **changed), sampler, pbrt.SAMPLERS[sampler])
        subprocess.run([os.environ["BN_PBRT_PROGRAM"], "--quiet", "--nthreads", str(threads), "--spp", str(spp), "--seed", str(seed), *flags,
                        "--pixelbounds", ",".join(map(str, bounds)), "--outfile", tmp_path / "out.exr", path], check=True)
        return read_exr(tmp_path / "out.exr")[0]

    if not os.environ.get("BN_PBRT_PROGRAM"):
        pytest.skip("BN_PBRT_PROGRAM is not set to a patched pbrt-v4")
    return picture


def test_crops_threads_and_seeds(picture):
    whole = picture()
    assert np.array_equal(picture(bounds=(611, 625, 407, 420)), whole[7:20, 11:25])
    assert np.array_equal(picture(threads=3), whole)
    assert not np.array_equal(picture(seed=2), whole)


def test_wavefront_integrator_renders_the_same_image(picture):
    """Both integrators draw the same numbers up to the light and direction at the first surface; only their rounding differs."""
    ours, theirs, other = picture(depth=1), picture(depth=1, flags=["--wavefront"]), picture(depth=1, seed=2)
    assert np.mean(np.abs(ours - theirs) > 1e-3 * (1 + ours)) < 0.01 and np.mean(np.abs(ours - other) > 1e-3 * (1 + ours)) > 0.5


@pytest.mark.parametrize(("scene", "lens"), [("skin", 0), ("penumbra", 0.12)])
def test_both_integrators_agree_with_another_sampler(picture, scene, lens):
    """Compares the mean values of a patch, which differ by a few per cent at 64 samples per pixel."""
    means = [picture(scene, spp=64, sampler=sampler, flags=flags, more=f' "float lensradius" {lens} "float focaldistance" 5.6').mean()
             for sampler, flags in (("independent", ()), ("blue", ()), ("blue", ["--wavefront"]))]
    assert means == pytest.approx(means[:1] * 3, rel=0.05)


# ---- With Cycles

@pytest.fixture
def cycles_run():
    if not os.environ.get("BN_CYCLES_PROGRAM") or not os.environ.get("BN_CYCLES"):
        pytest.skip("BN_CYCLES_PROGRAM and BN_CYCLES are not set to a patched Cycles and its sources")
    work = cycles.CyclesRun(os.environ["BN_CYCLES_PROGRAM"], os.environ["BN_CYCLES"], 1)
    return lambda sampler, tuned_for, spp, seed=1: work.rendered(other_renderer.Task(cycles.view_of("penumbra"), sampler, tuned_for=tuned_for), spp, seed)[1]


def test_images_differ_only_between_seeds(cycles_run):
    first, again, other = (cycles_run("blue", 2, 2, seed) for seed in (1, 1, 2))
    assert np.array_equal(first, again) and np.mean(first != other) > 0.5 and abs(first.mean() / other.mean() - 1) < 0.02


@pytest.mark.parametrize("sampler", cycles.SAMPLERS)
def test_only_cycles_own_blue_noise_depends_on_the_declared_sample_count(cycles_run, sampler):
    """The declared sample count changes Cycles' own blue noise, as the table "Stopped early" assumes, but no other pattern."""
    assert np.array_equal(cycles_run(sampler, 4, 4), cycles_run(sampler, 64, 4)) == (sampler not in cycles.PREVIEW)
