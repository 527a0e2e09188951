# SPDX-License-Identifier: Apache-2.0
"""Samplers: pure functions of (x, y, index, domain)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal, NoReturn, Optional, Sequence, Union, cast, overload

import numpy as np
import numpy.typing as npt

from . import _arguments as arguments
from . import _core
from ._arguments import Ranks, SamplerType, Seed

if TYPE_CHECKING:
    from ._qmc import SamplerEngine


class Sampler:
    """Samples in [0, 1) for every pixel, index and domain. Within a pixel, samples are well distributed. For the ``"blue"``,
    ``"zorder"`` and ``"mask"`` types, the error is also blue noise across the image.

    A sample depends only on the arguments to the sampler and the call, so draw order, tiling, threading and restarts cannot
    change it. Samplers are immutable and hashable, compare equal if their arguments are equal, and can be pickled.

    Parameters
    ----------
    type : {"blue", "sobol", "white", "zorder", "mask"}, optional
        ``"blue"``: the recommended type, which is progressive and has blue-noise error across the image. ``"sobol"``: padded
        Owen-scrambled Sobol'; each pair of dimensions in each pixel has its own independent sequence. ``"white"``: independent
        uniform numbers. ``"zorder"``: one Sobol' sequence along a Morton curve (Ahmed and Wonka, "Screen-Space Blue-Noise Diffusion
        of Monte Carlo Sampling Error via Hierarchical Ordering of Pixels", 2020), tuned for ``samples_per_pixel`` samples.
        ``"mask"``: a blue-noise mask supplies each pixel's first sample, and a Sobol' sequence supplies the others.
    seed : int, numpy.random.Generator, numpy.random.SeedSequence or None, default 0
        An integer from 0 to 2**64 - 1, a NumPy generator or seed sequence, or None for fresh entropy. Different seeds give
        independent images.
    samples_per_pixel : int, default 0
        The sample count that the ``"zorder"`` type is tuned for: up to 2**32 - 1, rounded up to a power of two (at most 2**16);
        0 means 256. Samples beyond that count are also valid. The other types are progressive and ignore this parameter.
    mask : array_like of int, optional
        The mask for the ``"mask"`` type: ranks of shape (height, width), or (n,) for a row, in which each rank from 0 to n - 1 occurs
        exactly once. Defaults to the built-in 64 x 64 mask.

    Examples
    --------
    >>> sampler = Sampler("blue", seed=1)
    >>> sampler.sample(3, 5, index=0).shape
    (4,)
    """

    __slots__ = ("_core", "_type", "_mask", "_samples_per_pixel", "_seed", "_words")

    _core: _core.Sampler
    _type: str
    _mask: Optional[Ranks]
    _samples_per_pixel: int
    _seed: int
    _words: tuple[int, int]  # the seed for shaders, as int32

    def __init__(
        self, type: SamplerType = "blue", *, seed: Seed = 0, samples_per_pixel: int = 0, mask: Optional[npt.ArrayLike] = None
    ) -> None:
        arguments.one_of("type", type, _core.sampler_types)
        ranks = None
        if mask is not None:
            if type != "mask":
                raise ValueError(f"mask needs type 'mask', not {type!r}")
            ranks = arguments.ranks("mask", mask)
            ranks.setflags(write=False)
        count = arguments.integer("samples_per_pixel", samples_per_pixel, *arguments.UINT32)
        number = arguments.seed(seed)
        put = object.__setattr__
        put(self, "_core", _core.Sampler(_core.sampler_types[type], number, count, ranks))
        put(self, "_type", str(type))
        put(self, "_seed", number)
        put(self, "_samples_per_pixel", count)
        put(self, "_mask", ranks)
        put(self, "_words", tuple(self._core.seed_words().view(np.int32).tolist()))

    if TYPE_CHECKING:

        @property
        def type(self) -> SamplerType:
            """The sampler type."""
            ...
    else:  # jedi, which completes names in IPython, fails on Literal here

        @property
        def type(self) -> str:
            """The sampler type."""
            return self._type

    @property
    def seed(self) -> int:
        """The seed as an integer, even if a Generator or None was given."""
        return self._seed

    @property
    def samples_per_pixel(self) -> int:
        """The given sample count, which only ``"zorder"`` uses; 0 if none was given."""
        return self._samples_per_pixel

    @property
    def mask(self) -> Optional[Ranks]:
        """The given mask, a read-only uint32 array, or None."""
        return self._mask

    def sample(
        self, x: npt.ArrayLike, y: npt.ArrayLike, index: npt.ArrayLike, domain: npt.ArrayLike = 0, dims: int = 4, *,
        pair: Optional[Literal[0, 1]] = None, out: Optional[npt.NDArray[np.float32]] = None,
    ) -> npt.NDArray[np.float32]:
        """Draw samples at arbitrary coordinates.

        Parameters
        ----------
        x, y : array_like of int
            Pixel coordinates, -2**31 to 2**31 - 1.
        index : array_like of int
            Sample index within the pixel, 0 to 2**32 - 1.
        domain : array_like of int, default 0
            The decision, 0 to 2**32 - 1; see `domain`. `x`, `y`, `index` and `domain` broadcast against each other.
        dims : int, default 4
            Number of dimensions, 1 to 4. Use dimensions (0, 1) and (2, 3) for two-dimensional decisions.
        pair : {0, 1}, optional
            Draw only dimensions (0, 1) or (2, 3), which takes about three quarters as long. Do not pass `dims` as well.
        out : ndarray of float32, optional
            A C-ordered array of the result's shape, which is filled and returned.

        Returns
        -------
        ndarray of float32
            Numbers in [0, 1) of shape ``(..., dims)``.

        Raises
        ------
        ValueError
            A number is out of range, or shapes do not broadcast.
        TypeError
            An argument does not hold integers.

        Notes
        -----
        For large arrays, each ``"blue"`` sample takes about ten nanoseconds.
        """
        dims = arguments.integer("dims", dims, 1, 4)
        if pair is not None:
            pair = cast(Literal[0, 1], arguments.integer("pair", pair, 0, 1))
            if dims not in (2, 4):
                raise ValueError(f"pair has two dimensions; leave dims out, not {dims}")
            dims = 2
        given: tuple[npt.NDArray[Any], ...] = (
            arguments.integers("x", x, np.int32, *arguments.INT32),
            arguments.integers("y", y, np.int32, *arguments.INT32),
            arguments.integers("index", index, np.uint32, *arguments.UINT32),
            arguments.integers("domain", domain, np.uint32, *arguments.UINT32),
        )
        axes = max(array.ndim for array in given)
        if axes > _MOST_AXES:
            raise ValueError(f"x, y, index and domain have {axes} axes together; {_MOST_AXES} is the most")
        shape = arguments.together("x, y, index and domain", *(array.shape for array in given))
        result = arguments.output(out, (*shape, dims), np.float32)
        if out is not None:
            given = tuple(array.copy() if np.may_share_memory(array, out) else array for array in given)
        self._draw(given, result, -1 if pair is None else pair)
        return result

    def _draw(self, given: Sequence[npt.NDArray[Any]], out: npt.NDArray[np.float32], pair: int) -> None:
        """Draws at x, y, index and domain, which broadcast. Works in parts and checks for Ctrl-C between them."""
        if out.size == 0:
            return
        lanes, first = out.reshape(-1, out.shape[-1]), 0
        if len(lanes) == 1:  # takes a fraction of the time
            x, y, index, domain = (array.reshape(1) for array in given)
            self._core.sample(x, y, index, domain, lanes, pair)
            return
        nditer: Any = np.nditer  # its types lack "contig"
        flags, op_flags = ["buffered", "external_loop"], [["readonly", "contig"]] * len(given)
        with nditer(given, flags, op_flags, order="C", buffersize=_LANES) as parts:
            for x, y, index, domain in parts:
                last = first + len(x)
                self._core.sample(x, y, index, domain, lanes[first:last], pair)
                first = last

    def block(
        self, x0: int, y0: int, width: int, height: int, first_index: int, index_count: int, domain: int = 0, dims: int = 4, *,
        out: Optional[npt.NDArray[np.float32]] = None,
    ) -> npt.NDArray[np.float32]:
        """Draw all samples in a rectangle of pixels. This is faster than `sample` and gives bit-identical results.

        Parameters
        ----------
        x0, y0 : int
            First column and row, -2**31 to 2**31 - 1.
        width, height : int
            Extents in pixels, at least 1.
        first_index, index_count : int
            Samples ``first_index`` to ``first_index + index_count - 1`` of each pixel.
        domain : int, default 0
            The decision; see `domain`.
        dims : int, default 4
            Number of dimensions, 1 to 4.
        out : ndarray of float32, optional
            A C-ordered array of the result's shape, which is filled and returned.

        Returns
        -------
        ndarray of float32
            Numbers in [0, 1) of shape ``(height, width, index_count, dims)``.

        Raises
        ------
        ValueError
            An extent is zero, a range runs past the last coordinate or index, or `out` has the wrong shape.
        MemoryError
            The array is too large.
        """
        x0 = arguments.integer("x0", x0, *arguments.INT32)
        y0 = arguments.integer("y0", y0, *arguments.INT32)
        first_index = arguments.integer("first_index", first_index, *arguments.UINT32)
        width = arguments.integer("width", width, 1, min(arguments.UINT32[1], 2**31 - x0))
        height = arguments.integer("height", height, 1, min(arguments.UINT32[1], 2**31 - y0))
        index_count = arguments.integer("index_count", index_count, 1, min(arguments.UINT32[1], 2**32 - first_index))
        domain = arguments.integer("domain", domain, *arguments.UINT32)
        dims = arguments.integer("dims", dims, 1, 4)
        result = arguments.output(out, (height, width, index_count, dims), np.float32)
        if dims == 4:
            rows = max(1, 4 * _LANES // (width * index_count))
            for row in range(0, height, rows):  # checks for Ctrl-C after each part
                self._core.block(x0, y0 + row, first_index, domain, result[row : row + rows])
            return result
        x = np.arange(x0, x0 + width, dtype=np.int64).astype(np.int32)[:, None]
        y = np.arange(y0, y0 + height, dtype=np.int64).astype(np.int32)[:, None, None]
        index = np.arange(first_index, first_index + index_count, dtype=np.int64).astype(np.uint32)
        self._draw((x, y, index, np.array(domain, np.uint32)), result, -1)
        return result

    def seed_words(self) -> npt.NDArray[np.uint32]:
        """Return the seed for shaders as a uint32 array of shape (2,). Use it with ``tables``."""
        return self._core.seed_words()

    def qmc(self, d: int, *, pixel: tuple[int, int] = (0, 0)) -> SamplerEngine:
        """Make a `scipy.stats.qmc.QMCEngine` from the samples of one pixel, in index order.

        Parameters
        ----------
        d : int
            Number of dimensions. Dimensions 4k to 4k + 3 come from ``bluenoise.domain(k)``, so each group of sixteen dimensions
            belongs to one family.
        pixel : tuple of int, default (0, 0)
            x and y.

        Returns
        -------
        scipy.stats.qmc.QMCEngine
            An engine that returns float64 numbers in (0, 1). They keep all 32 bits and lie at the centres of their intervals so
            that integrals are unbiased. After 2**32 points, the engine raises ``ValueError``.

        Raises
        ------
        ImportError
            SciPy is missing.
        """
        try:
            from ._qmc import SamplerEngine
        except ModuleNotFoundError as error:
            raise ImportError(f"qmc needs SciPy; run: pip install scipy ({error})") from None
        return SamplerEngine(self, d, pixel)

    def __setattr__(self, name: str, value: object) -> NoReturn:
        raise AttributeError(f"a Sampler is immutable: {name} cannot be set")

    def __delattr__(self, name: str) -> NoReturn:
        raise AttributeError(f"a Sampler is immutable: {name} cannot be deleted")

    def _key(self) -> tuple[Any, ...]:
        mask = self._mask
        texels = None if mask is None else (mask.shape, mask.tobytes())
        return (self._type, self._seed, self._samples_per_pixel, texels)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Sampler):
            return NotImplemented
        return self is other or self._key() == other._key()

    def __hash__(self) -> int:
        return hash(self._key())

    def __reduce__(self) -> tuple[Any, ...]:
        return (_restore, (self._type, self._seed, self._samples_per_pixel, self._mask))

    def __repr__(self) -> str:
        text = f"Sampler({self._type!r}, seed={self._seed}"
        if self._samples_per_pixel:
            text += f", samples_per_pixel={self._samples_per_pixel}"
        if self._mask is not None:
            text += f", mask=<{self._mask.shape[0]} x {self._mask.shape[1]}>"
        return text + ")"


@overload
def domain(*keys: int) -> int: ...
@overload
def domain(*keys: npt.ArrayLike) -> Union[int, npt.NDArray[np.uint32]]: ...


def domain(*keys: Any) -> Any:
    """Return the domain of a decision, given the path of keys that leads to it from the root.

    Samples from different domains are independent. Domains that differ only in their last key, within an aligned group of four (0
    to 3, 4 to 7, ...), form a family, which ``"blue"`` stratifies together. `PathSampler` chooses the domains of a path for you.

    Parameters
    ----------
    *keys : array_like of int
        Each from 0 to 2**32 - 1; arrays broadcast. Without keys, the result is the root, 0.

    Returns
    -------
    int or ndarray of uint32
        A domain for `Sampler.sample` and `Sampler.block`.

    Raises
    ------
    ValueError
        A key is out of range, or keys do not broadcast.
    """
    found: Any = 0
    for key in keys:
        array = arguments.integers("key", key, np.uint32, *arguments.UINT32)
        arguments.together("keys", np.shape(found), array.shape)
        found = _core.domain_child(found, int(array) if array.ndim == 0 else array)
    return found


def tables() -> npt.NDArray[np.uint32]:
    """Return the table that shaders need to draw ``"blue"``. It is the same for every seed.

    Returns
    -------
    ndarray of uint32
        A one-dimensional array of 46.5 KiB. ``bn/bn_draw.glsl`` describes the contents; docs/shaders.md shows how to use them.
    """
    return _core.tables()


_LANES = 2**16  # lanes per part
_MOST_AXES = 31  # NumPy before 2 supports 32, and the result has one more


def _restore(type: str, seed: int, samples_per_pixel: int, mask: Optional[Ranks]) -> Sampler:
    return Sampler(cast(SamplerType, type), seed=seed, samples_per_pixel=samples_per_pixel, mask=mask)
