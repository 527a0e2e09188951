# SPDX-License-Identifier: Apache-2.0
import importlib.util
import io
import json
import os
import struct
import subprocess
import sys

import numpy as np
import pytest
from onnx_file import convolution

import bluenoise
from bluenoise import _files
from bluenoise._cli import main

Image = pytest.importorskip("PIL.Image")


def lines(capsys):
    captured = capsys.readouterr()
    return captured.out.splitlines(), captured.err.splitlines()


def test_mask_as_png_keeps_every_rank(tmp_path, capsys):
    out = tmp_path / "mask.png"
    arguments = ["mask", "--size", "40x24", "--method", "void-and-cluster", "--seed", "3", "--sigma", "1.9", "-o", str(out)]
    assert main(arguments) == 0
    assert lines(capsys) == ([], [])
    picture = Image.open(out)
    assert picture.mode.startswith("I") and picture.size == (40, 24)
    assert "seed 3, sigma 1.9" in picture.info["Description"]
    ranks = bluenoise.void_and_cluster((24, 40), seed=3, sigma=1.9)
    values = np.asarray(picture)
    np.testing.assert_array_equal(values, (ranks + 0.5) * 65536 // ranks.size)
    assert bluenoise.measure(values) == bluenoise.measure(ranks)
    assert [p.name for p in tmp_path.iterdir()] == ["mask.png"]


@pytest.mark.parametrize(("size", "shape"), [("30", (30, 30)), ("30x1", (1, 30)), ("5x4", (4, 5)), ("5x4x3", (3, 4, 5))])
def test_mask_as_npy(tmp_path, size, shape):
    out = tmp_path / "mask.npy"
    assert main(["mask", "--size", size, "-o", str(out)]) == 0
    np.testing.assert_array_equal(np.load(out), bluenoise.mask(shape))


@pytest.mark.parametrize(("method", "options"), [("relax", {"threads": 2}), ("anneal", {"sweeps": 9, "sigma": 1.1})])
def test_mask_by_other_methods(method, options, tmp_path):
    out = tmp_path / "mask.npy"
    arguments = ["--size", "16x16", "--method", method, *(f"--{name}={value}" for name, value in options.items())]
    assert main(["mask", *arguments, "-o", str(out)]) == 0
    expected = getattr(bluenoise, method)((16, 16), **options)
    np.testing.assert_array_equal(np.load(out), expected)


@pytest.mark.skipif(importlib.util.find_spec("onnxruntime") is None, reason="no package onnxruntime")
def test_mask_by_a_network(tmp_path, capsys):
    model, out = tmp_path / "model.onnx", tmp_path / "mask.npy"
    model.write_bytes(convolution(np.full((2, 3, 3), 0.1)))
    arguments = ["mask", "--size", "20x16", "--method", "neural", "--model", str(model), "--threads", "1", "--seed", "5"]
    assert main([*arguments, "-o", str(out)]) == 0
    np.testing.assert_array_equal(np.load(out), bluenoise.NeuralGenerator(model).mask((16, 20), seed=5))
    assert lines(capsys) == ([], [])
    assert main([*arguments, "-o", str(tmp_path / "mask.png")]) == 0
    assert (tmp_path / "mask.png").read_bytes()[24:26] == b"\x10\x04" and lines(capsys) == ([], [])  # 16 bits, two channels
    (tmp_path / "mask.png").unlink()
    assert main([*arguments, "--runtime", str(tmp_path / "nowhere.so"), "-o", str(out)]) == 1
    assert "nowhere.so does not exist" in lines(capsys)[1][0]
    assert main([*arguments, "--runtime", "nowhere.so", "-o", str(out)]) == 1
    assert "pip install" in lines(capsys)[1][0]
    assert main([*arguments, "--provider", "cuda", "--runtime", "nowhere.so", "-o", str(out)]) == 1
    assert "onnxruntime-gpu" in lines(capsys)[1][0]
    assert sorted(p.name for p in tmp_path.iterdir()) == ["mask.npy", "model.onnx"]


def test_mask_with_more_ranks_than_levels_says_so(tmp_path, capsys):
    out = tmp_path / "mask.png"
    assert main(["mask", "--size", "300x300", "-o", str(out)]) == 0
    out_lines, err = lines(capsys)
    assert not out_lines and len(err) == 1 and "90000 ranks" in err[0]
    assert np.asarray(Image.open(out)).max() == 65535


def test_measure(tmp_path, capsys):
    ranks = bluenoise.mask((32, 64), seed=1)
    np.save(tmp_path / "mask.npy", ranks)
    assert main(["measure", str(tmp_path / "mask.npy")]) == 0
    out, err = lines(capsys)
    assert not err and "64 x 32" in out[0] and "yes" in out[1]
    assert f"{bluenoise.dithering_error(ranks):.5f}" in "\n".join(out)
    start = next(number for number, line in enumerate(out) if "white noise has 1" in line)
    assert out[start + 1].split()[:2] == ["grey", "0.0625"] and len(out) == start + 8
    assert main(["measure", "--json", str(tmp_path / "mask.npy")]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["size"] == [64, 32] and found["dithering_error"]["1.0"] == bluenoise.dithering_error(ranks)
    np.save(tmp_path / "tiny.npy", [[1, 0]])
    assert main(["measure", "--json", str(tmp_path / "tiny.npy")]) == 0
    assert json.loads(capsys.readouterr().out)["anisotropy"] is None  # NaN is not valid JSON


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
    exif[0x0112] = 6  # a quarter turn
    photograph.save(tmp_path / "in.jpg", exif=exif)
    assert main(["dither", str(tmp_path / "in.jpg"), str(tmp_path / "out.png")]) == 0
    assert Image.open(tmp_path / "out.png").size == (40, 60)


def test_resolution_turns_with_the_photograph(tmp_path):
    exif = Image.Exif()
    exif[0x0112] = 6
    Image.new("L", (6, 4), 90).save(tmp_path / "in.jpg", exif=exif, dpi=(300, 150))
    assert main(["dither", str(tmp_path / "in.jpg"), str(tmp_path / "out.png")]) == 0
    assert np.round(Image.open(tmp_path / "out.png").info["dpi"]).tolist() == [150, 300]


@pytest.mark.parametrize("channels", [1, 2, 3, 4])
def test_sixteen_bits_stay(channels, tmp_path):
    """A ramp over a few 8-bit steps, in which truncation would show as bands. Alpha and colour metadata are preserved."""
    pytest.importorskip("png")
    ramp = np.round(np.linspace(5140, 6168, 128)).astype(np.uint16)
    texels = np.repeat(np.tile(ramp, (128, 1))[..., None], channels, 2)
    if channels in (2, 4):
        texels[..., -1] = np.arange(128)[:, None] * 500
    gamma = (b"gAMA", (100000).to_bytes(4, "big"))
    (tmp_path / "in.png").write_bytes(_files.png(texels, [gamma]))
    assert main(["dither", "--levels", "256", str(tmp_path / "in.png"), str(tmp_path / "out.png")]) == 0
    data = (tmp_path / "out.png").read_bytes()
    out, alpha = _files.read_png(tmp_path / "out.png", data)
    colours = channels - alpha
    assert gamma[0] + gamma[1] in data and out.shape == texels.shape and alpha == (channels in (2, 4))
    assert (out[..., :colours] == bluenoise.dither(texels[..., :colours], 256)).all()
    assert np.abs(out[..., 0].mean(0) - ramp).max() < 0.2 * 257
    assert not alpha or (out[..., -1] == texels[..., -1]).all()
    assert main(["dither", str(tmp_path / "in.png"), str(tmp_path / "out.tif")]) == 1


@pytest.mark.parametrize(("mode", "clear", "other"), [("L", 7, 200), ("RGB", (255, 0, 255), (9, 9, 9)), ("P", 0, 1), ("1", 0, 1)])
def test_transparent_colours_stay_transparent(mode, clear, other, tmp_path):
    picture = Image.new(mode, (16, 16), other)
    if mode == "P":
        picture.putpalette([255, 0, 255, 9, 9, 9])
    picture.paste(clear, (0, 0, 8, 16))
    picture.save(tmp_path / "in.png", transparency=clear)
    assert main(["dither", str(tmp_path / "in.png"), str(tmp_path / "out.png")]) == 0
    before, after = (np.asarray(Image.open(tmp_path / name).convert("RGBA"))[..., 3] for name in ("in.png", "out.png"))
    assert (before == after).all() and (after[:, :8] == 0).all()


def test_gamma_stays_or_is_refused(tmp_path, capsys):
    from PIL.PngImagePlugin import PngInfo

    chunks = PngInfo()
    chunks.add(b"gAMA", (100000).to_bytes(4, "big"))
    Image.new("L", (4, 4), 90).save(tmp_path / "in.png", pnginfo=chunks, dpi=(300, 300))
    assert main(["dither", str(tmp_path / "in.png"), str(tmp_path / "out.png")]) == 0
    found = Image.open(tmp_path / "out.png").info
    assert found["gamma"] == 1 and np.round(found["dpi"]).tolist() == [300, 300]
    assert main(["dither", str(tmp_path / "in.png"), str(tmp_path / "out.bmp")]) == 1
    assert "out.bmp cannot hold the input's gamma" in capsys.readouterr().err


def lossy_pictures(folder):
    """Files from which Pillow would drop data, and a word of each error message."""
    grey = Image.new("L", (4, 4), 90)
    grey.save(folder / "frames.gif", save_all=True, append_images=[Image.new("L", (4, 4), 20)])
    yield "frames.gif", "2 frames"
    (folder / "deep.ppm").write_bytes(b"P6 2 2 65535\n" + bytes(24))
    yield "deep.ppm", "16 bits"
    Image.new("I", (4, 4), 200).save(folder / "integers.tif")
    yield "integers.tif", "32 bits"
    for name, bits, photometric, samples in (("twelve.tif", 12, 1, 1), ("white.tif", 16, 0, 1), ("deep.tif", 16, 2, 3)):
        tags = [(256, 4), (257, 4), (258, bits), (259, 1), (262, photometric), (273, 8), (277, samples), (278, 4), (279, 2 * samples * 16)]
        data = bytes(96) if bits == 16 else bytes(24)
        tags = [(tag, value if tag != 279 else len(data)) for tag, value in tags]
        at = 8 + len(data)
        entries = b"".join(struct.pack("<HHII", tag, 3, 1, value) if tag != 258 or samples == 1 else
                           struct.pack("<HHII", tag, 3, 3, at + 2 + 12 * len(tags) + 4) for tag, value in tags)
        (folder / name).write_bytes(struct.pack("<2sHI", b"II", 42, at) + data + struct.pack("<H", len(tags)) + entries + bytes(4)
                                    + struct.pack("<3H", bits, bits, bits))
        yield name, {"twelve.tif": "12 bits", "white.tif": "0 for white", "deep.tif": "16 bits per channel"}[name]


def test_pictures_that_would_lose_something_are_refused(tmp_path, capsys):
    for name, words in lossy_pictures(tmp_path):
        assert main(["dither", str(tmp_path / name), str(tmp_path / "out.png")]) == 1
        message = capsys.readouterr().err
        assert name in message and words in message, message
    with pytest.raises(ValueError, match="mode 1, .*not I"):
        bluenoise.dither(Image.new("I", (4, 4), 200))


def test_messages_about_contents_name_the_file(tmp_path, capsys):
    np.save(tmp_path / "nan.npy", [[0.5, np.nan]])
    np.save(tmp_path / "bool.npy", [[True, False]])
    np.save(tmp_path / "complex.npy", [[1j, 2]])
    Image.fromarray(np.full((4, 4), 1.5, np.float32)).save(tmp_path / "bright.tif")
    Image.new("LAB", (4, 4)).save(tmp_path / "lab.tif")
    for name in ("nan.npy", "bool.npy", "complex.npy"):
        for command in (["measure"], ["points", "--count", "2", "--method", "mask", "-o", str(tmp_path / "p.csv"), "--mask"]):
            assert main([*command, str(tmp_path / name)]) == 1
            assert name in capsys.readouterr().err
    for name in ("bright.tif", "lab.tif"):
        assert main(["dither", str(tmp_path / name), str(tmp_path / "out.tif")]) == 1
        assert name in capsys.readouterr().err


def test_two_channel_texture_is_a_two_channel_mask(tmp_path, capsys):
    """The third channel and alpha are constant. Their ranks would be white noise."""
    ranks = bluenoise.anneal((16, 16), channels=2, sweeps=20)
    values = _files.quantized(ranks, 8)
    texture = np.dstack([values, np.zeros((16, 16)), np.full((16, 16), 255)]).astype(np.uint8)
    Image.fromarray(texture).save(tmp_path / "rg.png")
    Image.new("RGB", (32, 32), (90, 90, 90)).save(tmp_path / "in.png")
    assert bluenoise.load(tmp_path / "rg.png", rank=True).shape == (2, 16, 16)
    dither = ["dither", "--mask", str(tmp_path / "rg.png"), str(tmp_path / "in.png"), str(tmp_path / "out.png")]
    assert main(dither) == 1 and "2 channels and the image 3" in capsys.readouterr().err
    assert main([*dither, "--channel", "2"]) == 0
    expected = bluenoise.dither(Image.open(tmp_path / "in.png"), mask=ranks[1])
    assert (np.asarray(Image.open(tmp_path / "out.png")) == np.asarray(expected)).all()
    points = ["points", "--method", "mask", "--mask", str(tmp_path / "rg.png"), "--count", "9", "-o", str(tmp_path / "p.npy")]
    assert main(points) == 1 and "--channel" in capsys.readouterr().err
    assert main([*points, "--channel", "1"]) == 0


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["mask", "--size", "8x8", "-o", "mask.jpg"], ["mask.jpg", ".png", ".npy"]),
        (["mask", "--size", "8x8", "-o", "no/such/mask.png"], ["no/such", "does not exist"]),
        (["mask", "--size", "8x8", "-o", "folder.png"], ["folder.png", "folder"]),
        (["mask", "--size", "8x8x8", "-o", "mask.png"], [".npy"]),
        (["mask", "--size", "99999x99999", "-o", "mask.png"], ["99999"]),
        (["mask", "--size", "8x8", "--method", "anneal", "--sigma", "-1", "-o", "mask.png"], ["sigma", "-1"]),
        (["mask", "--size", "8x8", "--method", "relax", "--sigma", "1", "-o", "m.png"], ["--sigma needs", "anneal", "relax"]),
        (["mask", "--size", "8", "--initial-fraction", "1", "--method", "relax", "-o", "m.png"], ["--initial-fraction needs"]),
        (["mask", "--size", "9x9", "--method", "builtin", "-o", "m.png"], ["(9, 9)"]),
        (["mask", "--size", "8", "--channels", "5", "--method", "anneal", "-o", "m.png"], ["channels", "5"]),
        (["mask", "--size", "8", "--channels", "2", "--method", "relax", "-o", "m.png"], ["--channels needs --method auto or anneal"]),
        (["mask", "--size", "8", "--json", "-o", "-"], ["--json"]),
        (["measure", "volume.npy"], ["volume.npy", "(2, 4, 4)", "--channel"]),
        (["points", "--count", "2", "--method", "mask", "--mask", "deep.npy", "-o", "s.csv"], ["deep.npy", "(2, 4, 4)", "--channel"]),
        (["dither", "colour.png", "colour.png"], ["colour.png", "input"]),
        (["dither", "colour.png", "./link.png"], ["link.png", "input"]),
        (["dither", "colour.png", "grey.png", "--mask", "grey.png"], ["grey.png", "input"]),
        (["mask", "--size", "8", "-o", "pipe.npy"], ["pipe.npy", "regular"]),
        (["dither", "colour.png", "out.png", "--mask", "grey.png"], ["grey.png", "8-bit", "--rank"]),
        (["dither", "colour.png", "out.png", "--rank"], ["--rank", "--mask"]),
        (["dither", "colour.png", "out.png", "--channel", "1"], ["--channel", "--mask"]),
        (["dither", "colour.png", "out.png", "--mask", "volume.npy"], ["volume.npy", "(2, 4, 4)", "--channel"]),
        (["points", "--count", "9", "--method", "mask", "--channel", "1", "-o", "p.csv"], ["--channel", "--mask"]),
        (["mask", "--size", "4x4x4", "--channels", "2", "-o", "m.npy"], ["2 channels", "(4, 4, 4)"]),
        (["points", "--count", "9", "--method", "mask", "--candidates", "2", "-o", "p.csv"], ["--candidates needs --method best"]),
        (["points", "--count", "-9", "-o", "p.csv"], ["n", "-9"]),
        (["points", "--count", "9", "-o", "p.png"], ["p.png", ".csv"]),
        (["measure", "deep.npy", "--channel", "3"], ["channel 3", "(2, 4, 4)"]),
        (["measure", "cut.npy"], ["cut.npy", "128 bytes", "127"]),
        (["measure", "huge.npy"], ["huge.npy", "800000000000 bytes"]),
        (["measure", "header.npy"], ["header.npy", "array"]),
        (["measure", "objects.npy"], ["objects.npy", "objects"]),
        (["measure", "pipe.npy"], ["pipe.npy", "regular"]),
        (["measure", "loop.npy"], ["loop.npy"]),
        (["measure", "missing.png"], ["missing.png", "does not exist"]),
        (["measure", "broken.png"], ["broken.png"]),
        (["measure", "line.npy"], ["line.npy", "(3,)"]),
        (["measure", "folder.png"], ["folder.png"]),
        (["dither", "colour.png", "out.jpg"], ["out.jpg", ".png"]),
        (["dither", "colour.png", "out.pgm", "--levels", "1"], ["levels", "1"]),
        (["dither", "colour.png", "out.png", "--mask", "line.npy"], ["line.npy"]),
        (["dither", "colour.png", "out.png", "--mask", "flat.npy"], ["flat.npy", "more than once"]),
        (["points", "--count", "2", "--method", "mask", "--mask", "colour.png", "-o", "out.csv"], ["colour.png"]),
    ],
)
def test_errors_are_one_line_and_leave_nothing(arguments, words, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder.png").mkdir()
    (tmp_path / "broken.png").write_bytes(b"\x89PNG\r\n\x1a\n no more")
    np.save(tmp_path / "line.npy", [0, 1, 2])
    np.save(tmp_path / "flat.npy", np.zeros((4, 4), int))
    np.save(tmp_path / "deep.npy", np.zeros((2, 4, 4), int))
    whole = (tmp_path / "flat.npy").read_bytes()
    (tmp_path / "cut.npy").write_bytes(whole[:-1])
    (tmp_path / "huge.npy").write_bytes(whole.replace(b"(4, 4), }              ", b"(100000, 1000000), }   "))
    (tmp_path / "header.npy").write_bytes(whole.replace(b"'descr'", b"(((((((").replace(b"(4, 4)", b"(4, 4'"))
    np.save(tmp_path / "objects.npy", np.array([[None]]), allow_pickle=True)
    os.mkfifo(tmp_path / "pipe.npy")
    (tmp_path / "loop.npy").symlink_to("loop.npy")
    np.save(tmp_path / "volume.npy", bluenoise.mask((2, 4, 4)))
    Image.new("RGB", (4, 4)).save(tmp_path / "colour.png")
    (tmp_path / "link.png").symlink_to("colour.png")
    Image.new("L", (4, 4)).save(tmp_path / "grey.png")
    before = sorted(tmp_path.iterdir())
    assert main(arguments) == 1
    out, err = lines(capsys)
    assert not out and len(err) == 1 and err[0].startswith("bluenoise: ")
    assert all(word in err[0] for word in words), err[0]
    assert sorted(tmp_path.iterdir()) == before


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        ([], "COMMAND"),
        ([], "bluenoise dither photo.jpg"),
        (["mask"], "--size"),
        (["mask", "--size", "8y8", "-o", "m.png"], "8y8"),
        (["mask", "--size", "0", "-o", "m.png"], "--size: '0'"),
        (["mask", "--size", "8x0", "-o", "m.png"], "--size: '8x0'"),
        (["mask", "--size", "8", "--bits", "12", "-o", "m.png"], "12"),
        (["measure", "--channel", "0", "m.npy"], "less than 1"),
        (["mask", "--size", "8x8", "--seed", "1.5", "-o", "m.png"], "1.5"),
        (["mask", "--size", "8x8", "--method", "void", "-o", "m.png"], "void-and-cluster"),
        (["paint"], "paint"),
    ],
)
def test_wrong_usage(arguments, word, capsys):
    with pytest.raises(SystemExit) as caught:
        main(arguments)
    error = capsys.readouterr().err
    assert caught.value.code == 2 and word in error
    assert error.count("\n") == 1 or not arguments


def test_a_failed_write_leaves_the_old_file(tmp_path, capsys, monkeypatch):
    out = tmp_path / "mask.npy"
    out.write_bytes(b"precious")

    def fail(file, array):
        file.write(b"half")
        raise OSError("the disk is full")

    monkeypatch.setattr(np.lib.format, "write_array_header_1_0", fail)
    assert main(["mask", "--size", "8x8", "-o", str(out)]) == 1
    assert "the disk is full" in capsys.readouterr().err
    assert out.read_bytes() == b"precious" and list(tmp_path.iterdir()) == [out]


def test_streams(tmp_path):
    def run(*arguments, data=None):
        command = [sys.executable, "-m", "bluenoise", *arguments]
        done = subprocess.run(command, input=data, capture_output=True, cwd=tmp_path, check=True)
        assert not done.stderr
        return done.stdout

    ranks = bluenoise.mask((16, 16), seed=2)
    npy = run("mask", "--size", "16", "--seed", "2", "-o", "-")
    np.testing.assert_array_equal(np.load(io.BytesIO(npy)), ranks)
    png = run("mask", "--size", "16", "--seed", "2", "--format", "png", "-o", "-")
    for data in (npy, png):
        assert json.loads(run("measure", "--json", "-", data=data))["dithering_error"]["1.0"] == bluenoise.dithering_error(ranks)
    grey = Image.new("L", (8, 8), 100)
    buffer = io.BytesIO()
    grey.save(buffer, "PNG")
    out = Image.open(io.BytesIO(run("dither", "-", "-", data=buffer.getvalue())))
    assert (np.asarray(out) == np.asarray(bluenoise.dither(grey))).all()
    assert not list(tmp_path.iterdir())
    assert run("--version").decode().strip() == f"bluenoise {bluenoise.__version__}" and b"measure" in run("--help")


def test_points(tmp_path, capsys):
    pytest.importorskip("scipy")
    out = tmp_path / "points.csv"
    assert main(["points", "--count", "50", "--seed", "3", "--candidates", "2", "--json", "-o", str(out)]) == 0
    assert json.loads(capsys.readouterr().out)["count"] == 50
    expected = bluenoise.points(50, seed=3, candidates=2)
    assert out.read_text().startswith("x,y\n")
    np.testing.assert_array_equal(np.loadtxt(out, delimiter=",", skiprows=1), expected)
    bluenoise.save(tmp_path / "mask.png", bluenoise.mask((20, 30)))
    arguments = ["points", "--count", "40", "--method", "mask", "--mask", str(tmp_path / "mask.png")]
    assert main([*arguments, "-o", str(tmp_path / "points.npy")]) == 0
    expected = bluenoise.points(40, method="mask", mask=bluenoise.mask((20, 30)))
    np.testing.assert_array_equal(np.load(tmp_path / "points.npy"), expected)


def test_temporary_files_cannot_be_guessed_and_reach_the_disk_before_the_rename(tmp_path, monkeypatch):
    out, folders, steps = tmp_path / "mask.npy", [], []
    for call in ("fsync", "replace"):
        monkeypatch.setattr(
            os, call, lambda *given, call=call, real=getattr(os, call): (steps.append(call), real(*given))
        )
    save = _files.save_array

    def record(path, array):
        folders.append(path.parent)
        assert path.parent.stat().st_mode & 0o077 == 0, "others could put a link there"
        save(path, array)

    monkeypatch.setattr(_files, "save_array", record)
    for _ in range(2):
        assert main(["mask", "--size", "8x8", "-o", str(out)]) == 0
    assert folders[0] != folders[1] and steps == ["fsync", "replace"] * 2
    assert list(tmp_path.iterdir()) == [out]


@pytest.mark.parametrize("arguments", [("measure", "{}"), ("measure", "m.npy", "{}"), ("mask", "--size", "300", "-o", "{}")])
def test_no_control_characters_reach_the_terminal(arguments, tmp_path, capsys, monkeypatch):
    """Neither ASCII nor Latin-1 control characters appear in the output."""
    monkeypatch.chdir(tmp_path)
    name = "a\x1b[31mb\x9bc\n.png"
    try:
        main([argument.format(name) for argument in arguments])
    except SystemExit as end:
        assert end.code == 2
    said = capsys.readouterr().err
    assert "a?[31mb?c" in said
    assert said.endswith("\n") and said[:-1].isprintable()


def test_an_output_that_is_a_link_is_replaced_not_followed(tmp_path):
    victim, out = tmp_path / "victim.npy", tmp_path / "mask.npy"
    victim.write_bytes(b"precious")
    out.symlink_to(victim)
    (tmp_path / "loop.npy").symlink_to("loop.npy")
    for name in ("mask.npy", "loop.npy"):
        assert main(["mask", "--size", "8x8", "-o", str(tmp_path / name)]) == 0
        assert not (tmp_path / name).is_symlink() and np.load(tmp_path / name).shape == (8, 8)
    assert victim.read_bytes() == b"precious"


def run_in_shell(command, cwd):
    """Runs a command in which {} stands for the program."""
    program = f"'{sys.executable}' -m bluenoise"
    return subprocess.run(["sh", "-c", command.replace("{}", program)], capture_output=True, text=True, cwd=cwd)


def test_closed_streams(tmp_path):
    """The command succeeds, or prints one line with the reason."""
    bluenoise.save(tmp_path / "in.npy", bluenoise.mask((8, 8)))
    for close in ("2>&-", ">&-", "<&-", "<&- >&- 2>&-"):
        done = run_in_shell("{} mask --size 8 -o out.npy " + close, tmp_path)
        assert (done.returncode, done.stdout, done.stderr) == (0, "", "") and bluenoise.load(tmp_path / "out.npy").shape == (8, 8)
        (tmp_path / "out.npy").unlink()
    for command in ("{} measure in.npy >&-", "{} measure --json in.npy >&-", "{} mask --size 8 -o - >&-"):
        done = run_in_shell(command, tmp_path)
        assert (done.returncode, done.stderr) == (1, "bluenoise: standard output is closed\n")
    done = run_in_shell("{} measure - <&-", tmp_path)
    assert (done.returncode, done.stdout, done.stderr) == (1, "", "bluenoise: standard input is closed\n")
    done = run_in_shell("{} measure none.npy 2>&-", tmp_path)
    assert (done.returncode, done.stdout) == (1, "")
    assert not os.path.exists("/dev/full") or run_in_shell("{} measure none.npy 2> /dev/full", tmp_path).returncode == 1
    done = run_in_shell("{} paint 2>&-", tmp_path)
    assert (done.returncode, done.stdout) == (2, "")


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="no /dev/full")
@pytest.mark.parametrize("command", ["--help", "--version", "measure in.npy", "mask --size 64 -o -", "mask --size 8 --json -o m.npy"])
def test_full_output_device_is_an_error(command, tmp_path):
    bluenoise.save(tmp_path / "in.npy", bluenoise.mask((8, 8)))
    done = run_in_shell("{} " + command + " > /dev/full", tmp_path)
    assert (done.returncode, done.stderr) == (1, "bluenoise: standard output: No space left on device\n")


@pytest.mark.parametrize("name", ["mask.npy", "mask.png", "mask.exr", "points.npy", "points.csv"])
def test_full_disk_error_names_the_file(name, tmp_path):
    """Exceeding a file size limit fails in the same way, but with another message."""
    if name == "mask.exr":
        pytest.importorskip("OpenEXR")
    (tmp_path / name).write_bytes(b"precious")
    command = {"mask": "mask --size 256", "points": "points --count 9999 --method mask"}[name.split(".")[0]]
    done = run_in_shell(f"ulimit -f 8; {{}} {command} -o {name}", tmp_path)
    assert done.returncode == 1 and done.stderr.count("\n") == 1
    assert done.stderr.startswith(f"bluenoise: {name}") and ("File too large" in done.stderr or name == "mask.exr"), done.stderr
    assert (tmp_path / name).read_bytes() == b"precious" and len(list(tmp_path.iterdir())) == 1
