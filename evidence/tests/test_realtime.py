# SPDX-License-Identifier: Apache-2.0
"""One sample per frame: mask slices read from files, error measures, moving averages, sparse frames, and tables in pages."""

import numpy as np
import pytest
from PIL import Image

from evidence.base.command import CommandError
from evidence.base.files import write_rows
from evidence.base.tables import update_table
from evidence.realtime import realtime

pytest.importorskip("bluenoise")


# ---- Slices

def write(folder, name, slices):
    for i, pixels in enumerate(slices):
        Image.fromarray(pixels).save(folder / f"{name}{i}.png")


def test_stacks_are_read_in_order_with_their_channels(tmp_path):
    random = np.random.default_rng(1)
    grey, deep = random.integers(0, 256, (12, 8, 8), np.uint8), random.integers(0, 65536, (2, 8, 8), np.uint16)
    vectors = random.integers(0, 256, (12, 8, 8, 4), np.uint8)
    for name, stack in (("vec2_", vectors), ("other_vec2_", vectors + 1), ("vec2_x", vectors + 1), ("scalar_", grey), ("rgb", grey[..., None].repeat(3, -1)), ("deep", deep)):
        write(tmp_path, name, stack)
    scalars, pairs = (realtime.read_stack(tmp_path / name) for name in ("scalar_", "vec2_"))
    assert np.array_equal(scalars[..., 0], (grey + np.float32(0.5)) / 256) and np.array_equal(scalars, realtime.read_stack(tmp_path / "rgb"))
    assert np.array_equal(pairs, (vectors[..., :2] + np.float32(0.5)) / 256)
    assert np.allclose(realtime.read_stack(tmp_path / "deep")[..., 0], (deep + 0.5) / 65536)
    slices = realtime.Slices(scalars, pairs)
    assert slices.stack_for(1) is scalars and slices.stack_for(4) is pairs
    # Slices repeat over the screen and over frames. The second pair uses a different offset.
    first, again = slices.frame(2, 4, 0, 16), slices.frame(14, 4, 0, 16)
    assert np.array_equal(first, again) and np.array_equal(first[:8, :8], first[8:, 8:])
    assert not np.array_equal(first[..., :2], first[..., 2:])
    assert np.array_equal(np.sort(first[:8, :8, 2], None), np.sort(first[:8, :8, 0], None))
    write(tmp_path, "deep", [deep[0], deep[1, :4]])
    for name in ("deep", "none"):
        with pytest.raises(CommandError, match="cannot read slices"):
            realtime.read_stack(tmp_path / name)


# ---- The measure

def test_integrands_have_the_stated_mean():
    points = np.random.default_rng(2).random((200_000, 4), np.float32)
    for dimensions, make in realtime.INTEGRANDS.values():
        for i in range(4):
            values, mean = make(np.random.default_rng(i))
            # The limit is five standard deviations of at most 0.0011 each.
            assert 0 < mean < 1 and np.mean(values(points[:, :dimensions])) == pytest.approx(mean, abs=0.006)


def test_filtering_spectra_matches_filtering_images():
    picture = np.random.default_rng(3).normal(size=(1, 32, 32))
    found = realtime.squares(np.fft.rfft2(picture))[0]
    expected = [np.mean(keep(picture[0]) ** 2) for keep in realtime.FILTERS.values()]
    assert found == pytest.approx(expected, rel=1e-6)


@pytest.fixture(scope="module")
def result():
    return realtime.measure(realtime.WAYS, 1, 3, ("half-plane", "step"), size=64)


def test_averaged_white_noise_matches_theory(result):
    unfiltered = dict(zip(realtime.OUTCOMES, result["half-plane", "white"][0][:, 0]))
    assert unfiltered["mean of 8"] / unfiltered["one frame"] == pytest.approx(8**-0.5, rel=0.1)
    assert unfiltered["average, 0.1"] / unfiltered["one frame"] == pytest.approx((0.1 / 1.9) ** 0.5, rel=0.1)


def test_samplers_rank_as_the_guide_states(result):
    one, average, blur = realtime.OUTCOMES.index("one frame"), realtime.OUTCOMES.index("average, 0.1"), 1

    def error(kind, way, outcome):
        return result[kind, way][0][outcome, blur] / result[kind, "white"][0][outcome, blur]

    for kind in ("half-plane", "step"):
        assert error(kind, "blue", average) < 0.75 * error(kind, "blue, a new stream every frame", average)
        assert error(kind, "mask + golden ratio, R2", one) < error(kind, "blue", one) < 0.8 * error(kind, "sobol", one)
    assert error("half-plane", "blue", average) < error("half-plane", "mask + golden ratio, R2", average)
    # The noise of every frame is blue, whatever its index.
    alone = result["half-plane", "blue"][1][:, blur]
    assert alone.max() < 1.2 * alone.min()


def test_sparse_frames_should_count_samples_per_pixel():
    integrands = [realtime.half_plane(np.random.default_rng(i)) for i in range(3)]
    for part in realtime.PARTS:
        white = realtime.part_errors(part, "white", next(iter(realtime.GIVEN.values())), 1, integrands, 64)
        frame, screen, small = (np.sqrt(realtime.part_errors(part, "blue", given, 1, integrands, 64) / white)[:, 1]
                                for given in realtime.GIVEN.values())
        assert screen[1] < 0.6 * frame[1] and small[1] < 0.8 * frame[1] and small[0] < 0.9 * screen[0]


# ---- Tables in pages

def test_page_keeps_earlier_rows_that_were_not_measured(tmp_path, monkeypatch):
    monkeypatch.setattr(realtime, "SIZE", 32)
    ways = {**realtime.WAYS, "FAST": realtime.WAYS["sobol"]}
    result = {(kind, way): (np.full((6, 5), 2.0 if way == "white" else 1.0), np.ones((1, 5))) for kind in realtime.INTEGRANDS for way in ways}
    monkeypatch.setattr(realtime, "measure", lambda *_: result)
    monkeypatch.setattr(realtime, "measure_parts", lambda *_: {("checkerboard", "x"): np.ones((2, 5))})
    earlier = [row for row in realtime.rows_of(result, ways) if row["way"] == "FAST"]
    write_rows(tmp_path / "realtime.csv", realtime.FIELDS, earlier)
    realtime.run(["--seeds", "1", "--integrands", "1", "--out", str(tmp_path)])
    text = (tmp_path / "realtime.md").read_text()
    assert "| white | 2.00 | 2.00 |" in text and "| FAST | 1.00 | 1.00 |" in text and "| checkerboard |" in text and (tmp_path / "realtime.png").exists()


def test_guide_without_markers_is_unchanged(tmp_path):
    guide, start, end = tmp_path / "guide.md", "<!-- table: a -->\n", "<!-- end of the table -->\n"
    for text in ("", start, end + start, start + start + end):
        guide.write_text(text)
        with pytest.raises(CommandError, match="markers"):
            update_table(guide, "a", "table")
        assert guide.read_text() == text
