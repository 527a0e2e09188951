# SPDX-License-Identifier: Apache-2.0
"""Point sets in the unit square."""

from __future__ import annotations

import inspect
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
_CELLS = 12  # per point spacing, in the grid that filters candidates
_MAX_CELLS = 2048  # along one side
_LEAST_THROWN = 16  # points tried at a time, for Poisson disks


def points(
    n: int,
    *,
    method: PointsMethod = "best-candidate",
    seed: Seed = 0,
    progress: Optional[Progress] = None,
    candidates: Optional[int] = None,
    mask: Optional[npt.ArrayLike] = None,
    jitter: Optional[bool] = None,
) -> Points:
    """Make blue-noise points in the unit square.

    On one machine, the same arguments give the same points. The results of ``"mask"`` are bit-identical on every machine; those
    of the other two methods depend on SciPy's rounding and version.

    Parameters
    ----------
    n : int
        The number of points, 0 to 2**24.
    method : {"best-candidate", "poisson-disk", "mask"}, optional
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
        Called with the fraction completed; the last call passes 1. If it returns a true value, `CancelledError` is raised.
    candidates : int, optional
    mask : array_like of int, optional
    jitter : bool, optional
        Options of individual methods; the other methods reject them. None selects the default, given in parentheses below.

        ``"best-candidate"``: ``candidates`` (1) is the number of candidates per existing point, from 1 to 64. A point has at most
        65536 candidates.

        ``"poisson-disk"``: ``candidates`` (30) ranges from 1 to 1000. Larger values shrink the radius more slowly, so the final
        radius is larger and the points are packed more densely.

        ``"mask"``: ``mask`` is a mask of shape (height, width) with at least n texels, given as ranks and stretched over the
        square. The default is a void-and-cluster mask with eight texels per point. ``jitter`` (True) places each point at random
        within its texel instead of at the centre.

    Returns
    -------
    ndarray of float64
        The coordinates x and y in [0, 1), as an array of shape ``(n, 2)``.

    Raises
    ------
    ValueError
        The method is unknown, a number is out of range, or the mask is not a permutation or has fewer than n texels.
    TypeError
        An argument has the wrong type, or the method has no such option.
    ImportError
        The method needs SciPy, which is not installed.

    Examples
    --------
    >>> points(100, method="mask", seed=1).shape
    (100, 2)
    """
    options = {"candidates": candidates, "mask": mask, "jitter": jitter}
    n = arguments.integer("n", n, 0, _MAX_POINTS)
    arguments.one_of("method", method, METHODS)
    arguments.callback("progress", progress)
    given = {name: value for name, value in options.items() if value is not None}
    if jitter is not None:
        arguments.flag("jitter", jitter)
    for name, value in given.items():
        if name not in METHODS[method]:
            raise TypeError(f"method {method!r} has no option {name} (given as {value!r})")
    found = _MAKERS[method](n, arguments.seed(seed), progress=progress, **given)
    arguments.report(progress, 1.0)
    return found


def _scipy(method: str) -> None:
    try:
        import scipy  # noqa: F401
    except ImportError:
        raise ImportError(f"method {method!r} needs SciPy; run: pip install scipy") from None


def _white(seed: int, most: int) -> Callable[[int, int], npt.NDArray[np.float32]]:
    """Returns a function of x and ``count`` that generates ``count`` random points, a different set for each x; ``count`` must not
    exceed ``most``. The points come from the library's sampler, so they do not depend on NumPy. Each call overwrites them."""
    sampler = _core.Sampler(_core.sampler_types["white"], seed, 0, None)
    column, row = np.zeros((2, most), np.int32)
    index, domain = np.arange(most, dtype=np.uint32), np.zeros(most, np.uint32)
    samples = np.empty((most, 2), np.float32)

    def draw(x: int, count: int) -> npt.NDArray[np.float32]:
        column[:count] = x
        sampler.sample(column[:count], row[:count], index[:count], domain[:count], samples[:count])
        return samples[:count]

    return draw


def _best_candidate(
    n: int, seed: int, *, progress: Optional[Progress] = None, candidates: int = 1
) -> Points:
    """A grid stores the distance from each cell's centre to the closest point. This bounds the distance of every candidate in the
    cell, so only candidates that may be the farthest are examined. The grid is updated only around each new point."""
    candidates = arguments.integer("candidates", candidates, 1, 64)
    _scipy("best-candidate")
    from scipy.spatial import cKDTree

    white = _white(seed, _MAX_CANDIDATES)
    result = np.empty((n, 2))
    in_tree, tree = 0, None
    grid = _Distances(min(_MAX_CELLS, math.ceil(_CELLS * math.sqrt(n))))
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
    """A toroidal grid of squared distances from the centres of its cells to the closest point."""

    def __init__(self, side: int) -> None:
        self.side = side
        self.square = np.full((side, side), np.inf, np.float32)
        self.margin = math.sqrt(2) / max(side, 1) + 1e-6  # twice the distance from a cell's centre to its corner, plus rounding
        self.reach = side

    def farthest(self, trials: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
        """The trials that may be farthest from all points."""
        cells = (trials * np.float32(self.side)).astype(np.int32)
        near = self.square.reshape(-1)[cells[:, 1] * np.int32(self.side) + cells[:, 0]]
        farthest: npt.NDArray[np.float32] = trials[near >= max(0.0, math.sqrt(near.max()) - self.margin) ** 2]
        return farthest

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
        self.square[window] = np.minimum(self.square[window], squares[0][:, None] + squares[1])

    def tighten(self) -> None:
        """Limits add() to the cells a new point can affect."""
        self.reach = math.ceil(math.sqrt(self.square.max()) * self.side) + 1


def _poisson_disk(
    n: int, seed: int, *, progress: Optional[Progress] = None, candidates: int = 30
) -> Points:
    candidates = arguments.integer("candidates", candidates, 1, 1000)
    _scipy("poisson-disk")
    from scipy.spatial import cKDTree

    white = _white(seed, max(n, _LEAST_THROWN))
    found = np.empty((0, 2))
    radius = math.sqrt(0.8 / max(n, 1))  # about 0.7 points fit into a square as wide as the radius
    throw = 0
    while len(found) < n:
        trials = white(throw, max(n, _LEAST_THROWN)).astype(np.float64)
        if len(found):
            trials = trials[np.isinf(cKDTree(found, boxsize=1).query(trials, distance_upper_bound=radius)[0])]
        kept = np.ones(len(trials), bool)
        pairs = cKDTree(trials, boxsize=1).query_pairs(radius, output_type="ndarray") if len(trials) else np.empty((0, 2), int)
        for first, second in pairs[np.lexsort(pairs.T[::-1])].tolist():  # an earlier point is preferred
            if kept[first]:
                kept[second] = False
        found = np.concatenate([found, trials[kept]])
        arguments.report(progress, min(len(found) / n, 1.0) ** 8)
        radius *= 1 - 0.1 / candidates
        throw += 1
    return found[:n]


def _mask(
    n: int,
    seed: int,
    *,
    progress: Optional[Progress] = None,
    mask: Optional[npt.ArrayLike] = None,
    jitter: bool = True,
) -> Points:
    if mask is None:
        side = max(1, math.ceil(math.sqrt(_TEXELS_PER_POINT * n)))
        ranks = void_and_cluster((side, side), seed=seed, progress=progress)
    else:
        ranks = arguments.ranks("mask", mask)
        if ranks.size < n:
            raise ValueError(f"mask must have at least n = {n} texels, not {ranks.size}")
    texels = np.empty(ranks.size, np.int64)
    texels[ranks.reshape(-1)] = np.arange(ranks.size)
    y, x = np.divmod(texels[:n], ranks.shape[1])
    inside = _white(seed, n)(0, n) if jitter and n else np.full((n, 2), 0.5)
    found: Points = (np.stack([x, y], 1) + inside) / (ranks.shape[1], ranks.shape[0])
    return found


_MAKERS: dict[str, Callable[..., Points]] = {
    "best-candidate": _best_candidate,
    "poisson-disk": _poisson_disk,
    "mask": _mask,
}

# Method -> the names of its options.
METHODS = {
    name: tuple(inspect.signature(maker).parameters)[2:] for name, maker in _MAKERS.items()
}
