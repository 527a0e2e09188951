# SPDX-License-Identifier: Apache-2.0
"""Point sets in the unit square and cube."""

from __future__ import annotations

import functools
import inspect
import itertools
import math
from typing import Any, Callable, Optional

import numpy as np
import numpy.typing as npt

from . import _arguments as arguments
from . import _core
from ._arguments import PointsMethod, Progress, Seed
from ._masks import void_and_cluster

Points = npt.NDArray[np.float64]

_MAX_POINTS = 2**24
_TEXELS_PER_POINT = 8  # in masks made here; void-and-cluster spreads points evenly at up to about 16
_MAX_CANDIDATES = 2**16  # for one point
_RECENT = 16  # number of points after which the tree is rebuilt
_CELLS = {2: 12, 3: 5}  # per point spacing, in the grid that filters candidates
_MAX_CELLS = {2: 2048, 3: 160}  # along one side
_MAX_TILE = {2: 512, 3: 64}  # side of a mask made here, which is repeated if more texels are needed
_LEAST_THROWN = 16  # points tried at a time, for Poisson disks


def points(
    n: Optional[int] = None, *, method: Optional[PointsMethod] = None, seed: Seed = 0, progress: Optional[Progress] = None, dims: int = 2,
    density: Optional[npt.ArrayLike] = None, candidates: Optional[int] = None, mask: Optional[npt.ArrayLike] = None,
    jitter: Optional[bool] = None,
) -> Points:
    """Make blue-noise points in the unit square or cube.

    On one machine, the same arguments give the same points. The results of ``"mask"`` without a density are bit-identical on every
    machine; others depend on SciPy's rounding and version.

    Parameters
    ----------
    n : int, optional
        The number of points, 0 to 2**24. With a density, None makes as many points as the density's sum, on average over seeds.
    method : {"best-candidate", "poisson-disk", "mask"}, optional
        The default is ``"best-candidate"`` or, with a density, ``"poisson-disk"``.

        ``"best-candidate"``: each point is the random candidate farthest from all earlier points, so every prefix is evenly
        spread. The sets are toroidal, so they tile. Takes about a second for 4000 points; the time grows as n**2. See Mitchell,
        "Spectrally optimal sampling for distribution ray tracing", 1991. Needs SciPy.

        ``"poisson-disk"``: no two points are closer than a radius, and few more points would fit. A random point is accepted if
        no other point is within the radius, which shrinks slowly until there are n points. The sets are toroidal, and their
        points are in no particular order. Takes a fraction of a second for 4000 points. See McCool and Fiume, "Hierarchical
        Poisson disk sampling distributions", 1992. Needs SciPy.

        ``"mask"``: the n texels with the lowest ranks in a mask, in rank order, so every prefix is evenly spread. The sets are
        toroidal. The fastest method: 1024 points take milliseconds.
    seed : int, numpy.random.Generator, numpy.random.SeedSequence or None, default 0
        See `mask`.
    progress : callable, optional
        See `bluenoise.mask`.
    dims : {2, 3}, default 2
        Number of dimensions.
    density : array_like, optional
        How dense the points are in each pixel: at least 0, of shape ``(height, width)`` or ``(depth, height, width)``. Only ratios count,
        unless n is None. The unit square is stretched over the image, in which the points are evenly spread; they do not tile. For dark
        ink on white paper, pass ``1 - image / 255``.

        ``"poisson-disk"`` draws trials from the density, and two points conflict if they are closer than both of their radii, which are
        proportional to ``density ** (-1 / dims)``; see Mitchell, Rand, Ebeida and Bajaj, "Variable radii Poisson-disk sampling", 2012.
        ``"mask"`` dithers the density: it orders the texels by rank over density, so every prefix follows the density.
    candidates : int, optional
    mask : array_like of int, optional
    jitter : bool, optional
        Options of individual methods; the other methods reject them. None selects the default, given in parentheses below.

        ``"best-candidate"``: ``candidates`` (1) is the number of candidates per existing point, from 1 to 64. A point has at most
        65536 candidates.

        ``"poisson-disk"``: ``candidates`` (30) ranges from 1 to 1000. Larger values shrink the radius more slowly, so the final
        radius is larger and the points are packed more densely.

        ``"mask"``: ``mask`` is a mask of shape (height, width) or (depth, height, width) with at least n texels, given as ranks and
        stretched over the square or cube. The default is a void-and-cluster mask with eight texels per point, at the density's peak.
        ``jitter`` (True) places each point at random within its texel instead of at the centre.

    Returns
    -------
    ndarray of float64
        The coordinates x, y (and z) in [0, 1), as an array of shape ``(n, dims)``.

    Raises
    ------
    ValueError
        The method is unknown, a number is out of range, a shape is wrong, or the mask is not a permutation or has too few texels.
    TypeError
        An argument has the wrong type, or the method has no such option.
    ImportError
        The method needs SciPy, which is not installed.

    Examples
    --------
    >>> points(100, method="mask", seed=1).shape
    (100, 2)
    >>> points(density=[[40, 60]], method="mask", seed=1).shape
    (100, 2)
    """
    dims = arguments.integer("dims", dims, 2, 3)
    field = None if density is None else _Density(density, dims)
    number = arguments.seed(seed)
    if n is None and field is not None:
        n = math.floor(field.sums[-1] + float(_white(number, 1, 1)(-1, 1)[0, 0]))
    n = arguments.integer("n", n, 0, _MAX_POINTS)
    if method is None:
        method = "best-candidate" if field is None else "poisson-disk"
    arguments.one_of("method", method, METHODS)
    arguments.callback("progress", progress)
    if jitter is not None:
        arguments.flag("jitter", jitter)
    given = {"density": density, "candidates": candidates, "mask": mask, "jitter": jitter}
    for name, value in given.items():
        if value is not None and name not in METHODS[method]:
            raise TypeError(f"method {method!r} has no option {name} (given as {arguments.said(value)})")
    options: dict[str, Any] = {name: value for name, value in {**given, "density": field}.items() if value is not None}
    found = _MAKERS[method](n, number, dims, progress=progress, **options)
    arguments.report(progress, 1.0)
    return found


def _tree(method: str) -> Any:
    return arguments.needed("scipy.spatial", f"method {method!r} needs SciPy", "scipy").cKDTree


def _white(seed: int, most: int, dims: int) -> Callable[[int, int], npt.NDArray[np.float32]]:
    """Returns a function of x and ``count`` that generates ``count`` random points, a different set for each x; ``count`` must not
    exceed ``most``. The points come from the library's sampler, so they do not depend on NumPy. Each call overwrites them."""
    sampler = _core.Sampler(_core.sampler_types["white"], seed, 0, None)
    column, row = np.zeros((2, most), np.int32)
    index, domain = np.arange(most, dtype=np.uint32), np.zeros(most, np.uint32)
    samples = np.empty((most, dims), np.float32)

    def draw(x: int, count: int) -> npt.NDArray[np.float32]:
        column[:count] = x
        sampler.sample(column[:count], row[:count], index[:count], domain[:count], samples[:count])
        return samples[:count]

    return draw


class _Density:
    """A density on a grid that covers the box, which is as wide as the grid's extents. Coordinates are x, y and z."""

    def __init__(self, value: npt.ArrayLike, dims: int) -> None:
        self.values = given = arguments.reals("density", value)
        if given.ndim != dims or given.size == 0:
            raise ValueError(f"density must have shape {'(height, width)' if dims == 2 else '(depth, height, width)'}, not {given.shape}")
        inside = (given >= 0) & (given < np.inf)
        if not inside.all():
            raise ValueError(f"density must have finite values of at least 0, not {given[~inside][0]}")
        self.sums = np.cumsum(given)
        if not 0 < self.sums[-1] < np.inf:
            raise ValueError(f"density must have a sum above 0, not {self.sums[-1]}")
        self.extents = np.array(given.shape[::-1], np.float64)
        self.peak = self.values.max() * self.values.size / self.sums[-1]

    def at(self, points: Points) -> Points:
        """The density at points of the unit box, relative to its mean."""
        cells = (points * self.extents).astype(np.int64).T[::-1]
        return np.asarray(self.values[tuple(cells)] * (self.values.size / self.sums[-1]))

    def place(self, u: npt.NDArray[np.float32]) -> Points:
        """Points of the unit box with this density, from random numbers. The first selects a cell, the others a place in it."""
        cells = np.searchsorted(self.sums, u[:, 0].astype(np.float64) * self.sums[-1], side="right")
        corners = np.stack(np.unravel_index(cells, self.values.shape)[::-1], 1)
        return np.asarray(np.minimum((corners + u[:, 1:]) / self.extents, 1 - 2.0**-53))


def _best_candidate(n: int, seed: int, dims: int, *, progress: Optional[Progress] = None, candidates: int = 1) -> Points:
    """A grid stores the distance from each cell's centre to the closest point. This bounds the distance of every candidate in the
    cell, so only candidates that may be the farthest are examined. The grid is updated only around each new point."""
    candidates = arguments.integer("candidates", candidates, 1, 64)
    cKDTree = _tree("best-candidate")
    white = _white(seed, _MAX_CANDIDATES, dims)
    result = np.empty((n, dims))
    in_tree, tree = 0, None
    grid = _Distances(min(_MAX_CELLS[dims], math.ceil(_CELLS[dims] * float(n) ** (1 / dims) - 1e-9)), dims)
    for k in range(n):
        trials = grid.farthest(white(k, min(max(1, k * candidates), _MAX_CANDIDATES))).astype(np.float64)
        recent = result[in_tree:k]
        apart = np.abs(trials[:, None, :] - recent)
        apart = np.minimum(apart, 1 - apart)
        square = (apart**2).sum(2).min(1, initial=np.inf)
        if tree is not None:
            square = np.minimum(square, tree.query(trials)[0] ** 2)
        result[k] = trials[np.argmax(square)]
        grid.add(result[k])
        if k + 1 - in_tree == _RECENT:
            in_tree, tree = k + 1, cKDTree(result[: k + 1], boxsize=1)
            grid.tighten()
            arguments.report(progress, ((k + 1) / n) ** 2)
    return result


class _Distances:
    """A toroidal grid of squared distances from the centres of its cells to the closest point. Its axes are x, y and z, backwards."""

    def __init__(self, side: int, dims: int) -> None:
        self.side, self.dims = side, dims
        self.square = np.full((side,) * dims, np.inf, np.float32)
        self.margin = math.sqrt(dims) / max(side, 1) + 1e-6  # twice the distance from a cell's centre to its corner, plus rounding
        self.reach = side

    def farthest(self, trials: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
        """The trials that may be farthest from all points."""
        cells = (trials * np.float32(self.side)).astype(np.int32)
        near = self.square.reshape(-1)[cells @ np.array([self.side**axis for axis in range(self.dims)], np.int32)]
        return np.asarray(trials[near >= max(0.0, math.sqrt(near.max()) - self.margin) ** 2])

    def add(self, point: Points) -> None:
        reach, side, at, squares = self.reach, self.side, [], []
        for middle in point[::-1]:
            first = int(middle * side) - reach
            cells = np.arange(first, first + 2 * reach + 1) if 2 * reach < side else np.arange(side)
            apart = np.abs((cells + 0.5) / side - middle)
            at.append(cells)
            squares.append((np.minimum(apart, np.abs(1 - apart)) ** 2).astype(np.float32))
        inside = all(0 <= cells[0] and cells[-1] < side for cells in at)  # views are faster than indices
        window: Any = tuple(slice(cells[0], cells[-1] + 1) for cells in at) if inside else np.ix_(*(c % side for c in at))
        self.square[window] = np.minimum(self.square[window], functools.reduce(lambda a, b: a[..., None] + b, squares))

    def tighten(self) -> None:
        """Limits add() to the cells a new point can affect."""
        self.reach = math.ceil(math.sqrt(self.square.max()) * self.side) + 1


def _poisson_disk(
    n: int, seed: int, dims: int, *, progress: Optional[Progress] = None, candidates: int = 30, density: Optional[_Density] = None
) -> Points:
    """Two points conflict if they are closer than both of their radii. A density scales the radii and selects the trials. Its box
    has the proportions of its grid, and is not toroidal."""
    candidates = arguments.integer("candidates", candidates, 1, 1000)
    cKDTree = _tree("poisson-disk")
    white = _white(seed, max(n, _LEAST_THROWN), dims + (density is not None))
    box = np.ones(dims) if density is None else density.extents / density.extents.prod() ** (1 / dims)
    wrap = box if density is None else None

    def conflicts(trials: Points, radii: Points, others: Points, other_radii: Points) -> tuple[Points, Points]:
        """The pairs of a trial and another point that conflict, as indices."""
        near = cKDTree(others, boxsize=wrap).query_ball_point(trials, radii)
        first = np.repeat(np.arange(len(trials)), [len(found) for found in near])
        second = np.array([k for found in near for k in found], np.int64)
        apart = np.abs(trials[first] - others[second])
        apart = apart if wrap is None else np.minimum(apart, 1 - apart)
        close = (apart**2).sum(1) < other_radii[second] ** 2
        return first[close], second[close]

    found, radii = np.empty((0, dims)), np.empty(0)
    radius = (0.8 / max(n, 1)) ** (1 / dims)  # about 0.7 points fit into a square as wide as the radius
    for k in itertools.takewhile(lambda _: len(found) < n, itertools.count()):
        u = white(k, max(n, _LEAST_THROWN))
        trials = u.astype(np.float64) if density is None else density.place(u)
        own = np.ones(len(u)) if density is None else density.at(trials) ** (-1 / dims)  # relative to that at the mean density
        trials = trials * box
        if len(found):
            apart, nearest = cKDTree(found, boxsize=wrap).query(trials)  # discards most trials
            free = apart >= radius * np.minimum(own, radii[nearest])
            if density is not None:
                at = np.flatnonzero(free)
                free[at[conflicts(trials[at], radius * own[at], found, radius * radii)[0]]] = False
            trials, own = trials[free], own[free]
        kept = np.ones(len(trials), bool)
        for first, second in zip(*(side.tolist() for side in conflicts(trials, radius * own, trials, radius * own))):
            if first < second and kept[first]:  # an earlier point is preferred
                kept[second] = False
        found, radii = np.concatenate([found, trials[kept]]), np.concatenate([radii, own[kept]])
        arguments.report(progress, min(len(found) / n, 1.0) ** 8)
        radius *= 1 - 0.1 / candidates
    return found[:n] / box


def _mask(
    n: int, seed: int, dims: int, *, progress: Optional[Progress] = None, mask: Optional[npt.ArrayLike] = None, jitter: bool = True,
    density: Optional[_Density] = None,
) -> Points:
    """The texels with the lowest ranks or, with a density, those whose density exceeds the highest multiple of their ranks."""
    if mask is None:
        box = np.ones(dims) if density is None else density.extents / density.extents.prod() ** (1 / dims)
        side = (_TEXELS_PER_POINT * n * (1 if density is None else density.peak)) ** (1 / dims)
        extents = tuple(max(1, math.ceil(side * each - 1e-9)) for each in box[::-1])
        arguments.enough_memory("a mask for that density", 64 * math.prod(extents))
        tile = void_and_cluster(tuple(min(each, _MAX_TILE[dims]) for each in extents), seed=seed, progress=progress)
    else:
        tile = arguments.integers("mask", mask, np.uint32, *arguments.UINT32) if dims == 3 else arguments.ranks("mask", mask)
        extents = tile.shape
        if len(extents) != dims or tile.size < n:
            raise ValueError(f"mask must have {dims} axes and at least n = {n} texels, not {tile.size} in shape {extents}")
        arguments.permutation("mask", tile.reshape(-1))
    keys: Any = tile[np.ix_(*(np.arange(each) % size for each, size in zip(extents, tile.shape)))].reshape(-1)
    if density is not None:
        centres = (np.stack(np.unravel_index(np.arange(keys.size), extents)[::-1], 1) + 0.5) / extents[::-1]
        with np.errstate(divide="ignore"):
            keys = (keys + 0.5) / density.at(centres)
        if np.isfinite(keys).sum() < n:
            raise ValueError(f"mask must have at least n = {n} texels where the density is above 0, not {np.isfinite(keys).sum()}")
    texels = np.argsort(keys, kind="stable")[:n]
    corners = np.stack(np.unravel_index(texels, extents)[::-1], 1)
    inside = _white(seed, n, dims)(0, n) if jitter and n else np.full((n, dims), 0.5)
    return np.asarray((corners + inside) / np.array(extents[::-1]))


_MAKERS: dict[str, Callable[..., Points]] = {
    "best-candidate": _best_candidate,
    "poisson-disk": _poisson_disk,
    "mask": _mask,
}

# Method -> the names of its options.
METHODS = {name: tuple(inspect.signature(maker).parameters)[3:] for name, maker in _MAKERS.items()}
