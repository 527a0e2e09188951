# SPDX-License-Identifier: Apache-2.0
"""Masks and pictures in files, for the command line. ``-`` is standard input or output; files are replaced atomically."""

from __future__ import annotations

import io
import math
import os
import stat
import struct
import sys
import tempfile
import warnings
import zlib
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Iterator, Sequence

import numpy as np
import numpy.typing as npt

from ._masks import to_float

# Lossless formats, which preserve a dithered picture.
LOSSLESS = (".png", ".tif", ".tiff", ".bmp", ".pgm", ".ppm")
STREAM = Path("-")

_PNG_COLOUR_TYPES = {1: 0, 2: 4, 3: 2, 4: 6}  # grey, grey and alpha, RGB, RGBA
_EXR_CHANNELS = {1: "Y", 2: "RG", 3: "RGB", 4: "RGBA"}
_NPY_MAGIC, _PNG_MAGIC, _EXR_MAGIC = b"\x93NUMPY", b"\x89PNG\r\n\x1a\n", b"\x76\x2f\x31\x01"


def pillow() -> Any:
    """The module PIL.Image."""
    try:
        from PIL import Image
    except ImportError:
        raise ImportError("pictures need Pillow; run pip install 'bluenoise[image]'") from None
    return Image


def openexr() -> Any:
    """The module OpenEXR."""
    try:
        import OpenEXR
    except ImportError:
        raise ImportError("EXR files need OpenEXR; run pip install 'bluenoise[exr]'") from None
    return OpenEXR


def check_output(path: Path, suffix: str, suffixes: Sequence[str]) -> None:
    """Raises, before any work is done, if the suffix is not one of suffixes or if path cannot be written."""
    if suffix not in suffixes:
        raise ValueError(f"output must end in {' or '.join(suffixes)}, not {path.name!r}")
    if path == STREAM:
        if sys.stdout.isatty() and suffix != ".csv":
            raise ValueError("output - is a terminal; redirect it to a file or a pipe")
        return
    if path.is_dir():
        raise IsADirectoryError(f"output {path} is a folder")
    if not path.parent.is_dir():
        raise FileNotFoundError(f"the folder {path.parent} does not exist")
    if not os.access(path.parent, os.W_OK):
        raise PermissionError(f"the folder {path.parent} is not writable")


@contextmanager
def replacing(path: Path, suffix: str) -> Iterator[Path]:
    """Yields a path in a private folder next to path. If the block succeeds, that file replaces path, complete and
    flushed to disk; if not, path is untouched. The folder has a random name and nobody else can put links into it."""
    stream = path == STREAM
    with tempfile.TemporaryDirectory(prefix=".bluenoise-", dir=None if stream else path.parent) as folder:
        beside = Path(folder) / f"output{suffix}"
        yield beside
        if stream:
            sys.stdout.buffer.write(beside.read_bytes())
            sys.stdout.buffer.flush()
            return
        with open(beside, "r+b") as file:
            os.fsync(file.fileno())
        os.replace(beside, path)


def read_bytes(path: Path) -> bytes:
    """The contents of a regular file, or of standard input."""
    if path == STREAM:
        return sys.stdin.buffer.read()
    try:
        with open(path, "rb", opener=lambda name, flags: os.open(name, flags | getattr(os, "O_NONBLOCK", 0))) as file:
            if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
                raise ValueError(f"{path} is not a regular file")
            return file.read()
    except FileNotFoundError:
        raise FileNotFoundError(f"{path} does not exist") from None
    except IsADirectoryError:
        raise ValueError(f"{path} is a folder") from None
    except OSError as error:
        raise ValueError(f"{path} cannot be read: {error.strerror or error}") from None


def open_picture(path: Path) -> Any:
    """A picture, read completely."""
    return _decode_picture(path, read_bytes(path))


def _decode_picture(path: Path, data: bytes) -> Any:
    Image = pillow()
    from PIL import ImageOps

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            warnings.simplefilter("error", Image.DecompressionBombWarning)
            picture = Image.open(io.BytesIO(data))
            picture.load()
            return ImageOps.exif_transpose(picture)
    except (Image.DecompressionBombError, Image.DecompressionBombWarning):
        raise ValueError(f"{path} has too many pixels") from None
    except MemoryError:
        raise
    except Exception as error:  # decoders of damaged files raise many types
        text = "unknown or damaged format" if isinstance(error, Image.UnidentifiedImageError) else str(error)
        raise ValueError(f"{path} cannot be read as a picture: {text}") from None


def _decode_npy(path: Path, data: bytes) -> npt.NDArray[Any]:
    """An array from the contents of a .npy file. The size is checked first, so a damaged header allocates nothing."""
    stream = io.BytesIO(data)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            version = np.lib.format.read_magic(stream)
            if version == (1, 0):
                shape, _, dtype = np.lib.format.read_array_header_1_0(stream)
            elif version == (2, 0):
                shape, _, dtype = np.lib.format.read_array_header_2_0(stream)
            else:
                raise ValueError(f"format version {version} is not supported")
            if dtype.hasobject:
                raise ValueError("it contains Python objects")
            found, expected = len(data) - stream.tell(), math.prod(shape) * dtype.itemsize
            if min(shape, default=0) < 0 or found != expected:
                raise ValueError(f"its header needs {expected} bytes of data, but there are {found}")
            stream.seek(0)
            array: npt.NDArray[Any] = np.load(stream, allow_pickle=False)
    except MemoryError:
        raise
    except Exception as error:  # the header is parsed as a Python expression, which can fail in many ways
        raise ValueError(f"{path} cannot be read as an array: {error}") from None
    return array


def _decode_exr(path: Path, data: bytes) -> npt.NDArray[Any]:
    """(height, width, channels), or (height, width) for a single channel."""
    exr = openexr()
    try:
        with tempfile.TemporaryDirectory() as folder:  # the package reads only from paths
            copy = Path(folder) / "input.exr"
            copy.write_bytes(data)
            with exr.File(str(copy), separate_channels=True) as file:
                channels = {name: np.array(channel.pixels) for name, channel in file.channels().items()}
    except MemoryError:
        raise
    except Exception as error:
        raise ValueError(f"{path} cannot be read as EXR: {error}") from None
    order = sorted(channels, key=lambda name: ("RGBAXYZ".find(name) % 8, name))
    planes = [channels[name] for name in order]
    return planes[0] if len(planes) == 1 else np.stack(planes, axis=-1)


def load_mask(path: Path, channel: int = 0) -> npt.NDArray[Any]:
    """A mask from a .npy or .exr file or a picture. ``channel`` counts from 1; 0: the file has only one."""
    data = read_bytes(path)
    if data.startswith(_NPY_MAGIC) or path.suffix.lower() == ".npy":
        array = _decode_npy(path, data)
    elif data.startswith(_EXR_MAGIC):
        array = _decode_exr(path, data)
        array = np.moveaxis(array, -1, 0) if array.ndim == 3 else array
    else:
        picture = _decode_picture(path, data)
        if picture.mode in ("P", "PA"):
            raise ValueError(f"{path} has a palette; a mask is a grey picture")
        if data.startswith(_PNG_MAGIC) and data[24:25] == b"\x10" and picture.mode in ("RGB", "RGBA", "LA"):
            raise ValueError(f"{path} has 16-bit channels, which Pillow reads as 8 bits; use .npy or .exr")
        array = np.asarray(picture.convert("L") if picture.mode == "1" else picture)
        array = np.moveaxis(array, -1, 0) if array.ndim == 3 else array
    if channel:
        if array.ndim != 3 or channel > len(array):
            raise ValueError(f"{path} has no channel {channel}: its shape is {array.shape}")
        array = array[channel - 1]
    if array.ndim != 2:
        hint = "; choose a channel with --channel" if array.ndim == 3 else ""
        raise ValueError(f"{path} has shape {array.shape}, but a mask must have two dimensions{hint}")
    return array


def save_mask(path: Path, suffix: str, ranks: npt.NDArray[np.uint32], bits: int, description: str) -> None:
    """Writes ranks of shape (height, width) or (channels, height, width): .npy as they are, .png as values
    (rank + 0.5) / n * 2**bits, rounded down, .exr as float values in [0, 1)."""
    with replacing(path, suffix) as beside:
        if suffix == ".npy":
            np.save(beside, ranks)
            return
        texels = np.moveaxis(ranks, 0, -1) if ranks.ndim == 3 else np.atleast_2d(ranks)[:, :, None]
        count = texels.shape[0] * texels.shape[1]
        if suffix == ".png":
            values = (2 * texels.astype(np.uint64) + 1) * np.uint64(2 ** (bits - 1)) // np.uint64(count)
            beside.write_bytes(_png(values.astype(f">u{bits // 8}"), description))
            return
        names = _EXR_CHANNELS[texels.shape[2]]
        planes = {name: to_float(texels[:, :, i], count) for i, name in enumerate(names)}
        exr = openexr()
        header = {"compression": exr.ZIP_COMPRESSION, "type": exr.scanlineimage, "comments": description}
        with exr.File(header, {name: np.ascontiguousarray(plane) for name, plane in planes.items()}) as file:
            file.write(str(beside))


def _png(values: npt.NDArray[Any], description: str) -> bytes:
    """A PNG file of 8- or 16-bit big-endian values (height, width, channels). Pillow writes 16 bits for grey only."""
    height, width, channels = values.shape
    rows = np.zeros((height, 1 + values[0].nbytes), np.uint8)  # each row starts with filter type 0
    rows[:, 1:] = np.frombuffer(values.tobytes(), np.uint8).reshape(height, -1)
    header = struct.pack(">IIBBBBB", width, height, 8 * values.itemsize, _PNG_COLOUR_TYPES[channels], 0, 0, 0)
    parts = [_PNG_MAGIC]
    for name, content in (
        (b"IHDR", header),
        (b"tEXt", b"Description\0" + description.encode("latin-1", "replace")),
        (b"IDAT", zlib.compress(rows.tobytes(), 9)),
        (b"IEND", b""),
    ):
        parts += [struct.pack(">I", len(content)), name, content, struct.pack(">I", zlib.crc32(name + content))]
    return b"".join(parts)


def save_picture(path: Path, suffix: str, picture: Any, source: Any) -> None:
    """Writes a picture with the colour profile and resolution of its source."""
    kept = {name: source.info[name] for name in ("icc_profile", "dpi") if source.info.get(name)}
    with replacing(path, suffix) as beside:
        try:
            picture.save(beside, **kept)
        except (ValueError, KeyError) as error:
            raise ValueError(f"{path} cannot hold this picture: {error}") from None
