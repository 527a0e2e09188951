# SPDX-License-Identifier: Apache-2.0
import importlib.util
import json
import subprocess
import sys

import numpy as np
import pytest
from onnx_file import convolution

import bluenoise
from bluenoise._cli import main

Image = pytest.importorskip("PIL.Image")


def lines(capsys):
    captured = capsys.readouterr()
    return captured.out.splitlines(), captured.err.splitlines()


def test_mask_as_png_keeps_every_rank(tmp_path, capsys):
    out = tmp_path / "mask.png"
    arguments = ["mask", "--size", "40x24", "--seed", "3", "--sigma", "1.9", "-o", str(out)]
    assert main(arguments) == 0
    assert lines(capsys) == ([], [])
    picture = Image.open(out)
    assert picture.mode.startswith("I") and picture.size == (40, 24)
    assert "seed 3, sigma 1.9" in picture.info["Description"]
    ranks = bluenoise.mask((24, 40), seed=3, sigma=1.9)
    values = np.asarray(picture)
    np.testing.assert_array_equal(values, (ranks + 0.5) * 65536 // ranks.size)
    assert bluenoise.measure(values) == bluenoise.measure(ranks)
    assert [p.name for p in tmp_path.iterdir()] == ["mask.png"]


@pytest.mark.parametrize(("size", "shape"), [("30", (30,)), ("5x4", (4, 5)), ("5x4x3", (3, 4, 5))])
def test_mask_as_npy(tmp_path, size, shape):
    out = tmp_path / "mask.npy"
    assert main(["mask", "--size", size, "--method", "white", "-o", str(out)]) == 0
    np.testing.assert_array_equal(np.load(out), bluenoise.mask(shape, method="white"))


def test_mask_builtin(tmp_path):
    out = tmp_path / "mask.npy"
    assert main(["mask", "--size", "64x64", "--method", "builtin", "-o", str(out)]) == 0
    np.testing.assert_array_equal(np.load(out), bluenoise.mask((64, 64), method="builtin"))


@pytest.mark.parametrize(("method", "option"), [("relax", "steps"), ("anneal", "sweeps")])
def test_mask_by_other_methods(method, option, tmp_path):
    out = tmp_path / "mask.npy"
    arguments = ["--size", "16x16", "--method", method, f"--{option}", "9", "--sigma", "1.1"]
    assert main(["mask", *arguments, "-o", str(out)]) == 0
    expected = bluenoise.mask((16, 16), method=method, sigma=1.1, **{option: 9})
    np.testing.assert_array_equal(np.load(out), expected)


@pytest.mark.skipif(importlib.util.find_spec("onnxruntime") is None, reason="no package onnxruntime")
def test_mask_by_a_network(tmp_path, capsys):
    model, out = tmp_path / "model.onnx", tmp_path / "mask.npy"
    model.write_bytes(convolution(np.full((2, 3, 3), 0.1)))
    arguments = ["mask", "--size", "20x16", "--method", "neural", "--model", str(model), "--threads", "1", "--seed", "5"]
    assert main([*arguments, "-o", str(out)]) == 0
    np.testing.assert_array_equal(np.load(out), bluenoise.NeuralGenerator(model).mask((16, 20), seed=5))
    assert lines(capsys) == ([], [])
    assert main([*arguments, "-o", str(tmp_path / "mask.png")]) == 1
    assert "2 channels" in lines(capsys)[1][0]
    assert main([*arguments, "--runtime", str(tmp_path / "nowhere.so"), "-o", str(out)]) == 1
    assert "pip install" in lines(capsys)[1][0]
    assert sorted(p.name for p in tmp_path.iterdir()) == ["mask.npy", "model.onnx"]


def test_mask_with_more_ranks_than_levels_says_so(tmp_path, capsys):
    out = tmp_path / "mask.png"
    assert main(["mask", "--size", "300x300", "--method", "white", "-o", str(out)]) == 0
    out_lines, err = lines(capsys)
    assert not out_lines and len(err) == 1 and "90000 ranks" in err[0]
    assert np.asarray(Image.open(out)).max() == 65535


def test_measure(tmp_path, capsys):
    ranks = bluenoise.mask((32, 64), seed=1)
    np.save(tmp_path / "mask.npy", ranks)
    assert main(["measure", str(tmp_path / "mask.npy")]) == 0
    out, err = lines(capsys)
    assert not err and "64 x 32" in out[0] and "yes" in out[1]
    assert f"{bluenoise.measure(ranks)['e_1']:.5f}" in "\n".join(out)
    assert main(["measure", "--json", str(tmp_path / "mask.npy")]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["size"] == [64, 32] and found["e_1"] == bluenoise.measure(ranks)["e_1"]
    np.save(tmp_path / "tiny.npy", [[1, 0]])
    assert main(["measure", "--json", str(tmp_path / "tiny.npy")]) == 0
    assert json.loads(capsys.readouterr().out)["anisotropy"] is None  # NaN is no JSON


def test_dither(tmp_path, capsys):
    y, x = np.mgrid[:40, :60]
    picture = Image.fromarray(np.stack([4 * x, 6 * y, 2 * (x + y)], axis=-1).astype(np.uint8))
    picture.save(tmp_path / "in.png", icc_profile=b"a profile")
    assert main(["dither", str(tmp_path / "in.png"), str(tmp_path / "out.png")]) == 0
    out = Image.open(tmp_path / "out.png")
    assert (np.asarray(out) == np.asarray(bluenoise.dither(picture))).all()
    assert out.info["icc_profile"] == b"a profile"
    ranks = bluenoise.mask((16, 16), seed=1)
    assert main(["mask", "--size", "16x16", "--seed", "1", "-o", str(tmp_path / "m.png")]) == 0
    arguments = ["--levels", "4", "--srgb", "--mask", str(tmp_path / "m.png")]
    assert main(["dither", str(tmp_path / "in.png"), str(tmp_path / "o.tif"), *arguments]) == 0
    expected = bluenoise.dither(picture, 4, mask=ranks, srgb=True)
    assert (np.asarray(Image.open(tmp_path / "o.tif")) == np.asarray(expected)).all()
    assert lines(capsys) == ([], [])


def test_dither_follows_the_orientation_of_a_photograph(tmp_path):
    photograph = Image.fromarray(np.tile(np.arange(0, 240, 4, dtype=np.uint8), (40, 1)))
    exif = Image.Exif()
    exif[0x0112] = 6  # turned by a quarter
    photograph.save(tmp_path / "in.jpg", exif=exif)
    assert main(["dither", str(tmp_path / "in.jpg"), str(tmp_path / "out.png")]) == 0
    assert Image.open(tmp_path / "out.png").size == (40, 60)


def test_spectrum(tmp_path, capsys):
    ranks = bluenoise.mask((64, 64), seed=1)
    np.save(tmp_path / "m.npy", ranks)
    assert main(["spectrum", str(tmp_path / "m.npy"), "-o", str(tmp_path / "s.npy")]) == 0
    np.testing.assert_array_equal(np.load(tmp_path / "s.npy"), bluenoise.power_spectrum(ranks))
    assert main(["spectrum", str(tmp_path / "m.npy"), "-o", str(tmp_path / "s.csv")]) == 0
    assert (tmp_path / "s.csv").read_text().startswith("frequency,power\n")
    table = np.loadtxt(tmp_path / "s.csv", delimiter=",", skiprows=1)
    np.testing.assert_allclose(table.T, bluenoise.radial_power(ranks), atol=1e-6)
    assert lines(capsys) == ([], [])


def test_spectrum_as_a_plot(tmp_path):
    pytest.importorskip("matplotlib")
    np.save(tmp_path / "m.npy", bluenoise.mask((32, 48), seed=1))
    for name in ("s.png", "s.svg"):
        assert main(["spectrum", str(tmp_path / "m.npy"), "-o", str(tmp_path / name)]) == 0
    assert np.asarray(Image.open(tmp_path / "s.png")).std() > 10
    assert "<svg" in (tmp_path / "s.svg").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["mask", "--size", "8x8", "-o", "mask.jpg"], ["mask.jpg", ".png", ".npy"]),
        (["mask", "--size", "8x8", "-o", "no/such/mask.png"], ["no/such", "does not exist"]),
        (["mask", "--size", "8x8", "-o", "folder.png"], ["folder.png", "folder"]),
        (["mask", "--size", "8x8x8", "-o", "mask.png"], [".npy"]),
        (["mask", "--size", "0x8", "-o", "mask.png"], ["shape", "0"]),
        (["mask", "--size", "99999x99999", "-o", "mask.png"], ["99999"]),
        (["mask", "--size", "8x8", "--sigma", "-1", "-o", "mask.png"], ["sigma", "-1"]),
        (["mask", "--size", "8x8", "--seed", "-1", "-o", "mask.png"], ["seed", "-1"]),
        (["mask", "--size", "8x8", "--method", "white", "--sigma", "1", "-o", "m.png"], ["white", "sigma"]),
        (["mask", "--size", "9x9", "--method", "builtin", "-o", "m.png"], ["(9, 9)"]),
        (["measure", "missing.png"], ["missing.png", "does not exist"]),
        (["measure", "missing.npy"], ["missing.npy", "does not exist"]),
        (["measure", "broken.png"], ["broken.png"]),
        (["measure", "broken.npy"], ["broken.npy"]),
        (["measure", "colour.png"], ["colour.png", "two dimensions"]),
        (["measure", "line.npy"], ["line.npy", "(3,)"]),
        (["measure", "folder.png"], ["folder.png"]),
        (["dither", "missing.png", "out.png"], ["missing.png"]),
        (["dither", "colour.png", "out.jpg"], ["out.jpg", ".png"]),
        (["dither", "colour.png", "out.pgm", "--levels", "1"], ["levels", "1"]),
        (["dither", "colour.png", "out.png", "--mask", "line.npy"], ["line.npy"]),
        (["dither", "colour.png", "out.png", "--mask", "flat.npy"], ["flat.npy", "more than once"]),
        (["spectrum", "colour.png", "-o", "out.csv"], ["colour.png"]),
        (["spectrum", "flat.npy", "-o", "out.txt"], ["out.txt", ".csv"]),
    ],
)
def test_errors_are_one_line_and_leave_nothing(arguments, words, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder.png").mkdir()
    (tmp_path / "broken.png").write_bytes(b"\x89PNG\r\n\x1a\n no more")
    (tmp_path / "broken.npy").write_bytes(b"\x93NUMPY no more")
    np.save(tmp_path / "line.npy", [0, 1, 2])
    np.save(tmp_path / "flat.npy", np.zeros((4, 4), int))
    Image.new("RGB", (4, 4)).save(tmp_path / "colour.png")
    before = sorted(tmp_path.iterdir())
    assert main(arguments) == 1
    out, err = lines(capsys)
    assert not out and len(err) == 1 and err[0].startswith("bluenoise: ")
    assert all(word in err[0] for word in words), err[0]
    assert sorted(tmp_path.iterdir()) == before


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        ([], "command"),
        (["mask"], "--size"),
        (["mask", "--size", "8y8", "-o", "m.png"], "8y8"),
        (["mask", "--size", "8x8", "--seed", "1.5", "-o", "m.png"], "1.5"),
        (["mask", "--size", "8x8", "--method", "void", "-o", "m.png"], "void-and-cluster"),
        (["paint"], "paint"),
    ],
)
def test_wrong_usage(arguments, word, capsys):
    with pytest.raises(SystemExit) as caught:
        main(arguments)
    assert caught.value.code == 2 and word in capsys.readouterr().err


def test_a_failed_write_leaves_the_old_file(tmp_path, capsys, monkeypatch):
    out = tmp_path / "mask.npy"
    out.write_bytes(b"precious")

    def fail(path, array):
        path.write_bytes(b"half")
        raise OSError("the disk is full")

    monkeypatch.setattr(np, "save", fail)
    assert main(["mask", "--size", "8x8", "-o", str(out)]) == 1
    assert "the disk is full" in capsys.readouterr().err
    assert out.read_bytes() == b"precious" and list(tmp_path.iterdir()) == [out]


def test_interrupt(monkeypatch, capsys, tmp_path):
    def interrupt(*arguments, **options):
        raise KeyboardInterrupt

    monkeypatch.setattr("bluenoise._cli.make_mask", interrupt)
    assert main(["mask", "--size", "8x8", "-o", str(tmp_path / "m.png")]) == 130
    assert not list(tmp_path.iterdir())


def test_run_as_a_module(tmp_path):
    def run(*arguments):
        command = [sys.executable, "-m", "bluenoise", *arguments]
        return subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)

    assert run("--version").stdout.strip() == f"bluenoise {bluenoise.__version__}"
    assert "measure" in run("--help").stdout
    made = run("mask", "--size", "8x8", "-o", "m.png")
    assert made.returncode == 0 and not made.stderr and (tmp_path / "m.png").exists()
    bad = run("measure", "none.png")
    assert bad.returncode == 1 and bad.stderr.count("\n") == 1
