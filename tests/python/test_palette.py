# SPDX-License-Identifier: Apache-2.0
"""Dithering to palettes: flat patches keep their mean colour, colours outside a palette become the closest mixture, and Pillow images
keep the palette."""

from pathlib import Path

import numpy as np
import pytest
from helpers import refused

import bluenoise

pytest.importorskip("scipy")
Image = pytest.importorskip("PIL.Image")
INK = [(0, 0, 0), (255, 255, 255), (0, 255, 0), (0, 0, 255), (255, 0, 0), (255, 255, 0), (255, 128, 0)]  # a 7-colour e-paper display
RANDOM = np.random.default_rng(3)
PALETTES = {
    "one": [(9, 99, 200)], "two": [(0, 0, 0), (255, 255, 255)], "greys": [(v, v, v) for v in (200, 0, 90, 255)],
    "plane": [(0, 0, 0), (255, 0, 0), (0, 255, 0), (255, 255, 0), (80, 90, 0)], "ink": INK,
    "web": np.stack(np.meshgrid(*[np.arange(0, 256, 51)] * 3), -1).reshape(-1, 3), "gif": RANDOM.integers(0, 256, (256, 3)),
}


def linear(values):
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)


@pytest.mark.parametrize("srgb", [False, True])
@pytest.mark.parametrize("name", PALETTES)
def test_flat_patches_have_the_mean_of_the_closest_mixture(name, srgb):
    palette = np.array(PALETTES[name], np.uint8)
    light = linear(palette / 255) if srgb else palette / 255
    for value in [*RANDOM.integers(0, 256, (5, 3)), palette[0], (128, 128, 128)]:
        found = bluenoise.dither(np.full((64, 64, 3), value, np.uint8), palette=palette, srgb=srgb)
        shown = linear(found / 255) if srgb else found / 255
        target = linear(np.asarray(value) / 255) if srgb else np.asarray(value) / 255
        # The mean is a mixture, and no colour lies beyond the plane through it that faces the value: no mixture is closer. The four
        # weights are rounded to 1/4096.
        mean = shown.mean((0, 1))
        assert ((light - mean) @ (target - mean)).max() < 0.003, (value, mean)
        if name == "web":
            np.testing.assert_allclose(mean, target, atol=4 / 4096)
        assert len(np.unique(found.reshape(-1, 3), axis=0)) <= 4
        assert (found.reshape(-1, 1, 3) == palette).all(2).any(1).all()


def test_even_greys_give_the_same_image_as_levels():
    image = RANDOM.random((70, 90)).astype(np.float32)
    for levels in (2, 4, 9):
        palette = np.arange(levels) / (levels - 1)
        np.testing.assert_allclose(bluenoise.dither(image, palette=palette), bluenoise.dither(image, levels), atol=1e-6)
    mask = bluenoise.mask((16, 32), seed=2)
    image = RANDOM.integers(0, 2**16, (40, 50)).astype(np.uint16)
    for given in (mask, mask / 512.0 + 0.5 / 512):
        np.testing.assert_array_equal(bluenoise.dither(image, palette=[65535, 0], mask=given), bluenoise.dither(image, mask=mask))


def test_brighter_colours_have_higher_thresholds():
    mask = bluenoise.mask((32, 32), seed=1)
    for value in RANDOM.integers(0, 256, (20, 3)):
        found = bluenoise.dither(np.full((32, 32, 3), value, np.uint8), palette=PALETTES["gif"], mask=mask)
        luminance = found.reshape(-1, 3)[np.argsort(mask, None)] @ (0.2126, 0.7152, 0.0722)
        assert (np.diff(luminance) >= 0).all()


def test_crops_agree_with_the_whole():
    image = RANDOM.random((128, 192, 3))
    palette = RANDOM.random((20, 3))
    whole = bluenoise.dither(image, palette=palette)
    np.testing.assert_array_equal(bluenoise.dither(image[64:, 128:], palette=palette), whole[64:, 128:])
    five = bluenoise.dither(RANDOM.integers(0, 256, (64, 64, 5)).astype(np.uint8), palette=RANDOM.integers(0, 256, (4, 5)))
    assert five.shape == (64, 64, 5)


def test_pillow_images_keep_the_palette(tmp_path):
    picture = Image.fromarray(RANDOM.integers(0, 256, (30, 40, 3)).astype(np.uint8))
    palette = [*INK, INK[0]]
    found = bluenoise.dither(picture, palette=palette)
    assert found.mode == "P" and np.array_equal(np.reshape(found.getpalette(), (-1, 3))[:8], palette)
    array = bluenoise.dither(np.asarray(picture), palette=palette)
    assert np.array_equal(np.asarray(found.convert("RGB")), array)
    for name in ("a.gif", "a.png"):
        found.save(tmp_path / name)
        with Image.open(tmp_path / name) as saved:
            assert np.array_equal(np.asarray(saved.convert("RGB")), array)
    again = bluenoise.dither(picture.convert("L").convert("RGB"), palette=found)
    assert np.array_equal(np.asarray(again), np.asarray(bluenoise.dither(picture.convert("L"), palette=palette)))
    few = bluenoise.dither(picture, palette=5)
    assert set(np.unique(few)) <= set(range(5))
    own = np.reshape(picture.quantize(5, dither=Image.Dither.NONE).getpalette(), (-1, 3))[:5]
    assert np.array_equal(np.reshape(few.getpalette(), (-1, 3))[:5], own)


def test_refusals():
    grey, colour = np.zeros((4, 4)), np.zeros((4, 4, 3))
    picture = Image.new("RGB", (4, 4))
    for error, words, image, options in (
        (ValueError, ["levels", "3"], grey, {"palette": [0, 1], "levels": 3}),
        (ValueError, ["palette", "('count', 3)", "(2,)"], colour, {"palette": [0, 1]}),
        (ValueError, ["palette", "('count',)", "(2, 3)"], grey, {"palette": [(0, 0, 0), (1, 1, 1)]}),
        (ValueError, ["palette", "256", "(257,)"], grey, {"palette": np.linspace(0, 1, 257)}),
        (ValueError, ["palette", "(0,)"], grey, {"palette": []}),
        (ValueError, ["palette", "[0, 1]", "2"], grey, {"palette": [0, 2]}),
        (ValueError, ["image", "[0, 1]", "7"], grey + 7, {"palette": [0, 1]}),
        (TypeError, ["palette", "numbers"], grey, {"palette": ["a"]}),
        (ValueError, ["mask", "2 channels"], grey, {"palette": [0, 1], "mask": np.stack([bluenoise.mask((4, 4))] * 2)}),
        (ValueError, ["palette", "0"], picture, {"palette": 0}),
        (ValueError, ["palette", "RGB"], picture, {"palette": picture}),
        (ValueError, ["RGBA", "convert('RGB')"], picture.convert("RGBA"), {"palette": INK}),
        (ValueError, ["I;16", "convert('RGB')"], Image.new("I;16", (4, 4)), {"palette": INK}),
    ):
        with refused(error, words):
            bluenoise.dither(image, **options)


def test_command(tmp_path, monkeypatch, capsys):
    from bluenoise._cli import main

    monkeypatch.chdir(tmp_path)
    picture = Image.fromarray(RANDOM.integers(0, 256, (30, 40, 3)).astype(np.uint8))
    picture.save("in.png")
    hexes = ",".join("#%02x%02x%02x" % colour for colour in INK)
    for option, palette in (("7", 7), (hexes, INK), ("ink.gif", INK)):
        assert main(["dither", "--palette", option, "in.png", f"{len(option)}.gif"]) == 0
        Path(f"{len(option)}.gif").rename("ink.gif")
        with Image.open("ink.gif") as found:
            expected = bluenoise.dither(picture, palette=palette).convert("RGB")
            assert np.array_equal(np.asarray(found.convert("RGB")), np.asarray(expected))
    for option, word in (("missing.png", "missing.png"), ("0", "palette"), ("in.png", "mode P"), ("7 --levels 4", "levels")):
        assert main(["dither", "--palette", *option.split(), "in.png", "out.png"]) == 1
        message = capsys.readouterr().err
        assert word in message and message.count("\n") == 1
    bluenoise.save("deep.png", bluenoise.mask((8, 8)))
    assert main(["dither", "--palette", "7", "deep.png", "out.png"]) == 1 and "16 bits" in capsys.readouterr().err
    assert not Path("out.png").exists()
