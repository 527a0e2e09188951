# SPDX-License-Identifier: Apache-2.0
"""Masks and pictures in files, for the command line: read whole, written beside and renamed."""

from __future__ import annotations

import os
import tempfile
import warnings
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Iterator, Sequence

import numpy as np
import numpy.typing as npt

_PNG_LEVELS = 2**16

# Pictures that keep what dithering made.
LOSSLESS = (".png", ".tif", ".tiff", ".bmp", ".pgm", ".ppm")


def pillow() -> Any:
    """The module PIL.Image."""
    try:
        from PIL import Image
    except ImportError:
        raise ImportError("pictures need Pillow: pip install 'bluenoise[image]'") from None
    return Image


def check_output(path: Path, suffixes: Sequence[str]) -> None:
    """Raises before any work is done when path has none of the suffixes or cannot be written."""
    if path.suffix.lower() not in suffixes:
        raise ValueError(f"output must end in {' or '.join(suffixes)}, not {path.name!r}")
    if path.is_dir():
        raise IsADirectoryError(f"output {path} is a folder")
    if not path.parent.is_dir():
        raise FileNotFoundError(f"the folder {path.parent} does not exist")
    if not os.access(path.parent, os.W_OK):
        raise PermissionError(f"the folder {path.parent} cannot be written to")


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Yields a path in a private folder next to path. If the block succeeds, that file replaces path, complete and
    flushed to disk; if not, path is untouched. The folder has a random name and nobody else can put links into it."""
    with tempfile.TemporaryDirectory(prefix=".bluenoise-", dir=path.parent) as folder:
        beside = Path(folder) / path.name
        yield beside
        with open(beside, "r+b") as file:
            os.fsync(file.fileno())
        os.replace(beside, path)


def open_picture(path: Path) -> Any:
    """A picture, read completely."""
    Image = pillow()
    from PIL import ImageOps

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", Image.DecompressionBombWarning)
            picture = Image.open(path)
            picture.load()
    except FileNotFoundError:
        raise FileNotFoundError(f"{path} does not exist") from None
    except (Image.DecompressionBombError, Image.DecompressionBombWarning):
        raise ValueError(f"{path} has too many pixels") from None
    except (OSError, SyntaxError, ValueError) as error:
        raise ValueError(f"{path} cannot be read as a picture: {error}") from None
    return ImageOps.exif_transpose(picture)


def load_mask(path: Path) -> npt.NDArray[Any]:
    """A mask from a .npy file or a picture of one channel."""
    if path.suffix.lower() == ".npy":
        try:
            array: npt.NDArray[Any] = np.load(path, allow_pickle=False)
        except FileNotFoundError:
            raise FileNotFoundError(f"{path} does not exist") from None
        except (OSError, ValueError, EOFError) as error:
            raise ValueError(f"{path} cannot be read as an array: {error}") from None
    else:
        picture = open_picture(path)
        array = np.asarray(picture.convert("L") if picture.mode == "1" else picture)
        if picture.mode in ("P", "PA"):
            raise ValueError(f"{path} has a palette; a mask is a grey picture")
    if array.ndim != 2:
        raise ValueError(f"{path} has shape {array.shape}; a mask to be measured has two dimensions")
    return array


def save_mask(path: Path, ranks: npt.NDArray[np.uint32], description: str) -> bool:
    """Writes ranks as .npy, or as a 16-bit PNG of the values (rank + 0.5) / n * 65536, rounded down. False when the
    PNG has fewer levels than there are ranks."""
    with replacing(path) as beside:
        if path.suffix.lower() == ".npy":
            np.save(beside, ranks)
            return True
        from PIL.PngImagePlugin import PngInfo

        texels = np.atleast_2d(ranks).astype(np.uint64)
        levels = ((2 * texels + 1) * (_PNG_LEVELS // 2) // np.uint64(ranks.size)).astype(np.uint16)
        text = PngInfo()
        text.add_text("Description", description)
        pillow().fromarray(levels).save(beside, pnginfo=text)
    return ranks.size <= _PNG_LEVELS


def save_picture(path: Path, picture: Any, source: Any) -> None:
    """Writes a picture with the colour profile and resolution of its source."""
    kept = {name: source.info[name] for name in ("icc_profile", "dpi") if source.info.get(name)}
    with replacing(path) as beside:
        try:
            picture.save(beside, **kept)
        except (ValueError, KeyError) as error:
            raise ValueError(f"{path} cannot hold this picture: {error}") from None
