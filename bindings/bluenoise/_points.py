# SPDX-License-Identifier: Apache-2.0
"""Point sets in the unit square."""

from __future__ import annotations

import inspect
import math
from typing import Any, Callable, Literal, Optional, overload

import numpy as np
import numpy.typing as npt

from . import _arguments as arguments
from . import _core
from ._arguments import PointsMethod, Seed
from ._masks import mask as make_mask

Points = npt.NDArray[np.float64]

_MAX_POINTS = 2**24
_TEXELS_PER_POINT = 8  # of masks made here; void-and-cluster keeps points even up to about 16
_MAX_CANDIDATES = 2**16  # of one point
_RECENT = 64  # points after which the tree is built again


@overload
def points(
    n: int, *, method: Literal["best-candidate"] = "best-candidate", seed: Seed = 0, candidates: int = 1
) -> Points: ...
@overload
def points(
    n: int, *, method: Literal["poisson-disk"], seed: Seed = 0, candidates: int = 30
) -> Points: ...
@overload
def points(
    n: int,
    *,
    method: Literal["mask"],
    seed: Seed = 0,
    mask: Optional[npt.ArrayLike] = None,
    jitter: bool = True,
) -> Points: ...
@overload
def points(n: int, *, method: PointsMethod, seed: Seed = 0) -> Points: ...


def points(n: Any, *, method: str = "best-candidate", seed: Any = 0, **options: Any) -> Points:
    """Makes n blue-noise points in the unit square: float64 of shape (n, 2), x and y in [0, 1).

    Equal arguments give equal points on one machine. On others, ``"mask"`` gives the same bits; the two other methods
    depend on SciPy's rounding and version.

    Parameters
    ----------
    n
        The number of points, 0 to 2**24.
    method
        ``"best-candidate"``: each point is the one of some random candidates that is farthest from the points so far, so
        that the first points of a set are a set, too. Toroidal: sets tile. Time grows with n**2, 1024 points take about a
        second. Mitchell, "Spectrally optimal sampling for distribution ray tracing", 1991. Needs SciPy.

        ``"poisson-disk"``: no two points are closer than a radius, and few more fit in. ``scipy.stats.qmc.PoissonDisk``
        with the largest radius found that leaves room for n points; a few too many are removed at random. Not toroidal,
        and in no order. Takes about a second for 1024 points. Bridson, "Fast Poisson disk sampling in arbitrary
        dimensions", 2007. Needs SciPy.

        ``"mask"``: the texels of a mask with the n lowest ranks, in this order, so that the first points of a set are a
        set, too. Toroidal. The fastest: milliseconds for 1024 points.
    seed
        An integer from 0 to 2**64 - 1, a ``numpy.random.Generator``, from which one integer is drawn, or None for fresh
        entropy.
    options
        ``"best-candidate"``: ``candidates`` (1), the number of candidates for each point so far, 1 to 64; a point has at most
        65536.

        ``"poisson-disk"``: ``candidates`` (30), the number of trials around each point, 1 to 1000.

        ``"mask"``: ``mask``, ranks of shape (height, width) with at least n texels, stretched over the square; by default
        void-and-cluster with eight texels a point. ``jitter`` (True): at random places in their texels, instead of at the
        centres.

    Raises
    ------
    ValueError
        The method is unknown, a number is out of range, or the mask is none or has fewer than n texels.
    TypeError
        An argument has a wrong type, or the method has no such option.
    ImportError
        The method needs SciPy, which is not installed.

    Examples
    --------
    >>> points(100, method="mask", seed=1).shape
    (100, 2)
    """
    n = arguments.integer("n", n, 0, _MAX_POINTS)
    if not isinstance(method, str):
        raise TypeError(f"method must be a string, not {method!r}")
    if method not in METHODS:
        raise ValueError(f"method must be one of {', '.join(METHODS)}, not {method!r}")
    for name, value in options.items():
        if name not in METHODS[method]:
            raise TypeError(f"method {method!r} has no option {name} (given as {value!r})")
    return _MAKERS[method](n, arguments.seed(seed), **options)


def _scipy(method: str) -> None:
    try:
        import scipy  # noqa: F401
    except ImportError:
        raise ImportError(f"method {method!r} needs SciPy; run: pip install scipy") from None


def _white(seed: int, x: int, count: int) -> Points:
    """Random points, others for each x, from the library's sampler, so that they do not depend on NumPy."""
    sampler = _core.Sampler(_core.sampler_kinds["white"], seed, 0, None)
    return sampler.block(x, 0, 1, 1, 0, count, 0)[0, 0, :, :2].astype(np.float64)


def _best_candidate(n: int, seed: int, *, candidates: int = 1) -> Points:
    candidates = arguments.integer("candidates", candidates, 1, 64)
    _scipy("best-candidate")
    from scipy.spatial import cKDTree

    result = np.empty((n, 2))
    in_tree, tree = 0, None
    for k in range(n):
        trials = _white(seed, k, min(max(1, k * candidates), _MAX_CANDIDATES))
        recent = result[in_tree:k]
        apart = np.abs(trials[:, None, :] - recent)
        apart = np.minimum(apart, 1 - apart)
        square = (apart**2).sum(2).min(1, initial=np.inf)
        if tree is not None:
            square = np.minimum(square, tree.query(trials)[0] ** 2)
        result[k] = trials[np.argmax(square)]
        if k + 1 - in_tree == _RECENT:
            in_tree, tree = k + 1, cKDTree(result[: k + 1], boxsize=1)
    return result


def _poisson_disk(n: int, seed: int, *, candidates: int = 30) -> Points:
    candidates = arguments.integer("candidates", candidates, 1, 1000)
    _scipy("poisson-disk")
    from scipy.stats import qmc

    def fill(radius: float) -> Points:
        rng = np.random.default_rng(seed)
        options = {"d": 2, "radius": radius, "ncandidates": candidates}
        try:
            engine = qmc.PoissonDisk(**options, rng=rng)
        except TypeError:  # before SciPy 1.15
            engine = qmc.PoissonDisk(**options, seed=rng)
        return np.asarray(engine.fill_space(), np.float64)

    if n == 0:
        return np.empty((0, 2))
    # About 0.7 points fit into each square of the radius.
    radius, best = min(1.0, math.sqrt(0.7 / n)), None
    for trial in range(12):
        found = fill(radius)
        if len(found) >= n and (best is None or len(found) < len(best)):
            best = found
        if best is not None and (len(best) <= 1.01 * n + 1 or trial >= 5):
            break
        # Slightly more than n, because the number jumps.
        radius *= min(max(math.sqrt(len(found) / (1.005 * n + 1)), 0.5), 1.5)
    assert best is not None
    kept = np.random.default_rng(seed).permutation(len(best))[:n]
    # SciPy scales its cells, so a coordinate may round to 1.
    return np.minimum(best[np.sort(kept)], np.nextafter(1.0, 0.0))


def _mask(
    n: int, seed: int, *, mask: Optional[npt.ArrayLike] = None, jitter: bool = True
) -> Points:
    if mask is None:
        side = max(1, math.ceil(math.sqrt(_TEXELS_PER_POINT * n)))
        ranks = make_mask((side, side), seed=seed)
    else:
        ranks = arguments.ranks("mask", mask)
        if ranks.size < n:
            raise ValueError(f"mask must have at least n = {n} texels, not {ranks.size}")
    texels = np.empty(ranks.size, np.int64)
    texels[ranks.reshape(-1)] = np.arange(ranks.size)
    y, x = np.divmod(texels[:n], ranks.shape[1])
    inside = _white(seed, 0, n) if jitter and n else np.full((n, 2), 0.5)
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
