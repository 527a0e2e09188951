# SPDX-License-Identifier: Apache-2.0
"""Masks survive a round trip through save() and load(), which reject unsupported input."""

import base64
import io
import struct
import zlib
from pathlib import Path

import numpy as np
import pytest
from helpers import refused, run_python

import bluenoise
from bluenoise import _files, load, mask, save
from bluenoise._cli import main

Image = pytest.importorskip("PIL.Image")
from PIL import features

FORMATS = ["npy", "png", "exr"]


def needs(suffix):
    if suffix == "exr":
        pytest.importorskip("OpenEXR")


@pytest.mark.parametrize("suffix", FORMATS)
def test_masks_round_trip(suffix, tmp_path):
    needs(suffix)
    path = tmp_path / f"mask.{suffix}"
    for channels in (1, 2, 3, 4):
        ranks = bluenoise.anneal((24, 20), channels=channels, sweeps=1)
        save(path, ranks)
        found = load(str(path))
        assert found.dtype == np.uint32
        np.testing.assert_array_equal(found, ranks)
    row = mask((50,))
    save(str(path), row.tolist())
    np.testing.assert_array_equal(load(path).reshape(-1), row)
    assert [each.name for each in tmp_path.iterdir()] == [path.name]


def test_rows_with_channels_round_trip(tmp_path):
    rows = bluenoise.anneal((50,), channels=2, sweeps=2)
    save(tmp_path / "rows.npy", rows)
    assert (load(tmp_path / "rows.npy") == rows).all()


def test_only_npy_stores_volumes_and_many_channels(tmp_path):
    for ranks in (mask((3, 8, 8)), np.stack([mask((8, 8), seed=seed) for seed in range(5)])):
        save(tmp_path / "mask.npy", ranks)
        np.testing.assert_array_equal(load(tmp_path / "mask.npy"), ranks)
        for suffix in ("png", "exr"):
            with pytest.raises(ValueError, match=r"8, 8\) does not fit in ."):
                save(tmp_path / f"mask.{suffix}", ranks)
    assert len(list(tmp_path.iterdir())) == 1


def test_8_bit_textures_are_ranked_on_request(tmp_path):
    ranks = mask((64, 64), seed=2)
    save(tmp_path / "mask.png", ranks, bits=8)
    with pytest.raises(ValueError, match="mask.png .*rank=True"):
        load(tmp_path / "mask.png")
    found = load(tmp_path / "mask.png", rank=True)
    assert (found // 16 == ranks // 16).all() and np.array_equal(np.sort(found, axis=None), np.arange(4096))
    np.testing.assert_array_equal(load(tmp_path / "mask.png", rank=True), found)
    tied = found[ranks // 16 == 7]  # ties are broken randomly, neither in order nor in reverse
    assert 3 < (np.diff(tied.astype(int)) > 0).sum() < 12
    assert bluenoise.dithering_error(found) == pytest.approx(bluenoise.dithering_error(ranks), rel=0.02)


@pytest.mark.parametrize(
    ("name", "array", "options", "error", "words"),
    [
        ("mask.jpg", [[0, 1]], {}, ValueError, ["mask.jpg", ".png"]),
        ("mask.png", [[0, 0]], {}, ValueError, ["mask", "0 2 times"]),
        ("mask.png", [[0.0, 1.0]], {}, TypeError, ["mask", "float64"]),
        ("mask.png", [[0, 1]], {"bits": 12}, ValueError, ["bits", "12"]),
        ("mask.npy", np.zeros((1, 1, 1, 1), int), {}, ValueError, ["mask", "(1, 1, 1, 1)"]),
        ("none/mask.npy", [[0, 1]], {}, FileNotFoundError, ["none"]),
    ],
)
def test_bad_masks_are_not_saved(name, array, options, error, words, tmp_path):
    with refused(error, words):
        save(tmp_path / name, array, **options)
    assert not list(tmp_path.iterdir())


def test_bad_files_are_not_loaded(tmp_path):
    for array in (np.zeros((2, 2, 2, 2)), np.zeros(0), np.array([["a"]])):
        np.save(tmp_path / "mask.npy", array)
        with pytest.raises(ValueError, match="mask.npy"):
            load(tmp_path / "mask.npy")
    with pytest.raises(FileNotFoundError, match="other.npy"):
        load(tmp_path / "other.npy")


def test_hyphen_is_an_ordinary_file_name(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ValueError, match=".npy"):
        save("-", [[0, 1]])
    with pytest.raises(FileNotFoundError):
        load("-")


PASSES = [(0, 0, 8, 8), (4, 0, 8, 8), (0, 4, 4, 8), (2, 0, 4, 4), (0, 2, 2, 4), (1, 0, 2, 2), (0, 1, 1, 2)]


def filtered(texels):
    """The rows of a PNG file: each has one of the five filters in turn."""
    height, width, channels = texels.shape
    rows = np.frombuffer(texels.astype(">u2").tobytes(), np.uint8).reshape(height, -1).astype(int)
    above = np.vstack([np.zeros_like(rows[:1]), rows[:-1]])
    left, corner = (np.hstack([np.zeros((height, 2 * channels), int), each[:, : -2 * channels]]) for each in (rows, above))
    to_left, to_above, to_corner = (abs(left + above - corner - each) for each in (left, above, corner))
    paeth = np.where((to_left <= to_above) & (to_left <= to_corner), left, np.where(to_above <= to_corner, above, corner))
    kinds = np.arange(height)[:, None] % 5
    coded = rows - np.choose(kinds, [0 * rows, left, above, (left + above) // 2, paeth])
    return np.hstack([kinds, coded]).astype(np.uint8).tobytes()


def png16(texels, *chunks, interlaced=False):
    """A 16-bit PNG with two data chunks, for which libpng needs all of its code."""
    height, width, channels = texels.shape
    parts = [texels[y::dy, x::dx] for x, y, dx, dy in PASSES] if interlaced else [texels]
    packed = zlib.compress(b"".join(filtered(part) for part in parts if part.size))
    data = b"\x89PNG\r\n\x1a\n"
    header = struct.pack(">IIBBBBB", width, height, 16, {1: 0, 2: 4, 3: 2, 4: 6}[channels], 0, 0, interlaced)
    for name, content in ((b"IHDR", header), *chunks, (b"IDAT", packed[:50]), (b"IDAT", packed[50:]), (b"IEND", b"")):
        data += struct.pack(">I", len(content)) + name + content + struct.pack(">I", zlib.crc32(name + content))
    return data


@pytest.mark.parametrize("channels", [1, 2, 3, 4])
@pytest.mark.parametrize("interlaced", [False, True])
@pytest.mark.parametrize("shape", [(23, 17), (1, 1), (9, 2), (1, 40)])
def test_16_bit_pngs_keep_every_bit(channels, interlaced, shape, tmp_path):
    """sBIT says how many bits the source had; the samples still have full scale."""
    texels = np.random.default_rng(1).integers(0, 2**16, (*shape, channels))
    data = png16(texels, (b"sBIT", bytes([9] * channels)), interlaced=interlaced)
    np.testing.assert_array_equal(bluenoise._files.read_png16(tmp_path / "t.png", data)[0], texels)
    (tmp_path / "t.png").write_bytes(data)
    found = bluenoise._files.load_values(tmp_path / "t.png")
    np.testing.assert_array_equal(found, texels[..., 0] if channels == 1 else np.moveaxis(texels, -1, 0))


@pytest.mark.parametrize("channels", [1, 3])
def test_a_transparent_16_bit_colour_becomes_alpha(channels, tmp_path):
    texels = np.random.default_rng(1).integers(0, 3, (8, 9, channels))
    found, _ = bluenoise._files.read_png16(tmp_path / "t.png", png16(texels, (b"tRNS", b"\0\1" * channels)))
    assert (found[..., :channels] == texels).all()
    np.testing.assert_array_equal(found[..., channels], np.where((texels == 1).all(-1), 0, 65535))


def test_damaged_16_bit_pngs_are_refused(tmp_path):
    whole = png16(np.random.default_rng(1).integers(0, 2**16, (6, 5, 3)))
    for at in range(0, len(whole), 5):
        changed = whole[:at] + bytes([whole[at] ^ 0x55]) + whole[at + 1 :]
        for data in (changed, whole[:at]):
            with refused(ValueError, ["t.png cannot be read"]):
                bluenoise._files.read_png16(tmp_path / "t.png", data)


def test_more_ranks_than_levels_are_announced(tmp_path):
    ranks = np.arange(65792, dtype=np.uint32).reshape(257, 256)
    with pytest.warns(UserWarning, match="mask.png has 65536 levels for 65792 ranks; .npy keeps every rank"):
        save(tmp_path / "mask.png", ranks)
    save(tmp_path / "mask.png", ranks, bits=8)
    save(tmp_path / "mask.npy", ranks)
    save(tmp_path / "mask.png", ranks[:256])


def test_masks_are_written_without_pillow_and_errors_name_the_package(tmp_path):
    """The names of packages can be installed anywhere; those of extras cannot."""
    program = f"""
import sys
sys.modules.update(dict.fromkeys(["PIL", "PIL.Image", "OpenEXR", "scipy"]))
import bluenoise, numpy as np
bluenoise.save({str(tmp_path / "mask.png")!r}, bluenoise.mask((16, 16)))
for call in (lambda: bluenoise.load({str(tmp_path / "mask.png")!r}), lambda: bluenoise.save({str(tmp_path / "mask.exr")!r}, [[1, 0]]),
             lambda: bluenoise.Sampler().qmc(2), lambda: bluenoise.points(4)):
    try:
        call()
    except ImportError as error:
        print(error)
"""
    found = run_python(program)
    for line, package in zip(found.stdout.splitlines(), ("Pillow", "OpenEXR", "scipy", "scipy"), strict=True):
        assert f"run: pip install {package}" in line
    assert (tmp_path / "mask.png").stat().st_size > 400, found.stderr


# An AVIF image of 8 x 8 texels.
TEN_BITS = (
    "AAAAIGZ0eXBhdmlmAAAAAGF2aWZtaWYxbWlhZk1BMUEAAADrbWV0YQAAAAAAAAAhaGRscgAAAAAAAAAAcGljdAAAAAAAAAAAAAAAAAAAAAAOcGl0bQAAAAAAAQ"
    "AAAB5pbG9jAAAAAEQAAAEAAQAAAAEAAAETAAAAIwAAAChpaW5mAAAAAAABAAAAGmluZmUCAAAAAAEAAGF2MDFDb2xvcgAAAABqaXBycAAAAEtpcGNvAAAAFGlz"
    "cGUAAAAAAAAACAAAAAgAAAAQcGl4aQAAAAADCgoKAAAADGF2MUOBIEAAAAAAE2NvbHJuY2x4AAIAAgAGgAAAABdpcG1hAAAAAAAAAAEAAQQBAoMEAAAAK21kYX"
    "QSAAoIOAi/bwICBpAyFRrCYuTgABQiAACQNY+rLPWUH/YaNA==")


class TestImages:
    """What `bluenoise dither` reads and writes is kept, announced or refused."""

    COLOUR = [(b"cICP", b"\x0c\x0d\0\1"), (b"mDCV", bytes(24)), (b"cLLI", bytes(8)), (b"gAMA", struct.pack(">I", 45455))]

    @pytest.fixture
    def run(self, tmp_path, monkeypatch, capsys):
        def run(command, *words):
            """Runs a command that must succeed, or fail with one line that contains these words."""
            status = main(command.split())
            said = capsys.readouterr().err
            assert status == bool(words) and all(word in said for word in words) and said.count("\n") == len(words[:1]), said

        monkeypatch.chdir(tmp_path)
        return run

    def picture(self, mode="RGB"):
        y, x = np.mgrid[:20, :30]
        rgba = np.stack([6 * x, 8 * y, 3 * (x + y), 2 * x + 9 * y], axis=-1).astype(np.uint8)
        return Image.fromarray(rgba if mode in ("RGBA", "LA") else rgba[..., :3].copy()).convert(mode)

    @pytest.mark.parametrize("bits", [8, 16])
    def test_colour_chunks_are_copied(self, bits, run):
        texels = np.asarray(self.picture()).astype(f"u{bits // 8}")
        chunks = [*self.COLOUR, (b"iCCP", b"x\0\0" + zlib.compress(b"profile")), (b"pHYs", struct.pack(">IIB", 2835, 2000, 1))]
        Path("in.png").write_bytes(_files.png(texels, chunks))
        run("dither in.png out.png")
        found = list(_files._png_chunks(Path("out.png").read_bytes()))
        assert sorted(found[1:-2]) == sorted(chunks)

    @pytest.mark.parametrize("suffix", ["jpg", "tif", "webp"])
    def test_profiles_of_other_formats_are_kept(self, suffix, run):
        self.picture().save(f"in.{suffix}", icc_profile=b"a profile", dpi=(300, 300))
        run(f"dither in.{suffix} out.png")
        assert Image.open("out.png").info["icc_profile"] == b"a profile"

    @pytest.mark.parametrize(("mode", "options", "suffix", "word"), [
        ("RGBA", {}, "bmp", "alpha"), ("RGBA", {}, "ppm", "alpha"), ("LA", {}, "pgm", "alpha"), ("LA", {}, "bmp", "alpha"),
        ("P", {"transparency": bytes(256)}, "bmp", "alpha"), ("RGB", {"transparency": (0, 0, 0)}, "ppm", "alpha"),
        ("RGBA", {}, "pgm", "alpha"),
        ("RGB", {"icc_profile": b"profile"}, "bmp", "colour profile"), ("L", {"icc_profile": b"profile"}, "pgm", "colour profile")])
    def test_formats_refuse_what_they_cannot_hold(self, mode, options, suffix, word, run):
        self.picture(mode).save("in.png", **options)
        run(f"dither in.png out.{suffix}", f"out.{suffix} cannot hold the input's {word}; write .png")
        assert not Path(f"out.{suffix}").exists()

    @pytest.mark.parametrize(("chunk", "content", "word"), [
        (b"cICP", b"\x09\x10\0\1", "cICP"), (b"gAMA", struct.pack(">I", 100000), "gamma of 1"),
        (b"cHRM", struct.pack(">8I", 31270, 32900, 68000, 32000, 26500, 69000, 15000, 6000), "cHRM")])
    def test_only_png_holds_its_colour_descriptions(self, chunk, content, word, run):
        Path("in.png").write_bytes(_files.png(np.asarray(self.picture()), [(chunk, content)]))
        for suffix in ("tif", "bmp", "ppm"):
            run(f"dither in.png out.{suffix}", "cannot hold", word)
        Path("in.png").write_bytes(_files.png(np.asarray(self.picture()), [(b"cICP", b"\1\x0d\0\1"), (chunk, content)]))
        if chunk != b"cICP":
            run("dither in.png out.bmp")  # sRGB, which takes precedence

    @pytest.mark.parametrize(("mode", "suffix", "result"), [
        ("RGB", "bmp", "RGB"), ("L", "bmp", "L"), ("RGB", "ppm", "RGB"), ("L", "ppm", "RGB"), ("L", "pgm", "L"), ("1", "pgm", "L"),
        ("RGBA", "tif", "RGBA"), ("LA", "tif", "LA"), ("P", "ppm", "RGB")])
    def test_formats_hold_the_dithered_image(self, mode, suffix, result, run):
        self.picture(mode).save("in.png")
        run(f"dither in.png out.{suffix}")
        with Image.open(f"out.{suffix}") as found:
            assert found.mode == result
            np.testing.assert_array_equal(found, bluenoise.dither(self.picture(mode)).convert(result))
        magic = {"pgm": b"P5", "ppm": b"P6", "bmp": b"BM", "tif": b"II"}
        assert Path(f"out.{suffix}").read_bytes()[:2] == magic[suffix]

    def test_opaque_alpha_is_no_loss(self, run):
        self.picture().convert("RGBA").save("in.png")
        run("dither in.png out.bmp")
        assert Image.open("out.bmp").mode == "RGB"

    def test_colours_become_grey_in_a_pgm_which_is_announced(self, run, capsys):
        self.picture().save("in.png")
        assert main(["dither", "in.png", "out.pgm"]) == 0
        assert capsys.readouterr().err == "bluenoise: out.pgm holds grey: the colours became their luminance\n"
        np.testing.assert_array_equal(Image.open("out.pgm"), bluenoise.dither(self.picture("L")))

    def test_compressed_tiffs_stay_lossless(self, run):
        self.picture().save("in.tif", compression="jpeg")
        run("dither in.tif out.tif")
        out = bluenoise.dither(Image.open("in.tif"))
        out.save("other.tif")
        for name in ("out.tif", "other.tif"):
            np.testing.assert_array_equal(Image.open(name), out)

    @pytest.mark.parametrize("suffix", ["png", "gif", "webp", "tif", "avif"])
    def test_animations_are_refused(self, suffix, run):
        if suffix == "avif" and not features.check("avif"):
            pytest.skip("this Pillow reads no AVIF")
        self.picture().save(f"in.{suffix}", save_all=True, append_images=[Image.new("RGB", (30, 20), 9)])
        run(f"dither in.{suffix} out.png", f"in.{suffix}", "2 frames")

    def test_16_bit_animations_are_refused(self, run):
        frame = struct.pack(">IIIIIHHBB", 0, 8, 8, 0, 0, 1, 10, 0, 0)
        texels = np.zeros((8, 8, 3), int)
        Path("in.png").write_bytes(png16(texels, (b"acTL", struct.pack(">II", 2, 0)), (b"fcTL", frame)))
        run("dither in.png out.png", "in.png", "2 frames")

    def test_jpegs_with_a_preview_are_images(self, run):
        self.picture().save("in.mpo", save_all=True, append_images=[Image.new("RGB", (30, 20), 9)])
        Path("in.mpo").rename("in.jpg")
        run("dither in.jpg out.png")

    def test_avif_with_ten_bits_is_refused(self, run):
        Path("in.avif").write_bytes(base64.b64decode(TEN_BITS))
        run("dither in.avif out.png", "in.avif", "8 of its 10 bits" if features.check("avif") else "cannot be read")

    @pytest.mark.skipif(not features.check("avif"), reason="this Pillow reads no AVIF")
    def test_colours_of_avif_are_kept(self, run):
        stream = io.BytesIO()
        self.picture().save(stream, "AVIF")
        data = bytearray(stream.getvalue())
        at = data.index(b"colrnclx") + 8
        data[at : at + 4] = struct.pack(">HH", 12, 13)  # Display P3
        Path("in.avif").write_bytes(data)
        run("dither in.avif out.png")
        assert (b"cICP", b"\x0c\x0d\0\1") in list(_files._png_chunks(Path("out.png").read_bytes()))
        run("dither in.avif out.bmp", "cannot hold", "cICP")

    def test_deep_images_of_other_formats_are_refused(self, run):
        header = struct.pack(">HBBHHHHII", 474, 0, 2, 3, 4, 4, 3, 0, 65535)
        Path("in.sgi").write_bytes(header.ljust(512, b"\0") + bytes(96))
        run("dither in.sgi out.png", "in.sgi", "8 of its 16 bits")
