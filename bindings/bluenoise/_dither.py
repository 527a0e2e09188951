# SPDX-License-Identifier: Apache-2.0
"""Dithering of arrays and Pillow images."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Any, Optional, Sequence, TypeVar, overload

import numpy as np
import numpy.typing as npt

from . import _arguments as arguments
from . import _core
from ._masks import builtin

if TYPE_CHECKING:
    from PIL.Image import Image

_Pixel = TypeVar("_Pixel", bound=np.generic)
_Floats = npt.NDArray[np.float32]
# The mask's y and x shifts from channel to channel, as fractions of its extents. bn_dither uses the same shifts.
_CHANNEL_STEPS = (0.5698402909980532, 0.7548776662466927)
_PART = 2**20  # values dithered at a time
_PICTURE_MODES = ("1", "L", "LA", "I;16", "F", "P", "PA", "RGB", "RGBA")


@overload
def dither(
    image: npt.NDArray[_Pixel], levels: int = 2, *, palette: Any = None, mask: Optional[npt.ArrayLike] = None, srgb: bool = False,
    channel_offset: bool = True,
) -> npt.NDArray[_Pixel]: ...
@overload
def dither(
    image: Image, levels: int = 2, *, palette: Any = None, mask: Optional[npt.ArrayLike] = None, srgb: bool = False,
    channel_offset: bool = True,
) -> Image: ...
@overload
def dither(
    image: Sequence[Any], levels: int = 2, *, palette: Any = None, mask: Optional[npt.ArrayLike] = None, srgb: bool = False,
    channel_offset: bool = True,
) -> npt.NDArray[np.float64]: ...


def dither(
    image: Any, levels: int = 2, *, palette: Any = None, mask: Optional[npt.ArrayLike] = None, srgb: bool = False,
    channel_offset: bool = True,
) -> Any:
    """Dither an image to a few levels, or to a palette, with a mask.

    A value v in [0, 1] becomes ``floor(v * (levels - 1) + t) / (levels - 1)``, where t is the mask's value at that pixel. The mask is tiled
    over the image. The values 0 and 1 are unchanged. Local means are preserved, even if an integer type cannot represent evenly spaced
    levels exactly.

    Parameters
    ----------
    image : array_like or PIL.Image.Image
        An array of shape ``(height, width)`` or ``(height, width, channels)``, in any memory order, or an object that NumPy converts to
        one, such as a pandas DataFrame or an xarray DataArray: uint8 or uint16, where the largest value is full scale, or floats in
        [0, 1]; all channels are dithered. Or a Pillow image of mode 1, L, LA, I;16, F, P, PA, RGB or RGBA: alpha is unchanged,
        mode 1 becomes L, palettes become RGB or RGBA, and transparent colours become alpha.
    levels : int, default 2
        Number of levels, 2 to 256, evenly spaced from 0 to full scale.
    palette : array_like, PIL.Image.Image or int, optional
        Up to 256 colours of shape ``(count, channels)`` or, for a grey array, ``(count,)``, in the image's units. For a Pillow image of
        mode 1, L, P or RGB, also an image of mode P, or the number of colours that Pillow's quantiser is to choose. Each pixel gets one of
        up to four colours that mix its value, or the closest value that the palette can mix. Excludes `levels`. Needs SciPy.
    mask : array_like, optional
        Ranks of shape ``(height, width)``, or ``(n,)`` for a row, in which each rank occurs exactly once; or the values t themselves as
        floats in [0, 1), such as a window from `NeuralGenerator`. If the shape is ``(channels, height, width)``, each image channel uses
        its own mask; extra masks are ignored. A palette needs a single mask. Defaults to the built-in 64 x 64 mask.
    srgb : bool, default False
        Whether values are sRGB-encoded. If so, local means are preserved in linear light.
    channel_offset : bool, default True
        Whether to shift the mask from channel to channel so that the channels' errors are uncorrelated. Masks with multiple channels are
        never shifted.

    Returns
    -------
    ndarray or PIL.Image.Image
        The dithered image, with the dtype and shape of the input. A Pillow image keeps its metadata (``info``); with a palette, it has
        mode P.

    Raises
    ------
    ValueError
        A number is out of range, or a shape or mode is not supported.
    TypeError
        The dtype of the image or the mask is not supported.

    Notes
    -----
    Takes about ten nanoseconds per value; with a palette, about a microsecond per pixel, and ten per colour that the palette cannot mix.
    Palettes follow Gröller and Purgathofer, "Using tetrahedrons for dithering color pictures", 1988. Needs memory for the result plus a
    few megabytes; with a palette, about 100 megabytes.

    Examples
    --------
    >>> float(dither(np.full((64, 64), 0.25)).mean())
    0.25
    """
    levels = arguments.integer("levels", levels, 2, 256)
    srgb, channel_offset = arguments.flag("srgb", srgb), arguments.flag("channel_offset", channel_offset)
    thresholds = None if mask is None else _mask_of(mask)
    pillow = sys.modules.get("PIL.Image")  # a caller with an image has imported Pillow
    if palette is not None:
        if levels != 2:
            raise ValueError(f"levels and palette exclude each other, but levels is {levels}")
        return _to_palette(image, pillow, palette, srgb, thresholds)
    if pillow is not None and isinstance(image, pillow.Image):
        return _dither_picture(image, pillow, levels, srgb, channel_offset, thresholds)
    return _dither_array(image, levels, srgb, channel_offset, thresholds)


def _mask_of(mask: npt.ArrayLike) -> npt.NDArray[Any]:
    """A checked copy of a mask: ranks or values, of shape (height, width) or (channels, height, width)."""
    given = arguments.array("mask", mask)
    if given.dtype.kind == "f":
        values = np.atleast_2d(given).astype(np.float64)
        if values.ndim > 3 or values.size == 0:
            raise ValueError(f"mask must have shape (height, width) or (channels, height, width), not {given.shape}")
        inside = (values >= 0) & (values < 1)
        if not inside.all():
            raise ValueError(f"mask must have ranks or values in [0, 1), not {values[~inside][0]}")
        return values
    if given.ndim == 3 and given.size:
        if len(given) > 1 and arguments.is_permutation(given.flatten()):
            raise ValueError(f"mask {given.shape} has three dimensions; for one slice, give to_float(mask)[0]")
        return np.stack([arguments.ranks("mask", channel) for channel in given])
    return arguments.ranks("mask", given)


def _checked(image: Any) -> tuple[npt.NDArray[Any], int]:
    """An image as an array of shape (height, width) or (height, width, channels), and its full scale."""
    array = arguments.array("image", image)
    integers = array.dtype.kind == "u" and array.dtype.itemsize <= 2
    if not integers and array.dtype.kind != "f":
        hint = "; convert it, for example with np.asarray(image, np.uint8)" if array.dtype.kind in "biuO" else ""
        raise TypeError(f"image must have dtype uint8, uint16 or float, not {array.dtype} ({arguments.said(image)}){hint}")
    if array.ndim not in (2, 3) or array.size == 0:
        raise ValueError(f"image must have shape (height, width) or (height, width, channels), not {array.shape}")
    if array.ndim == 3 and array.shape[0] <= 4 < array.shape[2]:
        given = "image" if isinstance(image, np.ndarray) else "np.asarray(image)"
        raise ValueError(f"image of shape {array.shape} has its channels first: give np.moveaxis({given}, 0, -1)")
    return array, np.iinfo(array.dtype).max if integers else 1


def _dither_array(image: Any, levels: int, srgb: bool, channel_offset: bool, mask: Optional[npt.NDArray[Any]]) -> npt.NDArray[Any]:
    array, full = _checked(image)
    integers = array.dtype.kind == "u"
    texels = array.reshape(*array.shape[:2], -1)
    steps = levels - 1
    level = np.arange(levels, dtype=np.result_type(array.dtype, np.float64))
    ends = (np.rint(level * (full / steps)) if integers else level / steps).astype(array.dtype)
    table = _positions(full, ends.astype(np.float64), srgb) if integers else None
    out = np.empty(texels.shape, array.dtype)
    # Works in parts of a few megabytes, each of which is a stack of whole mask tiles.
    period = 64 if mask is None else mask.shape[-2]
    rows = -(-max(1, _PART // texels[0].size) // period) * period
    for first in range(0, len(texels), rows):
        part = texels[first : first + rows]
        if table is not None:
            found = _dither_channels(table[part], levels, False, channel_offset, mask)
        else:
            values = part.astype(np.float32)
            inside = (values >= 0) & (values <= 1)
            if not inside.all():
                raise ValueError(f"image must have values in [0, 1], not {part[~inside][0]}")
            found = _dither_channels(values, levels, srgb, channel_offset, mask)
        out[first : first + rows] = ends[(found * np.float32(steps) + np.float32(0.5)).astype(np.uint8)]
    return out.reshape(array.shape)


def _positions(full: int, ends: npt.NDArray[np.float64], srgb: bool) -> _Floats:
    """The position of each integer up to `full` between the levels, which are also integers: level k is at k / (levels - 1). Preserves
    means even though the levels are not evenly spaced."""
    values = np.arange(full + 1, dtype=np.float64)
    low = np.minimum(np.searchsorted(ends, values, side="right") - 1, len(ends) - 2)
    dark, light = ends[low], ends[low + 1]
    if srgb:
        values, dark, light = (_linear(each / full) for each in (values, dark, light))
    return np.asarray((low + (values - dark) / (light - dark)) / (len(ends) - 1), np.float32)


def _dither_channels(
    values: _Floats, levels: int, srgb: bool, channel_offset: bool, mask: Optional[npt.NDArray[Any]]
) -> _Floats:
    """Dithers (height, width, channels)."""
    if mask is None or mask.ndim == 2 and mask.dtype.kind != "f":
        return _core.dither(values, levels, srgb, channel_offset, mask)
    channels = values.shape[2]
    if mask.ndim == 3 and len(mask) < channels:
        raise ValueError(f"mask has {len(mask)} channels and the image {channels}; give one channel for all (mask[0], --channel 1)")
    planes = []
    for channel in range(channels):
        plane, own = values[:, :, channel : channel + 1], mask[channel] if mask.ndim == 3 else mask
        if mask.dtype.kind != "f":
            planes.append(_core.dither(plane, levels, srgb, False, own))
            continue
        if channel_offset and mask.ndim == 2:
            own = np.roll(own, [-int(channel * step % 1 * n) for step, n in zip(_CHANNEL_STEPS, own.shape)], (0, 1))
        planes.append(_quantised(plane, levels, srgb, own))
    return np.concatenate(planes, axis=2)


def _quantised(plane: _Floats, levels: int, srgb: bool, thresholds: npt.NDArray[np.float64]) -> _Floats:
    """bn_dither() for float thresholds."""
    height, width, _ = plane.shape
    rows, columns = (np.arange(size) % n for size, n in zip((height, width), thresholds.shape))
    steps, values = levels - 1, plane.astype(np.float64)
    low = np.minimum(np.floor(values * steps), steps - 1)
    fraction = values * steps - low
    if srgb:
        dark, light = _linear(low / steps), _linear((low + 1) / steps)
        fraction = np.clip((_linear(values) - dark) / (light - dark), 0, 1)
    above = np.floor(fraction + thresholds[rows[:, None], columns][:, :, None])
    return np.asarray((low + above) / steps, np.float32)


def _linear(encoded: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)


def _dither_picture(picture: Any, pillow: Any, *options: Any) -> Any:
    transparent = picture.mode == "PA" or "transparency" in picture.info and picture.mode in ("1", "L", "P", "RGB")
    if picture.mode in ("P", "PA") or transparent:
        picture = picture.convert(("LA" if picture.mode in ("1", "L") else "RGBA") if transparent else "RGB")
    elif picture.mode == "1":
        picture = picture.convert("L")
    elif "transparency" in picture.info and picture.mode.startswith("I"):
        raise ValueError("image has 16 bits and a transparent colour, but Pillow has no 16-bit mode with alpha: give image.convert('LA')")
    array = np.asarray(picture)
    # Older versions of Pillow use mode I for 16-bit PNG and PGM files.
    if picture.mode.startswith("I;16") or picture.mode == "I" and picture.format in ("PNG", "PPM"):
        array = array.astype(np.uint16)
    elif picture.mode not in _PICTURE_MODES:
        raise ValueError(f"image must have mode {', '.join(_PICTURE_MODES)}, not {picture.mode}; give image.convert('RGB')")
    if picture.mode in ("LA", "RGBA"):
        out = array.copy()
        out[..., :-1] = _dither_array(array[..., :-1], *options)
    else:
        out = _dither_array(array, *options)
    result = pillow.fromarray(out)
    result.info = _kept_info(picture)
    return result


def _kept_info(picture: Any) -> dict[Any, Any]:
    """A copy of an image's metadata, without the compression of TIFF files, which may be lossy."""
    return {name: value for name, value in picture.info.items() if name != "compression"}


def _to_palette(image: Any, pillow: Any, palette: Any, srgb: bool, mask: Optional[npt.NDArray[Any]]) -> Any:
    from ._palette import indices

    picture = image if pillow is not None and isinstance(image, pillow.Image) else None
    if picture is not None:
        if picture.mode not in ("1", "L", "P", "RGB") or "transparency" in picture.info:
            raise ValueError(f"image must have mode 1, L, P or RGB and no transparency, not {picture.mode}; give image.convert('RGB')")
        image = picture.convert("RGB")
        if isinstance(palette, (int, np.integer)):
            palette = image.quantize(arguments.integer("palette", palette, 1, 256), dither=pillow.Dither.NONE)
        if isinstance(palette, pillow.Image):
            if palette.mode != "P":
                raise ValueError(f"palette must be an image of mode P, not {palette.mode}")
            palette = np.reshape(palette.getpalette("RGB"), (-1, 3))
    array, full = _checked(image)
    colours = arguments.reals("palette", palette)
    if not colours.ndim or not 1 <= len(colours) <= 256 or colours.shape[1:] != array.shape[2:]:
        raise ValueError(f"palette must have shape {('count', *array.shape[2:])} with 1 to 256 colours, not {colours.shape}")
    mask = builtin((64, 64)) if mask is None else mask
    if mask.ndim == 3:
        raise ValueError(f"mask has {len(mask)} channels, but a palette needs one (mask[0], --channel 1)")

    def light(name: str, values: npt.NDArray[Any]) -> npt.NDArray[np.float64]:
        inside = (values >= 0) & (values <= full)
        if not inside.all():
            raise ValueError(f"{name} must have values in [0, {full}], not {values[~inside][0]}")
        return _linear(values.astype(np.float64) / full) if srgb else values.astype(np.float64) / full

    texels, values = array.reshape(*array.shape[:2], -1), light("palette", colours.reshape(len(colours), -1))
    thresholds: Any = mask if mask.dtype.kind == "f" else (mask + 0.5) / mask.size
    found = indices(texels, lambda some: light("image", some), values, thresholds)
    if picture is None:
        return colours.astype(array.dtype)[found]
    result = pillow.fromarray(found)
    result.putpalette(colours.astype(np.uint8).tobytes())
    result.info = _kept_info(picture)
    return result
