# SPDX-License-Identifier: Apache-2.0
"""Mask generation, and conversion of ranks to values."""

from __future__ import annotations

import math
import sys
from typing import Any, Callable, Optional, Union

import numpy as np
import numpy.typing as npt

from . import _arguments as arguments
from . import _core
from ._arguments import NeuralProvider, Progress, Ranks, Seed, Shape
from ._neural import NeuralGenerator, PathLike, builtin_generator

_BUILTIN_SIZES = (16, 32, 64, 128, 256)
_MEMORY = 12  # bytes per texel and channel that even the leanest generator needs, measured
# For mask(): the largest number of texels for void-and-cluster, and the number of annealing sweeps if no other method applies.
_LARGE, _SWEEPS = 512 * 512, 100


def mask(
    shape: Shape, *, seed: Seed = 0, channels: int = 1, out: Optional[Ranks] = None, progress: Optional[Progress] = None
) -> Ranks:
    """Make a blue-noise mask with the best generator for its shape.

    Single-channel masks come from `void_and_cluster`, or from `relax` if they are two-dimensional and have more than 512 x 512
    texels. Two-dimensional masks with two channels come from the built-in network (`neural`), which needs ONNX Runtime. Other
    multi-channel masks come from `anneal` with 100 sweeps.

    Masks are toroidal, so they tile seamlessly. Results are bit-identical on every machine, except for two-channel masks in two
    dimensions.

    Parameters
    ----------
    shape : tuple of int
        One to three extents, each at least 1; the mask may have at most 2**31 - 1 texels. ``(64, 64)`` is a square; ``(64,)`` is a
        row.
    seed : int, numpy.random.Generator, numpy.random.SeedSequence or None, default 0
        An integer from 0 to 2**64 - 1, a NumPy generator or seed sequence, or None for fresh entropy.
    channels : int, default 1
        Number of channels, 1 to 4. More than one channel requires one or two dimensions. Each channel is then a permutation, and
        the channels are jointly blue: nearby texels differ as vectors.
    out : ndarray of uint32, optional
        A C-ordered array of the result's shape, which is filled and returned. After an exception, its contents are undefined.
    progress : callable, optional
        Called with the fraction completed; the last call passes 1. If it returns a true value, `CancelledError` is raised.

    Returns
    -------
    ndarray of uint32
        Ranks of shape `shape`, or ``(channels, *shape)``. Each rank from 0 to n - 1 occurs exactly once per channel.

    Raises
    ------
    ValueError
        A number is out of range.
    TypeError
        An argument has the wrong type.
    MemoryError
        There is not enough memory. If the machine has too little memory for the mask, the exception is raised immediately.
    CancelledError
        `progress` returned a true value.
    RuntimeMissingError
        ONNX Runtime, which two-channel masks need, is missing. `anneal` makes them without it.

    Notes
    -----
    All generators raise these exceptions, release the GIL and can be interrupted with Ctrl-C.

    Examples
    --------
    >>> int(mask((64, 64), seed=1).max())
    4095
    """
    extents, count = arguments.shape(shape, 3), arguments.integer("channels", channels, 1, 4)
    given: dict[str, Any] = {"seed": seed, "out": out, "progress": progress}
    if count > 1 and len(extents) == 3:
        raise ValueError(f"a {count}-channel mask must have one or two dimensions, not shape {extents}")
    if count == 1:
        return (relax if len(extents) == 2 and math.prod(extents) > _LARGE else void_and_cluster)(extents, **given)
    if count == 2 and len(extents) == 2:
        try:
            return neural(extents, channels=2, **given)
        except _core.RuntimeMissingError as error:
            raise _core.RuntimeMissingError(f"{error}; without it, anneal makes two-channel masks, more slowly") from None
    return anneal(extents, channels=count, sweeps=_SWEEPS, **given)


def void_and_cluster(
    shape: Shape,
    *,
    seed: Seed = 0,
    sigma: float = 1.5,
    initial_fraction: float = 0.1,
    out: Optional[Ranks] = None,
    progress: Optional[Progress] = None,
) -> Ranks:
    """Make a mask in one to three dimensions with void-and-cluster, which takes milliseconds.

    Parameters
    ----------
    shape, seed, out, progress
        See `mask`.
    sigma : float, default 1.5
        Standard deviation of the Gaussian in texels, from 0.25 to 16.
    initial_fraction : float, default 0.1
        Fraction of texels in the initial pattern, above 0 and at most 0.5.

    Returns
    -------
    ndarray of uint32
        Ranks of shape `shape`. Each rank occurs exactly once. The result is bit-identical on every machine.

    References
    ----------
    Robert Ulichney, "The void-and-cluster method for dither array generation", 1993.
    """
    extents, options = arguments.shape(shape, 3), _core.VoidAndClusterOptions()
    options.sigma = arguments.real("sigma", sigma, 0.25, 16)
    options.initial_fraction = arguments.real("initial_fraction", initial_fraction, 0, 0.5, False)
    ranks = _result(extents, out)
    return _generate(_core.void_and_cluster, ranks, (1,) * (3 - len(extents)) + extents, options, seed, progress)


def relax(
    shape: Shape, *, seed: Seed = 0, threads: int = 0, out: Optional[Ranks] = None, progress: Optional[Progress] = None
) -> Ranks:
    """Make a mask with parallel relaxation, which is the fastest method for large masks but slightly worse than void-and-cluster.

    Parameters
    ----------
    shape, seed, out, progress
        See `mask`. `shape` must have one or two dimensions.
    threads : int, default 0
        Number of threads; 0 means one per CPU that the process may use. The thread count does not affect the result.

    Returns
    -------
    ndarray of uint32
        Ranks of shape `shape`. Each rank occurs exactly once. The result is bit-identical on every machine.
    """
    extents, options = _flat(shape, "relax"), _core.RelaxOptions()
    options.threads = arguments.integer("threads", threads, *arguments.UINT32)
    ranks = _result(extents, out)
    return _generate(_core.relax, ranks, (1,) * (3 - len(extents)) + extents, options, seed, progress)


def anneal(
    shape: Shape,
    *,
    seed: Seed = 0,
    channels: int = 1,
    sweeps: int = 1000,
    sigma: float = 1.0,
    far_sigma: Optional[float] = None,
    far_weight: float = 1.0,
    value_sigma: float = 1.0,
    start_temperature: float = 4e-4,
    end_temperature: float = 2e-6,
    order_ends: bool = True,
    start_from_ranks: Optional[npt.ArrayLike] = None,
    out: Optional[Ranks] = None,
    progress: Optional[Progress] = None,
) -> Ranks:
    """Make a mask with simulated annealing, which is slow but gives the lowest error.

    Compared with void-and-cluster, 10,000 sweeps lower the error after a 1-texel blur by about 4%.

    Parameters
    ----------
    shape, seed, out, progress
        See `mask`. `shape` must have one or two dimensions.
    channels : int, default 1
        Number of channels, 1 to 4. With more than one, the channels are jointly blue (see `mask`), and a trial swap takes about 1
        us.
    sweeps : int, default 1000
        Trial swaps per texel. Each takes about 65 ns.
    sigma, far_sigma : float, default 1 and max(1.5, sigma)
        Standard deviations, in texels, of the blurs after which the error is minimised, where 0.25 <= sigma <= far_sigma <= 4.
        With multiple channels, only `sigma` is used.
    far_weight : float, default 1
        Weight of the squared error after the second blur; must be at least 0.
    value_sigma : float, default 1
        With multiple channels, the distance between values within which vectors repel each other, from 0.01 to 100.
    start_temperature, end_temperature : float, default 4e-4 and 2e-6
        Temperatures as fractions of the largest possible gain from one texel's pairs, where 0 < end <= start <= 1. Cooling is
        geometric.
    order_ends : bool, default True
        Whether to order the first and last ranks with void-and-cluster, because their texels are too far apart for the blurs to
        have any effect.
    start_from_ranks : array_like of int, optional
        A mask of the result's shape to start from, instead of void-and-cluster.

    Returns
    -------
    ndarray of uint32
        Ranks of shape `shape`, or ``(channels, *shape)``. The result is bit-identical on every machine.

    References
    ----------
    Iliyan Georgiev and Marcos Fajardo, "Blue-noise dithered sampling", 2016.
    """
    extents, options = _flat(shape, "anneal"), _core.AnnealOptions()
    channels = arguments.integer("channels", channels, 1, 4)
    options.sigma = sigma = arguments.real("sigma", sigma, 0.25, 4)
    options.far_sigma = max(1.5, sigma) if far_sigma is None else arguments.real("far_sigma", far_sigma, sigma, 4)
    options.far_weight = arguments.real("far_weight", far_weight, 0, sys.float_info.max)
    options.value_sigma = arguments.real("value_sigma", value_sigma, 0.01, 100)
    options.start_temperature = start = arguments.real("start_temperature", start_temperature, 0, 1, False)
    options.end_temperature = arguments.real("end_temperature", end_temperature, 0, start, False)
    options.sweeps = arguments.integer("sweeps", sweeps, *arguments.UINT32)
    options.order_ends = arguments.flag("order_ends", order_ends)
    ranks = _result(extents if channels == 1 else (channels, *extents), out)
    if start_from_ranks is not None:
        _start_from(ranks, start_from_ranks, channels)
        options.start_from_ranks = 1
    return _generate(_core.anneal, ranks, (channels, *(1,) * (2 - len(extents)), *extents), options, seed, progress)


def neural(
    shape: Shape,
    *,
    seed: Seed = 0,
    channels: int = 0,
    model: Union[None, PathLike, bytes] = None,
    runtime: Optional[PathLike] = None,
    threads: int = 0,
    provider: Optional[NeuralProvider] = None,
    out: Optional[Ranks] = None,
    progress: Optional[Progress] = None,
) -> Ranks:
    """Make a mask with one pass of a neural network, in linear time. Needs ONNX Runtime.

    To make several masks with the same options, keep a `NeuralGenerator`, which opens its network only once.

    Parameters
    ----------
    shape, seed, out, progress
        See `mask`. `shape` must have two dimensions.
    channels, model, runtime, threads, provider
        See `NeuralGenerator`. Two-channel masks are jointly blue. They are nearly as good as those from `anneal` and take far less
        time.

    Returns
    -------
    ndarray of uint32
        Ranks of shape `shape`, or ``(channels, *shape)``. Quality does not depend on the machine, but the exact bits may.
    """
    extents = arguments.shape(shape, 3)
    if len(extents) != 2:
        raise ValueError(f"shape of a neural mask must be (h, w), not {extents}")
    if model is runtime is provider is None and type(channels) is type(threads) is int and threads == 0:
        generator = builtin_generator(channels or 1)
    else:
        generator = NeuralGenerator(model, runtime, threads, provider, channels)
    return generator.mask(extents, seed, out=out, progress=progress)


def builtin(shape: Shape, *, out: Optional[Ranks] = None) -> Ranks:
    """Return a copy of a built-in mask, which took minutes to optimise.

    Parameters
    ----------
    shape : tuple of int
        ``(64, 64)``. Builds with more masks also offer side lengths of 16, 32, 128 and 256.
    out : ndarray of uint32, optional
        See `mask`.

    Returns
    -------
    ndarray of uint32
        Ranks of shape `shape`. Each rank occurs exactly once.
    """
    extents = arguments.shape(shape, 3)
    sizes = [size for size in _BUILTIN_SIZES if _core.builtin_mask_exists(size)]
    if len(extents) != 2 or extents[0] != extents[1] or extents[0] not in sizes:
        known = ", ".join(f"({size}, {size})" for size in sizes)
        raise ValueError(f"shape of a built-in mask must be one of {known}, not {extents}")
    ranks = _result(extents, out)
    np.copyto(ranks, _core.builtin_mask(extents[0]))  # type: ignore[arg-type]
    return ranks


METHODS: dict[str, Callable[..., Ranks]] = {
    "auto": mask, "void-and-cluster": void_and_cluster, "relax": relax, "anneal": anneal, "neural": neural, "builtin": builtin,
}


def _flat(shape: Shape, generator: str) -> tuple[int, ...]:
    extents = arguments.shape(shape, 3)
    if len(extents) > 2:
        raise ValueError(f"shape for {generator}() must be (n,) or (h, w), not {extents}")
    return extents


def _result(shape: tuple[int, ...], out: Optional[Ranks]) -> Ranks:
    arguments.enough_memory(f"a mask of shape {shape}", math.prod(shape) * _MEMORY)
    return arguments.output(out, shape, np.uint32)


def _generate(
    make: Callable[..., None], ranks: Ranks, extents: tuple[int, ...], options: Any, seed: Seed, progress: Optional[Progress]
) -> Ranks:
    options.seed = arguments.seed(seed)
    make(ranks.reshape(extents), options, arguments.callback("progress", progress))
    return ranks


def _start_from(ranks: Ranks, given: npt.ArrayLike, channels: int) -> None:
    """Copies the initial ranks into the result array and checks the copy."""
    start = arguments.array("start_from_ranks", given)
    if start.shape != ranks.shape:
        raise ValueError(f"start_from_ranks must have shape {ranks.shape}, not {start.shape}")
    np.copyto(ranks, arguments.integers("start_from_ranks", start, np.uint32, *arguments.UINT32))
    for channel in ranks.reshape(channels, -1):
        arguments.permutation("start_from_ranks", channel)


def to_float(ranks: npt.ArrayLike, count: Optional[int] = None) -> npt.NDArray[np.float32]:
    """Convert ranks to values: ``(rank + 0.5) / count``, computed in double precision and rounded down.

    Parameters
    ----------
    ranks : array_like of int
        An array of integers from 0 to ``count - 1``, of any shape.
    count : int, optional
        The number of ranks. Defaults to the number of elements, or of elements per channel for a multi-channel mask, such as the
        result of ``mask(..., channels=2)``. Required if `ranks` is only part of a mask.

    Returns
    -------
    ndarray of float32
        Values of the same shape, in [0, 1 - 2**-24].

    Raises
    ------
    ValueError
        A rank is out of range.
    TypeError
        The elements are not integers.
    """
    array = arguments.array("ranks", ranks)
    if count is None:
        count = array[0].size if arguments.has_channels(array) else array.size
    count = arguments.integer("count", count, 0, 2**32)
    if array.size == 0:
        return np.zeros(array.shape, np.float32)
    texels = arguments.integers("ranks", array, np.uint32, 0, count - 1)
    return _core.ranks_to_float(np.ascontiguousarray(texels).reshape(-1), count).reshape(array.shape)
