# SPDX-License-Identifier: Apache-2.0
"""Places blue-noise points on a triangle mesh: white noise by area, then sample elimination.

    mesh_points.py -o points.png [--obj mesh.obj] [--count 2000]

Sample elimination starts with several times too many points and removes, again and again, the one that is most crowded
(Yuksel, "Sample elimination for generating Poisson disk sample sets", 2015). Distances are straight lines in space, so
sheets that lie closer together than the points influence each other. n log n, about a second for 2000 points.
"""

import argparse
import heapq

import numpy as np
from scipy.spatial import cKDTree

import bluenoise

CANDIDATES = 5  # for each point that stays


def white_points(vertices, triangles, count, seed):
    """Random points on a mesh, as many per area everywhere: (count, 3), and the triangle of each."""
    a, b, c = (vertices[triangles[:, i]] for i in range(3))
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    u = bluenoise.Sampler("white", seed=seed).block(0, 0, 1, 1, 0, count, 0)[0, 0].astype(float)
    chosen = np.minimum(np.searchsorted(np.cumsum(areas) / areas.sum(), u[:, 0], side="right"), len(triangles) - 1)
    # The square folded onto the triangle
    s, t = np.sqrt(u[:, 1:2]), u[:, 2:3]
    return (1 - s) * a[chosen] + s * (1 - t) * b[chosen] + s * t * c[chosen], chosen


def eliminate(points, count, area):
    """The indices of `count` of the points, evenly spread over a surface of this area."""
    # The largest distance that so many points can keep on a plane, twice: discs in a hexagonal lattice.
    reach = 2 * np.sqrt(area / (2 * np.sqrt(3) * count))
    pairs = cKDTree(points).query_pairs(reach, output_type="ndarray")
    weights = (1 - np.linalg.norm(points[pairs[:, 0]] - points[pairs[:, 1]], axis=1) / reach) ** 8
    neighbours = [[] for _ in points]
    for (i, j), weight in zip(pairs.tolist(), weights.tolist()):
        neighbours[i].append((j, weight))
        neighbours[j].append((i, weight))
    crowding = [sum(weight for _, weight in near) for near in neighbours]
    heap = [(-weight, i) for i, weight in enumerate(crowding)]
    heapq.heapify(heap)
    kept = np.ones(len(points), bool)
    left = len(points)
    while left > count:
        weight, i = heapq.heappop(heap)
        if not kept[i] or -weight != crowding[i]:
            continue  # out of date: the heap has another entry with today's weight
        kept[i] = False
        left -= 1
        for j, share in neighbours[i]:
            if kept[j]:
                crowding[j] -= share
                heapq.heappush(heap, (-crowding[j], j))
    return np.flatnonzero(kept)


def blue_points(vertices, triangles, count, seed=0):
    """Blue-noise points on a mesh: (count, 3), and the triangle of each."""
    points, chosen = white_points(vertices, triangles, CANDIDATES * count, seed)
    a, b, c = (vertices[triangles[:, i]] for i in range(3))
    kept = eliminate(points, count, np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)
    return points[kept], chosen[kept]


def pebble(rows=48, columns=96):
    """A bumpy ball whose triangles are small at the poles and large at the equator."""
    theta, phi = np.meshgrid(np.linspace(0, np.pi, rows + 1), np.arange(columns) * 2 * np.pi / columns, indexing="ij")
    radius = 1 + 0.12 * np.sin(3 * phi) * np.sin(theta) ** 3 + 0.1 * np.cos(4 * theta)
    vertices = np.stack([radius * np.sin(theta) * np.cos(phi), radius * np.cos(theta), radius * np.sin(theta) * np.sin(phi)], -1)
    i, j = np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij")
    corner = [(i + di) * columns + (j + dj) % columns for di, dj in ((0, 0), (1, 0), (1, 1), (0, 1))]
    triangles = np.concatenate([np.stack([corner[0], corner[2], corner[1]], -1), np.stack([corner[0], corner[3], corner[2]], -1)])
    return vertices.reshape(-1, 3), triangles.reshape(-1, 3)


def read_obj(path):
    """Vertices and triangles of an OBJ file; polygons become fans."""
    vertices, triangles = [], []
    with open(path, encoding="utf-8") as file:
        for words in map(str.split, file):
            if words[:1] == ["v"]:
                vertices.append([float(word) for word in words[1:4]])
            elif words[:1] == ["f"]:
                corners = [int(word.split("/")[0]) for word in words[1:]]
                corners = [i - 1 if i > 0 else len(vertices) + i for i in corners]
                triangles += [[corners[0], corners[i], corners[i + 1]] for i in range(1, len(corners) - 1)]
    return np.array(vertices), np.array(triangles)


def draw(vertices, triangles, sets, path):
    """The points that face the viewer, over the mesh, in a picture of one panel for each set {title: (points, chosen)}."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    from matplotlib.collections import PolyCollection

    angle = np.radians(28)
    turn = np.array([[1, 0, 0], [0, np.cos(angle), -np.sin(angle)], [0, np.sin(angle), np.cos(angle)]])
    corners = (vertices @ turn.T)[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    facing = normals[:, 2] / np.maximum(np.linalg.norm(normals, axis=1), 1e-30)
    shown = np.argsort(corners[:, :, 2].mean(1))
    shown = shown[facing[shown] > 0]
    grey = 0.72 + 0.22 * facing[shown]
    figure, axes = plt.subplots(1, len(sets), figsize=(9.6, 4.9))
    for axis, (title, (points, chosen)) in zip(axes, sets.items()):
        axis.add_collection(PolyCollection(corners[shown][:, :, :2], facecolors=np.stack([grey] * 3, 1), edgecolors="face",
                                           linewidth=0.3))
        front = (points @ turn.T)[facing[chosen] > 0]
        axis.plot(front[:, 0], front[:, 1], ".", color="#0050b0", markersize=3.5)
        axis.set(aspect="equal", title=title)
        axis.autoscale()
        axis.axis("off")
    figure.tight_layout()
    figure.savefig(path, dpi=80)
    try:
        from PIL import Image
    except ImportError:
        return
    Image.open(path).convert("RGB").quantize(32, dither=0).save(path)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", dest="output", required=True, metavar="FILE.png", help="the picture")
    parser.add_argument("--obj", help="a mesh to use instead of a bumpy ball")
    parser.add_argument("--count", type=int, default=2000, help="number of points (default 2000)")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    vertices, triangles = read_obj(options.obj) if options.obj else pebble()
    draw(vertices, triangles, {
        "white noise, by area": white_points(vertices, triangles, options.count, options.seed),
        "after sample elimination": blue_points(vertices, triangles, options.count, options.seed)}, options.output)


if __name__ == "__main__":
    main()
