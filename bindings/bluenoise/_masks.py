# SPDX-License-Identifier: Apache-2.0
"""Mask generation, and conversion of ranks to values."""

from __future__ import annotations

import functools
import math
import sys
from typing import Any, Optional, Sequence, Union

import numpy as np
import numpy.typing as npt

from . import _arguments as arguments
from . import _core
from ._arguments import MaskMethod, NeuralProvider, Progress, Ranks, Seed, Shape
from ._neural import NeuralGenerator, PathLike, builtin_generator

_FAR_SIGMA = 1.5
_BUILTIN_SIZES = (16, 32, 64, 128, 256)
_WHITE_BLOCK = 2**20
# Bytes per texel and channel that a method needs at least, measured.
_MEMORY = {"white": 24}
_LEAST_MEMORY = 12
# Method "auto": the most texels for void-and-cluster, and the sweeps of annealing where nothing else will do.
_AUTO_LARGE, _AUTO_SWEEPS = 512 * 512, 100


# The options of the library's methods and how they are checked; a name stands for the value of that option.
_LIBRARY: dict[str, dict[str, Sequence[Any]]] = {
    "void-and-cluster": {
        "sigma": (arguments.real, 0.25, 16),
        "initial_fraction": (arguments.real, 0, 0.5, False),
    },
    "relax": {"threads": (arguments.integer, *arguments.UINT32)},
    "anneal": {
        "sigma": (arguments.real, 0.25, 4),
        "far_sigma": (arguments.real, "sigma", 4),
        "far_weight": (arguments.real, 0, sys.float_info.max),
        "value_sigma": (arguments.real, 0.01, 100),
        "start_temperature": (arguments.real, 0, 1, False),
        "end_temperature": (arguments.real, 0, "start_temperature", False),
        "sweeps": (arguments.integer, *arguments.UINT32),
        "order_ends": (lambda _, value: bool(value),),
    },
}
# Method -> the names of its options.
METHODS: dict[str, tuple[str, ...]] = {
    "auto": ("channels", "progress"),
    **{method: (*options, "progress") for method, options in _LIBRARY.items()},
    "neural": ("model", "runtime", "threads", "provider", "channels", "progress"),
    "white": ("progress",),
    "builtin": ("progress",),
}
METHODS["anneal"] += ("channels", "start_from_ranks")


def mask(
    shape: Shape,
    *,
    method: MaskMethod = "void-and-cluster",
    seed: Seed = 0,
    out: Optional[Ranks] = None,
    progress: Optional[Progress] = None,
    channels: Optional[int] = None,
    sigma: Optional[float] = None,
    initial_fraction: Optional[float] = None,
    sweeps: Optional[int] = None,
    far_sigma: Optional[float] = None,
    far_weight: Optional[float] = None,
    value_sigma: Optional[float] = None,
    start_temperature: Optional[float] = None,
    end_temperature: Optional[float] = None,
    order_ends: Optional[bool] = None,
    start_from_ranks: Optional[npt.ArrayLike] = None,
    model: Union[None, PathLike, bytes] = None,
    runtime: Optional[PathLike] = None,
    threads: Optional[int] = None,
    provider: Optional[NeuralProvider] = None,
) -> Ranks:
    """Makes a mask: uint32 ranks of shape (n,), (h, w) or (d, h, w), in which each of 0 .. n - 1 occurs exactly once.

    Masks are toroidal: they tile without seams. Equal arguments give equal bits on every machine, except for ``"neural"`` and
    for ``"auto"`` with two channels, which uses it.

    Parameters
    ----------
    shape
        One to three extents of at least 1, at most 2**31 - 1 texels in total: ``(64, 64)`` is a square, ``(64,)`` a row.
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
        An integer from 0 to 2**64 - 1, a ``numpy.random.Generator``, from which one integer is drawn, a
        ``numpy.random.SeedSequence``, or None for fresh entropy. Must be 0 for ``"builtin"``.
    out
        An array for the result, which is returned: uint32, in C order, of the result's shape. Without it, a new one. After an
        exception its contents are undefined.
    progress
        A function that is called with the fraction done, at last with 1. If it returns a true value, the work stops with
        ``CancelledError``; exceptions propagate.
    channels, sigma, ...
        Options of single methods. None stands for the default, in brackets here; for other methods they are errors.

        ``"void-and-cluster"``: ``sigma`` (1.5), the standard deviation of the Gaussian in texels, 0.25 to 16;
        ``initial_fraction`` (0.1), the share of texels in the initial pattern, above 0 and up to 0.5.

        ``"relax"``: ``threads`` (0: one per processor), which does not affect the result.

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
        There is not enough memory, or there are too many texels. Masks for which the machine has too little memory are
        refused at once.
    KeyboardInterrupt
        Ctrl-C was pressed.

    Examples
    --------
    >>> int(mask((64, 64), seed=1).max())
    4095
    """
    given = {name: value for name, value in locals().items() if value is not None}
    extents = arguments.shape(shape, 3)
    arguments.one_of("method", method, METHODS)
    options = {name: value for name, value in given.items() if name not in ("shape", "method", "seed", "out")}
    for name, value in options.items():
        if name not in METHODS[method]:
            having = ", ".join(repr(each) for each in METHODS if name in METHODS[each])
            raise TypeError(f"method {method!r} has no option {name} (given as {value!r}); {having} have it")
    makers = {"auto": _auto, "anneal": _anneal, "neural": _neural, "white": _white, "builtin": _builtin}
    make: Any = makers[method] if method in makers else functools.partial(_by_library, method)
    return make(extents, seed, out, **options)  # type: ignore[no-any-return]


def _result(shape: tuple[int, ...], out: Optional[Ranks], method: str) -> Ranks:
    size = math.prod(shape) * _MEMORY.get(method, _LEAST_MEMORY)
    arguments.enough_memory(f"a mask of shape {shape} by method {method!r}", size)
    return arguments.output(out, shape, np.uint32)


def _check_flat(shape: tuple[int, ...], method: str) -> None:
    if len(shape) > 2:
        raise ValueError(f"shape for method {method!r} must be (n,) or (h, w), not {shape}")


def _by_library(
    method: str, shape: tuple[int, ...], seed: Seed, out: Optional[Ranks], *, progress: Optional[Progress] = None, channels: int = 1,
    start_from_ranks: Optional[npt.ArrayLike] = None, **given: Any
) -> Ranks:
    if method == "relax":
        _check_flat(shape, method)
    ranks = _result(shape if channels == 1 else (channels, *shape), out, method)
    library: dict[str, tuple[Any, Any]] = {
        "void-and-cluster": (_core.void_and_cluster, _core.VoidAndClusterOptions()),
        "relax": (_core.relax, _core.RelaxOptions()),
        "anneal": (_core.anneal, _core.AnnealOptions()),
    }
    make, options = library[method]
    for name, (check, *limits) in _LIBRARY[method].items():
        if name in given:
            bounds = (getattr(options, limit) if isinstance(limit, str) else limit for limit in limits)
            setattr(options, name, check(name, given[name], *bounds))
    if start_from_ranks is not None:
        _start_from(ranks, start_from_ranks, channels)
        options.start_from_ranks = 1
    options.seed = arguments.seed(seed)
    extents = shape if len(shape) == 3 else (channels, *(1,) * (2 - len(shape)), *shape)
    make(ranks.reshape(extents), options, arguments.callback("progress", progress))
    return ranks


def _anneal(
    shape: tuple[int, ...], seed: Seed, out: Optional[Ranks], *, channels: int = 1, **given: Any
) -> Ranks:
    _check_flat(shape, "anneal")
    far_sigma = max(_FAR_SIGMA, arguments.real("sigma", given.get("sigma", 1), *_LIBRARY["anneal"]["sigma"][1:]))
    channels = arguments.integer("channels", channels, 1, 4)
    return _by_library("anneal", shape, seed, out, channels=channels, **{"far_sigma": far_sigma, **given})


def _start_from(ranks: Ranks, given: npt.ArrayLike, channels: int) -> None:
    """Copies the ranks to start from into the array for the result, and checks the copy."""
    start = arguments.array("start_from_ranks", given)
    if start.shape != ranks.shape:
        raise ValueError(f"start_from_ranks must have shape {ranks.shape}, not {start.shape}")
    np.copyto(ranks, arguments.integers("start_from_ranks", start, np.uint32, *arguments.UINT32))
    for channel in ranks.reshape(channels, -1):
        arguments.permutation("start_from_ranks", channel)


def _neural(
    shape: tuple[int, ...],
    seed: Seed,
    out: Optional[Ranks],
    *,
    progress: Optional[Progress] = None,
    **options: Any,
) -> Ranks:
    if len(shape) != 2:
        raise ValueError(f"shape for method 'neural' must be (h, w), not {shape}")
    channels, threads = options.get("channels", 0), options.get("threads", 0)
    shared = type(channels) is type(threads) is int and threads == 0 and not options.keys() - {"channels", "threads"}
    generator = builtin_generator(channels or 1) if shared else NeuralGenerator(**options)
    return generator.mask(shape, seed, out=out, progress=progress)


def _auto(
    shape: tuple[int, ...],
    seed: Seed,
    out: Optional[Ranks],
    *,
    channels: int = 1,
    progress: Optional[Progress] = None,
) -> Ranks:
    count = arguments.integer("channels", channels, 1, 4)
    method, options = auto_method(shape, count)
    return mask(shape, method=method, seed=seed, out=out, progress=progress, **options)


def auto_method(shape: tuple[int, ...], channels: int) -> tuple[MaskMethod, dict[str, Any]]:
    """The method that "auto" takes, and its options, as docs/report/masks.md recommends. The choice depends on shape and
    channels alone. The bits do not depend on the machine either, except with two channels, which the network makes."""
    if channels == 1:
        large = len(shape) == 2 and math.prod(shape) > _AUTO_LARGE
        return ("relax" if large else "void-and-cluster"), {}
    if channels == 2 and len(shape) == 2:
        return "neural", {"channels": 2}
    return "anneal", {"channels": channels, "sweeps": _AUTO_SWEEPS}


def _white(
    shape: tuple[int, ...], seed: Seed, out: Optional[Ranks], *, progress: Optional[Progress] = None
) -> Ranks:
    """Sorts 48 random bits per texel from the library's white sampler, so the result does not depend on NumPy. Draws and
    sorts in blocks, between which Ctrl-C is noticed."""
    arguments.callback("progress", progress)
    ranks = _result(shape, out, "white")
    count = ranks.size
    sampler = _core.Sampler(_core.sampler_types["white"], arguments.seed(seed), 0, None)
    keys = np.empty(count, np.uint64)
    for first in range(0, count, _WHITE_BLOCK):
        samples = np.empty((1, 1, min(_WHITE_BLOCK, count - first), 4), np.float32)
        sampler.block(0, 0, first, 0, samples)
        bits = (samples[0, 0, :, :2] * 2**24).astype(np.uint64)
        keys[first : first + len(bits)] = (bits[:, 0] << np.uint64(24)) | bits[:, 1]
        arguments.report(progress, 0.5 * first / count)
    blocks = -(-count // _WHITE_BLOCK)
    block = (keys * np.uint64(blocks) >> np.uint64(48)).astype(np.uint16)
    flat, first = ranks.reshape(-1), 0
    for number in range(blocks):
        texels = np.flatnonzero(block == number)
        texels = texels[np.argsort(keys[texels], kind="stable")]
        flat[texels] = np.arange(first, first + texels.size, dtype=np.uint32)
        first += texels.size
        arguments.report(progress, 0.5 + 0.5 * first / count)
    return ranks


def _builtin(
    shape: tuple[int, ...], seed: Seed, out: Optional[Ranks], *, progress: Optional[Progress] = None
) -> Ranks:
    arguments.callback("progress", progress)
    sizes = [size for size in _BUILTIN_SIZES if _core.builtin_mask_exists(size)]
    if len(shape) != 2 or shape[0] != shape[1] or shape[0] not in sizes:
        known = ", ".join(f"({size}, {size})" for size in sizes)
        raise ValueError(f"shape of a built-in mask must be one of {known}, not {shape}")
    if not hasattr(seed, "__index__") or arguments.seed(seed) != 0:
        raise ValueError(f"seed must be 0 for method 'builtin', not {seed!r}")
    ranks = _result(shape, out, "builtin")
    builtin = _core.builtin_mask(shape[0])
    assert builtin is not None
    np.copyto(ranks, builtin)
    arguments.report(progress, 1.0)
    return ranks


def to_float(ranks: npt.ArrayLike, count: Optional[int] = None) -> npt.NDArray[np.float32]:
    """Converts ranks to values, float32 in [0, 1): (rank + 0.5) / count in double precision, rounded down.

    ``ranks`` is an array of any shape with integers from 0 to count - 1. ``count`` defaults to the number of texels: that of
    elements, or of elements per channel if the array consists of channels as from ``mask(..., channels=2)``, each with every
    rank once. Give it for a part of a mask. Values are at most 1 - 2**-24. Raises ``ValueError`` for ranks out of range and
    ``TypeError`` for other types.
    """
    array = arguments.array("ranks", ranks)
    if count is None:
        count = array[0].size if arguments.has_channels(array) else array.size
    count = arguments.integer("count", count, 0, 2**32)
    if array.size == 0:
        return np.zeros(array.shape, np.float32)
    texels = arguments.integers("ranks", array, np.uint32, 0, count - 1)
    return _core.ranks_to_float(np.ascontiguousarray(texels).reshape(-1), count).reshape(array.shape)
