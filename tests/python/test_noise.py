# SPDX-License-Identifier: Apache-2.0
"""bluenoise.visible_noise and the noise command; tests/c/test_visible_noise.c tests the values."""

import json

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

import bluenoise
from bluenoise import _files
from bluenoise._cli import main


def curve(v):
    return 255 * np.where(v <= 0.0031308, 12.92 * v, 1.055 * np.maximum(v, 1e-9) ** (1 / 2.4) - 0.055)


def halves(shape=(60, 50, 3), seed=1):
    """Two halves with values from -0.2 to 1.3, so that some are clipped."""
    return np.random.default_rng(seed).uniform(-0.2, 1.3, (2, *shape))


def test_whole_image_matches_scipy():
    first, second = halves()
    one, other, mean = (curve(gaussian_filter(np.clip(image, 0, 1), (2.1, 2.1, 0))) for image in (first, second, (first + second) / 2))
    right = np.sqrt((((one - other) / 2) ** 2 + (mean - (one + other) / 2) ** 2).mean())
    noise = bluenoise.visible_noise(first, second, window=1023)
    assert noise.shape == (60, 50) and noise.dtype == np.float32
    np.testing.assert_allclose(noise, right, rtol=0.01)  # SciPy's blur reaches farther


def test_exposure_is_a_factor_and_memory_order_does_not_matter():
    first, second = halves()
    right = bluenoise.visible_noise(first, second, exposure=0.5, window=5)
    np.testing.assert_array_equal(right, bluenoise.visible_noise(0.5 * first, 0.5 * second, window=5))
    turned = [np.asfortranarray(image.astype(">f4")) for image in (first, second)]
    np.testing.assert_allclose(right, bluenoise.visible_noise(*turned, exposure=0.5, window=5), rtol=1e-5)
    grey = bluenoise.visible_noise(first[..., 0], second[..., 0], sigma=1, first_share=0.25)
    np.testing.assert_array_equal(grey, bluenoise.visible_noise(first[..., :1], second[..., :1], sigma=1, first_share=0.25))


def test_progress_can_cancel():
    fractions = []
    bluenoise.visible_noise(*halves(), progress=fractions.append)
    assert fractions == sorted(fractions) and fractions[-1] == 1 and len(fractions) > 2
    with pytest.raises(bluenoise.CancelledError):
        bluenoise.visible_noise(*halves(), progress=lambda fraction: True)


def test_command(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    first, second = halves()
    np.save("first.npy", first)
    np.save("second.npy", second)
    np.save("mean.npy", (first + second) / 2)
    right = bluenoise.visible_noise(first, second, exposure=0.7, window=9)
    assert main("noise first.npy second.npy --exposure 0.7 --window 9 -o map.npy --json".split()) == 0
    found = json.loads(capsys.readouterr().out)
    assert found == {"median": pytest.approx(np.median(right)), "percentile_95": pytest.approx(np.percentile(right, 95)),
                     "width": 50, "height": 60}
    np.testing.assert_array_equal(np.load("map.npy"), right)
    assert main("noise first.npy mean.npy --mean -o map.png --exposure 0.7 --window 9".split()) == 0
    printed = capsys.readouterr().out
    assert f"median {np.median(right):.2f}, 95% of the image below {np.percentile(right, 95):.2f} steps" in printed and "green 1" in printed
    quarter = bluenoise.visible_noise(first, second, first_share=0.25)
    np.save("mean.npy", 0.25 * first + 0.75 * second)
    for options in ("second.npy", "mean.npy --mean"):
        assert main(f"noise first.npy {options} --first-share 0.25 -o map.npy".split()) == 0
        np.testing.assert_allclose(np.load("map.npy"), quarter, rtol=1e-4)
    capsys.readouterr()
    assert main("noise first.npy mean.npy --mean --first-share 1".split()) == 1
    assert capsys.readouterr().err == "bluenoise: first_share must be in [0.001, 0.999], not 1.0\n"
    for name in ("first.npy", "missing.npy"):
        assert main(["noise", "first.npy", name, "-o", "first.npy"]) == 1
    assert main("noise first.npy first.npy".split()) == 1 and "different samples" in capsys.readouterr().err
    np.save("black.npy", 0 * first)
    assert main("noise black.npy black.npy".split()) == 0
    assert main("noise map.png map.png".split()) == 1 and "neither .exr nor .npy" in capsys.readouterr().err


def test_command_reads_colour_channels_of_exr(tmp_path, capsys):
    exr = pytest.importorskip("OpenEXR")
    first, second = (image.astype(np.float32) for image in halves())
    for name, image in (("first", first), ("second", second)):
        planes = {key: np.ascontiguousarray(image[..., c]) for c, key in enumerate("RGB")}
        planes.update({"albedo.R": np.zeros((60, 50), np.float32), "A": np.ones((60, 50), np.float32)})
        with exr.File({"type": exr.scanlineimage}, planes) as file:
            file.write(str(tmp_path / f"{name}.exr"))
    np.testing.assert_array_equal(_files.load_light(tmp_path / "first.exr"), first)
    assert main(["noise", str(tmp_path / "first.exr"), str(tmp_path / "second.exr")]) == 0
    right = bluenoise.visible_noise(first, second)
    assert f"{np.median(right):.2f}" in capsys.readouterr().out


def test_colours():
    from bluenoise._noise import COLOURS, false_colour

    steps = np.array([[0.0, *COLOURS, 100.0]], np.float32)
    black, *known, white = false_colour(steps)[0].tolist()
    assert known == [list(colour) for _, colour in COLOURS.values()] and black == known[0] and white == known[-1]
