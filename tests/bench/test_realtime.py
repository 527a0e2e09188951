# SPDX-License-Identifier: Apache-2.0
"""One sample per frame: the integrands, the frames that are drawn, the order of the errors, and the table in the guide."""

import numpy as np
import pytest
from report.base.tables import TableError, begin, update_table
from report.samplers import realtime

bluenoise = pytest.importorskip("bluenoise")


def test_a_key_and_an_index_per_frame():
    assert [realtime.place(frame, None) for frame in (0, 9)] == [(0, 0), (0, 9)]
    assert [realtime.place(frame, 8) for frame in (7, 8, 17)] == [(0, 7), (1, 0), (2, 1)]
    assert realtime.place(5, 1) == (5, 0)


def test_frames_are_draws_of_the_library():
    frames = realtime.draw_frames("blue", 8, 3, size=16, count=10)
    sampler = bluenoise.Sampler("blue", seed=3)
    assert frames.shape == (10, 16, 16, 2)
    assert np.array_equal(frames[9, 4, 7], sampler.sample(7, 4, 1, bluenoise.domain(1, 0), 2))


def test_half_planes_have_their_area():
    points = np.random.default_rng(2).random((200_000, 2))
    for plane in realtime.half_planes(np.random.default_rng(1), 6):
        inside = np.mean(points @ plane[:2] < plane[2])
        # Five standard deviations of at most 0.0011.
        assert 0 < inside < 1 and realtime.mean_inside(plane) == pytest.approx(inside, abs=0.006)


@pytest.fixture(scope="module")
def result():
    return realtime.measure(1, 2, size=64)


def test_white_noise_is_averaged_as_theory_says(result):
    white = result["`white`"]
    # Independent frames: the mean of 16 has a quarter of the error, the moving average the root of weight / (2 - weight).
    assert white["mean of 16"] / white["one frame"] == pytest.approx(0.25, rel=0.15)
    moving = (realtime.WEIGHT / (2 - realtime.WEIGHT)) ** 0.5
    assert white["moving average"] / white["one frame"] == pytest.approx(moving, rel=0.15)


def test_blue_is_best_where_the_guide_says(result):
    on, eight, every = (result[f"`blue`, {what}"] for what in ("the index goes on", "a new key every 8 frames",
                                                              "a new key every frame"))
    sobol = result["`sobol`, the index goes on"]
    # Every frame is blue, whatever its index.
    assert max(on["one frame"], eight["one frame"]) < 0.7 * sobol["one frame"]
    assert on["mean of 16"] < 0.7 * min(every["mean of 16"], sobol["mean of 16"])
    assert on["moving average"] < 0.8 * min(every["moving average"], sobol["moving average"])
    assert on["moving average"] < 1.1 * eight["moving average"]
    assert on["moving average, unblurred"] < 0.7 * every["moving average, unblurred"]


def test_the_table_takes_its_place(tmp_path, capsys):
    guide = tmp_path / "guide.md"
    guide.write_text(f"before\n{begin(realtime.COMMAND)}old\n<!-- end of the table -->\nafter\n")
    realtime.run(["--seeds", "1", "--integrands", "1", "--guide", str(guide)])
    text = guide.read_text()
    assert text.startswith("before\n") and text.endswith("\nafter\n") and "old" not in text
    assert capsys.readouterr().out.strip() in text and "| `white` | 1.00 | 1.00 | 1.00 | 1.00 |" in text


@pytest.mark.parametrize("text", ["", "<!-- table: a -->\n", "<!-- end of the table -->\n<!-- table: a -->\n",
                                  "<!-- table: a -->\n<!-- table: a -->\n<!-- end of the table -->\n"])
def test_a_guide_without_markers_is_left_alone(tmp_path, text):
    guide = tmp_path / "guide.md"
    guide.write_text(text)
    with pytest.raises(TableError, match="markers"):
        update_table(guide, "a", "table")
    assert guide.read_text() == text
