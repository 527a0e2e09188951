# SPDX-License-Identifier: Apache-2.0
"""A moving camera: reprojection, averages, draws that follow the image, and the page."""

import numpy as np
import pytest

from evidence.base.files import read_numbers
from evidence.realtime import motion, realtime

pytest.importorskip("bluenoise")


@pytest.fixture
def frames(pathtracer, tmp_path):
    program = pathtracer.parents[2] / "evidence" / "programs" / "render_frames"
    if not program.is_file():
        pytest.skip("render_frames is not built; run scripts/setup")
    return motion.Frames(program, "penumbra", tmp_path)


@pytest.mark.parametrize("way", motion.MOTIONS)
def test_reprojection_agrees_with_the_path_tracer(frames, way, monkeypatch):
    """Points seen in the last frame lie at the predicted depth in the first of three frames, except at silhouettes."""
    monkeypatch.setattr(motion, "FRAMES", 3)
    first, *_, last = motion.sequence(frames, "penumbra", way, 4)
    depth = frames.depth(last.camera, last.corner, motion.CROP)
    x, y, away = motion.motion_between(first.camera, last.camera, last.corner, depth)
    moved = [np.median(own - at) for own, at in zip(motion.centres(last.corner, depth.shape), (x, y))]
    assert np.hypot(*moved) == pytest.approx(8, rel=0.1) and np.hypot(*last.offset) == pytest.approx(8, abs=1)
    place = x - first.corner[0] - 0.5, y - first.corner[1] - 0.5
    seen, inside = frames.depth(first.camera, first.corner, motion.CROP)[motion.nearest(*place, motion.CROP)], motion.is_inside(*place, motion.CROP)
    assert np.mean(np.abs(seen / away - 1)[inside] < 0.01) > 0.9 and inside.mean() > 0.8


@pytest.mark.parametrize("resampling", motion.RESAMPLING)
def test_resampling_reproduces_pixels_and_ramps(resampling):
    y, x = np.mgrid[:20, :30].astype(float)
    image = np.random.default_rng(1).random((20, 30))
    for picture, dx, dy in ((image, 3, -2), (2 * x - y, 0.3, -0.6)):
        shown = (motion.taps(resampling, x + dx, y + dy, (30, 20)) @ picture.ravel()).reshape(20, 30)
        expected = np.roll(image, (2, -3), (0, 1)) if picture is image else 2 * (x + dx) - (y + dy)
        assert shown[4:-4, 4:-4] == pytest.approx(expected[4:-4, 4:-4], abs=1e-4)


def test_averages_start_as_means_and_are_clamped():
    pictures = np.random.default_rng(2).random((12, 16, 18, 3)).astype(np.float32)
    averages = motion.Averages("bilinear")
    here = np.meshgrid(np.arange(18.0), np.arange(16.0))
    for t, picture in enumerate(pictures):
        averages.add(picture, here, np.ones((16, 18), bool))
        if t == 7:
            assert averages.histories[:, :, motion.COMBINATIONS.index((False, 0.1))] == pytest.approx(pictures[:8].mean(0), abs=1e-5)
            before = averages.histories.copy()
    # A frame of one value clamps the history to it, wherever that history came from.
    averages.add(np.full((16, 18, 3), 7, np.float32), here, np.ones((16, 18), bool))
    assert (averages.histories[:, :, motion.COMBINATIONS.index((True, 0.05))] == 7).all() and before.max() < 1
    # History that is not known starts anew.
    averages.add(pictures[0], here, np.zeros((16, 18), bool))
    assert averages.histories[:, :, motion.COMBINATIONS.index((False, 0.05))] == pytest.approx(pictures[0], abs=1e-6)


def test_draws_that_follow_have_less_noise_and_are_those_of_a_still_image(frames):
    ways = {name: way for name, way in motion.ways_of({}).items() if way.sampler == "blue"}
    found = {row["way"]: row["noise"] for row in motion.measure(frames, "penumbra", "pan", 2, ways)
             if (row["resampling"], row["clamped"], row["weight"], row["sigma"]) == (*motion.MAIN, 1.0)}
    assert found["`blue`, following"] < 0.75 * found["`blue`"]  # mean squares


def test_slices_and_their_page(frames, tmp_path, monkeypatch, capsys):
    """Slices reach the path tracer, results are cached, and ways of an earlier run stay in the page."""
    for name, value in {"SCENES": {"penumbra": (400, 520)}, "FRAMES": 4, "MEASURED": (3,), "AGE": 1, "SPEEDS": (2,), "REFERENCE_SPP": 2, "CROP": (40, 32),
                        "FILM_FRAMES": 2, "FILM_SIZE": (40, 32)}.items():
        monkeypatch.setattr(motion, name, value)
    guide = tmp_path / "guide.md"
    guide.write_text(f"<!-- table: {motion.COMMAND} -->\nold\n<!-- end of the table -->\n")
    pairs = np.random.default_rng(3).integers(0, 256, (3, 16, 16, 4), np.uint8)
    for i, slice_of in enumerate(pairs):
        realtime.Image.fromarray(slice_of).save(tmp_path / f"vector2_uniform_{i}.png")
    arguments = ["--motion", "--frames", str(frames.command[0]), "--out", str(tmp_path / "out"), "--guide", str(guide)]
    realtime.run([*arguments, "--slices", f"FAST={tmp_path}/vector2_uniform_"])
    rows = read_numbers(tmp_path / "out" / "motion.csv")
    assert {row["way"] for row in rows} > {"FAST", "FAST, following", "`blue`, a stream per frame", "mask + R2"}
    assert all(row["noise"] > 0 and row["total"] > 0 for row in rows)
    assert "| FAST | " in guide.read_text() and "old" not in guide.read_text() and (tmp_path / "out" / "motion.webp").is_file()
    monkeypatch.setattr(motion, "measure", lambda *_: pytest.fail("cached results are measured again"))
    realtime.run([*arguments, "--slices", f"FAST={tmp_path}/vector2_uniform_"])
    assert len(read_numbers(tmp_path / "out" / "motion.csv")) == len(rows)
    page = (tmp_path / "out" / "motion.md").read_text()
    assert page.count("| FAST, following |") == 5 and "at most" in page and capsys.readouterr().out.count("# A moving camera") == 2
