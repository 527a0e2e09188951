# SPDX-License-Identifier: Apache-2.0
"""Random numbers for paths, requested by purpose: bn_path.h on arrays. Results are bit-identical to those in C."""

from __future__ import annotations

from typing import Any, Iterator, NoReturn, Optional

import numpy as np
import numpy.typing as npt

from . import _arguments as arguments
from . import _core
from ._sampler import Sampler

_MOST = (0, 2**28 - 1)  # the limit for rays and for each counter

_Floats = npt.NDArray[np.float32]
_Words = npt.NDArray[np.uint32]


def _kept(name: str, value: npt.ArrayLike, dtype: npt.DTypeLike, low: int, high: int) -> npt.NDArray[Any]:
    """A checked copy, which the caller cannot change."""
    return np.array(arguments.integers(name, value, dtype, low, high))


def _sequence(index: _Words, count: int, k: _Words) -> _Words:
    """The samples k of `count` that belong to sample `index` of a pixel."""
    at = index.astype(np.uint64) * np.uint64(count) + k
    if at.size and int(at.max()) > arguments.UINT32[1]:
        raise ValueError(f"index * count + k must be below 2**32, not {int(at.max())} with index {int(index.max())}")
    return np.asarray(at, np.uint32)


def _counter(k: int) -> int:
    return arguments.integer("k", k, *_MOST)


class _OnceOnly:
    """Base of stateful samplers, which must not be copied: a copy would repeat their numbers."""

    __slots__ = ()

    def __reduce_ex__(self, protocol: object) -> NoReturn:  # of copy, deepcopy and pickle
        name = type(self).__name__
        raise TypeError(f"a {name} cannot be copied or pickled, because the copy would repeat its numbers; pass it on")


class PathSampler:
    """Random numbers for one path (a sample of a pixel) or for an array of paths, requested by purpose.

    A path consists of rays: ray 0 leaves the camera; ray d leaves the d-th surface or other event. Each ray has four numbers (two for its
    direction, and two for the light sample at its end) and as many more as you like. No two decisions share a number, and paths
    that drew different numbers of samples at one ray are back in step at the next ray. ``bn_path.h`` describes the layout; results are
    bit-identical to those in C for every sampler type.

    ``x``, ``y``, ``index`` and ``stream`` are integers or integer arrays that broadcast against each other to ``shape``. Every draw makes
    one call to ``Sampler.sample`` for all paths and returns float32 in [0, 1). In the documented result shapes, ``...`` stands for
    ``shape``.

    Parameters
    ----------
    sampler : Sampler
        The sampler that supplies the numbers.
    x, y : array_like of int
        Pixel coordinates, -2**31 to 2**31 - 1.
    index : array_like of int
        Sample indices within these pixels, 0 to 2**32 - 1.
    stream : array_like of int, default 0
        Stream numbers, 0 to 2**32 - 1. Streams are independent: use them for light paths alongside camera paths. Frames share a stream
        and continue the index: see `frame_index`.

    Examples
    --------
    >>> y, x = np.mgrid[0:4, 0:6]
    >>> path = PathSampler(Sampler("blue", seed=1), x, y, index=0)
    >>> camera = path.ray(0)
    >>> camera.draw().shape, camera.next_2d().shape
    ((4, 6, 4), (4, 6, 2))
    """

    __slots__ = ("_domain", "_index", "_sampler", "_x", "_y", "shape")

    shape: tuple[int, ...]

    def __init__(
        self, sampler: Sampler, x: npt.ArrayLike, y: npt.ArrayLike, index: npt.ArrayLike, stream: npt.ArrayLike = 0
    ) -> None:
        if not isinstance(sampler, Sampler):
            raise TypeError(f"sampler must be a Sampler, not {arguments.said(sampler)}")
        streams = arguments.integers("stream", stream, np.uint32, *arguments.UINT32)
        self._set(
            sampler,
            _kept("x", x, np.int32, *arguments.INT32),
            _kept("y", y, np.int32, *arguments.INT32),
            _kept("index", index, np.uint32, *arguments.UINT32),
            np.asarray(_core.stream_domain(streams), np.uint32),
            "x, y, index and stream",
        )

    def _set(
        self, sampler: Sampler, x: npt.NDArray[Any], y: npt.NDArray[Any], index: _Words, domain: _Words, names: str
    ) -> None:
        self.shape = arguments.together(names, x.shape, y.shape, index.shape, domain.shape)
        self._sampler, self._x, self._y, self._index, self._domain = sampler, x, y, index, domain

    def _like(self, index: _Words, domain: _Words) -> PathSampler:
        path = PathSampler.__new__(PathSampler)
        path._set(self._sampler, self._x, self._y, index, domain, "the ray and k")
        return path

    def ray(self, number: npt.ArrayLike) -> RaySampler:
        """Return a ray of the path.

        Parameters
        ----------
        number : array_like of int
            From 0 to 2**28 - 1: ray 0 leaves the camera; ray d leaves the d-th surface or other event. For paths at different rays, pass
            an array, which broadcasts with `shape`.

        Returns
        -------
        RaySampler
            A second `RaySampler` for the same ray returns the same numbers.
        """
        return RaySampler(self, number)

    def first_light(self, count: int = 1, k: npt.ArrayLike = 0) -> _Floats:
        """Draw the light sample at the end of ray 0. Shape ``(..., 2)``.

        Call this if a lens uses that ray's second pair, or if you take multiple light samples.

        Parameters
        ----------
        count : int, default 1
            Number of light samples. It must be the same for all samples of a pixel, and index * count must be below 2**32.
        k : array_like of int, default 0
            Index of the light sample, 0 to ``count - 1``. Broadcasts with `shape`.
        """
        count = arguments.integer("count", count, 1, arguments.UINT32[1])
        points = arguments.integers("k", k, np.uint32, 0, count - 1)
        arguments.together("the path and k", self.shape, points.shape)
        return self._draw(_core.path_camera_domain(self._domain), _sequence(self._index, count, points), pair=0)

    def time_wavelength(self) -> _Floats:
        """Draw the time, as a fraction of the shutter interval, and the position in the spectrum. Shape ``(..., 2)``."""
        return self._draw(_core.path_camera_domain(self._domain), self._index, pair=1)

    def _draw(self, domain: _Words, index: _Words, pair: Any = None) -> _Floats:
        return self._sampler.sample(self._x, self._y, index, domain, pair=pair)

    def __repr__(self) -> str:
        return f"PathSampler({self._sampler!r}, shape={self.shape})"


class RaySampler(_OnceOnly):
    """One ray of a path, made by ``PathSampler.ray``. It counts the numbers drawn, so make one per ray and pass it around. It cannot be
    copied or pickled. Draws are float32 in [0, 1); in their shapes, ``...`` stands for ``shape``."""

    __slots__ = ("_1d", "_2d", "_4d", "_domain", "_kept", "_loops", "_path", "_splits", "shape")

    shape: tuple[int, ...]

    def __init__(self, path: PathSampler, number: npt.ArrayLike) -> None:
        numbers = arguments.integers("number", number, np.uint32, *_MOST)
        self.shape = arguments.together("the path and number", path.shape, numbers.shape)
        self._start(path, _core.path_ray_domain(path._domain, numbers))

    def _start(self, path: PathSampler, domain: _Words) -> None:
        self._path, self._domain = path, domain
        self._1d = self._2d = self._4d = self._splits = self._loops = 0
        self._kept = np.empty(0, np.float32)

    def draw(self) -> _Floats:
        """Draw the ray's direction (the first two numbers) and the light sample at its end (the other two). Shape ``(..., 4)``.

        Every call returns the same numbers.
        """
        return self._draw(self._domain)

    def draw_direction(self) -> _Floats:
        """Draw only the first pair of `draw`. Shape ``(..., 2)``."""
        return self._draw(self._domain, 0)

    def draw_end_light(self) -> _Floats:
        """Draw only the second pair of `draw`. Shape ``(..., 2)``."""
        return self._draw(self._domain, 1)

    def draw_1d(self, k: int) -> _Floats:
        """Draw single number `k` of the ray. Shape ``(...)``.

        Returns the result of call ``k + 1`` of `next_1d`. `draw_2d`, `draw_4d`, `draw_split` and `draw_loop` work the same way.

        Parameters
        ----------
        k : int
            From 0 to 2**28 - 1.
        """
        return self._singles(_counter(k))[..., k & 1]

    def draw_2d(self, k: int) -> _Floats:
        """Draw pair `k` of the ray. Shape ``(..., 2)``."""
        return self._draw(_core.ray_2d_domain(self._domain, _counter(k)), k & 1)

    def draw_4d(self, k: int) -> _Floats:
        """Draw the ray's `k`-th group of four numbers. Shape ``(..., 4)``."""
        return self._draw(_core.ray_4d_domain(self._domain, _counter(k)))

    def draw_split(self, k: int, count: int) -> Split:
        """Return split `k`, into `count` branches."""
        count = arguments.integer("count", count, *arguments.UINT32)
        return Split(self, self._split_domain(_counter(k)), max(count, 1), count)

    def draw_loop(self, k: int) -> LoopSampler:
        """Return the sampler of loop `k`."""
        return LoopSampler(self, np.asarray(_core.ray_loop_domain(self._domain, _counter(k)), np.uint32))

    def next_1d(self) -> _Floats:
        """Draw the next single number. Shape ``(...)``.

        Every four consecutive numbers are stratified together. They are drawn in pairs, so every second call is free.
        """
        k = self._1d
        if k & 1 == 0:
            self._kept = self._singles(k)
        self._1d += 1  # after the draw, so an interrupted draw can be repeated
        return self._kept[..., k & 1]

    def next_2d(self) -> _Floats:
        """Draw the next pair. Shape ``(..., 2)``.

        Two consecutive pairs are stratified together.
        """
        pair = self.draw_2d(self._2d)
        self._2d += 1
        return pair

    def next_4d(self) -> _Floats:
        """Draw four numbers. Shape ``(..., 4)``.

        Use them for two 2-D decisions whose contributions multiply in the integrand, or for a choice (the third number) followed by a
        pair (the first two).
        """
        four = self.draw_4d(self._4d)
        self._4d += 1
        return four

    def next_split(self, count: int) -> Split:
        """Split the path into `count` branches, each of which is a path.

        Parameters
        ----------
        count : int
            Number of branches, 0 (which means 1) to 2**32 - 1. It must be the same for all samples of a pixel; if it varies, use
            `next_split_from`.
        """
        split = self.draw_split(self._splits, count)
        self._splits += 1
        return split

    def next_split_from(self, first: npt.ArrayLike) -> Split:
        """Split the path into any number of branches.

        Parameters
        ----------
        first : array_like of int
            The number of branches the pixel's earlier samples took here; 0 for its first sample. Broadcasts with `shape`.
        """
        taken = _kept("first", first, np.uint32, *arguments.UINT32)
        arguments.together("the ray and first", self.shape, taken.shape)
        split = Split(self, self._split_domain(self._splits), 0, None, taken)
        self._splits += 1
        return split

    def next_loop(self) -> LoopSampler:
        """Return a sampler for a loop of unknown length, such as delta tracking."""
        loop = self.draw_loop(self._loops)
        self._loops += 1
        return loop

    def child(self, key: npt.ArrayLike) -> RaySampler:
        """Return a sub-sampler of the ray, selected by a key such as a primitive's index.

        Parameters
        ----------
        key : array_like of int
            From 0 to 2**32 - 1. Broadcasts with `shape`.

        Returns
        -------
        RaySampler
            Draw from it as you would from a ray. Its numbers do not depend on earlier draws: a second child with the same key
            returns the same numbers.
        """
        keys = arguments.integers("key", key, np.uint32, *arguments.UINT32)
        part = RaySampler.__new__(RaySampler)
        part.shape = arguments.together("the ray and key", self.shape, keys.shape)
        part._start(self._path, _core.ray_child_domain(self._domain, keys))
        return part

    def _singles(self, k: int) -> _Floats:
        """The pair that holds number k."""
        return self._draw(_core.ray_1d_domain(self._domain, k), (k & 3) >> 1)

    def _split_domain(self, k: int) -> _Words:
        return np.asarray(_core.ray_split_domain(self._domain, k), np.uint32)

    def _draw(self, domain: _Words, pair: Any = None) -> _Floats:
        return self._path._draw(domain, self._path._index, pair)

    def __repr__(self) -> str:
        return f"RaySampler({self._path!r}, shape={self.shape})"


class Split:
    """A path that continues in multiple branches. ``split[k]`` is branch k. If the split comes from ``RaySampler.next_split``,
    ``len(split)`` is the number of branches, and iterating over the split yields all of them. If the split comes from
    ``RaySampler.next_split_from``, both operations raise ``TypeError``."""

    __slots__ = ("_count", "_domain", "_index", "_length", "_path", "_shape")

    def __init__(
        self, ray: RaySampler, domain: _Words, count: int, length: Optional[int], first: Optional[_Words] = None
    ) -> None:
        self._count, self._length = count, length
        self._path, self._domain, self._shape = ray._path, domain, ray.shape
        self._index = ray._path._index if first is None else first

    def __len__(self) -> int:
        if self._length is None:
            raise TypeError("a split from next_split_from has no length")
        return self._length

    def __getitem__(self, k: npt.ArrayLike) -> PathSampler:
        """Return branch `k`, a path whose rays start at 0.

        A path may use fewer branches than the split's count, or more (k = count, count + 1, ...).

        Parameters
        ----------
        k : array_like of int
            From 0 to 2**32 - 1. Broadcasts with the ray's shape. To get all branches along a new first axis, use
            ``split[np.arange(count)[:, None, None]]``.
        """
        branches = arguments.integers("k", k, np.uint32, *arguments.UINT32)
        arguments.together("the ray and k", self._shape, branches.shape)
        domain = np.asarray(_core.branch_domain(self._domain, self._count, branches), np.uint32)
        if self._count > 0:
            branches = branches % np.uint32(self._count)
        return self._path._like(_sequence(self._index, max(self._count, 1), branches), domain)

    def __iter__(self) -> Iterator[PathSampler]:
        return (self[k] for k in range(len(self)))

    def __repr__(self) -> str:
        return f"Split({self._path!r}{'' if self._length is None else f', count={self._length}'})"


class LoopSampler(_OnceOnly):
    """Numbers for a loop of unknown length, made by ``RaySampler.next_loop``. The first four are stratified; the rest come from a
    counter-based generator. A ``LoopSampler`` cannot be copied or pickled. Draws are float32 in [0, 1); ``...`` stands for the ray's
    shape."""

    __slots__ = ("_domain", "_drawn", "_four", "_path")

    def __init__(self, ray: RaySampler, domain: _Words) -> None:
        self._path, self._domain = ray._path, domain
        self._four = ray._draw(domain)
        self._drawn = 0

    def next_1d(self) -> _Floats:
        """Draw the next number for all paths. Shape ``(...)``."""
        k, path = self._drawn, self._path
        self._drawn += 1
        if k < 4:
            return self._four[..., k]
        first, second = map(int, path._sampler.seed_words())
        return np.asarray(_core.loop_float(first, second, path._x, path._y, path._index, self._domain, k), np.float32)

    def __repr__(self) -> str:
        return f"LoopSampler(shape={self._four.shape[:-1]}, drawn={self._drawn})"
