# SPDX-License-Identifier: Apache-2.0
"""The views used to compare samplers: eight of every built-in scene.

The gain of blue noise along an edge depends on how the edge is aligned with the pixel grid, and so on the picture size:
a single size of a single scene proves nothing. The sizes here have no common factor within a view or across the views of
a scene, and each view rotates, moves and zooms the camera slightly, so that no edge stays in place.
"""

import argparse
import dataclasses
import math
from pathlib import Path

from .renderer import Request

DIRECT = ("cornell", "penumbra", "glossy", "lens")  # mostly direct lighting
SCENES = (*DIRECT, "glass", "interior")

# Each scene's own camera, as `pathtracer --list-cameras` prints it: eye, target, vertical angle of view in degrees.
CAMERAS = {
    "cornell": ((278, 273, -800), (278, 273, 0), 39.30765),
    "penumbra": ((0.15, 2.3, 6), (0, 0.42, 0.1), 26.4491),
    "glossy": ((0, 2.4, 8), (0, 0.95, 0.9), 27.5326),
    "lens": ((0, 0.8, 4.2), (0, 0.33, 0), 25.90553),
    "glass": ((0, 1.45, 5), (0.02, 0.42, 0), 29.68445),
    "interior": ((1.9, 1.5, 2.6), (-0.5, 1.1, -1.6), 49.40486),
}
# Exposure of a scene's displayed picture, in stops.
EXPOSURES = {"cornell": 1.0, "interior": 1.0}

# Pairwise coprime. Small, because cost grows with pixels; each scene also gets one large picture.
SIZES = (121, 125, 127, 128, 131, 137, 139, 149, 151, 157, 163, 167, 169, 173)
LARGE = ((397, 269), (389, 271), (383, 277), (379, 281), (373, 283), (367, 293))
NAMES = "abcdefgh"
CORE, HELD_OUT = "ab", "fgh"
TURN, SHIFT, ZOOM = 3.0, 0.02, 0.06  # degrees, share of the distance to the target, share of the angle of view


@dataclasses.dataclass(frozen=True)
class View:
    """A built-in scene or a file, seen by one camera at one size."""

    scene: str
    name: str
    width: int
    height: int
    camera: tuple = ()  # options of the path tracer
    exposure: float | None = None  # of the displayed picture, in stops; None: chosen by the path tracer for the reference
    core: bool = False
    held_out: bool = False  # never used to choose or tune anything

    @property
    def size(self):
        return self.width, self.height

    @property
    def pixels(self):
        return self.width * self.height

    @property
    def label(self):
        return f"{Path(self.scene).stem} {self.name}".strip()

    def request(self, sampler, spp, seed=0, **more):
        return Request(sampler, spp, seed, self.scene, self.width, self.height, more=self.camera, **more)


def _matching(round_number):
    """Pairs of SIZES as in one round of a round-robin tournament: no pair occurs in two rounds."""
    count = len(SIZES) - 1
    ring = [(round_number + i) % count for i in range(count)]
    pairs = [(ring[0], count), *((ring[i], ring[count - i]) for i in range(1, len(SIZES) // 2))]
    # Alternate portrait and landscape.
    return [(SIZES[a], SIZES[b]) if (SIZES[a] > SIZES[b]) == (i % 2 == 0) else (SIZES[b], SIZES[a]) for i, (a, b) in enumerate(pairs)]


def _spread(index, count):
    """A low-discrepancy sequence in [-1, 1]: multiples of powers of the generalised golden ratio."""
    root = 2.0
    for _ in range(40):
        root = (1 + root) ** (1 / (count + 1))
    return [2 * ((0.5 + (index + 1) * root ** -(i + 1)) % 1) - 1 for i in range(count)]


def _camera(scene, index):
    """Options for the scene's camera, rotated, shifted and zoomed."""
    (eye, target, fov) = CAMERAS[scene]
    yaw, pitch, side, up, zoom = _spread(index, 5)
    forward = [b - a for a, b in zip(eye, target)]
    distance = math.hypot(*forward)
    level = math.hypot(forward[0], forward[2])
    azimuth = math.atan2(forward[0], forward[2]) + math.radians(TURN * yaw)
    elevation = math.atan2(forward[1], level) + math.radians(TURN * pitch / 2)
    across = (-forward[2] / level, 0, forward[0] / level)
    eye = [e + SHIFT * distance * (side * a + up * u) for e, a, u in zip(eye, across, (0, 1, 0))]
    turned = (math.sin(azimuth) * math.cos(elevation), math.sin(elevation), math.cos(azimuth) * math.cos(elevation))
    target = [e + distance * t for e, t in zip(eye, turned)]

    def text(point):
        return ",".join(f"{value:.6g}" for value in point)

    return "--eye", text(eye), "--target", text(target), "--fov", f"{fov * (1 + ZOOM * zoom):.6g}"


def _views_of(scene):
    number = SCENES.index(scene)
    sizes = [*_matching(2 * number), LARGE[number]]
    return [View(scene, name, *size, _camera(scene, len(NAMES) * number + i), EXPOSURES.get(scene, 0.0),
                 name in CORE, name in HELD_OUT) for i, (name, size) in enumerate(zip(NAMES, sizes))]


ALL = tuple(view for scene in SCENES for view in _views_of(scene))
SETS = {
    "core": "two views of each scene",
    "tuning": "views that may be used to choose and tune",
    "held-out": "views that are never used to choose or tune",
    "all": "all views",
}


def chosen(name="core", scenes=SCENES, size=None):
    """The views of a set and of some scenes; size: (width, height) to use instead of their own."""
    wanted = {"core": lambda view: view.core, "tuning": lambda view: not view.held_out,
              "held-out": lambda view: view.held_out, "all": lambda view: True}[name]
    found = tuple(view for view in ALL if wanted(view) and view.scene in scenes)
    return tuple(dataclasses.replace(view, width=size[0], height=size[1]) for view in found) if size else found


def parse_scenes(text):
    names = [name for name in text.split(",") if name]
    unknown = [name for name in names if name not in SCENES]
    if unknown or not names:
        raise argparse.ArgumentTypeError(f"unknown scene '{', '.join(unknown)}'; choose from {', '.join(SCENES)}")
    return tuple(scene for scene in SCENES if scene in names)


def add_options(parser):
    """Adds --views, --all-views and --scenes; chosen(options.views, options.scenes) gives the views."""
    parser.add_argument("--views", choices=SETS, default="core", metavar="SET", help=(
        "; ".join(f"{name}: {what}" for name, what in SETS.items()) + " (default core)"))
    parser.add_argument("--all-views", dest="views", action="store_const", const="all", help="the same as --views all")
    parser.add_argument("--scenes", type=parse_scenes, default=SCENES, metavar="A,B,...",
                        help=f"scenes out of {', '.join(SCENES)} (default all)")
