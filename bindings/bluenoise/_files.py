# SPDX-License-Identifier: Apache-2.0
"""Masks and images in files. On the command line, ``-`` stands for standard input or output. Files are replaced atomically."""

from __future__ import annotations

import io
import itertools
import os
import re
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

Chunks = list[tuple[bytes, bytes]]  # of a PNG file: names and contents
# Lossless formats, which preserve a dithered image, and the Pillow modes that each can hold.
_TIFF = (".tif", ".tiff")
_MODES: dict[str, tuple[str, ...]] = {
    ".png": (), **dict.fromkeys(_TIFF, ("L", "LA", "RGB", "RGBA", "I", "F", "P")), ".bmp": ("L", "RGB", "P"),
    ".gif": ("L", "P"), ".pgm": ("L", "I"), ".ppm": ("RGB",)}
LOSSLESS = tuple(_MODES)
STREAM = Path("-")
MASK_SUFFIXES = (".png", ".exr", ".npy")

_ORIENTATION = 0x0112
_PNG_COLOUR_TYPES = {1: 0, 2: 4, 3: 2, 4: 6}  # grey, grey and alpha, RGB, RGBA
_PNG_PASSES = [(0, 0, 8, 8), (4, 0, 8, 8), (0, 4, 4, 8), (2, 0, 4, 4), (0, 2, 2, 4), (1, 0, 2, 2), (0, 1, 1, 2)]  # x, y and their steps
_COLOUR_CHUNKS = (b"cHRM", b"gAMA", b"iCCP", b"sRGB", b"cICP", b"mDCV", b"cLLI")
_SRGB_PRIMARIES = struct.pack(">8I", 31270, 32900, 64000, 33000, 30000, 60000, 15000, 6000)
_ONE_PICTURE = ("MPO", "PSD")  # a JPEG with previews, depth or gain maps behind it; layers, which Pillow flattens
_EXR_CHANNELS = {1: "Y", 2: "RG", 3: "RGB", 4: "RGBA"}
_NPY_MAGIC, _PNG_MAGIC, _EXR_MAGIC = b"\x93NUMPY", b"\x89PNG\r\n\x1a\n", b"\x76\x2f\x31\x01"


def pillow() -> Any:
    return arguments.needed("PIL.Image", "images need Pillow", "Pillow")


def openexr() -> Any:
    return arguments.needed("OpenEXR", "EXR files need OpenEXR", "OpenEXR")


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


def open_picture(path: Path) -> tuple[Any, Chunks]:
    """Reads an image completely. Returns a Pillow image, or the texels (height, width, channels) of a 16-bit PNG, in which the last of two
    or four channels is alpha; and the PNG chunks that describe its colours and resolution."""
    data = read_bytes(path)
    if is_png16(data):
        return read_png16(path, data)
    picture = _decode_picture(path, data)
    if picture.mode == "I" and picture.format not in ("PNG", "PPM"):
        raise ValueError(f"{path} has 32-bit integers, whose range is unknown; save it with 8 or 16 bits")
    if picture.format == "PNG":
        before = itertools.takewhile(lambda chunk: chunk[0] != b"IDAT", _png_chunks(data))
        chunks = [chunk for chunk in before if chunk[0] in _COLOUR_CHUNKS]
    elif picture.info.get("icc_profile"):
        chunks = [(b"iCCP", b"profile\0\0" + zlib.compress(picture.info["icc_profile"]))]
    else:
        chunks = _coded_colour(picture, data)
    dpi = [float(each) for each in picture.info.get("dpi", ())]
    if len(dpi) == 2 and all(0 < each < 1e6 for each in dpi):
        chunks.append((b"pHYs", struct.pack(">IIB", *(round(each / 0.0254) for each in dpi), 1)))
    return picture, chunks


def _coded_colour(picture: Any, data: bytes) -> Chunks:
    """The colour description of an AVIF file, which Pillow ignores, as a cICP chunk."""
    at = data.find(b"colrnclx") + 8
    primaries, transfer = struct.unpack_from(">HH", data, at) if picture.format == "AVIF" and at >= 8 else (2, 2)
    known = 2 not in (primaries, transfer) and max(primaries, transfer) < 256
    return [(b"cICP", bytes([primaries, transfer, 0, 1]))] if known else []


@contextmanager
def _decoding(path: Path) -> Iterator[Any]:
    """Yields Pillow's Image module, and turns the errors of its decoders into one line. Images that are too large are errors."""
    Image = pillow()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            warnings.simplefilter("error", Image.DecompressionBombWarning)
            yield Image
    except (Image.DecompressionBombError, Image.DecompressionBombWarning):
        raise ValueError(f"{path} has more than {Image.MAX_IMAGE_PIXELS / 1e6:.1f} megapixels, the most that is read") from None
    except MemoryError:
        raise
    except Exception as error:  # decoders of damaged files raise many types
        text = "unknown or damaged format" if isinstance(error, Image.UnidentifiedImageError) else str(error)
        raise ValueError(f"{path} cannot be read as an image: {text}") from None


def _decode_picture(path: Path, data: bytes) -> Any:
    with _decoding(path) as Image:
        from PIL import ImageOps

        picture = Image.open(io.BytesIO(data))
        _refuse_losses(picture, data)
        picture.load()
        upright = ImageOps.exif_transpose(picture)
        upright.format = picture.format
        if picture.getexif().get(_ORIENTATION, 1) > 4 and "dpi" in upright.info:
            upright.info["dpi"] = upright.info["dpi"][::-1]
        return upright


def _refuse_losses(picture: Any, data: bytes) -> None:
    """Raises ValueError if Pillow would silently drop a part of the file."""
    frames = getattr(picture, "n_frames", 1)
    if frames > 1 and picture.format not in _ONE_PICTURE:
        raise ValueError(f"it has {frames} frames; save one")
    tags = getattr(picture, "tag_v2", {}) if picture.format == "TIFF" else {}
    bits = max(tags.get(258, (8,)))
    if picture.format == "PPM" and isinstance(picture.tile[0][3], tuple):
        bits = int(picture.tile[0][3][1]).bit_length()
    elif picture.format == "SGI":
        bits = 8 * data[3]
    elif picture.format == "JPEG2000":
        at = data.find(b"\xff\x4f\xff\x51") + 40  # the number of components, then three bytes for each
        bits = max(byte & 127 for byte in data[at + 2 : at + 2 + 3 * int.from_bytes(data[at : at + 2], "big") : 3]) + 1
    elif data[4:8] == b"ftyp":  # AVIF, and HEIF through a plugin
        depths = re.findall(rb"pixi\0{4}([\1-\4])(.{4})", data, re.DOTALL)
        coded = re.findall(rb"av1C\x81.(.)", data, re.DOTALL)
        bits = max([8, *(each for count, depth in depths for each in depth[: count[0]]), *(_av1_bits(each[0]) for each in coded)])
    deep = bits > 8 and (picture.format == "SGI" or data[4:8] == b"ftyp")
    if deep or bits > 8 and picture.mode in ("RGB", "RGBA", "RGBX", "LA", "CMYK", "YCbCr"):
        raise ValueError(f"Pillow keeps 8 of its {bits} bits per channel; save it as a 16-bit PNG")
    if bits in range(9, 16):
        raise ValueError(f"its range of {bits} bits gets lost; save it with 8 or 16 bits")
    if tags.get(262) == 0 and bits > 8:
        raise ValueError("it has 0 for white; save it with 0 for black")


def _av1_bits(flags: int) -> int:
    """The bit depth in the third byte of an AV1 configuration box."""
    return 8 + 2 * (flags >> 6 & 1) + 2 * (flags >> 5 & 1)


def _decode_npy(path: Path, data: bytes) -> npt.NDArray[Any]:
    """An array from the contents of a .npy file."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            array: npt.NDArray[Any] = np.lib.format.read_array(io.BytesIO(data), allow_pickle=False)
    except Exception as error:  # a damaged header may demand any amount of memory
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


def _png_chunks(data: bytes) -> Iterator[tuple[bytes, bytes]]:
    """The names and contents of a PNG file's chunks."""
    at, name = len(_PNG_MAGIC), b""
    while name != b"IEND":
        size, name = struct.unpack_from(">I4s", data.ljust(at + 8, b"\0"), at)
        content, check = data[at + 8 : at + 8 + size], data[at + 8 + size : at + 12 + size]
        if check != struct.pack(">I", zlib.crc32(name + content)):
            raise ValueError("it is truncated" if len(check) < 4 else f"its chunk {name.decode('latin-1')} is damaged")
        yield name, content
        at += 12 + size


def read_png16(path: Path, data: bytes) -> tuple[npt.NDArray[np.uint16], Chunks]:
    """The texels (height, width, channels) of a 16-bit PNG file, and its chunks with metadata. Transparent colours become alpha.

    Pillow keeps only 8 bits of most such files. PNG predicts each byte of a texel from the same byte of its neighbours, so the upper bytes
    and the lower bytes are two valid 8-bit images, which Pillow decodes."""
    with _decoding(path) as Image:
        _refuse_losses(Image.open(io.BytesIO(data)), data)
        chunks = list(_png_chunks(data))
        width, height, _, colour, _, _, interlaced = struct.unpack(">IIBBBBB", chunks[0][1])
        channels = {kind: count for count, kind in _PNG_COLOUR_TYPES.items()}[colour]
        passes = [(len(range(y, height, dy)), len(range(x, width, dx))) for x, y, dx, dy in (_PNG_PASSES if interlaced else [(0, 0, 1, 1)])]
        passes = [(rows, columns) for rows, columns in passes if rows and columns]
        size = sum(rows * (1 + 2 * channels * columns) for rows, columns in passes)
        packed = b"".join(content for name, content in chunks if name == b"IDAT")
        coded = np.frombuffer(zlib.decompressobj().decompress(packed, size), np.uint8)
        if coded.size < size:
            raise ValueError("it is truncated")
        upper, lower, at = [], [], 0
        for rows, columns in passes:
            lines = coded[at : at + rows * (1 + 2 * channels * columns)].reshape(rows, -1)
            at += lines.size
            upper.append(np.hstack([lines[:, :1], lines[:, 1::2]]))
            lower.append(np.hstack([lines[:, :1], lines[:, 2::2]]))
        header = struct.pack(">IIBBBBB", width, height, 8, colour, 0, 0, interlaced)
        texels = np.zeros((height, width, channels), np.uint16)
        for half in (upper, lower):
            parts = [(b"IHDR", header), (b"IDAT", zlib.compress(b"".join(each.tobytes() for each in half), 0)), (b"IEND", b"")]
            texels = texels << 8 | np.asarray(Image.open(io.BytesIO(_png_file(parts)))).reshape(texels.shape)
        for name, content in chunks:
            if name == b"tRNS":
                key = np.frombuffer(content, ">u2")
                texels = np.dstack([texels, np.where((texels == key).all(-1), 0, 65535).astype(np.uint16)])
    return texels, [chunk for chunk in chunks if chunk[0] in (*_COLOUR_CHUNKS, b"pHYs", b"eXIf")]


def without_alpha(texels: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """The first of one or two channels, or the first three of three or four."""
    return texels[..., : texels.shape[-1] - 1 | 1]


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
        array = read_png16(path, data)[0]
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


def one_channel(path: Path, array: npt.NDArray[Any], channel: int) -> npt.NDArray[Any]:
    """A two-dimensional mask from the values of a file. ``channel`` counts from 1; 0 means that the file has only one channel."""
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

    Warns
    -----
    UserWarning
        The mask has more ranks than a 16-bit PNG or an EXR keeps distinct, so `load` will need ``rank=True``.
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
    lost = merged_ranks(given, suffix, bits, ranks[0].size if channels else ranks.size)
    if lost:
        warnings.warn(lost, stacklevel=2)


def merged_ranks(path: Path, suffix: str, bits: int, count: int) -> str:
    """A message if a format has too few values for this many ranks; 8 bits are too few on purpose."""
    levels = {".png": 2**16 if bits == 16 else count, ".exr": 2**24}.get(suffix, count)
    return f"{path} has {levels} levels for {count} ranks; .npy keeps every rank" if count > levels else ""


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


def png(values: npt.NDArray[Any], chunks: Sequence[tuple[bytes, bytes]], palette: bytes = b"") -> bytes:
    """The bytes of a PNG file that contains the given chunks, then uint8 or uint16 texels (height, width, channels), or indices of a
    palette. Pillow writes 16 bits only for grey images."""
    height, width, channels = values.shape
    rows = np.zeros((height, 1 + values[0].nbytes), np.uint8)  # each row starts with filter type 0
    rows[:, 1:] = np.frombuffer(values.astype(values.dtype.newbyteorder(">")).tobytes(), np.uint8).reshape(height, -1)
    header = struct.pack(">IIBBBBB", width, height, 8 * values.itemsize, 3 if palette else _PNG_COLOUR_TYPES[channels], 0, 0, 0)
    colours = [(b"PLTE", palette)] if palette else []
    return _png_file([(b"IHDR", header), *chunks, *colours, (b"IDAT", zlib.compress(rows.tobytes(), 9)), (b"IEND", b"")])


def _png_file(chunks: Chunks) -> bytes:
    parts = [_PNG_MAGIC]
    for name, content in chunks:
        parts += [struct.pack(">I", len(content)), name, content, struct.pack(">I", zlib.crc32(name + content))]
    return b"".join(parts)


def save_picture(path: Path, suffix: str, picture: Any, chunks: Chunks) -> None:
    """Writes a Pillow image or texels (height, width, channels) with the chunks of open_picture(). Raises ValueError if the format cannot
    hold the image, its alpha or its colours."""
    if suffix == ".png":
        texels = np.asarray(picture)
        if texels.dtype.kind != "u":
            raise ValueError(f"{path} cannot hold floats; write .tif")
        with replacing(path, suffix) as beside:
            palette = bytes(picture.getpalette("RGB")) if getattr(picture, "mode", "") == "P" else b""
            beside.write_bytes(png(texels if texels.ndim == 3 else texels[..., None], chunks, palette))
        return
    lost = _undescribed(dict(chunks))
    if lost and not (suffix in _TIFF and lost == "colour profile"):
        raise ValueError(f"{path} cannot hold the input's {lost}; write .png")
    modes, mode = _MODES[suffix], picture.mode
    if mode in ("LA", "RGBA") and mode not in modes and picture.getextrema()[-1] == (255, 255):
        mode = mode[:-1]  # opaque
    if mode in ("L", "P") and mode not in modes:
        mode = "RGB"
    if mode.split(";")[0] not in modes:
        words = {"LA": "alpha", "RGBA": "alpha", "RGB": "colours", "F": "floats"}.get(mode, "16 bits per channel")
        raise ValueError(f"{path} cannot hold the input's {words}; write {'.tif' if mode == 'F' else '.png'}")
    picture = picture if mode == picture.mode else picture.convert(mode)
    kept = {name: picture.info[name] for name in ("icc_profile", "dpi") if picture.info.get(name)}
    picture.info = {}
    with replacing(path, suffix) as beside:
        picture.save(beside, **kept)


def _undescribed(chunks: dict[bytes, bytes]) -> str:
    """What gets lost without a PNG's colour description: nothing for sRGB. The chunks are in order of precedence."""
    if b"cICP" in chunks:
        return "" if chunks[b"cICP"] == b"\x01\x0d\0\x01" else "colour description (cICP)"
    if b"iCCP" in chunks:
        return "colour profile"
    if b"sRGB" in chunks:
        return ""
    if b"gAMA" in chunks and abs(int.from_bytes(chunks[b"gAMA"], "big") - 45455) > 1000:
        return f"gamma of {100000 / max(1, int.from_bytes(chunks[b'gAMA'], 'big')):.3g}"
    found, usual = (np.frombuffer(each, ">u4").astype(np.int64) for each in (chunks.get(b"cHRM", _SRGB_PRIMARIES), _SRGB_PRIMARIES))
    return "primaries (cHRM)" if (abs(found - usual) > 1000).any() else ""
