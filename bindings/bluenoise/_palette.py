# SPDX-License-Identifier: Apache-2.0
"""Dithering to a palette: a colour becomes a mixture of the palette's colours around it, and the mask picks one of them.

The weights are barycentric coordinates in the Delaunay triangulation of the palette (Gröller and Purgathofer, "Using tetrahedrons for
dithering color pictures", 1988), so they reproduce the colour exactly. A colour outside the palette's convex hull is replaced by the
closest one on it. The colours are sorted by luminance, so that a grey mixture is dithered as with levels.
"""

from __future__ import annotations

from typing import Any, Callable

import numpy as np
import numpy.typing as npt

from . import _arguments as arguments

_Floats = npt.NDArray[np.float64]
_LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
_PART, _PIXELS = 2**20, 2**18  # distances and pixels computed at a time


class _Palette:
    """Colours of shape (count, channels)."""

    def __init__(self, colours: _Floats) -> None:
        Delaunay = arguments.needed("scipy.spatial", "a palette needs SciPy", "scipy").Delaunay
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
            a, b, c = ((one * other).sum(1) for one, other in ((first, first), (first, second), (second, second)))
            p, q = (values @ side.T - (corner * side).sum(1) for side in (first, second))
            area = np.where(a * c - b * b > 1e-12 * a * c, a * c - b * b, -np.inf)
            u, v = (c * p - b * q) / area, (a * q - b * p) / area
            over = (u >= 0) & (v >= 0) & (u + v <= 1) & (area > 0)
            square = np.where(over, (corner**2).sum(1) - 2 * values @ corner.T - u * p - v * q, np.inf) - square[row, best][:, None]
            face = square.argmin(1)
            closer = np.flatnonzero(square[row, face] < 0)
            which[closer, :3], weights[closer, 1] = self.faces[face[closer]], u[closer, face[closer]]
            weights[closer, 2] = v[closer, face[closer]]
        weights[:, 0] = 1 - weights[:, 1] - weights[:, 2]
        return which, weights


def indices(
    texels: npt.NDArray[Any], light: Callable[[npt.NDArray[Any]], _Floats], colours: _Floats, thresholds: _Floats
) -> npt.NDArray[np.uint8]:
    """The index of each pixel's colour. Texels have shape (height, width, channels); light() converts them to the units of the
    colours; thresholds in [0, 1) are tiled over the image."""
    palette, found = _Palette(colours), np.empty(texels.shape[:2], np.uint8)
    columns, rows = np.arange(texels.shape[1]) % thresholds.shape[1], max(1, _PIXELS // texels.shape[1])
    for first in range(0, len(texels), rows):
        part = found[first : first + rows]
        flat = texels[first : first + rows].reshape(part.size, -1)
        same: Any = np.arange(part.size)
        if flat.dtype.kind == "u" and flat.shape[1] <= 4:  # mixes each colour once
            words = flat.astype(np.uint64) @ np.uint64(2**16) ** np.arange(flat.shape[1], dtype=np.uint64)
            _, kept, same = np.unique(words, return_index=True, return_inverse=True)
            flat = flat[kept]
        which, summed = palette.mix(light(flat))
        tiled = thresholds[np.ix_(np.arange(first, first + len(part)) % len(thresholds), columns)].reshape(-1, 1)
        part[:] = which[same, (summed[same, :3] <= tiled).sum(1)].reshape(part.shape)
    return found
