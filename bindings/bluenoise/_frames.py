# SPDX-License-Identifier: Apache-2.0
"""Pans that follow a moving image, and sample indices for film frames: bn_path.h on numbers and arrays."""

from __future__ import annotations

from typing import Any, Union

import numpy as np
import numpy.typing as npt

from . import _arguments as arguments
from . import _core

_Whole = Union[int, npt.NDArray[Any]]


def _whole(values: object, dtype: npt.DTypeLike, shape: tuple[int, ...]) -> _Whole:
    """An int if the shape is (), or else an array."""
    array = np.asarray(values, dtype)
    return int(array[()]) if shape == () else array


class Pan:
    """How far an image has moved, in whole pixels. Draws that follow a moving image subtract it from their coordinates.

    Call `follow` once per frame. Sums are exact: errors do not grow with the distance. Results are bit-identical to those of
    ``bn_follow`` in C and in shaders.

    Parameters
    ----------
    shape : tuple of int, default ()
        The shape of `x` and `y`: one pan, or an array of pans, for example one for each layer of the image.

    Examples
    --------
    >>> pan = Pan()
    >>> for frame in range(4):  # draw at (x - pan.x, y - pan.y), then move on
    ...     pan.follow(2.5, -0.25)
    >>> pan.x, pan.y
    (10, -1)
    """

    __slots__ = ("_sums", "shape")

    shape: tuple[int, ...]

    def __init__(self, shape: tuple[int, ...] = ()) -> None:
        extents = () if isinstance(shape, tuple) and not shape else arguments.shape(shape, 31)
        self._sums = np.zeros((2, *extents), np.uint64)  # whole pixels in the upper half, the rest in the lower
        self.shape = self._sums.shape[1:]

    def follow(self, x: npt.ArrayLike, y: npt.ArrayLike) -> None:
        """Add the motion of one frame.

        Parameters
        ----------
        x, y : array_like of float
            How far the image moved since the last frame, in pixels, in the directions in which coordinates grow. Both broadcast to
            `shape` and are rounded to float32. Values that are NaN or at least 2**24 in size count as 0.
        """
        self._sums[...] = _core.pan_add(self._sums, np.stack([self._motion("x", x), self._motion("y", y)]))

    def _motion(self, name: str, value: npt.ArrayLike) -> npt.NDArray[np.float32]:
        motion = arguments.reals(name, value)
        try:
            with np.errstate(over="ignore"):
                return np.broadcast_to(motion.astype(np.float32), self.shape)
        except ValueError:
            raise ValueError(f"{name} must broadcast to {self.shape}, the pan's shape, not {motion.shape}") from None

    @property
    def x(self) -> _Whole:
        """The sum of all x, rounded to the nearest integer (halves upwards), modulo 2**32: an int, or int32 of `shape`."""
        return _whole(self._sums[0].view(np.int64) >> 32, np.int32, self.shape)

    @property
    def y(self) -> _Whole:
        """The same for y."""
        return _whole(self._sums[1].view(np.int64) >> 32, np.int32, self.shape)

    def __repr__(self) -> str:
        return f"Pan(x={self.x!r}, y={self.y!r})"


def _frame(function: Any, frame: npt.ArrayLike, most: npt.ArrayLike) -> _Whole:
    frames = arguments.integers("frame", frame, np.uint32, *arguments.UINT32)
    counts = arguments.integers("most", most, np.uint32, *arguments.UINT32)
    shape = arguments.together("frame and most", frames.shape, counts.shape)
    return _whole(function(frames, counts), np.uint32, shape)


def frame_index(frame: npt.ArrayLike, most: npt.ArrayLike) -> _Whole:
    """Return the index of the first sample of a film's frame.

    Parameters
    ----------
    frame : array_like of int
        The frame number, 0 to 2**32 - 1.
    most : array_like of int
        The largest number of samples that a pixel takes in any frame; 0 counts as 1. Pass the same one for all frames, and none
        larger than necessary, because frames gain from each other only where few indices are left out.

    Returns
    -------
    int or ndarray of uint32
        The frame number times the smallest power of two that is at least `most`, modulo 2**32. Pass `frame_stream` as the stream.

    Examples
    --------
    >>> frame_index(3, most=100), frame_stream(3, most=100)
    (384, 0)
    """
    return _frame(_core.frame_index, frame, most)


def frame_stream(frame: npt.ArrayLike, most: npt.ArrayLike) -> _Whole:
    """Return the stream of a film's frame: 0 until the indices are used up, then 1 and so on.

    With 1,024 samples, the stream changes every 4,194,304 frames. The arguments are those of `frame_index`, the result is an int or an
    array of uint32.
    """
    return _frame(_core.frame_stream, frame, most)
