# SPDX-License-Identifier: Apache-2.0
"""Masks survive a round trip through save() and load(), which reject unsupported input."""

import struct
import zlib

import numpy as np
import pytest
from helpers import refused

import bluenoise
from bluenoise import load, mask, save

FORMATS = ["npy", "png", "exr"]


def needs(suffix):
    if suffix != "npy":
        pytest.importorskip("PIL.Image" if suffix == "png" else "OpenEXR")


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
    pytest.importorskip("PIL.Image")
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


def png16(texels, kind):
    """A 16-bit PNG with two data chunks. Rows use filter type 0 (none) or 1 (differences from the previous texel)."""
    height, width, channels = texels.shape
    data = np.frombuffer(texels.astype(">u2").tobytes(), np.uint8).reshape(height, -1)
    rows = np.insert(data, 0, kind, axis=1)
    if kind == 1:
        rows[:, 1 + 2 * channels:] -= data[:, :-2 * channels]
    packed = zlib.compress(rows.tobytes())
    parts = [b"\x89PNG\r\n\x1a\n"]
    colour = {2: 4, 3: 2, 4: 6}[channels]
    for name, content in ((b"IHDR", struct.pack(">IIBBBBB", width, height, 16, colour, 0, 0, 0)),
                          (b"IDAT", packed[:50]), (b"IDAT", packed[50:]), (b"IEND", b"")):
        parts += [struct.pack(">I", len(content)), name, content, struct.pack(">I", zlib.crc32(name + content))]
    return b"".join(parts)


@pytest.mark.parametrize("channels", [2, 3, 4])
@pytest.mark.parametrize("kind", [0, 1])
def test_16_bit_pngs_with_multiple_channels(channels, kind, tmp_path):
    pytest.importorskip("PIL.Image")
    texels = np.random.default_rng(1).integers(0, 2**16, (9, 11, channels))
    (tmp_path / "t.png").write_bytes(png16(texels, kind))
    np.testing.assert_array_equal(bluenoise._files.load_values(tmp_path / "t.png"), np.moveaxis(texels, -1, 0))
