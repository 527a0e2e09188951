# SPDX-License-Identifier: Apache-2.0
"""bluenoise textures: what a pack holds, read back by readers of its own, and when it is refused."""

import hashlib
import json
import os
import shutil
import struct
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import bluenoise
from bluenoise import _files, _textures
from bluenoise._cli import main

pytest.importorskip("PIL.Image")
pytest.importorskip("OpenEXR")

ROOT = Path(__file__).resolve().parents[2]
SIZES, SEED, SWEEPS = (16, 32), 7, 5
# Names of the formats in vulkan_core.h.
VULKAN = {9: ("R", 8), 16: ("RG", 8), 37: ("RGBA", 8), 70: ("R", 16), 77: ("RG", 16), 91: ("RGBA", 16), 98: ("R", 32)}
MASKS = [(size, channels) for size in SIZES for channels in (1, 2, 4)]


@pytest.fixture(scope="module")
def pack(tmp_path_factory):
    folder = tmp_path_factory.mktemp("textures") / "pack"
    assert main(["textures", str(folder), "--sizes", "32,16", "--seed", str(SEED), "--sweeps", str(SWEEPS)]) == 0
    return folder


def expected(size, channels):
    """Ranks, (channels, size, size)."""
    if channels == 1:
        return bluenoise.builtin((size, size))[None]
    return bluenoise.anneal((size, size), seed=SEED, channels=channels, sweeps=SWEEPS)


class Ktx2:
    """Reads a KTX 2.0 file by the tables of the specification and checks all that it demands of such a file."""

    def __init__(self, path):
        data = path.read_bytes()
        assert data[:12] == bytes([0xAB, 0x4B, 0x54, 0x58, 0x20, 0x32, 0x30, 0xBB, 0x0D, 0x0A, 0x1A, 0x0A])
        (vk_format, type_size, self.width, self.height, depth, layers, faces, levels, scheme,
         dfd_at, dfd_size, kvd_at, kvd_size) = struct.unpack_from("<13I", data, 12)
        assert struct.unpack_from("<2Q", data, 64) == (0, 0)  # no global data of a compression
        assert (depth, layers, faces, levels, scheme) == (0, 0, 1, 1, 0)
        at, size, unpacked = struct.unpack_from("<3Q", data, 80)
        self.channels, bits = VULKAN[vk_format]
        octets = bits // 8 * len(self.channels)
        assert type_size == bits // 8 and size == unpacked == octets * self.width * self.height
        # In order: header, index, descriptor, pairs, texels at a multiple of 4 and of a texel's size; nothing behind them.
        assert dfd_at == 104 and kvd_at == dfd_at + dfd_size and kvd_at % 4 == 0
        assert kvd_at + kvd_size <= at < kvd_at + kvd_size + 8 and at % np.lcm(4, octets) == 0 and at + size == len(data)
        assert not any(data[kvd_at + kvd_size:at])
        self.check_descriptor(data[dfd_at:dfd_at + dfd_size], bits, octets)
        self.pairs = dict(self.pairs_of(data[kvd_at:kvd_at + kvd_size]))
        assert list(self.pairs) == sorted(self.pairs)
        self.texels = np.frombuffer(data[at:], f"<u{bits // 8}").reshape(self.height, self.width, len(self.channels))

    def check_descriptor(self, dfd, bits, octets):
        total, kind, version, size = struct.unpack_from("<IIHH", dfd)
        assert total == len(dfd) and (kind, version) == (0, 2) and size == len(dfd) - 4 == 24 + 16 * len(self.channels)
        model, primaries, transfer, flags = dfd[12:16]
        assert (model, primaries, transfer, flags) == (1, 1, 1, 0)  # RGBSDA, BT.709, linear, straight alpha
        assert dfd[16:20] == bytes(4) and dfd[20:28] == bytes([octets]) + bytes(7)
        for i, name in enumerate(self.channels):
            offset, length, channel, position, low, high = struct.unpack_from("<HBBIII", dfd, 28 + 16 * i)
            assert (offset, length + 1, channel) == (i * bits, bits, {"R": 0, "G": 1, "B": 2, "A": 15}[name])
            assert (position, low, high) == (0, 0, 1 if bits == 32 else 2**bits - 1)

    @staticmethod
    def pairs_of(kvd):
        while kvd:
            (size,) = struct.unpack_from("<I", kvd)
            key, value, rest = kvd[4:4 + size].split(b"\0")
            assert rest == b""
            yield key.decode(), value.decode()
            kvd = kvd[4 + size + -size % 4:]


def test_a_pack_holds_what_it_lists(pack):
    facts = json.loads((pack / "pack.json").read_text())
    found = {path.relative_to(pack).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
             for path in pack.rglob("*") if path.is_file()}
    found.pop("pack.json")
    assert facts["sha256"] == found
    masks = {f"masks/mask_{size}_{channels}ch{rest}" for size, channels in MASKS
             for rest in ("_8bit.png", "_16bit.png", "_8bit.ktx2", "_16bit.ktx2", ".exr")}
    assert {each["file"] for each in facts["masks"]} == masks == {name for name in found if name.startswith("masks/")}
    assert {name for name in found if "/" not in name} == {"README.md", "LICENSE.txt", "contact-sheet.png"}
    assert (pack / "LICENSE.txt").read_text().endswith((ROOT / "LICENSES/CC0-1.0.txt").read_text())
    assert (pack / "draws/LICENSE.txt").read_text() == (ROOT / "LICENSE").read_text()
    for name in masks | {"README.md", "draws/draws.ktx2"}:
        assert (pack / name).stat().st_mode & 0o444 == 0o444 & ~umask()


def umask():
    mask = os.umask(0)
    os.umask(mask)
    return mask


@pytest.mark.parametrize(("size", "channels"), MASKS)
def test_all_formats_hold_the_ranks_of_the_mask(pack, size, channels):
    ranks = expected(size, channels)
    values = (ranks + 0.5) / size**2
    for bits in (8, 16):
        stem = pack / f"masks/mask_{size}_{channels}ch_{bits}bit"
        read = _files.load_values(stem.with_suffix(".png"))
        np.testing.assert_array_equal(read.reshape(ranks.shape), np.floor(values * 2**bits))
        np.testing.assert_array_equal(np.moveaxis(Ktx2(stem.with_suffix(".ktx2")).texels, -1, 0), np.floor(values * 2**bits))
    read = _files.load_values(pack / f"masks/mask_{size}_{channels}ch.exr")
    np.testing.assert_array_equal(read.reshape(ranks.shape), values.astype(np.float32))
    facts = [each for each in json.loads((pack / "pack.json").read_text())["masks"] if (each["size"], each["channels"]) == (size, channels)]
    for each in facts:
        assert each["dithering_error"] == [round(bluenoise.dithering_error(plane), 5) for plane in ranks]
        assert max(each["dithering_error"]) < 0.1  # white noise: .115


def test_the_table_is_where_the_shaders_read_it(pack):
    words = bluenoise.tables()
    i = np.arange(words.size)
    ktx2 = Ktx2(pack / "draws/draws.ktx2")
    assert ktx2.width == 64 and ktx2.height == -(-words.size // 64)
    np.testing.assert_array_equal(ktx2.texels[i >> 6, i & 63, 0], words)
    png = np.moveaxis(_files.load_values(pack / "draws/draws.png"), 0, -1).astype(np.uint32)
    np.testing.assert_array_equal((png << [0, 8, 16, 24]).sum(axis=2)[i >> 6, i & 63], words)
    for name in ("bn_draw.glsl", "bn_path.glsl", "bn_draw.hlsl", "bn_path.hlsl"):
        assert (pack / "draws" / name).read_bytes() == (ROOT / "libbn/include/bn" / name).read_bytes()


@pytest.mark.parametrize("from_png", [False, True])
def test_examples_compile(pack, from_png, tmp_path):
    glslang = shutil.which("glslangValidator") or shutil.which("glslang")
    if glslang is None:
        pytest.skip("no glslangValidator")
    for name, options in (("example.frag", ()), ("example.hlsl", ("-D", "-V", "-e", "main", "-o", tmp_path / "x.spv"))):
        text = (pack / "draws" / name).read_text()
        if from_png:  # what the comments say
            glsl = name.endswith("frag")
            old = "usampler2D bn_words" if glsl else "Texture2D<uint> bn_words"
            new = "sampler2D bn_bytes" if glsl else "Texture2D<float4> bn_bytes"
            assert old in text
            lines = [line for line in text.replace(old, new).split("\n") if not line.startswith("#define BN_WORD")]
            at = next(i for i, line in enumerate(lines) if line.startswith("// #define BN_WORD"))
            lines[at:at + 5] = [line[3:] for line in lines[at:at + 5]]
            text = "\n".join(lines)
        if name.endswith("frag"):
            text = text.replace('#include "bn_draw.glsl"', (pack / "draws/bn_draw.glsl").read_text())
        (tmp_path / name).write_text(text)
        done = subprocess.run([glslang, "-S", "frag", f"-I{pack / 'draws'}", *options, tmp_path / name], capture_output=True, text=True,
                              check=False)
        assert done.returncode == 0, done.stdout


@pytest.mark.parametrize(("arguments", "status", "message"), [
    (["used"], 1, "other files, such as mine.txt"), (["file"], 1, "not a folder"), (["no/where"], 1, "does not exist"),
    (["new", "--sizes", "17"], 2, "'17'"),
    (["new", "--formats", "dds"], 2, "'dds'"), (["new", "--sweeps", "0"], 2, "less than 1"), (["new", "--seed", "-1"], 1, "seed"),
])
def test_what_is_wrong_is_said_in_one_line(tmp_path, monkeypatch, capsys, arguments, status, message):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "used").mkdir()
    (tmp_path / "used" / "mine.txt").write_text("mine")
    (tmp_path / "file").write_text("mine")
    try:
        found = main(["textures", *arguments])
    except SystemExit as error:
        found = error.code
    (line,) = capsys.readouterr().err.splitlines()
    assert found == status and message in line
    assert sorted(path.relative_to(tmp_path).as_posix() for path in tmp_path.rglob("*")) == ["file", "used", "used/mine.txt"]


@pytest.mark.parametrize("there", [False, True])
def test_nothing_is_left_of_a_pack_that_failed(tmp_path, monkeypatch, there):
    folder = tmp_path / "pack"
    if there:
        folder.mkdir()
    monkeypatch.setattr(_textures, "_contact_sheet", lambda *_: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        _textures.write(folder, ("png",), (16,), 1, 1, "0")
    assert folder.exists() == there and list(tmp_path.rglob("*")) == ([folder] if there else [])


def test_the_examples_have_the_seed(pack):
    words = ", ".join(f"0x{word:08x}u" for word in bluenoise.Sampler(seed=SEED).seed_words())
    for name in ("example.frag", "example.hlsl"):
        assert f"({words}); // of {SEED}," in (pack / "draws" / name).read_text()


# ---- What others made


@pytest.mark.parametrize("name", ["README.md", "draws"])
def test_what_appears_meanwhile_is_left_alone(tmp_path, monkeypatch, name):
    folder, sheet = tmp_path / "pack", _textures._contact_sheet
    folder.mkdir()

    def busy(*arguments):
        if name == "draws":
            (folder / name).mkdir()
            (folder / name / "work.txt").write_text("mine")
        else:
            (folder / name).write_text("mine")
        return sheet(*arguments)

    monkeypatch.setattr(_textures, "_contact_sheet", busy)
    with pytest.raises(FileExistsError, match=f"other files, such as {name}"):
        _textures.write(folder, ("png",), (16,), 1, 1, "0")
    assert [path.name for path in folder.iterdir()] == [name]
    assert (folder / name / "work.txt" if name == "draws" else folder / name).read_text() == "mine"


@pytest.mark.parametrize("there", [False, True])
def test_sigterm_leaves_nothing(tmp_path, there):
    folder = tmp_path / "pack"
    if there:
        folder.mkdir()
    run = subprocess.Popen([sys.executable, "-m", "bluenoise", "textures", str(folder), "--sizes", "128", "--formats", "png",
                            "--sweeps", "100000"], stderr=subprocess.PIPE, text=True)
    until = time.monotonic() + 30
    while not any(tmp_path.glob(".bluenoise-*/pack/masks/*")):
        assert time.monotonic() < until, "it did not start"
        time.sleep(0.05)
    time.sleep(0.3)  # in the work, not while the temporary folder is made
    run.terminate()
    assert "terminated" in run.communicate()[1] and run.returncode == 143
    assert list(tmp_path.rglob("*")) == ([folder] if there else [])


def test_a_full_disk_is_named(tmp_path):
    """A limit on the size of files fails in the same way, with other words."""
    command = f"ulimit -f 8; exec {sys.executable} -m bluenoise textures {tmp_path}/pack --sizes 64 --formats png --sweeps 1"
    done = subprocess.run(["bash", "-c", command], capture_output=True, text=True, check=False)
    assert done.returncode == 1 and done.stderr == f"bluenoise: {tmp_path}/pack: File too large\n"
    assert not list(tmp_path.iterdir())
