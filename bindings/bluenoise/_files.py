# SPDX-License-Identifier: Apache-2.0
"""Masks and images in files. On the command line, ``-`` stands for standard input or output. Files are replaced atomically."""

from __future__ import annotations

import importlib
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
from typing import Any, BinaryIO, Iterator, Optional, Sequence

import numpy as np
import numpy.typing as npt

from . import _arguments as arguments
from ._masks import to_float
from ._measure import ranks_of
from ._neural import PathLike
from ._sampler import Sampler

# Lossless formats, which preserve a dithered image.
LOSSLESS = (".png", ".tif", ".tiff", ".bmp", ".pgm", ".ppm")
STREAM = Path("-")
MASK_SUFFIXES = (".png", ".exr", ".npy")

_ORIENTATION = 0x0112
_PNG_COLOUR_TYPES = {1: 0, 2: 4, 3: 2, 4: 6}  # grey, grey and alpha, RGB, RGBA
_EXR_CHANNELS = {1: "Y", 2: "RG", 3: "RGB", 4: "RGBA"}
_NPY_MAGIC, _PNG_MAGIC, _EXR_MAGIC = b"\x93NUMPY", b"\x89PNG\r\n\x1a\n", b"\x76\x2f\x31\x01"


def needed(module: str, words: str, extra: str) -> Any:
    """A module that only some functions need."""
    try:
        return importlib.import_module(module)
    except ImportError:
        raise ImportError(f"{words}; run pip install 'libbn[{extra}]'") from None


def pillow() -> Any:
    return needed("PIL.Image", "images need Pillow", "image")


def openexr() -> Any:
    return needed("OpenEXR", "EXR files need OpenEXR", "exr")


def standard(name: str) -> BinaryIO:
    """Standard input or output ("stdin" or "stdout"). Raises OSError if the program was started without it."""
    stream = getattr(sys, name)
    if stream is None:
        raise OSError(f"standard {name[3:]}put is closed")
    return stream.buffer  # type: ignore[no-any-return]


def check_output(path: Path, suffix: str, suffixes: Sequence[str], *inputs: Optional[Path]) -> None:
    """Raises an error before any work is done if the suffix is not in suffixes, if path cannot be written, or if it is one of the
    inputs."""
    if suffix not in suffixes:
        raise ValueError(f"output must end in {' or '.join(suffixes)}, not {path.name!r}")
    if path == STREAM:
        if standard("stdout").isatty() and suffix != ".csv":
            raise ValueError("output - is a terminal; redirect it to a file or a pipe")
        return
    if path.is_dir():
        raise IsADirectoryError(f"output {path} is a folder")
    if not path.parent.is_dir():
        raise FileNotFoundError(f"the folder {path.parent} does not exist")
    if not os.access(path.parent, os.W_OK):
        raise PermissionError(f"the folder {path.parent} is not writable")
    if os.path.lexists(path) and not (path.is_symlink() or path.is_file()):
        raise ValueError(f"output {path} exists and is not a regular file")
    for each in inputs:
        if each is not None and path.exists() and each.exists() and path.samefile(each):
            raise ValueError(f"output {path} is also an input; give another name")


@contextmanager
def replacing(path: Path, suffix: str) -> Iterator[Path]:
    """Yields a path in a private folder next to path. If the block succeeds, that file is flushed to disk and replaces path; otherwise
    path is untouched. The folder has a random name, and other users cannot put links into it. Errors name path."""
    stream = path == STREAM
    name = "standard output" if stream else str(path)
    try:
        with tempfile.TemporaryDirectory(prefix=".bluenoise-", dir=None if stream else path.parent) as folder:
            beside = Path(folder) / f"output{suffix}"
            yield beside
            if stream:
                standard("stdout").write(beside.read_bytes())
                standard("stdout").flush()
                return
            with open(beside, "r+b") as file:
                os.fsync(file.fileno())
            os.replace(beside, path)
    except BrokenPipeError:
        raise
    except OSError as error:
        if error.errno is None:
            raise OSError(f"{name} cannot be written: {error}") from None
        raise OSError(error.errno, error.strerror, name) from None


def read_bytes(path: Path) -> bytes:
    """The contents of a regular file, or of standard input."""
    if path == STREAM:
        return standard("stdin").read()
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


@contextmanager
def about(path: Path) -> Iterator[None]:
    """Prefixes errors about a file's contents with the file's name."""
    try:
        yield
    except (ValueError, TypeError) as error:
        if str(path) in str(error):
            raise
        raise type(error)(f"{path}: {error}") from None


def open_picture(path: Path) -> Any:
    """Reads a single-frame image completely. Returns a Pillow image, or the bytes of a 16-bit PNG."""
    data = read_bytes(path)
    if is_png16(data):
        return data
    picture = _decode_picture(path, data)
    if picture.mode == "I" and picture.format not in ("PNG", "PPM"):
        raise ValueError(f"{path} has 32-bit integers, whose range is unknown; save it with 8 or 16 bits")
    return picture


def _decode_picture(path: Path, data: bytes) -> Any:
    Image = pillow()
    from PIL import ImageOps

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            warnings.simplefilter("error", Image.DecompressionBombWarning)
            picture = Image.open(io.BytesIO(data))
            lost = _lost(picture, data)
            if lost:
                raise ValueError(lost)
            picture.load()
            upright = ImageOps.exif_transpose(picture)
            upright.format = picture.format
            if picture.getexif().get(_ORIENTATION, 1) > 4 and "dpi" in upright.info:
                upright.info["dpi"] = upright.info["dpi"][::-1]
            return upright
    except (Image.DecompressionBombError, Image.DecompressionBombWarning):
        raise ValueError(f"{path} has more than {Image.MAX_IMAGE_PIXELS / 1e6:.1f} megapixels, the most that is read") from None
    except MemoryError:
        raise
    except Exception as error:  # decoders of damaged files raise many types
        text = "unknown or damaged format" if isinstance(error, Image.UnidentifiedImageError) else str(error)
        raise ValueError(f"{path} cannot be read as an image: {text}") from None


def _lost(picture: Any, data: bytes) -> str:
    """Names metadata that Pillow would silently drop."""
    if picture.format in ("GIF", "PNG", "WEBP", "TIFF") and getattr(picture, "n_frames", 1) > 1:
        return f"it has {picture.n_frames} frames; save one"
    tags = getattr(picture, "tag_v2", {}) if picture.format == "TIFF" else {}
    bits = max(tags.get(258, (8,)))
    if picture.format == "PPM" and isinstance(picture.tile[0][3], tuple):
        bits = int(picture.tile[0][3][1]).bit_length()
    at = data.find(b"ihdr", 0, 100)
    if picture.format == "JPEG2000" and at > 0:
        bits = (data[at + 14] & 127) + 1
    if bits > 8 and picture.mode in ("RGB", "RGBA", "RGBX", "LA", "CMYK", "YCbCr"):
        return f"Pillow keeps 8 of its {bits} bits per channel; save it as a 16-bit PNG"
    if bits in range(9, 16):
        return f"its range of {bits} bits gets lost; save it with 8 or 16 bits"
    if tags.get(262) == 0 and bits > 8:
        return "it has 0 for white; save it with 0 for black"
    return ""


def _decode_npy(path: Path, data: bytes) -> npt.NDArray[Any]:
    """An array from the contents of a .npy file. The size is checked first so that a damaged header allocates nothing."""
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


def _exr_planes(path: Path, data: bytes) -> dict[str, npt.NDArray[Any]]:
    """{channel: (height, width)}."""
    exr = openexr()
    try:
        with tempfile.TemporaryDirectory() as folder:  # the package reads only from paths
            copy = Path(folder) / "input.exr"
            copy.write_bytes(data)
            with exr.File(str(copy), separate_channels=True) as file:
                return {name: np.array(channel.pixels) for name, channel in file.channels().items()}
    except MemoryError:
        raise
    except Exception as error:
        raise ValueError(f"{path} cannot be read as EXR: {error}") from None


def _decode_exr(path: Path, data: bytes) -> npt.NDArray[Any]:
    """(height, width, channels), or (height, width) for a single channel."""
    channels = _exr_planes(path, data)
    order = sorted(channels, key=lambda name: ("RGBAXYZ".find(name) % 8, name))
    planes = [channels[name] for name in order]
    return planes[0] if len(planes) == 1 else np.stack(planes, axis=-1)


def read_png(path: Path, data: bytes) -> tuple[npt.NDArray[np.uint16], bool]:
    """The texels (height, width, channels) of a 16-bit PNG file, and whether the last channel is alpha. Transparent colours become alpha.
    Pillow would keep only 8 bits."""
    reader = needed("png", "16-bit PNG files need pypng", "image").Reader
    try:
        width, height, rows, info = reader(bytes=data).asDirect()
        texels = np.empty((height, width, info["planes"]), np.uint16)
        for y, row in enumerate(rows):
            texels[y] = np.asarray(row, np.uint16).reshape(width, -1)
    except MemoryError:
        raise
    except Exception as error:
        raise ValueError(f"{path} cannot be read as an image: {error}") from None
    return texels, info["alpha"]


def is_png16(data: bytes) -> bool:
    return data.startswith(_PNG_MAGIC) and data[24:25] == b"\x10"


def load_values(path: Path) -> npt.NDArray[Any]:
    """The numbers in a .npy file, an .exr file or an image, of shape (height, width) or (channels, height, width); a .npy may have any
    shape."""
    data = read_bytes(path)
    if data.startswith(_NPY_MAGIC) or path.suffix.lower() == ".npy":
        return _decode_npy(path, data)
    if data.startswith(_EXR_MAGIC):
        array = _decode_exr(path, data)
    elif is_png16(data) and data[25]:
        array = read_png(path, data)[0]
    else:
        picture = _decode_picture(path, data)
        if picture.mode in ("P", "PA"):
            raise ValueError(f"{path} has a palette; a mask is a grey image")
        array = np.asarray(picture.convert("L") if picture.mode == "1" else picture)
    return np.moveaxis(array, -1, 0) if array.ndim == 3 else array


def load_light(path: Path) -> npt.NDArray[Any]:
    """Linear light from the channels R, G and B of an .exr file, or its only channel, or from a .npy file: (height, width) or (height,
    width, channels)."""
    data = read_bytes(path)
    if not data.startswith((_NPY_MAGIC, _EXR_MAGIC)):
        raise ValueError(f"{path} is neither .exr nor .npy, which hold linear light")
    if data.startswith(_NPY_MAGIC):
        return _decode_npy(path, data)
    planes = _exr_planes(path, data)
    if all(name in planes for name in "RGB"):
        return np.stack([planes[name] for name in "RGB"], axis=-1)
    if len(planes) != 1:
        raise ValueError(f"{path} has the channels {', '.join(planes)}, but not R, G and B")
    return next(iter(planes.values()))


def load_mask(path: Path, channel: int = 0) -> npt.NDArray[Any]:
    """A two-dimensional mask from a file. ``channel`` counts from 1; 0 means that the file has only one channel."""
    return one_channel(path, load_values(path), channel)


def one_channel(path: Path, array: npt.NDArray[Any], channel: int) -> npt.NDArray[Any]:
    if channel:
        if array.ndim != 3 or channel > len(array):
            raise ValueError(f"{path} has no channel {channel}: its shape is {array.shape}")
        array = array[channel - 1]
    if array.ndim != 2:
        hint = "; choose a channel with --channel" if array.ndim == 3 else ""
        raise ValueError(f"{path} has shape {array.shape}, but a mask must have two dimensions{hint}")
    return array


def without_constants(values: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Removes constant channels from (channels, height, width), unless all are constant."""
    varied = [channel for channel in values if (channel != channel.flat[0]).any()]
    return np.stack(varied) if varied and len(values) > 1 else values


def ranked(path: Path, values: npt.NDArray[Any], rank: bool, option: str) -> arguments.Ranks:
    """The ranks of a file's values, which have shape (height, width). Ties are an error unless ``rank`` is set (messages call it
    ``option``); then they are broken at random, but reproducibly."""
    with about(path):
        ranks, exact = ranks_of("mask", values)
    if exact:
        return ranks
    if not rank:
        raise ValueError(f"{path} has values that occur more than once, as 8-bit textures do; {option} ranks them")
    tie = Sampler("white").block(0, 0, ranks.shape[1], ranks.shape[0], 0, 1)[..., 0, 0]
    ranks.reshape(-1)[np.lexsort((tie.reshape(-1), values.reshape(-1)))] = np.arange(ranks.size, dtype=np.uint32)
    return ranks


def load(path: PathLike, *, rank: bool = False) -> arguments.Ranks:
    """Read a mask from a PNG or other image (needs Pillow), an EXR file (needs OpenEXR) or an NPY file.

    Values other than ranks, such as grey levels, are replaced by their ranks, which restores the saved ranks if all texels are distinct.
    Constant channels, such as an opaque alpha channel, are left out.

    Parameters
    ----------
    path : path-like
        The file.
    rank : bool, default False
        Whether to accept repeated values, as in 8-bit textures. Ties are broken at random, but reproducibly.

    Returns
    -------
    ndarray of uint32
        Ranks of shape ``(height, width)``, ``(channels, height, width)``, or any shape that `save` wrote as NPY.

    Raises
    ------
    ValueError
        The file is damaged or contains no mask, or it contains repeated values and `rank` is False.
    FileNotFoundError, ImportError
        The file or a required package is missing.
    """
    given = _path(path)
    values = load_values(given)
    if values.dtype.kind not in "iuf" or not 1 <= values.ndim <= 3 or values.size == 0:
        raise ValueError(f"{given} has shape {values.shape} and dtype {values.dtype}, and is not a mask")
    if values.dtype.kind != "f" and (arguments.is_permutation(values.reshape(-1)) or arguments.has_channels(values)):
        return values.astype(np.uint32)
    if values.ndim < 3:
        return ranked(given, np.atleast_2d(values), rank, "rank=True")
    return np.stack([ranked(given, channel, rank, "rank=True") for channel in without_constants(values)])


def save(path: PathLike, mask: npt.ArrayLike, *, bits: int = 16) -> None:
    """Write a mask atomically, in the format given by the file's extension.

    Parameters
    ----------
    path : path-like
        ``.npy`` stores the ranks. ``.png`` stores (rank + 0.5) / n * 2**bits, rounded down. ``.exr`` (needs OpenEXR) stores floats in [0,
        1). PNG and EXR files have one to four channels: grey, grey and alpha (EXR: R and G), RGB, RGBA.
    mask : array_like of int
        Ranks, as returned by `mask`. A row becomes an image of height 1.
    bits : {16, 8}, optional
        Bits per channel of a PNG. A 16-bit PNG keeps up to 65536 ranks distinct; EXR keeps up to 2**24.

    Raises
    ------
    ValueError
        The file extension is not supported, the array is not a mask, or the format cannot hold it.
    OSError
        The file cannot be written.
    ImportError
        A required package is missing.
    """
    given = _path(path)
    suffix = given.suffix.lower()
    check_output(given, suffix, MASK_SUFFIXES)
    if arguments.integer("bits", bits, 8, 16) not in (8, 16):
        raise ValueError(f"bits must be 8 or 16, not {bits}")
    ranks = np.array(arguments.integers("mask", mask, np.uint32, *arguments.UINT32), order="C")
    channels = arguments.has_channels(ranks)
    if not channels:
        if not 1 <= ranks.ndim <= 3:
            raise ValueError(f"mask must have 1 to 3 dimensions, not {ranks.shape}")
        arguments.permutation("mask", ranks.reshape(-1))
    if suffix != ".npy":
        ranks = ranks.reshape(len(ranks), -1, ranks.shape[-1]) if channels else np.atleast_2d(ranks)
        if ranks.ndim == 3 and not (channels and len(ranks) <= 4):
            raise ValueError(f"a mask of shape {ranks.shape} does not fit in {suffix}; write .npy")
    save_mask(given, suffix, ranks, bits, "bluenoise")


def _path(path: PathLike) -> Path:
    given = Path(path)
    return given.absolute() if given == STREAM else given


def save_array(path: Path, array: npt.NDArray[Any]) -> None:
    """numpy.save() with clear error messages."""
    with open(path, "wb") as file:
        np.lib.format.write_array_header_1_0(file, np.lib.format.header_data_from_array_1_0(array))
        file.write(np.ascontiguousarray(array).data)


def save_mask(path: Path, suffix: str, ranks: npt.NDArray[np.uint32], bits: int, description: str) -> None:
    """Writes ranks of shape (height, width) or (channels, height, width): unchanged to .npy; to .png as (rank + 0.5) / n * 2**bits,
    rounded down; to .exr as floats in [0, 1)."""
    with replacing(path, suffix) as beside:
        if suffix == ".npy":
            save_array(beside, ranks)
            return
        texels = np.moveaxis(ranks, 0, -1) if ranks.ndim == 3 else np.atleast_2d(ranks)[:, :, None]
        count = texels.shape[0] * texels.shape[1]
        if suffix == ".png":
            beside.write_bytes(png(quantized(ranks, bits), [(b"tEXt", b"Description\0" + description.encode("latin-1", "replace"))]))
            return
        names = _EXR_CHANNELS[texels.shape[2]]
        planes = {name: to_float(texels[:, :, i], count) for i, name in enumerate(names)}
        exr = openexr()
        header = {"compression": exr.ZIP_COMPRESSION, "type": exr.scanlineimage, "comments": description}
        with exr.File(header, {name: np.ascontiguousarray(plane) for name, plane in planes.items()}) as file:
            try:
                file.write(str(beside))
            except RuntimeError as error:
                raise OSError(str(error).replace(str(beside), path.name)) from None


def quantized(ranks: npt.NDArray[np.uint32], bits: int) -> npt.NDArray[Any]:
    """Ranks of shape (height, width) or (channels, height, width) as texels (height, width, channels) of 8 or 16 bits:
    (rank + 0.5) / n * 2**bits, rounded down."""
    texels = np.moveaxis(ranks, 0, -1) if ranks.ndim == 3 else np.atleast_2d(ranks)[:, :, None]
    count = np.uint64(texels.shape[0] * texels.shape[1])
    values = (2 * texels.astype(np.uint64) + 1) * np.uint64(2 ** (bits - 1)) // count
    return values.astype(f"u{bits // 8}")


def png(values: npt.NDArray[Any], chunks: Sequence[tuple[bytes, bytes]]) -> bytes:
    """The bytes of a PNG file that contains the given chunks, then uint8 or uint16 texels (height, width, channels). Pillow writes 16
    bits only for grey images."""
    height, width, channels = values.shape
    rows = np.zeros((height, 1 + values[0].nbytes), np.uint8)  # each row starts with filter type 0
    rows[:, 1:] = np.frombuffer(values.astype(values.dtype.newbyteorder(">")).tobytes(), np.uint8).reshape(height, -1)
    header = struct.pack(">IIBBBBB", width, height, 8 * values.itemsize, _PNG_COLOUR_TYPES[channels], 0, 0, 0)
    parts = [_PNG_MAGIC]
    for name, content in ((b"IHDR", header), *chunks, (b"IDAT", zlib.compress(rows.tobytes(), 9)), (b"IEND", b"")):
        parts += [struct.pack(">I", len(content)), name, content, struct.pack(">I", zlib.crc32(name + content))]
    return b"".join(parts)


_KEPT_CHUNKS = (b"cHRM", b"gAMA", b"iCCP", b"sRGB", b"cICP", b"eXIf", b"pHYs")


def save_png16(path: Path, texels: npt.NDArray[np.uint16], source: bytes) -> None:
    """Writes a 16-bit PNG with its source's colour, orientation and resolution metadata."""
    reader = needed("png", "16-bit PNG files need pypng", "image").Reader
    chunks = [(name, content) for name, content in reader(bytes=source).chunks() if name in _KEPT_CHUNKS]
    with replacing(path, ".png") as beside:
        beside.write_bytes(png(texels, chunks))


def save_picture(path: Path, suffix: str, picture: Any, source: Any) -> None:
    """Writes an image with its source's colour profile, gamma and resolution."""
    kept = {name: source.info[name] for name in ("icc_profile", "dpi") if source.info.get(name)}
    gamma = source.info.get("gamma")
    if suffix == ".png":
        from PIL.PngImagePlugin import PngInfo

        kept["pnginfo"] = chunks = PngInfo()
        if gamma:
            chunks.add(b"gAMA", struct.pack(">I", round(100000 * gamma)))
        if source.info.get("chromaticity"):
            chunks.add(b"cHRM", struct.pack(">8I", *(round(100000 * each) for each in source.info["chromaticity"])))
        if "srgb" in source.info:
            chunks.add(b"sRGB", bytes([source.info["srgb"]]))
    elif gamma and abs(gamma - 1 / 2.2) > 0.01 and "icc_profile" not in kept:
        raise ValueError(f"{path} cannot hold the input's gamma of {1 / gamma:.3g}; write .png")
    with replacing(path, suffix) as beside:
        try:
            picture.save(beside, **kept)
        except (ValueError, KeyError) as error:
            raise ValueError(f"{path} cannot hold this image: {error}") from None
