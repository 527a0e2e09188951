# SPDX-License-Identifier: Apache-2.0
"""The comparison in pbrt-v4: scenes, crops, measures and the report. With BN_PBRT=DIR, a checkout of pbrt-v4, the sampler's
pictures too: crops, threads and the wavefront integrator. That builds pbrt, which takes a quarter of an hour the first time."""

import os
import subprocess
from types import SimpleNamespace

import numpy as np
import pytest
from conftest import ROOT
from report.base.files import read_exr, write_exr
from report.measure.image_error import all_errors
from report.others import other_renderer, pbrt, pbrt_build, pbrt_report, pbrt_scenes
from report.renders.renderer import RenderError

# ---- Scenes and crops

def test_scenes_are_halved_and_crops_differ():
    assert len(pbrt_scenes.TUNING) == len(pbrt_scenes.HELD_OUT) == 6 and len(pbrt_scenes.SCENES) == 12
    places = []
    for scene in pbrt_scenes.SCENES:
        for purpose in pbrt.VIEWS:
            for view in pbrt_scenes.crops(scene, purpose):
                x0, x1, y0, y1 = view.bounds
                assert 0 <= x0 < x1 <= pbrt_scenes.WIDTH and 0 <= y0 < y1 <= pbrt_scenes.HEIGHT
                assert (x1 - x0, y1 - y0) == pbrt_scenes.CROP
                places.append((scene, x0, y0))
    assert len(set(places)) == 12 * 3 * pbrt_scenes.CROPS


def test_crops_stay_where_they_are():
    """They were placed before anything was rendered."""
    assert [view.bounds[::2] for view in pbrt_scenes.crops("cornell", "final")] == [(619, 563), (850, 857), (28, 418)]


def test_a_lamp_looks_where_its_sides_say():
    text = pbrt_scenes.lamp((0, 0, 3), (0, 2, 0), (2, 0, 0), (1, 2, 3))
    numbers = [float(word) for word in text.split('"point3 P" [')[1].split("]")[0].split()]
    p = np.array(numbers).reshape(4, 3)
    assert np.cross(p[1] - p[0], p[2] - p[0])[2] < 0 and '"rgb L" [ 1 2 3 ]' in text


def test_the_sky_has_equal_areas():
    """The mean of a function over the pixels is its mean over the sphere, and every direction has length 1."""
    d = pbrt_scenes.sphere_of_square(64)
    assert np.allclose(np.linalg.norm(d, axis=-1), 1)
    assert np.allclose(d.mean((0, 1)), 0, atol=1e-9) and np.allclose((d**2).mean((0, 1)), 1 / 3, atol=1e-3)
    assert np.isfinite(pbrt_scenes.sky_image()).all()


def test_a_scene_names_its_sampler_and_a_film_that_spreads_no_sample(tmp_path):
    path = pbrt_scenes.write_files(tmp_path, pbrt_scenes.SCENES["metal"], "blue", 'Sampler "blue"')
    text = path.read_text()
    assert text.count("Sampler") == 1 and '"box" "float xradius" 0.5 "float yradius" 0.5' in text and '"string sensor" "cie1931"' in text
    assert read_exr(tmp_path / pbrt_scenes.SKY)[0].shape == (pbrt_scenes.SKY_SIZE, pbrt_scenes.SKY_SIZE, 3)


# ---- Measures and stand-ins

def test_errors_of_rgb_are_those_of_every_report():
    picture, reference = np.random.default_rng(1).random((2, 20, 30, 3)) * 2
    ours, theirs = pbrt.errors(picture, reference), all_errors(picture, reference)
    assert set(ours) == set(pbrt.MEASURES)
    for kind in ("rmse", "displayed"):
        for sigma, name in ((0.0, kind), (1.0, f"{kind}_1.0"), (2.1, f"{kind}_2.1")):
            assert ours[f"{kind}_{sigma}"] == pytest.approx(theirs[name])
    grey = np.repeat(picture[..., :1], 3, 2), np.repeat(reference[..., :1], 3, 2)
    same = pbrt.errors(*grey)
    assert same["luminance_1.0"] == pytest.approx(same["rmse_1.0"]) and same["displayed_luminance_0.0"] < same["luminance_0.0"]


def test_stand_in_points_are_nets():
    pytest.importorskip("bluenoise")
    sets = pbrt_build.point_sets()
    assert sets.shape == (5, 65536, 2) and len({points.tobytes() for points in sets}) == 5
    for points in sets:
        for m in (4, 10, 16):
            for k in range(m + 1):
                x, y = (points[:2**m] >> np.array([32 - k, 32 - m + k], np.uint64)).T.astype(np.int64)
                assert len(np.unique(x << (m - k) | y)) == 2**m


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


def test_another_commit_is_refused_with_the_commands_that_help(checkout, tmp_path):
    with pytest.raises(RenderError, match="checkout 5f7a6068"):
        pbrt_build.check(checkout)
    with pytest.raises(RenderError, match="git clone --recursive"):
        pbrt_build.check(tmp_path)


def test_missing_large_files_are_found(checkout):
    assert pbrt_build.missing(checkout) == [pbrt_build.MASKS, pbrt_build.POINTS]
    (checkout / pbrt_build.MASKS).write_text("const int a[] = {1, 2};\n")
    assert pbrt_build.missing(checkout) == [pbrt_build.POINTS]


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


def test_a_reference_too_noisy_leaves_a_crop_out(made):
    gains = made.sets["Held-out scenes"]
    gains.references[gains.views[0]].own["rmse_2.1"] = 0.03  # a half of blue's error at 64 samples, a twelfth at 1
    assert gains.gain("blue", 64, "rmse_2.1", "sobol").left_out == 1
    assert gains.gain("blue", 1, "rmse_2.1", "sobol").left_out == 0


def test_time_to_an_error(made):
    # blue needs a quarter of the samples; independent's take half the time.
    gains = made.sets["Held-out scenes"]
    assert made.equal_error(gains, "rmse_2.1", "halton").value == pytest.approx(4)
    assert made.equal_error(gains, "rmse_2.1", "independent").value == pytest.approx(2)
    assert "| `independent` | 1.00 | 1.00 |" in made.rates_table() and "| `blue` | 2.00 | 2.00 |" in made.rates_table()


def test_counts_that_a_sampler_rounds_are_looked_up():
    view = pbrt_scenes.crops("cornell", "final")[0]
    task = pbrt.Task(view, "zsobol", 1, (2, 4))
    cells = pbrt.PbrtCells({task: ([{"spp": 2, "rmse_2.1": 0.25}, {"spp": 4, "rmse_2.1": 0.125}], {})})
    assert cells.get(view, "zsobol", 3, "rmse_2.1") == [0.25] and cells.get(view, "zsobol", 6, "rmse_2.1") == [0.125]


def test_options():
    options = pbrt.parse_options(["--pbrt", "/some/where", "--quick", "--jobs", "2"])
    assert options.command == "scripts/bench pbrt --pbrt DIR --quick"
    assert (options.seeds, options.spp, options.whole, str(options.out)) == (2, 16, False, "out/pbrt")
    options = pbrt.parse_options(["--pbrt=/some/where"])
    assert options.command == "scripts/bench pbrt --pbrt=DIR" and options.whole and str(options.out) == "docs/report"
    for part in (["--spp", "4"], ["--seeds", "1"], ["--samplers", "blue,zsobol"], ["--scenes", "hair"]):
        assert str(pbrt.parse_options(["--pbrt", "x", *part]).out) == "out/pbrt", part
    with pytest.raises(SystemExit):
        pbrt.parse_options(["--pbrt", "x", "--views", "tuning", "--scenes", "room"])


def test_pbrt_that_fails_is_an_error_with_its_last_line(tmp_path):
    program = tmp_path / "pbrt"
    program.write_text("#!/bin/sh\necho warning >&2\necho no such sampler >&2\nexit 1\n")
    program.chmod(0o755)
    with pytest.raises(RenderError, match="no such sampler"):
        pbrt.render(program, "scene.pbrt", (0, 1, 0, 1), 1, 1, tmp_path / "out.exr")
    with pytest.raises(RenderError, match="cannot run"):
        pbrt.render(tmp_path / "missing", "scene.pbrt", (0, 1, 0, 1), 1, 1, tmp_path / "out.exr")


def test_the_picture(tmp_path, monkeypatch):
    x0, x1, y0, y1 = pbrt.PICTURE_BOUNDS
    asked = []

    def render(program, scene_file, bounds, spp, seed, out):
        asked.append((scene_file.stem, spp))
        write_exr(out, np.random.default_rng(spp).random((y1 - y0, x1 - x0, 3)).astype(np.float32), {})

    monkeypatch.setattr(pbrt, "render", render)
    pbrt.run(["--pbrt", "x", "--program", "pbrt", "--picture", str(tmp_path / "picture.jpg")])
    left, top, width, height = pbrt.PICTURE_PART
    assert left + width <= x1 - x0 and top + height <= y1 - y0 and (tmp_path / "picture.jpg").is_file()
    assert asked == [(f"penumbra-{name}", 6) for name in pbrt.PICTURE_SAMPLERS] + [("penumbra-reference", 512)]


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
