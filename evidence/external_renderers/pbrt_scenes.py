# SPDX-License-Identifier: Apache-2.0
"""Scenes for `scripts/bench pbrt` in pbrt-v4's format, and the crops to render.

Images are 1280x960 pixels. The film uses pbrt's neutral sensor (cie1931) and a box filter one pixel wide, so that a
pixel's samples contribute only to that pixel. z points up.
"""

import dataclasses
import hashlib
import math
from pathlib import Path

import numpy as np

from ..base.files import write_exr, write_text

WIDTH, HEIGHT = 1280, 960
CROP = (48, 48)
CROPS = 2
SKY = "sky.exr"
SKY_SIZE = 256


# ---- Text

def numbers(values):
    return "[ " + " ".join(f"{value:.6g}" for value in values) + " ]"


def inside(*lines):
    return "\n".join(("AttributeBegin", *lines, "AttributeEnd"))


SKY_LIGHT = f'LightSource "infinite" "string filename" "{SKY}"'


@dataclasses.dataclass(frozen=True)
class Scene:
    """eye, target, fov: camera. depth: bounces. more: further camera parameters. before: lines before the camera."""

    name: str
    what: str
    world: str
    eye: tuple
    target: tuple
    fov: float = 40
    depth: int = 5
    more: str = ""
    before: str = ""
    reference_spp: int = 2048

    def text(self, sampler):
        """The scene for pbrt; `sampler` is a sampler's line."""
        look = " ".join(f"{value:.6g}" for value in (*self.eye, *self.target, 0, 0, 1))
        return (f"{self.before}LookAt {look}\n"
                f'Camera "perspective" "float fov" {self.fov}{self.more}\n'
                f'Film "rgb" "integer xresolution" {WIDTH} "integer yresolution" {HEIGHT} "bool savefp16" false '
                '"string sensor" "cie1931"\n'
                'PixelFilter "box" "float xradius" 0.5 "float yradius" 0.5\n'
                f'Integrator "volpath" "integer maxdepth" {self.depth}\n'
                f"{sampler}\nWorldBegin\n{self.world}\n")


# ---- Our own scenes: for tests, and for an image in the guide

def of_file(name, *camera, **more):
    return Scene(name, "", (Path(__file__).parent / "scenes" / f"{name}.pbrt").read_text(encoding="utf-8"), *camera, **more)


OWN = {scene.name: scene for scene in (of_file("penumbra", (0, -5, 3.6), (0, -0.6, 0.2), reference_spp=4096),
                                       of_file("skin", (0, -4.6, 2.6), (0.1, -0.3, 0.45), depth=6))}


@dataclasses.dataclass(frozen=True)
class View:
    """A crop of a scene's image: [x0, x1) x [y0, y1)."""

    scene: str
    name: str
    x0: int
    y0: int
    size: tuple = CROP

    @property
    def bounds(self):
        """The bounds in pbrt's order."""
        return self.x0, self.x0 + self.size[0], self.y0, self.y0 + self.size[1]

    @property
    def label(self):
        return f"{self.scene} {self.name}"


def crops(scene):
    """The CROPS views of a scene, placed by a hash of their names."""
    views = []
    for k in range(CROPS):
        digest = hashlib.sha256(f"{scene.removesuffix('-fixed')} fresh {k}".encode()).digest()
        place = [int.from_bytes(digest[4 * i:4 * i + 4], "little") for i in range(2)]
        views.append(View(scene, f"crop {k + 1}", place[0] % (WIDTH - CROP[0]), place[1] % (HEIGHT - CROP[1])))
    return views


# ---- Files

def sphere_of_square(size):
    """The direction of each pixel of a square image light, (size, size, 3), by pbrt's equal-area octahedral mapping."""
    v, u = np.meshgrid(*(2 * (np.arange(size) + 0.5) / size - 1,) * 2, indexing="ij")
    a, b = np.abs(u), np.abs(v)
    signed = 1 - (a + b)
    r = 1 - np.abs(signed)
    phi = ((b - a) / np.maximum(r, 1e-9) + 1) * math.pi / 4
    side = r * np.sqrt(np.maximum(2 - r * r, 0))
    return np.stack([np.copysign(np.cos(phi), u) * side, np.copysign(np.sin(phi), v) * side, np.copysign(1 - r * r, signed)], -1)


def sky_image():
    """A pale sky with a broad sun and two bright panels, over dark ground."""
    d = sphere_of_square(SKY_SIZE)
    up = d[..., 2:]
    sky = np.where(up > 0, np.array([0.25, 0.4, 0.75]) + (1 - up) ** 3 * np.array([0.5, 0.35, 0.1]), np.array([0.12, 0.1, 0.08]))
    for direction, cosine, light in (((0.5, -0.6, 0.62), 0.992, (60, 52, 40)), ((-0.8, -0.3, 0.5), 0.95, (3, 4, 6)),
                                     ((0.1, 0.9, 0.4), 0.97, (7, 5, 3))):
        toward = d @ (np.array(direction) / np.linalg.norm(direction))
        sky = sky + np.clip((toward - cosine) / (1 - cosine) * 3, 0, 1)[..., None] * np.array(light)
    return sky.astype(np.float32)


def write_files(folder, scene, sampler, line):
    """Writes a scene with a sampler's line, and the image it may use. Returns the scene's path."""
    if SKY in scene.world and not (Path(folder) / SKY).exists():
        write_exr(Path(folder) / SKY, sky_image(), {})
    path = Path(folder) / f"{scene.name}-{sampler}.pbrt"
    write_text(path, scene.text(line))
    return path
