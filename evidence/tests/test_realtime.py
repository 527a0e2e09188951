# SPDX-License-Identifier: Apache-2.0
"""One sample a frame: slices from files, the measure, averages that follow a moving camera, and tables in pages."""

import numpy as np
import pytest
from PIL import Image

from evidence.base.command import CommandError
from evidence.base.tables import begin, update_table
from evidence.measure.image_error import blurred
from evidence.realtime import moving, realtime

pytest.importorskip("bluenoise")


# ---- Slices

def write(folder, name, pixels):
    Image.fromarray(pixels).save(folder / name)


def test_packs_are_read_in_order_with_their_channels(tmp_path):
    random = np.random.default_rng(1)
    scalar = random.integers(0, 256, (12, 8, 8), np.uint8)
    vectors = random.integers(0, 256, (12, 8, 8, 4), np.uint8)
    for i in range(12):
        write(tmp_path, f"stbn_scalar_2Dx1Dx1D_8x8x12x1_{i}.png", scalar[i])
        write(tmp_path, f"stbn_vec2_2Dx1D_8x8x12_{i}.png", vectors[i])
        write(tmp_path, f"stbn_unitvec2_2Dx1D_8x8x12_{i}.png", vectors[i])
        write(tmp_path, "stbn_vec2_2Dx1D_8x8x12.mag.xy.png", vectors[i])
    slices = realtime.read_pack("STBN", tmp_path)
    assert np.array_equal(slices.stack_for(1)[..., 0], (scalar + np.float32(0.5)) / 256)
    assert np.array_equal(slices.stack_for(2), (vectors[..., :2] + np.float32(0.5)) / 256)
    # Slices repeat over the screen and over frames; a second pair comes from another place.
    first, again = slices.frame(2, 4, 0, 16), slices.frame(14, 4, 0, 16)
    assert np.array_equal(first, again) and np.array_equal(first[:8, :8], first[8:, 8:])
    assert not np.array_equal(first[..., :2], first[..., 2:])
    assert np.array_equal(np.sort(first[:8, :8, 2], None), np.sort(first[:8, :8, 0], None))


def test_other_stacks_and_what_is_refused(tmp_path):
    deep = np.arange(64, dtype=np.uint16).reshape(8, 8) * 1000
    write(tmp_path, "mine3.png", deep)
    write(tmp_path, "mine4.png", deep)
    stack = realtime.read_pack("slices", tmp_path).stack_for(1)
    assert stack.shape == (2, 8, 8, 1) and np.allclose(stack[0, ..., 0], (deep + 0.5) / 65536)
    write(tmp_path, "mine5.png", deep[:4])
    for pack, said in (("FAST", "named like"), ("slices", "cannot read")):
        with pytest.raises(CommandError, match=said):
            realtime.read_pack(pack, tmp_path)


def test_what_a_mask_moves_by():
    assert realtime.golden_powers(1) == pytest.approx([0.6180339887])
    assert realtime.golden_powers(2) == pytest.approx([0.7548776662, 0.5698402909])


# ---- The measure

def test_integrands_have_their_mean():
    points = np.random.default_rng(2).random((200_000, 4), np.float32)
    for dimensions, make in realtime.INTEGRANDS.values():
        for i in range(4):
            values, mean = make(np.random.default_rng(i))
            # Five standard deviations of at most 0.0011.
            assert 0 < mean < 1 and np.mean(values(points[:, :dimensions])) == pytest.approx(mean, abs=0.006)


def test_filters_of_spectra_are_filters_of_pictures():
    picture = np.random.default_rng(3).normal(size=(1, 32, 32))
    found = realtime.squares(np.fft.rfft2(picture))[0]
    expected = [np.mean(keep(picture[0]) ** 2) for keep in realtime.FILTERS.values()]
    assert found == pytest.approx(expected, rel=1e-6)


@pytest.fixture(scope="module")
def result():
    return realtime.measure(realtime.WAYS, 1, 3, ("half-plane", "step"), size=64)


def test_white_noise_is_averaged_as_theory_says(result):
    unfiltered = dict(zip(realtime.OUTCOMES, result["half-plane", "white"].outcomes[:, 0]))
    assert unfiltered["mean of 8"] / unfiltered["one frame"] == pytest.approx(8**-0.5, rel=0.1)
    assert unfiltered["average, 0.1"] / unfiltered["one frame"] == pytest.approx((0.1 / 1.9) ** 0.5, rel=0.1)


def test_the_orders_that_the_guide_states(result):
    one, average, blur = realtime.OUTCOMES.index("one frame"), realtime.OUTCOMES.index("average, 0.1"), 1

    def error(kind, way, outcome):
        return realtime.over_white(result, kind, way)[outcome, blur]

    for kind in ("half-plane", "step"):
        assert error(kind, "blue", average) < 0.75 * error(kind, "blue, a new key every frame", average)
        assert error(kind, "mask + golden ratio, R2", one) < error(kind, "blue", one) < 0.8 * error(kind, "sobol", one)
    assert error("half-plane", "blue", average) < error("half-plane", "mask + golden ratio, R2", average)
    # Every frame is blue, whatever its index.
    alone = result["half-plane", "blue"].alone[:, blur]
    assert alone.max() < 1.2 * alone.min()


def test_sparse_frames_count_the_samples_of_a_pixel():
    integrands = [realtime.half_plane(np.random.default_rng(i)) for i in range(3)]
    for part in realtime.PARTS:
        white = realtime.part_errors(part, "white", next(iter(realtime.GIVEN.values())), 1, integrands, 64)
        frame, screen, small = (np.sqrt(realtime.part_errors(part, "blue", given, 1, integrands, 64) / white)[:, 1]
                                for given in realtime.GIVEN.values())
        assert screen[1] < 0.6 * frame[1] and small[1] < 0.8 * frame[1] and small[0] < 0.9 * screen[0]


# ---- Averages that follow surfaces

def frame_of(light, motion=(0.0, 0.0), distance=1.0, then=1.0):
    """A frame of a wall that moved by `motion` pixels since the one before."""
    height, width = light.shape[:2]
    frame = np.zeros((height, width, 13), np.float32)
    y, x = np.mgrid[:height, :width]
    frame[..., :3], frame[..., 8] = light.reshape(height, width, -1), 1
    frame[..., 9], frame[..., 10], frame[..., 11], frame[..., 12] = x - motion[0], y - motion[1], distance, then
    return frame


def test_history_moves_with_the_surface():
    x = np.arange(24.0)
    ramp = np.broadcast_to(x[None, :, None], (16, 24, 3))
    averages = moving.Accumulations()
    averages.add(frame_of(ramp))
    # The second frame sees the same ramp moved by 2.25 pixels: old and new agree where the surface was in view.
    second = averages.add(frame_of(ramp - 2.25, (2.25, 0)))
    for name in ("bilinear", "Catmull-Rom"):
        assert np.allclose(second[name][3:-3, 5:-3], (ramp - 2.25)[3:-3, 5:-3], atol=1e-4), name
    weights = np.array(moving.cubic(np.linspace(0, 1, 5)))
    assert np.allclose(weights.sum(0), 1) and np.allclose(np.arange(-1, 3) @ weights, np.linspace(0, 1, 5))


def test_weights_are_those_of_a_mean_and_then_of_a_moving_average():
    averages, light = moving.Accumulations(("bilinear",)), np.ones((8, 8, 3))
    found = [averages.add(frame_of(light * (t == 0)))["bilinear"][4, 4, 0] for t in range(13)]
    assert found[:10] == pytest.approx([1 / (t + 1) for t in range(10)], rel=1e-5)
    assert found[12] / found[11] == pytest.approx(0.9, rel=1e-5)


def test_hidden_surfaces_have_no_history_and_sparse_frames_keep_theirs():
    averages, light = moving.Accumulations(("bilinear",)), np.ones((8, 8, 3))
    averages.add(frame_of(light))
    assert np.allclose(averages.add(frame_of(0 * light, then=2.0))["bilinear"], 0)
    sparse = 0.5 * light
    sparse[::2] = np.nan
    kept = averages.add(frame_of(sparse))["bilinear"]
    assert np.allclose(kept[::2], 0) and np.allclose(kept[1::2], 0.25)
    # Without history, a hole shows the mean of what is around.
    assert np.allclose(averages.add(frame_of(sparse, then=2.0))["bilinear"], 0.5)


def test_clamping_takes_history_to_what_is_around():
    averages = moving.Accumulations(("Catmull-Rom", "Catmull-Rom, clamped"))
    averages.add(frame_of(np.full((8, 8, 3), 5.0)))
    after = averages.add(frame_of(np.ones((8, 8, 3))))
    assert np.allclose(after["Catmull-Rom"], 3) and np.allclose(after["Catmull-Rom, clamped"], 1, atol=1e-4)


needs_program = pytest.mark.skipif(not moving.PROGRAM.exists(), reason="no build with the path tracer")


@needs_program
def test_every_pixel_has_its_turn_and_stands_still_with_the_camera():
    size = (16, 12)
    for part, n in (("full", 1), ("checkerboard", 2), ("columns", 2), ("half", 4), ("quarter", 16)):
        each = list(moving.frames("penumbra", "blue", part, first=32, size=size, phase=16))[:n]
        drawn = sum(np.isfinite(frame[..., 0]).astype(int) for frame in each)
        assert np.array_equal(drawn, np.ones((12, 16))), part
        y, x = np.mgrid[:12, :16]
        seen = each[0][..., 11] > 0
        assert np.allclose(each[-1][seen][:, 9:11], np.stack([x, y], -1)[seen], atol=1e-3) or n == 1
        assert np.allclose(each[-1][seen][:, 11], each[-1][seen][:, 12], rtol=1e-4) or n == 1


@needs_program
def test_frames_average_to_the_reference_and_slices_are_read(tmp_path):
    size = (32, 24)
    reference, = moving.frames("penumbra", "white", given="pixel", samples=400, first=47, size=size, phase=16)
    draws = {"blue": "blue", "slices": str(tmp_path / "slices")}
    moving.write_slices(tmp_path / "slices", realtime.Draws("white").frame(0, 2, 5, 64)[None])
    for name, draw in draws.items():
        frame, = moving.frames("penumbra", draw, given="pixel" if name == "blue" else "screen", seed=3, first=47, size=size, phase=16)
        difference = blurred(np.clip(frame[..., :3], 0, 1) - np.clip(reference[..., :3], 0, 1), 4.0)
        assert np.abs(difference).max() < 0.12, name
    with pytest.raises(CommandError):
        list(moving.frames("penumbra", str(tmp_path / "missing"), size=size, phase=16))


# ---- Tables in pages

def test_the_table_takes_its_place(tmp_path, capsys):
    guide, end = tmp_path / "guide.md", "<!-- end of the table -->\n"
    empty = "".join(begin(f"{realtime.COMMAND}: {name}") + end for name in ("parts of the screen", "all figures"))
    guide.write_text(f"before\n{begin(realtime.COMMAND)}stale\n{end}{empty}after\n")
    realtime.run(["--seeds", "1", "--integrands", "1", "--guide", str(guide), "--out", str(tmp_path)])
    text = guide.read_text()
    assert text.startswith("before\n") and text.endswith("after\n") and "stale" not in text
    assert "| `white` | 1.00 | 1.00 | 1.00 |" in text and "| checkerboard |" in text
    assert "| blue | mean of 32 |" in text and (tmp_path / "realtime.png").exists()


def test_a_guide_without_markers_is_left_alone(tmp_path):
    guide, start, end = tmp_path / "guide.md", "<!-- table: a -->\n", "<!-- end of the table -->\n"
    for text in ("", start, end + start, start + start + end):
        guide.write_text(text)
        with pytest.raises(CommandError, match="markers"):
            update_table(guide, "a", "table")
        assert guide.read_text() == text
