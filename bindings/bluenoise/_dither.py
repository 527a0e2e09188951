# SPDX-License-Identifier: Apache-2.0
"""Dithering of arrays and Pillow pictures."""

from __future__ import annotations

import reprlib
import sys
from typing import TYPE_CHECKING, Any, Optional, Sequence, TypeVar, overload

import numpy as np
import numpy.typing as npt

from . import _arguments as arguments
from . import _core

if TYPE_CHECKING:
    from PIL.Image import Image

_Pixel = TypeVar("_Pixel", bound=np.generic)
_PICTURE_MODES = ("1", "L", "LA", "I;16", "F", "P", "PA", "RGB", "RGBA")


@overload
def dither(
    image: npt.NDArray[_Pixel],
    levels: int = 2,
    *,
    mask: Optional[npt.ArrayLike] = None,
    srgb: bool = False,
    channel_offset: bool = True,
) -> npt.NDArray[_Pixel]: ...
@overload
def dither(
    image: Image,
    levels: int = 2,
    *,
    mask: Optional[npt.ArrayLike] = None,
    srgb: bool = False,
    channel_offset: bool = True,
) -> Image: ...
@overload
def dither(
    image: Sequence[Any],
    levels: int = 2,
    *,
    mask: Optional[npt.ArrayLike] = None,
    srgb: bool = False,
    channel_offset: bool = True,
) -> npt.NDArray[np.float64]: ...


def dither(
    image: Any,
    levels: int = 2,
    *,
    mask: Optional[npt.ArrayLike] = None,
    srgb: bool = False,
    channel_offset: bool = True,
) -> Any:
    """Dithers a picture to a few levels with a mask. The result has the type, dtype and shape of the picture.

    A value v in [0, 1] becomes ``floor(v * (levels - 1) + t) / (levels - 1)``, where t is the value of the mask, which
    is tiled over the picture. 0 and 1 are preserved.

    Parameters
    ----------
    image
        An array of shape (height, width) or (height, width, channels): uint8 or uint16, whose largest value is full
        scale, or floats in [0, 1]; all channels are dithered. Or a Pillow picture of mode 1, L, LA, I;16, F, P, PA, RGB
        or RGBA: its alpha channel is preserved, mode 1 becomes L, and palettes become RGB or RGBA.
    levels
        The number of levels, 2 to 256, evenly spaced from 0 to full scale.
    mask
        Ranks of shape (height, width), each of 0 .. n - 1 exactly once. None: the built-in 64 x 64 mask.
    srgb
        True if values are sRGB-encoded; local means are then preserved in linear light.
    channel_offset
        True to shift the mask differently for each channel, so that the errors of channels are uncorrelated.

    Raises
    ------
    ValueError
        There are NaN or values outside [0, 1], a shape is wrong, or a mask is not a permutation.
    TypeError
        An argument has a wrong type.
    MemoryError
        There is not enough memory.

    Examples
    --------
    >>> float(dither(np.full((64, 64), 0.25)).mean())
    0.25
    """
    levels = arguments.integer("levels", levels, 2, 256)
    for name, flag in (("srgb", srgb), ("channel_offset", channel_offset)):
        if not isinstance(flag, (bool, np.bool_)):
            raise TypeError(f"{name} must be True or False, not {flag!r}")
    ranks = None if mask is None else arguments.ranks("mask", mask)
    pillow = sys.modules.get("PIL.Image")  # a caller with a picture has imported Pillow
    if pillow is not None and isinstance(image, pillow.Image):
        return _dither_picture(image, pillow, levels, bool(srgb), bool(channel_offset), ranks)
    return _dither_array(image, levels, bool(srgb), bool(channel_offset), ranks)


def _dither_array(
    image: Any, levels: int, srgb: bool, channel_offset: bool, ranks: Optional[arguments.Ranks]
) -> npt.NDArray[Any]:
    array = np.asarray(image)
    if array.dtype.kind == "f":
        values = array.astype(np.float32, order="C")
        inside = (values >= 0) & (values <= 1)
        if not inside.all():
            raise ValueError(f"image must have values in [0, 1], not {array[~inside][0]}")
    elif array.dtype.kind == "u" and array.dtype.itemsize <= 2:
        values = array.astype(np.float32, order="C") / np.float32(np.iinfo(array.dtype).max)
    else:
        raise TypeError(
            f"image must have dtype uint8, uint16 or float, not {array.dtype} ({reprlib.repr(image)})"
        )
    if array.ndim not in (2, 3) or array.size == 0:
        raise ValueError(
            f"image must have shape (height, width) or (height, width, channels), not {array.shape}"
        )
    if array.ndim == 2:
        values = values[:, :, None]
    values = np.ascontiguousarray(values)
    out = _core.dither(values, levels, srgb, channel_offset, ranks).reshape(array.shape)
    if array.dtype.kind == "f":
        return out.astype(array.dtype)
    return np.rint(out * np.iinfo(array.dtype).max).astype(array.dtype)


def _dither_picture(picture: Any, pillow: Any, *options: Any) -> Any:
    if picture.mode == "1":
        picture = picture.convert("L")
    elif picture.mode in ("P", "PA"):
        transparent = picture.mode == "PA" or "transparency" in picture.info
        picture = picture.convert("RGBA" if transparent else "RGB")
    array = np.asarray(picture)
    if picture.mode.startswith("I") and array.size and 0 <= array.min() <= array.max() <= 65535:
        array = array.astype(np.uint16)
    elif picture.mode not in _PICTURE_MODES:
        raise ValueError(f"image must have mode {', '.join(_PICTURE_MODES)}, not {picture.mode}")
    if picture.mode in ("LA", "RGBA"):
        out = array.copy()
        out[..., :-1] = _dither_array(array[..., :-1], *options)
    else:
        out = _dither_array(array, *options)
    return pillow.fromarray(out)
