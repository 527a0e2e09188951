# SPDX-License-Identifier: Apache-2.0
"""The comparison in pbrt-v4: scenes, crops, measures and the report. With BN_PBRT=DIR, a checkout of pbrt-v4, the sampler's
pictures too: crops, threads and the wavefront integrator. That builds pbrt, which takes a quarter of an hour the first time."""

import os
import subprocess
from types import SimpleNamespace

import numpy as np
import pytest
from conftest import ROOT
from report.base.files import read_exr
from report.others import other_renderer, pbrt, pbrt_build, pbrt_report, pbrt_scenes

# ---- Scenes and crops


def test_crops_stay_where_they_are():
    """They were placed before anything was rendered."""
    assert [view.bounds[::2] for view in pbrt_scenes.crops("cornell", "final")] == [(619, 563), (850, 857), (28, 418)]


# ---- Measures and stand-ins


# ---- The checkout

@pytest.fixture
def checkout(tmp_path):
    """What looks like a checkout with one submodule and one large file, at a commit that is taken for the pinned one."""
    folder = tmp_path / "pbrt-v4"
    (folder / "src" / "pbrt").mkdir(parents=True)
    (folder / "src" / "pbrt" / "samplers.h").write_text("first\n")
    (folder / "src" / "ext" / "ptex").mkdir(parents=True)
    (folder / "src" / "ext" / "ptex" / "CMakeLists.txt").write_text("\n")
    (folder / "src" / "pbrt" / "util").mkdir()
    (folder / pbrt_build.MASKS).write_text("version https://git-lfs.github.com/spec/v1\n")
    for words in (["init", "-q"], ["add", "-A"], ["-c", "user.name=a", "-c", "user.email=a@b", "commit", "-q", "-m", "a"]):
        subprocess.run(["git", "-C", folder, *words], check=True)
    return folder


def test_the_copy_is_patched_and_the_checkout_stays(checkout, tmp_path, monkeypatch):
    patch = tmp_path / "own.patch"
    patch.write_text("--- a/src/pbrt/samplers.h\n+++ b/src/pbrt/samplers.h\n@@ -1 +1,2 @@\n first\n+second\n")
    monkeypatch.setattr(pbrt_build, "PATCH", patch)
    monkeypatch.setattr(pbrt_build, "STAND_INS", {pbrt_build.MASKS: (lambda: "stand-in\n", "a stand-in")})
    folder = tmp_path / "build"
    folder.mkdir()
    assert pbrt_build.prepare(checkout, folder) == [pbrt_build.MASKS]
    copy = folder / "src"
    assert (copy / "src" / "pbrt" / "samplers.h").read_text() == "first\nsecond\n"
    assert (copy / pbrt_build.MASKS).read_text() == "stand-in\n"
    assert (copy / "src" / "pbrt" / "blue.h").read_text() == (pbrt_build.OWN / "blue.h").read_text()
    assert (checkout / "src" / "pbrt" / "samplers.h").read_text() == "first\n"
    assert subprocess.run(["git", "-C", checkout, "status", "--porcelain"], capture_output=True, text=True).stdout == ""
    # Again with another patch: only what it changes is new.
    times = {path: path.stat().st_mtime_ns for path in copy.rglob("*") if path.is_file()}
    patch.write_text(patch.read_text().replace("second", "third"))
    pbrt_build.prepare(checkout, folder)
    assert {path.name for path, old in times.items() if path.stat().st_mtime_ns != old} == {"samplers.h"}


# ---- The report

class Made:
    """Cells made up: blue's error is half of the others', zsobol's does not fall, and a sample takes a microsecond."""

    def get(self, view, label, spp, measure):
        if measure == "seconds":
            return [0.1 + spp * pbrt_scenes.CROP[0] * pbrt_scenes.CROP[1] * 1e-6 * (1 if label == "independent" else 2)] * 4
        return [(0.5 if label == "blue" else 1.0) / np.sqrt(spp)] * 4


def made_of(*scenes):
    options = SimpleNamespace(samplers=list(pbrt.SAMPLERS), seeds=4, views="final", command="scripts/bench pbrt --pbrt DIR")
    views = [view for scene in scenes for view in pbrt_scenes.crops(scene, "final")]
    references = {view: other_renderer.Reference(np.zeros((2, 2, 3)), dict.fromkeys(pbrt.MEASURES, 0.001), 4096, 1.0) for view in views}
    return pbrt_report.Report(options, Made(), references, ("A remark.",), list(pbrt.COUNTS))


@pytest.fixture
def made():
    return made_of("cornell", "room")


def test_ratios_are_over_blue(made):
    gains = made.sets["Held-out scenes"]
    assert {view.scene for view in gains.views} == {"room"}
    gain = gains.gain("blue", 6, "rmse_2.1", "zsobol")
    assert (gain.value, gain.low, gain.high) == pytest.approx((2, 2, 2))
    text = made.text()
    assert text.index("## Held-out scenes") < text.index("## Tuning scenes") and "A remark." in text
    assert "| `zsobol` |" + " 2.00 (2.00) |" * 7 in made.summary()
    assert "2.00 (2.00 to 2.00)" in text and "None" not in text and " nan" not in text and "without `hair`" not in text
    assert "without `hair`" in made_of("hair", "room").text()


def test_time_to_an_error(made):
    # blue needs a quarter of the samples; independent's take half the time.
    gains = made.sets["Held-out scenes"]
    assert made.equal_error(gains, "rmse_2.1", "halton").value == pytest.approx(4)
    assert made.equal_error(gains, "rmse_2.1", "independent").value == pytest.approx(2)
    assert "| `independent` | 1.00 | 1.00 |" in made.rates_table() and "| `blue` | 2.00 | 2.00 |" in made.rates_table()


# ---- With pbrt

@pytest.fixture(scope="module")
def program():
    if not os.environ.get("BN_PBRT"):
        pytest.skip("BN_PBRT is not set to a checkout of pbrt-v4")
    return pbrt_build.build(ROOT / os.environ["BN_PBRT"], os.cpu_count() or 1).program


@pytest.fixture(scope="module")
def picture(program, tmp_path_factory):
    folder = tmp_path_factory.mktemp("pictures")

    def picture(scene="motion", bounds=(600, 640, 400, 430), spp=4, seed=1, threads=1, sampler="blue", more=(), edit=lambda text: text):
        path = pbrt_scenes.write_files(folder, pbrt_scenes.SCENES[scene], sampler, pbrt.SAMPLERS[sampler])
        path.write_text(edit(path.read_text()))
        out = folder / "out.exr"
        subprocess.run([program, "--quiet", "--nthreads", str(threads), "--spp", str(spp), "--seed", str(seed), *more,
                        "--pixelbounds", ",".join(map(str, bounds)), "--outfile", out, path], check=True)
        return read_exr(out)[0]

    return picture


def test_the_patch_applies_to_the_checkout(program):
    subprocess.run(["git", "-C", os.environ["BN_PBRT"], "apply", "--check", pbrt_build.PATCH], check=True)


def test_crops_threads_and_seeds(picture):
    whole = picture()
    assert np.array_equal(picture(bounds=(611, 625, 407, 420)), whole[7:20, 11:25])
    assert np.array_equal(picture(threads=3), whole)
    assert not np.array_equal(picture(seed=2), whole)
    # The first samples of a longer run are those of a shorter one: more samples of the same sequence differ less.
    assert not np.array_equal(picture(spp=5), whole)


def test_the_wavefront_integrator_renders_the_same(picture):
    """Up to the first surface's light and direction the two ask for the same; their arithmetic differs in the last digits."""
    def once(text):
        return text.replace('"integer maxdepth" [ 5 ]', '"integer maxdepth" [ 1 ]').replace('"integer maxdepth" 5', '"integer maxdepth" 1')

    ours, theirs = picture(edit=once), picture(edit=once, more=["--wavefront"])
    assert np.mean(np.abs(ours - theirs) > 1e-3 * (1 + ours)) < 0.01
    other = picture(edit=once, seed=2)
    assert np.mean(np.abs(ours - other) > 1e-3 * (1 + ours)) > 0.5


@pytest.mark.parametrize("scene", ["skin", "fog", "room"])
def test_both_integrators_agree_with_another_sampler(picture, scene):
    """The means of a patch; at 64 samples they differ by a few per cent."""
    wanted = picture(scene, spp=64, sampler="independent").mean()
    for more in ((), ("--wavefront",)):
        assert picture(scene, spp=64, more=more).mean() == pytest.approx(wanted, rel=0.05)
