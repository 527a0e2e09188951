# SPDX-License-Identifier: Apache-2.0
"""Dithering to a palette: a colour becomes a mixture of the palette's colours around it, and the mask picks one of them.

The weights are barycentric coordinates in the Delaunay triangulation of the palette (Gröller and Purgathofer, "Using tetrahedrons for
dithering color pictures", 1988), so they reproduce the colour exactly. A colour outside the palette's convex hull is replaced by the
closest one on it. The up to four colours are sorted by luminance, so that a grey mixture is dithered as with levels. Takes about a
microsecond for each different colour inside the hull, and up to ten outside it.
"""

from __future__ import annotations

from typing import Any, Callable

import numpy as np
import numpy.typing as npt

_Floats = npt.NDArray[np.float64]
_LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
_PART = 2**20  # distances computed at a time


class _Palette:
    """Colours of shape (count, channels)."""

    def __init__(self, colours: _Floats) -> None:
        try:
            from scipy.spatial import Delaunay
        except ImportError:
            raise ImportError("a palette needs SciPy; run: pip install scipy") from None
        self.colours, self.first = np.unique(colours, axis=0, return_index=True)
        self.centre = self.colours.mean(0)
        _, spread, axes = np.linalg.svd(self.colours - self.centre, full_matrices=False)
        self.axes = axes[spread > 1e-9]  # of the point, line, plane or space that contains the palette
        flat = (self.colours - self.centre) @ self.axes.T
        self.solid: Any = None
        self.faces = np.empty((0, 3), np.intp)
        if len(self.axes) > 1:
            triangulation = Delaunay(flat)
            self.solid = triangulation if len(self.axes) == 3 else None
            self.faces = triangulation.simplices if self.solid is None else triangulation.convex_hull
        line = np.argsort(flat[:, 0]) if len(self.axes) == 1 else np.zeros(2, np.intp)
        self.edges = self.faces[:, [[0, 1], [0, 2], [1, 2]]].reshape(-1, 2) if len(self.faces) else np.stack([line[:-1], line[1:]], 1)

    def mix(self, values: _Floats) -> tuple[npt.NDArray[np.intp], _Floats]:
        """Up to four colours for each value, darkest first, and their cumulative weights; both of shape (count, 4)."""
        which, weights = np.zeros((len(values), 4), np.intp), np.zeros((len(values), 4))
        outside = np.arange(len(values))
        if self.solid is not None:
            flat = (values - self.centre) @ self.axes.T
            found = self.solid.find_simplex(flat, bruteforce=True)  # the other way may not end
            inside, outside = np.flatnonzero(found >= 0), np.flatnonzero(found < 0)
            frames, which[inside] = self.solid.transform[found[inside]], self.solid.simplices[found[inside]]
            weights[inside, :3] = np.einsum("nij,nj->ni", frames[:, :3], flat[inside] - frames[:, 3])
            weights[inside, 3] = 1 - weights[inside, :3].sum(1)
        for part in np.array_split(outside, -(-len(outside) * len(self.edges) // _PART) or 1):
            which[part], weights[part] = self._nearest(values[part])
        order = np.argsort((self.colours @ (_LUMINANCE if values.shape[1] == 3 else np.ones(values.shape[1])))[which], 1, kind="stable")
        summed = np.cumsum(np.take_along_axis(np.maximum(weights, 0), order, 1), 1)
        return self.first[np.take_along_axis(which, order, 1)], summed / summed[:, 3:]

    def _nearest(self, values: _Floats) -> tuple[npt.NDArray[np.intp], _Floats]:
        """The closest point to each value on the edges and faces, as colours and weights."""
        row = np.arange(len(values))
        which, weights = np.zeros((len(values), 4), np.intp), np.zeros((len(values), 4))
        start, end = self.colours[self.edges].swapaxes(0, 1)
        size = np.maximum(((end - start) ** 2).sum(1), 1e-300)
        along = values @ (end - start).T - (start * (end - start)).sum(1)
        t = np.clip(along / size, 0, 1)
        square = (start**2).sum(1) - 2 * values @ start.T + t * (t * size - 2 * along)  # less the square of the value
        best = square.argmin(1)
        which[:, :2], weights[:, 1] = self.edges[best], t[row, best]
        if len(self.faces):
            corner, first, second = self.colours[self.faces].swapaxes(0, 1)
            first, second = first - corner, second - corner
            a, b, c = ((p * q).sum(1) for p, q in ((first, first), (first, second), (second, second)))
            p, q = (values @ side.T - (corner * side).sum(1) for side in (first, second))
            with np.errstate(divide="ignore", invalid="ignore"):  # faces without an area
                u, v = (c * p - b * q) / (a * c - b * b), (a * q - b * p) / (a * c - b * b)
                over = (u >= 0) & (v >= 0) & (u + v <= 1)
                face_square = np.where(over, (corner**2).sum(1) - 2 * values @ corner.T - u * p - v * q, np.inf)
            face = face_square.argmin(1)
            closer = np.flatnonzero(face_square[row, face] < square[row, best])
            face = face[closer]
            which[closer, :3], weights[closer, 1], weights[closer, 2] = self.faces[face], u[closer, face], v[closer, face]
        weights[:, 0] = 1 - weights[:, 1] - weights[:, 2]
        return which, weights


def indices(
    texels: npt.NDArray[Any], light: Callable[[npt.NDArray[Any]], _Floats], colours: _Floats, thresholds: _Floats
) -> npt.NDArray[np.uint8]:
    """The index of each pixel's colour. Texels have shape (height, width, channels); light() converts them to the units of the
    colours; thresholds in [0, 1) are tiled over the image."""
    height, width, channels = texels.shape
    flat, same = texels.reshape(-1, channels), np.arange(height * width)
    if texels.dtype.kind == "u" and channels <= 4:  # mixes each colour once
        words = flat.astype(np.uint64) @ np.uint64(2**16) ** np.arange(channels, dtype=np.uint64)
        _, first, same = np.unique(words, return_index=True, return_inverse=True)
        flat = flat[first]
    which, summed = _Palette(colours).mix(light(flat))
    tiled = thresholds[np.ix_(np.arange(height) % len(thresholds), np.arange(width) % thresholds.shape[1])].reshape(-1)
    chosen = which[same, (summed[same, :3] <= tiled[:, None]).sum(1)]
    return np.asarray(chosen.reshape(height, width), np.uint8)
