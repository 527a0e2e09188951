# SPDX-License-Identifier: Apache-2.0
"""The views used to compare samplers: crops of large images.

A small image mostly shows silhouettes, and each of its pixels covers many pixels of a full-size image. Samplers are therefore
compared on crops of images with 1280x960 pixels or more: one crop in each quarter, placed by a hash of the image's name before
anything is rendered. Each set contains one image of every scene, with its own crops and its own camera, which is the scene's
camera rotated, moved and zoomed. The scenes are the path tracer's built-in scenes and those of models.py.
"""

import dataclasses
import hashlib
import math
from pathlib import Path

from ..base.command import Parser, command_shown, core_count, names_of, parse_size
from ..samplers import variants
from . import models
from .renderer import Request, scene_label

BUILT_IN = ("cornell", "penumbra", "glossy", "lens", "glass", "interior", "motion", "fog")
SCENES = (*BUILT_IN, *models.MODELS)  # append new scenes: crop positions depend on the order

# Each scene's own camera, as `pathtracer --list-cameras` prints it: eye, target, vertical angle of view in degrees.
CAMERAS = {
    "cornell": ((278, 273, -800), (278, 273, 0), 39.30765),
    "penumbra": ((0.15, 2.3, 6), (0, 0.42, 0.1), 26.4491),
    "glossy": ((0, 2.4, 8), (0, 0.95, 0.9), 27.5326),
    "lens": ((0, 0.8, 4.2), (0, 0.33, 0), 25.90553),
    "glass": ((0, 1.45, 5), (0.02, 0.42, 0), 29.68445),
    "interior": ((1.9, 1.5, 2.6), (-0.5, 1.1, -1.6), 49.40486),
    "motion": ((0.1, 1.5, 6), (0, 0.93, 0), 25.360766),
    "fog": ((-0.6, 2, 8.8), (0, 1.2, 0), 29.684453),
    **dict.fromkeys(models.MODELS, models.CAMERA),
}
# Exposure of a scene's displayed image, in stops.
EXPOSURES = {"cornell": 1.0, "interior": 1.0}

# cornell shows a square box.
LARGE_SIZE, LARGE_SIZES = (1280, 960), {"cornell": (1280, 1280)}
CROP, QUICK_CROP = (64, 48), (48, 36)
SEEDS, REFERENCE_SPP = 4, 1024
TURN, SHIFT, ZOOM = 6.0, 0.04, 0.12  # maxima: degrees, fraction of the distance to the target, fraction of the angle of view


@dataclasses.dataclass(frozen=True)
class View:
    """A scene seen by one camera at one image size."""

    file: str  # or the name of a built-in scene
    name: str
    width: int
    height: int
    camera: tuple = ()  # options of the path tracer
    exposure: float = 0.0  # of the displayed image, in stops
    crop: tuple = ()  # x0, y0, x1, y1 in pixels, half-open; empty: the whole image
    lights: tuple = ()  # options of the path tracer that do not change the expected image

    @property
    def scene(self):
        return scene_label(self.file)

    @property
    def size(self):
        """(width, height) of the rendered crop or image, in pixels."""
        if self.crop:
            return self.crop[2] - self.crop[0], self.crop[3] - self.crop[1]
        return self.width, self.height

    @property
    def pixels(self):
        return self.size[0] * self.size[1]

    @property
    def label(self):
        return f"{self.scene} {self.name}".strip()

    @property
    def picture(self):
        """Identifies the image: the same for all its crops."""
        return self.scene, self.width, self.height, self.camera

    @property
    def options(self):
        return (*self.camera, *(("--crop", ",".join(map(str, self.crop))) if self.crop else ()), *self.lights)

    @property
    def key(self):
        """Everything that the pixels depend on, as a cache key."""
        return [self.file, (self.width, self.height), self.options]

    def request(self, sampler, spp, seed=0):
        return Request(variants.program_name(sampler), spp, seed, self.file, self.width, self.height, more=self.options,
                       declared=spp if variants.is_tuned(sampler) else 0)


def golden_powers(count):
    """The increments of a low-discrepancy sequence with `count` dimensions: the golden ratio for one, R2 for two, and generalisations for
    more (M. Roberts, "The Unreasonable Effectiveness of Quasirandom Sequences", 2018)."""
    root = 2.0
    for _ in range(40):
        root = (1 + root) ** (1 / (count + 1))
    return [root ** -(i + 1) for i in range(count)]


def _camera(scene, index):
    """Camera options for the scene's camera after rotating, shifting and zooming it."""
    (eye, target, fov) = CAMERAS[scene]
    yaw, pitch, side, up, zoom = (2 * ((0.5 + (index + 1) * step) % 1) - 1 for step in golden_powers(5))
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


def crops_of(view, size=CROP):
    """The four crops of an image, one in each quarter."""
    wide, high = view.width // 2, view.height // 2
    if size[0] > wide or size[1] > high:
        raise ValueError(f"crops of {size[0]}x{size[1]} pixels do not fit into the quarters of an image of "
                         f"{view.width}x{view.height}")
    found = []
    for i in range(4):
        digest = hashlib.sha256(f"{view.scene} {view.camera} {i}".encode()).digest()
        x = i % 2 * wide + int.from_bytes(digest[:8], "big") % (wide - size[0] + 1)
        y = i // 2 * high + int.from_bytes(digest[8:16], "big") % (high - size[1] + 1)
        found.append(dataclasses.replace(view, name=f"{view.name}-{i + 1}".strip("-"), crop=(x, y, x + size[0], y + size[1])))
    return found


SETS = {"development": (1000, "used while the sampler was developed"), "held-out": (2000, "never used for tuning, decisions or illustrations")}
SHOWN = "held-out"  # the set whose figures are in evidence/results


def crops(name=SHOWN, scenes=SCENES, size=None, crop=CROP):
    """The crops of a set's large images. size: (width, height) that replaces the images' own sizes."""
    found = []
    for scene in scenes:
        own = ("--env", "none" if models.MODELS[scene][2] else "sky") if scene in models.MODELS else ()
        file = models.scene(scene) if own else scene
        camera = _camera(scene, SETS[name][0] + SCENES.index(scene))
        found += crops_of(View(file, name, *(size or LARGE_SIZES.get(scene, LARGE_SIZE)), (*camera, *own), EXPOSURES.get(scene, 0.0)), crop)
    return tuple(found)


def parse_options(command, text, arguments, counts, choose=True, **defaults):
    """The options of `renders` and `denoise`, with views, labels, counts and command. choose: whether --samplers is an option. Trials and
    sets other than SHOWN go to out."""
    parser = Parser(command, text)
    parser.add_argument("--views", choices=SETS, default=SHOWN, metavar="SET", help=(
        "; ".join(f"{name}: {what}" for name, (_, what) in SETS.items()) + f" (default {SHOWN})"))
    parser.add_argument("--scenes", type=names_of("scene", SCENES), metavar="A,B,...",
                        help=f"scenes from {', '.join(SCENES)} (default all; with --quick those without third-party models)")
    parser.add_argument("--size", type=parse_size, metavar="WxH", help="one size for all images, for trials (default "
                        f"{LARGE_SIZE[0]}x{LARGE_SIZE[1]} or more)")
    parser.add_argument("--crop", type=parse_size, metavar="WxH",
                        help=f"size of the crops, four per image (default {CROP[0]}x{CROP[1]})")
    parser.add_argument("--quick", action="store_true", help=f"crops of {QUICK_CROP[0]}x{QUICK_CROP[1]} pixels, with "
                        "figures written only to out/")
    if choose:
        parser.add_argument("--samplers", type=names_of("sampler", variants.OWN), default=variants.OWN, metavar="A,B,...",
                            help=f"samplers from {', '.join(variants.OWN)}; {', '.join(variants.ALWAYS)} are always included")
    parser.number("--spp", max(counts), f"largest sample count, at most {max(counts)}")
    parser.number("--seeds", SEEDS, "number of seeds per image")
    parser.number("--reference-spp", REFERENCE_SPP, "samples per pixel of the references, a multiple of 32")
    parser.number("--jobs", core_count(), "number of single-threaded renders to run in parallel", ": one per core")
    parser.add_argument("--out", type=Path, help="folder for the report (default evidence/results; out for trials)")
    parser.pathtracer()
    parser.set_defaults(**defaults)
    options = parser.parse_args(arguments)
    options.scenes = options.scenes or (BUILT_IN if options.quick else SCENES)
    if options.reference_spp % 32:
        parser.error(f"--reference-spp must be a multiple of 32, not {options.reference_spp}")
    try:
        options.chosen = crops(options.views, options.scenes, options.size, options.crop or (QUICK_CROP if options.quick else CROP))
    except ValueError as error:
        parser.error(str(error))
    options.out = options.out or Path(f"out/{command}" if options.quick or options.sampler or options.views != SHOWN else "evidence/results")
    options.labels = variants.chosen(options.samplers, options)
    options.counts = tuple(spp for spp in counts if spp <= options.spp)
    options.command = command_shown(command, arguments)
    return options
