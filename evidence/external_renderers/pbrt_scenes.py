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
from ..renders.views import View

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

def light(*colour):
    return f'AreaLightSource "diffuse" "rgb L" {numbers(colour)}'


def diffuse(*colour):
    return f'Material "diffuse" "rgb reflectance" {numbers(colour)}'


def subsurface(reflectance, mfp):
    return f'Material "subsurface" "rgb reflectance" {numbers(reflectance)} "rgb mfp" {numbers(mfp)} "float roughness" 0.3 "float eta" 1.33'


def patch(*points):
    return f'Shape "bilinearmesh" "point3 P" {numbers(points)}'


def sphere(radius, *centre):
    return "Translate {:g} {:g} {:g}\n".format(*centre) + f'Shape "sphere" "float radius" {numbers([radius])}'


def box(half, centre, turn):
    """An axis-aligned box of the given half widths, turned about the vertical axis."""
    corners = [sign * width for z in (-1, 1) for y in (-1, 1) for x in (-1, 1) for sign, width in zip((x, y, z), half)]
    return inside("Translate {:g} {:g} {:g}".format(*centre), f"Rotate {turn:g} 0 0 1",
                  'Shape "bilinearmesh" "integer indices" [ 0 2 1 3 4 5 6 7 0 1 4 5 2 6 3 7 0 4 2 6 1 3 5 7 ] ' + f'"point3 P" {numbers(corners)}')


FLOOR = patch(-20, -20, 0, 20, -20, 0, -20, 20, 0, 20, 20, 0)
# Soft shadows of bars and balls.
PENUMBRA = (
    inside(light(26, 24, 20), patch(-0.7, -0.7, 4, -0.7, 0.7, 4, 0.7, -0.7, 4, 0.7, 0.7, 4)),
    inside(light(5, 7, 10), patch(4, -3, 2, 4, -2, 2, 4, -3, 3, 4, -2, 3)),
    inside(diffuse(0.72, 0.7, 0.66), FLOOR),
    inside(diffuse(0.6, 0.25, 0.15), *(box((0.045, 1.7 - 0.1 * (i % 3), 0.05 + 0.05 * (i % 2)), (-2.355 + 0.42 * i, 0.1 + 0.1 * (i % 3), 0.95 + 0.05 * (i % 2)), 7 * i)
                                       for i in range(12))),
    inside(diffuse(0.2, 0.45, 0.65), sphere(0.45, -1.6, -2, 0.45)), inside(diffuse(0.75, 0.6, 0.15), sphere(0.35, 1.2, -2.3, 0.35)))
# Light below surfaces.
SKIN = (
    inside(light(11, 10, 9), patch(-2.5, -2, 3, -2.5, -0.4, 3, -0.9, -2, 3.4, -0.9, -0.4, 3.4)),
    inside(light(8, 9, 12), patch(1.6, 2, 1.5, 2.6, 1.6, 1.5, 1.6, 2, 2.5, 2.6, 1.6, 2.5)),
    'LightSource "infinite" "rgb L" [ 0.12 0.13 0.15 ]', inside(diffuse(0.45, 0.43, 0.4), FLOOR),
    inside(subsurface((0.75, 0.5, 0.4), (0.3, 0.12, 0.07)), sphere(0.8, -1.2, 0, 0.8)),
    inside(subsurface((0.8, 0.85, 0.8), (0.06, 0.08, 0.07)), sphere(0.8, 0.6, 0.3, 0.8)),
    inside(subsurface((0.4, 0.65, 0.35), (0.1, 0.2, 0.1)), box((0.4, 0.4, 0.4), (1.3, -1.1, 0.4), 30), box((0.55, 0.3, 0.125), (-0.45, -1.6, 0.125), -10)))
OWN = {scene.name: scene for scene in (Scene("penumbra", "", "\n".join(PENUMBRA), (0, -5, 3.6), (0, -0.6, 0.2), reference_spp=4096),
                                       Scene("skin", "", "\n".join(SKIN), (0, -4.6, 2.6), (0.1, -0.3, 0.45), depth=6))}


def view_of(scene, name, x, y, size=CROP):
    """A crop of a scene's image."""
    return View(scene, name, WIDTH, HEIGHT, crop=(x, y, x + size[0], y + size[1]))


def crops(scene):
    """The CROPS views of a scene, placed by a hash of their names."""
    views = []
    for k in range(CROPS):
        digest = hashlib.sha256(f"{scene.removesuffix('-fixed')} fresh {k}".encode()).digest()
        place = [int.from_bytes(digest[4 * i:4 * i + 4], "little") for i in range(2)]
        views.append(view_of(scene, f"crop {k + 1}", place[0] % (WIDTH - CROP[0]), place[1] % (HEIGHT - CROP[1])))
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
