# SPDX-License-Identifier: Apache-2.0
"""Mask generation, and conversion of ranks to values."""

from __future__ import annotations

import inspect
import math
import sys
from typing import Any, Callable, Literal, Optional, Union, overload

import numpy as np
import numpy.typing as npt

from . import _arguments as arguments
from . import _core
from ._arguments import MaskMethod, NeuralProvider, Progress, Ranks, Seed, Shape
from ._interrupt import interruptible
from ._neural import NeuralGenerator, PathLike, builtin_generator

_FAR_SIGMA = 1.5
_BUILTIN_SIZES = (16, 32, 64, 128, 256)
_MAX_TEXELS = 2**31 - 1
_WHITE_BLOCK = 2**20
# Method "auto": the most texels for void-and-cluster, and the sweeps of annealing where nothing else will do.
_AUTO_LARGE, _AUTO_SWEEPS = 512 * 512, 100


# One overload for each method, so that editors complete its options and type checkers check them. A test compares them
# with the functions below.
@overload
def mask(
    shape: Shape,
    *,
    method: Literal["void-and-cluster"] = "void-and-cluster",
    seed: Seed = 0,
    sigma: float = 1.5,
    initial_fraction: float = 0.1,
    progress: Optional[Progress] = None,
) -> Ranks: ...
@overload
def mask(
    shape: Shape,
    *,
    method: Literal["relax"],
    seed: Seed = 0,
    sigma: Optional[float] = None,
    start_step: Optional[float] = None,
    end_step: Optional[float] = None,
    start_softness: Optional[float] = None,
    end_softness: Optional[float] = None,
    steps: Optional[int] = None,
    threads: int = 0,
    start_from_ranks: Optional[npt.ArrayLike] = None,
    progress: Optional[Progress] = None,
) -> Ranks: ...
@overload
def mask(
    shape: Shape,
    *,
    method: Literal["anneal"],
    seed: Seed = 0,
    sigma: float = 1.0,
    far_sigma: Optional[float] = None,
    far_weight: float = 1.0,
    value_sigma: float = 1.0,
    start_temperature: float = 4e-4,
    end_temperature: float = 2e-6,
    sweeps: int = 1000,
    order_ends: bool = True,
    channels: int = 1,
    start_from_ranks: Optional[npt.ArrayLike] = None,
    progress: Optional[Progress] = None,
) -> Ranks: ...
@overload
def mask(
    shape: Shape,
    *,
    method: Literal["neural"],
    seed: Seed = 0,
    model: Union[None, PathLike, bytes] = None,
    runtime: Optional[PathLike] = None,
    threads: int = 0,
    provider: Optional[NeuralProvider] = None,
    channels: int = 0,
    progress: Optional[Progress] = None,
) -> Ranks: ...
@overload
def mask(
    shape: Shape,
    *,
    method: Literal["auto"],
    seed: Seed = 0,
    channels: int = 1,
    progress: Optional[Progress] = None,
) -> Ranks: ...
@overload
def mask(shape: Shape, *, method: MaskMethod, seed: Seed = 0) -> Ranks: ...


def mask(
    shape: Any, *, method: str = "void-and-cluster", seed: Any = 0, **options: Any
) -> Ranks:
    """Makes a mask: uint32 ranks of shape (n,), (h, w) or (d, h, w), in which each of 0 .. n - 1 occurs exactly once.

    Masks are toroidal: they tile without seams. Equal arguments give equal bits on every machine, except for ``"neural"`` and
    for ``"auto"`` with two channels, which uses it.

    Parameters
    ----------
    shape
        One to three extents of at least 1, at most 2**31 - 1 texels in total; or a single integer.
    method
        ``"auto"``: chooses by shape and channels. One channel: relaxation for two-dimensional masks of more than 512 x 512
        texels in all, otherwise void-and-cluster. Two channels in two dimensions: the network, which needs ONNX Runtime.
        Other vectors: annealing with 100 sweeps. ``"void-and-cluster"``: Ulichney, "The void-and-cluster method for
        dither array generation", 1993; takes milliseconds. ``"relax"``: parallel relaxation in one or two dimensions; the
        fastest, above all for large masks on several cores, with slightly lower quality. ``"anneal"``: Georgiev and
        Fajardo, "Blue-noise dithered sampling", 2016, in one or two dimensions; slow, but with thousands of sweeps it has
        the best quality.
        ``"builtin"``: a built-in square mask, the result of a long optimisation. ``"neural"``: the built-in network, in
        two dimensions; needs ONNX Runtime (see ``NeuralGenerator``). ``"white"``: a random permutation.
    seed
        An integer from 0 to 2**64 - 1, a ``numpy.random.Generator``, from which one integer is drawn, or None for fresh
        entropy. Must be 0 for ``"builtin"``.
    options
        All methods except ``"white"`` and ``"builtin"`` accept ``progress``, a function that is called with the fraction
        done. If it returns a true value, the work stops with ``CancelledError``; exceptions propagate.

        ``"void-and-cluster"``: ``sigma`` (1.5), the standard deviation of the Gaussian in texels, 0.25 to 16;
        ``initial_fraction`` (0.1), the share of texels in the initial pattern, above 0 and up to 0.5.

        ``"relax"``: ``threads`` (0: one per processor), which does not affect the result. A learned schedule of a few
        steps is used unless one of the following options is given: ``steps`` (64); ``sigma`` (0.92), the viewing blur in
        texels whose error is minimised, 0.25 to 2.5; ``start_step`` (4, at most 8) and ``end_step`` (0.05), how far
        values move, in value ranges; ``start_softness`` (0.45, at most 0.49) and ``end_softness`` (0.008), the difference
        of values at which a pair reaches full force; ``start_from_ranks``, a mask to start from instead of noise, for
        which a start_step of 0.1 and a start_softness of 0.02 work well.

        ``"anneal"``: ``sigma`` (1) and ``far_sigma`` (1.5 or sigma), the blurs in texels whose dithering errors are
        minimised, 0.25 <= sigma <= far_sigma <= 4; ``far_weight`` (1), the weight of the second squared error; ``sweeps``
        (1000), trial swaps per texel, about 50 ns each; ``start_temperature`` (4e-4) and ``end_temperature`` (2e-6), as
        shares of the largest possible gain of one texel; ``start_from_ranks``, a mask to start from instead of
        void-and-cluster; ``order_ends`` (True), whether to order the first and last ranks, which are too far apart for
        the blurs, by their distances. With ``channels`` of 2 to 4 the result has shape (channels, h, w): each channel is
        a permutation, and the vectors of values are blue jointly (about 1 us per trial); ``value_sigma`` (1, 0.01 to
        100) is then the distance of values within which vectors repel each other, and the far blur is not used.

        ``"auto"``: ``channels`` (1), up to 4.

        ``"neural"``: ``model``, ``runtime``, ``threads``, ``provider`` and ``channels``, as for ``NeuralGenerator``: two
        channels are blue each and together, nearly as those of ``"anneal"``, in far less time. To make several masks
        with these options, use a ``NeuralGenerator``, which opens the network only once.

    Raises
    ------
    ValueError
        The method is unknown, or a number is out of range.
    TypeError
        An argument has a wrong type, or the method has no such option.
    MemoryError
        There is not enough memory, or there are too many texels.
    KeyboardInterrupt
        Ctrl-C was pressed.

    Examples
    --------
    >>> int(mask((64, 64), seed=1).max())
    4095
    """
    extents = arguments.shape(shape, 3)
    if not isinstance(method, str):
        raise TypeError(f"method must be a string, not {method!r}")
    if method not in METHODS:
        raise ValueError(f"method must be one of {', '.join(METHODS)}, not {method!r}")
    if math.prod(extents) > _MAX_TEXELS:
        raise MemoryError(f"shape {extents} has more than 2**31 - 1 texels")
    for name, value in options.items():
        if name not in METHODS[method]:
            raise TypeError(f"method {method!r} has no option {name} (given as {value!r})")
    return _MAKERS[method](extents, seed, **options)


def _void_and_cluster(
    shape: tuple[int, ...],
    seed: Seed,
    *,
    sigma: float = 1.5,
    initial_fraction: float = 0.1,
    progress: Optional[Progress] = None,
) -> Ranks:
    depth, height, width = (1,) * (3 - len(shape)) + shape
    ranks = _core.void_and_cluster(
        depth,
        height,
        width,
        arguments.real("sigma", sigma, 0.25, 16),
        arguments.real("initial_fraction", initial_fraction, 0, 0.5, low_included=False),
        arguments.seed(seed),
        arguments.callback("progress", progress),
    )
    return ranks.reshape(shape)


def _check_flat(shape: tuple[int, ...], method: str) -> None:
    if len(shape) > 2:
        raise ValueError(f"shape for method {method!r} must be (n,) or (h, w), not {shape}")


def _working_ranks(
    shape: tuple[int, ...], start_from_ranks: Optional[npt.ArrayLike], channels: int = 1
) -> Ranks:
    """An array for the result: a copy of the ranks to start from, or uninitialised."""
    if start_from_ranks is None:
        return np.empty(shape, np.uint32)
    ranks = arguments.integers("start_from_ranks", start_from_ranks, np.uint32, *arguments.UINT32)
    if ranks.shape != shape:
        raise ValueError(f"start_from_ranks must have shape {shape}, not {ranks.shape}")
    for channel in ranks.reshape(channels, -1):
        arguments.permutation("start_from_ranks", channel)
    return np.array(ranks, order="C")


def _or(value: Any, default: Any) -> Any:
    return default if value is None else value


def _relax(
    shape: tuple[int, ...],
    seed: Seed,
    *,
    sigma: Optional[float] = None,
    start_step: Optional[float] = None,
    end_step: Optional[float] = None,
    start_softness: Optional[float] = None,
    end_softness: Optional[float] = None,
    steps: Optional[int] = None,
    threads: int = 0,
    start_from_ranks: Optional[npt.ArrayLike] = None,
    progress: Optional[Progress] = None,
) -> Ranks:
    _check_flat(shape, "relax")
    ranks = _working_ranks(shape, start_from_ranks)
    described = (steps, sigma, start_step, end_step, start_softness, end_softness, start_from_ranks)
    learned = all(option is None for option in described)
    step = arguments.real("start_step", _or(start_step, 4.0), 0, 8, low_included=False)
    softness = arguments.real("start_softness", _or(start_softness, 0.45), 0, 0.49, low_included=False)
    _core.relax(
        ranks.reshape((1,) * (2 - len(shape)) + shape),
        arguments.real("sigma", _or(sigma, 0.92), 0.25, 2.5),
        step,
        arguments.real("end_step", _or(end_step, 0.05), 0, step, low_included=False),
        softness,
        arguments.real("end_softness", _or(end_softness, 0.008), 0, softness, low_included=False),
        0 if learned else arguments.integer("steps", _or(steps, 64), 1, arguments.UINT32[1]),
        arguments.integer("threads", threads, 0, arguments.UINT32[1]),
        start_from_ranks is not None,
        arguments.seed(seed),
        arguments.callback("progress", progress),
    )
    return ranks


def _anneal(
    shape: tuple[int, ...],
    seed: Seed,
    *,
    sigma: float = 1.0,
    far_sigma: Optional[float] = None,
    far_weight: float = 1.0,
    value_sigma: float = 1.0,
    start_temperature: float = 4e-4,
    end_temperature: float = 2e-6,
    sweeps: int = 1000,
    order_ends: bool = True,
    channels: int = 1,
    start_from_ranks: Optional[npt.ArrayLike] = None,
    progress: Optional[Progress] = None,
) -> Ranks:
    _check_flat(shape, "anneal")
    channels = arguments.integer("channels", channels, 1, 4)
    result = shape if channels == 1 else (channels, *shape)
    sigma = arguments.real("sigma", sigma, 0.25, 4)
    if far_sigma is None:
        far_sigma = max(sigma, _FAR_SIGMA)
    start = arguments.real("start_temperature", start_temperature, 0, 1, low_included=False)
    ranks = _working_ranks(result, start_from_ranks, channels)
    _core.anneal(
        ranks.reshape((channels,) + (1,) * (2 - len(shape)) + shape),
        sigma,
        arguments.real("far_sigma", far_sigma, sigma, 4),
        arguments.real("far_weight", far_weight, 0, sys.float_info.max),
        arguments.real("value_sigma", value_sigma, 0.01, 100),
        start,
        arguments.real("end_temperature", end_temperature, 0, start, low_included=False),
        arguments.integer("sweeps", sweeps, 0, arguments.UINT32[1]),
        bool(order_ends),
        start_from_ranks is not None,
        arguments.seed(seed),
        arguments.callback("progress", progress),
    )
    return ranks


def _neural(
    shape: tuple[int, ...],
    seed: Seed,
    *,
    model: Union[None, PathLike, bytes] = None,
    runtime: Optional[PathLike] = None,
    threads: int = 0,
    provider: Optional[NeuralProvider] = None,
    channels: int = 0,
    progress: Optional[Progress] = None,
) -> Ranks:
    if len(shape) != 2:
        raise ValueError(f"shape for method 'neural' must be (h, w), not {shape}")
    default = model is runtime is provider is None and type(threads) is int and threads == 0
    if default and type(channels) is int:
        generator = builtin_generator(channels)
    else:
        generator = NeuralGenerator(model, runtime, threads, provider, channels)
    return generator.mask(shape, seed, progress=progress)


def _auto(
    shape: tuple[int, ...],
    seed: Seed,
    *,
    channels: int = 1,
    progress: Optional[Progress] = None,
) -> Ranks:
    """The method that docs/report/neural.md recommends. The choice depends on shape and channels alone. The bits do not
    depend on the machine either, except with two channels, which the network makes."""
    count = arguments.integer("channels", channels, 1, 4)
    if count == 1:
        large = len(shape) == 2 and math.prod(shape) > _AUTO_LARGE
        return (_relax if large else _void_and_cluster)(shape, seed, progress=progress)
    if count == 2 and len(shape) == 2:
        return _neural(shape, seed, channels=2, progress=progress)
    return _anneal(shape, seed, channels=count, sweeps=_AUTO_SWEEPS, progress=progress)


def _white(shape: tuple[int, ...], seed: Seed) -> Ranks:
    """Sorts 48 random bits per texel from the library's white sampler, so the result does not depend on NumPy."""
    count = math.prod(shape)
    sampler = _core.Sampler(_core.sampler_kinds["white"], arguments.seed(seed), 0, None)
    keys = np.empty(count, np.uint64)
    for first in range(0, count, _WHITE_BLOCK):  # in blocks, so that Ctrl-C is noticed between them
        samples = sampler.block(0, 0, 1, 1, first, min(_WHITE_BLOCK, count - first), 0)[0, 0, :, :2]
        bits = (samples * 2**24).astype(np.uint64)
        keys[first : first + len(bits)] = (bits[:, 0] << np.uint64(24)) | bits[:, 1]
    order = interruptible(lambda: np.argsort(keys, kind="stable"))
    ranks = np.empty(count, np.uint32)
    ranks[order] = np.arange(count, dtype=np.uint32)
    return ranks.reshape(shape)


def _builtin(shape: tuple[int, ...], seed: Seed) -> Ranks:
    sizes = [size for size in _BUILTIN_SIZES if _core.builtin_mask_exists(size)]
    if len(shape) != 2 or shape[0] != shape[1] or shape[0] not in sizes:
        known = ", ".join(f"({size}, {size})" for size in sizes)
        raise ValueError(f"shape of a built-in mask must be one of {known}, not {shape}")
    if isinstance(seed, np.random.Generator) or seed is None or arguments.seed(seed) != 0:
        raise ValueError(f"seed must be 0 for method 'builtin', not {seed!r}")
    ranks = _core.builtin_mask(shape[0])
    assert ranks is not None
    return ranks


_MAKERS: dict[str, Callable[..., Ranks]] = {
    "auto": _auto,
    "void-and-cluster": _void_and_cluster,
    "relax": _relax,
    "anneal": _anneal,
    "neural": _neural,
    "white": _white,
    "builtin": _builtin,
}

# Method -> the names of its options.
METHODS = {
    name: tuple(inspect.signature(maker).parameters)[2:] for name, maker in _MAKERS.items()
}


def to_float(ranks: npt.ArrayLike, count: Optional[int] = None) -> npt.NDArray[np.float32]:
    """Converts ranks to values, float32 in [0, 1): (rank + 0.5) / count in double precision, rounded down.

    ``ranks`` is an array of any shape with integers from 0 to count - 1. ``count`` defaults to the number of elements; give
    it for a part of a mask. Values are at most 1 - 2**-24. Raises ``ValueError`` for ranks out of range and ``TypeError``
    for other types.
    """
    array = np.asarray(ranks)
    if count is None:
        count = array.size
    count = arguments.integer("count", count, 0, 2**32)
    if array.size == 0:
        return np.zeros(array.shape, np.float32)
    texels = arguments.integers("ranks", ranks, np.uint32, 0, count - 1)
    return _core.ranks_to_float(np.ascontiguousarray(texels).reshape(-1), count).reshape(array.shape)
