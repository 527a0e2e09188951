# SPDX-License-Identifier: Apache-2.0
"""The command `bluenoise`: its files match the library's results; errors are one line and leave no files."""

import io
import json
import os
import struct
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from helpers import needs_package
from onnx_file import convolution

import bluenoise
from bluenoise import _files
from bluenoise._cli import main

Image = pytest.importorskip("PIL.Image")


@pytest.fixture
def run(tmp_path, monkeypatch, capsys):
    """run(command, status=0) runs the command in an empty folder and returns the lines it prints to standard output and standard error."""
    def run(command, status=0):
        assert main(command.split() if isinstance(command, str) else command) == status
        captured = capsys.readouterr()
        return captured.out.splitlines(), captured.err.splitlines()

    monkeypatch.chdir(tmp_path)
    return run


def files():
    return sorted(os.listdir())


def texels(name):
    return np.asarray(Image.open(name))


def test_mask_png_keeps_every_rank(run):
    assert run("mask --size 40x24 --method void-and-cluster --seed 3 --sigma 1.9 -o mask.png") == ([], [])
    picture = Image.open("mask.png")
    assert picture.mode.startswith("I") and picture.size == (40, 24)
    assert "seed 3, sigma 1.9" in picture.info["Description"]
    ranks = bluenoise.void_and_cluster((24, 40), seed=3, sigma=1.9)
    np.testing.assert_array_equal(picture, (ranks + 0.5) * 65536 // ranks.size)
    assert bluenoise.measure(np.asarray(picture)) == bluenoise.measure(ranks)
    assert files() == ["mask.png"]


@pytest.mark.parametrize(("arguments", "make"), [
    ("30", lambda: bluenoise.mask((30, 30))), ("30x1", lambda: bluenoise.mask((1, 30))),
    ("5x4", lambda: bluenoise.mask((4, 5))), ("5x4x3", lambda: bluenoise.mask((3, 4, 5))),
    ("16x16 --method relax --threads 2", lambda: bluenoise.relax((16, 16), threads=2)),
    ("16x16 --method anneal --sweeps 9 --sigma 1.1", lambda: bluenoise.anneal((16, 16), sweeps=9, sigma=1.1))])
def test_mask_npy_matches_the_library(run, arguments, make):
    run(f"mask -o mask.npy --size {arguments}")
    np.testing.assert_array_equal(np.load("mask.npy"), make())


@pytest.mark.parametrize(("written", "seed"), [("007", 7), ("0", 0), ("00", 0), ("010", 10), ("0x1f", 31)])
def test_seed_notations(written, seed, run):
    run(f"mask -o mask.npy --size 16 --seed {written}")
    np.testing.assert_array_equal(np.load("mask.npy"), bluenoise.mask((16, 16), seed=seed))


@needs_package
def test_neural_masks(run, tmp_path):
    (tmp_path / "model.onnx").write_bytes(convolution(np.full((2, 3, 3), 0.1)))
    command = "mask --size 20x16 --method neural --model model.onnx --threads 1 --seed 5"
    assert run(f"{command} -o mask.npy") == run(f"{command} -o mask.png") == ([], [])
    np.testing.assert_array_equal(np.load("mask.npy"), bluenoise.NeuralGenerator(tmp_path / "model.onnx").mask((16, 20), seed=5))
    assert (tmp_path / "mask.png").read_bytes()[24:26] == b"\x10\x04"  # 16 bits, two channels
    os.remove("mask.png")
    for options, words in ((f"--runtime {tmp_path}/nowhere.so", "nowhere.so does not exist"), ("--runtime nowhere.so", "pip install"),
                           ("--provider cuda --runtime nowhere.so", "onnxruntime-gpu")):
        assert words in run(f"{command} {options} -o mask.npy", 1)[1][0]
    assert files() == ["mask.npy", "model.onnx"]


def test_mask_with_more_ranks_than_levels_warns(run):
    out, (said,) = run("mask --size 300x300 -o mask.png")
    assert not out and "90000 ranks" in said and texels("mask.png").max() == 65535


def test_measure(run):
    ranks = bluenoise.mask((32, 64), seed=1)
    np.save("mask.npy", ranks)
    out, err = run("measure mask.npy")
    assert not err and "64 x 32" in out[0] and "yes" in out[1]
    assert f"{bluenoise.dithering_error(ranks):.5f}" in "\n".join(out)
    start = next(number for number, line in enumerate(out) if "white noise has 1" in line)
    assert out[start + 1].split()[:2] == ["grey", "0.0625"] and len(out) == start + 8
    found = json.loads("".join(run("measure --json mask.npy")[0]))
    assert found["size"] == [64, 32] and found["dithering_error"]["1.0"] == bluenoise.dithering_error(ranks)
    np.save("tiny.npy", [[1, 0]])
    assert json.loads("".join(run("measure --json tiny.npy")[0]))["anisotropy"] is None  # NaN is not valid JSON


def test_dither(run):
    y, x = np.mgrid[:40, :60]
    picture = Image.fromarray(np.stack([4 * x, 6 * y, 2 * (x + y)], axis=-1).astype(np.uint8))
    picture.save("in.png", icc_profile=b"a profile")
    assert run("dither in.png out.png") == ([], [])
    np.testing.assert_array_equal(texels("out.png"), bluenoise.dither(picture))
    assert Image.open("out.png").info["icc_profile"] == b"a profile"
    assert run("mask --size 16x16 --seed 1 -o m.png") == run("dither in.png o.tif --levels 4 --srgb --mask m.png") == ([], [])
    np.testing.assert_array_equal(texels("o.tif"), bluenoise.dither(picture, 4, mask=bluenoise.mask((16, 16), seed=1), srgb=True))


def test_dither_applies_the_exif_orientation(run):
    exif = Image.Exif()
    exif[0x0112] = 6  # a quarter turn
    Image.new("L", (60, 40), 90).save("in.jpg", exif=exif, dpi=(300, 150))
    run("dither in.jpg out.png")
    out = Image.open("out.png")
    assert out.size == (40, 60) and np.round(out.info["dpi"]).tolist() == [150, 300]


@pytest.mark.parametrize("channels", [1, 2, 3, 4])
def test_dither_keeps_16_bits_alpha_and_gamma(channels, run, tmp_path):
    """The ramp spans only a few 8-bit steps, so truncation to 8 bits would cause banding. Alpha and colour metadata are preserved."""
    ramp = np.round(np.linspace(5140, 6168, 128)).astype(np.uint16)
    texels = np.repeat(np.tile(ramp, (128, 1))[..., None], channels, 2)
    if channels in (2, 4):
        texels[..., -1] = np.arange(128)[:, None] * 500
    gamma = (b"gAMA", (100000).to_bytes(4, "big"))
    (tmp_path / "in.png").write_bytes(_files.png(texels, [gamma]))
    run("dither --levels 256 in.png out.png")
    data = (tmp_path / "out.png").read_bytes()
    out, _ = _files.read_png16(tmp_path / "out.png", data)
    alpha = channels in (2, 4)
    colours = channels - alpha
    assert gamma[0] + gamma[1] in data and out.shape == texels.shape
    assert (out[..., :colours] == bluenoise.dither(texels[..., :colours], 256)).all()
    assert np.abs(out[..., 0].mean(0) - ramp).max() < 0.2 * 257
    assert not alpha or (out[..., -1] == texels[..., -1]).all()
    run("dither in.png out.tif", 1)


def write_tiff(name, bits, photometric, samples):
    """Writes a black 4 x 4 image with 12 or 16 bits per sample, which Pillow cannot write."""
    data = bytes(16 * samples * bits // 8)
    tags = {256: 4, 257: 4, 258: bits, 259: 1, 262: photometric, 273: 8, 277: samples, 278: 4, 279: len(data)}
    several = 8 + len(data) + 2 + 12 * len(tags) + 4  # offset of the bit depths if there are multiple samples
    entries = b"".join(struct.pack("<HHII", tag, 3, samples if tag == 258 else 1, several if tag == 258 and samples > 1 else value)
                       for tag, value in tags.items())
    head = struct.pack("<2sHI", b"II", 42, 8 + len(data)) + data + struct.pack("<H", len(tags))
    Path(name).write_bytes(head + entries + struct.pack("<I3H", 0, bits, bits, bits))


def test_images_that_pillow_would_degrade_are_rejected(run):
    """Pillow would silently drop data from these files."""
    grey = Image.new("L", (4, 4), 90)
    grey.save("frames.gif", save_all=True, append_images=[Image.new("L", (4, 4), 20)])
    Path("deep.ppm").write_bytes(b"P6 2 2 65535\n" + bytes(24))
    Image.new("I", (4, 4), 200).save("integers.tif")
    write_tiff("twelve.tif", 12, 1, 1)
    write_tiff("white.tif", 16, 0, 1)
    write_tiff("deep.tif", 16, 2, 3)
    for name, words in (("frames.gif", "2 frames"), ("deep.ppm", "16 bits"), ("integers.tif", "32-bit integers"), ("twelve.tif", "12 bits"),
                        ("white.tif", "0 for white"), ("deep.tif", "16 bits per channel")):
        _, (message,) = run(f"dither {name} out.png", 1)
        assert name in message and words in message, message
    with pytest.raises(ValueError, match="mode 1, .*not I"):
        bluenoise.dither(Image.new("I", (4, 4), 200))


def test_content_errors_name_the_file(run):
    np.save("nan.npy", [[0.5, np.nan]])
    np.save("bool.npy", [[True, False]])
    np.save("complex.npy", [[1j, 2]])
    Image.fromarray(np.full((4, 4), 1.5, np.float32)).save("bright.tif")
    Image.new("LAB", (4, 4)).save("lab.tif")
    for command, names in (("measure {}", ("nan.npy", "bool.npy", "complex.npy")), ("dither {} out.tif", ("bright.tif", "lab.tif")),
                           ("points --count 2 --method mask -o p.csv --mask {}", ("nan.npy", "bool.npy", "complex.npy"))):
        for name in names:
            assert name in run(command.format(name), 1)[1][0]


def test_two_channel_texture_loads_as_a_two_channel_mask(run):
    """The third channel and alpha are constant, so ranking them would produce white noise. They are ignored."""
    ranks = bluenoise.anneal((16, 16), channels=2, sweeps=20)
    texture = np.dstack([_files.quantized(ranks, 8), np.zeros((16, 16)), np.full((16, 16), 255)]).astype(np.uint8)
    Image.fromarray(texture).save("rg.png")
    picture = Image.new("RGB", (32, 32), (90, 90, 90))
    picture.save("in.png")
    assert bluenoise.load("rg.png", rank=True).shape == (2, 16, 16)
    dither = "dither --mask rg.png in.png out.png"
    assert "2 channels and the image 3" in run(dither, 1)[1][0]
    run(f"{dither} --channel 2")
    np.testing.assert_array_equal(texels("out.png"), bluenoise.dither(picture, mask=ranks[1]))
    points = "points --method mask --mask rg.png --count 9 -o p.npy"
    assert "--channel" in run(points, 1)[1][0]
    run(f"{points} --channel 1")


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
        (["points", "--count", "9", "--method", "mask", "--candidates", "2", "-o", "p.csv"], ["--candidates needs --method best"]),
        (["points", "--count", "9", "-o", "p.png"], ["p.png", ".csv"]),
        (["measure", "deep.npy", "--channel", "3"], ["channel 3", "(2, 4, 4)"]),
        (["measure", "cut.npy"], ["cut.npy", "127"]),
        (["measure", "huge.npy"], ["huge.npy", "array"]),
        (["measure", "header.npy"], ["header.npy", "array"]),
        (["measure", "objects.npy"], ["objects.npy", "Object"]),
        (["measure", "pipe.npy"], ["pipe.npy", "regular"]),
        (["measure", "loop.npy"], ["loop.npy"]),
        (["measure", "missing.png"], ["missing.png", "does not exist"]),
        (["measure", "broken.png"], ["broken.png"]),
        (["measure", "line.npy"], ["line.npy", "(3,)"]),
        (["measure", "folder.png"], ["folder.png"]),
        (["dither", "colour.png", "out.jpg"], ["out.jpg", ".png"]),
        (["dither", "colour.png", "out.png", "--mask", "line.npy"], ["line.npy"]),
        (["points", "--count", "2", "--method", "mask", "--mask", "colour.png", "-o", "out.csv"], ["colour.png"]),
    ],
)
def test_errors_print_one_line_and_leave_no_files(arguments, words, run):
    os.mkdir("folder.png")
    Path("broken.png").write_bytes(b"\x89PNG\r\n\x1a\n no more")
    for name, array in (("line", [0, 1, 2]), ("flat", np.zeros((4, 4), int)), ("deep", np.zeros((2, 4, 4), int)),
                        ("objects", np.array([[None]])), ("volume", bluenoise.mask((2, 4, 4)))):
        np.save(f"{name}.npy", array, allow_pickle=True)
    whole = Path("flat.npy").read_bytes()
    Path("cut.npy").write_bytes(whole[:-1])
    Path("huge.npy").write_bytes(whole.replace(b"(4, 4), }              ", b"(100000, 1000000), }   "))
    Path("header.npy").write_bytes(whole.replace(b"'descr'", b"(((((((").replace(b"(4, 4)", b"(4, 4'"))
    os.mkfifo("pipe.npy")
    os.symlink("loop.npy", "loop.npy")
    Image.new("RGB", (4, 4)).save("colour.png")
    os.symlink("colour.png", "link.png")
    Image.new("L", (4, 4)).save("grey.png")
    before = files()
    out, (said,) = run(arguments, 1)
    assert not out and said.startswith("bluenoise: ") and all(word in said for word in words), said
    assert files() == before


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
def test_usage_errors(arguments, word, capsys):
    with pytest.raises(SystemExit) as caught:
        main(arguments)
    error = capsys.readouterr().err
    assert caught.value.code == 2 and word in error
    assert error.count("\n") == 1 or not arguments


def test_failed_write_keeps_the_old_file(run, monkeypatch):
    Path("mask.npy").write_bytes(b"precious")

    def fail(file, array):
        file.write(b"half")
        raise OSError("the disk is full")

    monkeypatch.setattr(np.lib.format, "write_array_header_1_0", fail)
    assert "the disk is full" in run("mask --size 8x8 -o mask.npy", 1)[1][0]
    assert Path("mask.npy").read_bytes() == b"precious" and files() == ["mask.npy"]


def test_standard_streams(tmp_path):
    def run(arguments, data=None):
        command = [sys.executable, "-m", "bluenoise", *arguments.split()]
        done = subprocess.run(command, input=data, capture_output=True, cwd=tmp_path, check=True)
        assert not done.stderr
        return done.stdout

    ranks = bluenoise.mask((16, 16), seed=2)
    npy = run("mask --size 16 --seed 2 -o -")
    np.testing.assert_array_equal(np.load(io.BytesIO(npy)), ranks)
    for data in (npy, run("mask --size 16 --seed 2 --format png -o -")):
        assert json.loads(run("measure --json -", data))["dithering_error"]["1.0"] == bluenoise.dithering_error(ranks)
    grey = Image.new("L", (8, 8), 100)
    buffer = io.BytesIO()
    grey.save(buffer, "PNG")
    np.testing.assert_array_equal(texels(io.BytesIO(run("dither - -", buffer.getvalue()))), bluenoise.dither(grey))
    assert not list(tmp_path.iterdir())
    assert run("--version").decode().strip() == f"bluenoise {bluenoise.__version__}" and b"measure" in run("--help")


def test_points(run):
    pytest.importorskip("scipy")
    out, _ = run("points --count 50 --seed 3 --candidates 2 --json -o points.csv")
    assert json.loads("".join(out))["count"] == 50
    assert Path("points.csv").read_text().startswith("x,y\n")
    np.testing.assert_array_equal(np.loadtxt("points.csv", delimiter=",", skiprows=1), bluenoise.points(50, seed=3, candidates=2))
    mask = bluenoise.mask((20, 30))
    bluenoise.save("mask.png", mask)
    run("points --count 40 --method mask --mask mask.png -o points.npy")
    np.testing.assert_array_equal(np.load("points.npy"), bluenoise.points(40, method="mask", mask=mask))
    run("points --count 40 --dims 3 -o deep.csv")
    assert Path("deep.csv").read_text().startswith("x,y,z\n") and np.loadtxt("deep.csv", delimiter=",", skiprows=1).shape == (40, 3)


def test_points_with_a_density(run):
    pytest.importorskip("scipy")
    values = np.arange(60, dtype=np.uint8).reshape(6, 10)
    Image.fromarray(values).save("grey.png")
    np.save("density.npy", values / 100)
    for options, density in (("grey.png", values), ("grey.png --dark", 59 - values.astype(float))):
        run(f"points --count 80 --density {options} -o out.npy")
        np.testing.assert_array_equal(np.load("out.npy"), bluenoise.points(80, density=density))
    assert json.loads("".join(run("points --density density.npy --json -o out.npy")[0]))["method"] == "poisson-disk"
    assert len(np.load("out.npy")) in (17, 18)
    assert "--density" in run("points -o out.npy", 1)[1][0]
    assert "--density" in run("points --count 3 --dark -o out.npy", 1)[1][0]


def test_temporary_files_are_private_and_synced_before_the_rename(run, monkeypatch):
    folders, steps = [], []
    for call in ("fsync", "replace"):
        monkeypatch.setattr(os, call, lambda *given, call=call, real=getattr(os, call): (steps.append(call), real(*given)))
    save = _files.save_array

    def record(path, array):
        folders.append(path.parent)
        assert path.parent.stat().st_mode & 0o077 == 0, "other users could put a link there"
        save(path, array)

    monkeypatch.setattr(_files, "save_array", record)
    for _ in range(2):
        run("mask --size 8x8 -o mask.npy")
    assert folders[0] != folders[1] and steps == ["fsync", "replace"] * 2 and files() == ["mask.npy"]


@pytest.mark.parametrize("arguments", [("measure", "{}"), ("measure", "m.npy", "{}"), ("mask", "--size", "300", "-o", "{}")])
def test_control_characters_are_replaced(arguments, tmp_path, capsys, monkeypatch):
    """Both ASCII and Latin-1 control characters are replaced in error messages."""
    monkeypatch.chdir(tmp_path)
    name = "a\x1b[31mb\x9bc\n.png"
    try:
        main([argument.format(name) for argument in arguments])
    except SystemExit as end:
        assert end.code == 2
    said = capsys.readouterr().err
    assert "a?[31mb?c" in said
    assert said.endswith("\n") and said[:-1].isprintable()


def test_output_symlinks_are_replaced_not_followed(run):
    Path("victim.npy").write_bytes(b"precious")
    os.symlink("victim.npy", "mask.npy")
    os.symlink("loop.npy", "loop.npy")
    for name in ("mask.npy", "loop.npy"):
        run(f"mask --size 8x8 -o {name}")
        assert not os.path.islink(name) and np.load(name).shape == (8, 8)
    assert Path("victim.npy").read_bytes() == b"precious"


def test_sigterm_leaves_no_files(tmp_path):
    """The signal arrives after the temporary file is written."""
    program = "import os, signal, sys; from bluenoise import _cli, _files; save = _files.save_array;" \
              "sys.argv[1:] = 'mask --size 8 -o m.npy'.split();" \
              "_files.save_array = lambda *given: (save(*given), os.kill(os.getpid(), signal.SIGTERM)); sys.exit(_cli.main())"
    assert subprocess.run([sys.executable, "-c", program], cwd=tmp_path, capture_output=True).returncode == 143
    assert not list(tmp_path.iterdir())


def run_in_shell(command, cwd):
    """Runs a shell command in which {} stands for the program."""
    program = f"'{sys.executable}' -m bluenoise"
    return subprocess.run(["sh", "-c", command.replace("{}", program)], capture_output=True, text=True, cwd=cwd)


def test_closed_standard_streams(tmp_path):
    """If a standard stream is closed, the command succeeds or prints the reason on one line."""
    bluenoise.save(tmp_path / "in.npy", bluenoise.mask((8, 8)))
    for close in ("2>&-", "<&- >&- 2>&-"):
        done = run_in_shell("{} mask --size 8 -o out.npy " + close, tmp_path)
        assert (done.returncode, done.stdout, done.stderr) == (0, "", "") and bluenoise.load(tmp_path / "out.npy").shape == (8, 8)
        (tmp_path / "out.npy").unlink()
    no_output, no_input = (f"bluenoise: standard {name} is closed\n" for name in ("output", "input"))
    for command, status, error in (
            ("measure in.npy >&-", 1, no_output), ("mask --size 8 -o - >&-", 1, no_output), ("measure - <&-", 1, no_input),
            ("paint 2>&-", 2, "")):
        done = run_in_shell("{} " + command, tmp_path)
        assert (done.returncode, done.stdout, done.stderr) == (status, "", error), command
    assert not os.path.exists("/dev/full") or run_in_shell("{} measure none.npy 2> /dev/full", tmp_path).returncode == 1


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="requires /dev/full")
@pytest.mark.parametrize("command", ["measure in.npy", "mask --size 64 -o -"])
def test_full_output_device_is_an_error(command, tmp_path):
    bluenoise.save(tmp_path / "in.npy", bluenoise.mask((8, 8)))
    done = run_in_shell("{} " + command + " > /dev/full", tmp_path)
    assert (done.returncode, done.stderr) == (1, "bluenoise: standard output: No space left on device\n")


@pytest.mark.parametrize("name", ["mask.npy", "mask.png", "mask.exr", "points.csv"])
def test_full_disk_error_names_the_file(name, tmp_path):
    """A file size limit stands in for a full disk: writes fail in the same way, but with a different message."""
    if name == "mask.exr":
        pytest.importorskip("OpenEXR")
    (tmp_path / name).write_bytes(b"precious")
    command = {"mask": "mask --size 256", "points": "points --count 9999 --method mask"}[name.split(".")[0]]
    done = run_in_shell(f"ulimit -f 8; {{}} {command} -o {name}", tmp_path)
    assert done.returncode == 1 and done.stderr.count("\n") == 1
    assert done.stderr.startswith(f"bluenoise: {name}") and ("File too large" in done.stderr or name == "mask.exr"), done.stderr
    assert (tmp_path / name).read_bytes() == b"precious" and len(list(tmp_path.iterdir())) == 1
