# SPDX-License-Identifier: Apache-2.0
"""The scenes of `scripts/bench pbrt`, in the format of pbrt-v4, and the crops of them that are rendered.

Pictures have 1280x960 pixels. The film has pbrt's neutral sensor (cie1931) and a box filter one pixel wide, so that the
samples of a pixel count for that pixel only. z points up.
"""

import dataclasses
import hashlib
import math
import random
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


def shape(kind, **parameters):
    return f'Shape "{kind}"' + "".join(f' "{name.replace("_", " ", 1)}" {numbers(value)}' for name, value in parameters.items())


def inside(*lines):
    return "\n".join(("AttributeBegin", *lines, "AttributeEnd"))


def translate(x, y, z):
    return f"Translate {x:.6g} {y:.6g} {z:.6g}"


def sphere(x, y, z, radius, *lines):
    return inside(*lines, translate(x, y, z), shape("sphere", float_radius=[radius]))


def patch(corner, u, v):
    """A parallelogram whose front looks along u x v."""
    points = [corner[i] + a * u[i] + b * v[i] for b in (0, 1) for a in (0, 1) for i in range(3)]
    return shape("bilinearmesh", point3_P=points)


def lamp(corner, u, v, radiance):
    return inside(f'AreaLightSource "diffuse" "rgb L" {numbers(radiance)}', patch(corner, u, v))


def block(low, high, turn=0.0):
    """A box that stands on low[2], turned by degrees about its own vertical axis."""
    middle, half = [(a + b) / 2 for a, b in zip(low, high)], [(b - a) / 2 for a, b in zip(low, high)]
    x, y, z = half
    points = [s * c for k in (-z, z) for j in (-y, y) for i in (-x, x) for s, c in ((1, i), (1, j), (1, k))]
    faces = (0, 2, 1, 3, 4, 5, 6, 7, 0, 1, 4, 5, 2, 6, 3, 7, 0, 4, 2, 6, 1, 3, 5, 7)
    return inside(translate(*middle), f"Rotate {turn:.6g} 0 0 1", shape("bilinearmesh", integer_indices=faces, point3_P=points))


def diffuse(*rgb):
    return f'Material "diffuse" "rgb reflectance" {numbers(rgb)}'


def metal(name, roughness):
    return (f'Material "conductor" "spectrum eta" "metal-{name}-eta" "spectrum k" "metal-{name}-k" "float roughness" '
            f"{numbers([roughness])}")


def checkered(name, scale, one, two):
    """Defines a texture and a diffuse material of it."""
    return (f'Texture "{name}" "spectrum" "checkerboard" "float uscale" {scale} "float vscale" {scale} '
            f'"rgb tex1" {numbers(one)} "rgb tex2" {numbers(two)}\n'
            f'Material "diffuse" "texture reflectance" "{name}"')


def floor(size=20.0):
    return patch((-size, -size, 0), (2 * size, 0, 0), (0, 2 * size, 0))


SKY_LIGHT = f'LightSource "infinite" "string filename" "{SKY}"'


@dataclasses.dataclass(frozen=True)
class Scene:
    """eye, target, fov: of the camera. depth: bounces. more: parameters of the camera, before: lines before it."""

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


# ---- Scenes

def penumbra():
    bars = [block((x, -1.6 + 0.2 * (i % 3), 0.9), (x + 0.09, 1.8, 1.0 + 0.1 * (i % 2)), 7 * i)
            for i, x in enumerate(np.arange(-2.4, 2.5, 0.42))]
    return Scene("penumbra", "soft shadows of bars and balls", "\n".join((
        lamp((-0.7, -0.7, 4), (0, 1.4, 0), (1.4, 0, 0), (26, 24, 20)),
        lamp((4, -3, 2), (0, 1, 0), (0, 0, 1), (5, 7, 10)),
        inside(diffuse(0.72, 0.7, 0.66), floor()), inside(diffuse(0.6, 0.25, 0.15), *bars),
        sphere(-1.6, -2, 0.45, 0.45, diffuse(0.2, 0.45, 0.65)), sphere(1.2, -2.3, 0.35, 0.35, diffuse(0.75, 0.6, 0.15)))),
        (0, -5, 3.6), (0, -0.6, 0.2), reference_spp=4096)


def depth():
    pick = random.Random("depth")
    balls = [sphere(x + pick.uniform(-0.2, 0.2), y, 0.22, 0.22, diffuse(*(pick.uniform(0.1, 0.8) for _ in range(3))))
             for y in np.arange(-3, 7, 0.8) for x in np.arange(-3.2, 3.3, 0.8)]
    return Scene("depth", "depth of field", "\n".join((
        'LightSource "infinite" "rgb L" [ 0.25 0.3 0.4 ]', lamp((-1, -1, 6), (0, 2, 0), (2, 0, 0), (22, 20, 17)),
        inside(checkered("tiles", 60, (0.7, 0.7, 0.65), (0.15, 0.16, 0.2)), floor()), *balls)),
        (0, -5.5, 2.2), (0, -0.9, 0), 42, more=' "float lensradius" 0.12 "float focaldistance" 5.6', reference_spp=4096)


def metals():
    return Scene("metal", "glossy metal under an image", "\n".join((
        SKY_LIGHT, inside('Material "coateddiffuse" "float roughness" 0.15 "rgb reflectance" [ 0.3 0.25 0.2 ]', floor()),
        sphere(-1.5, 0, 0.8, 0.8, metal("Cu", 0.02)), sphere(0.3, 0.5, 0.8, 0.8, metal("Au", 0.15)),
        sphere(1.9, -0.2, 0.7, 0.7, metal("Al", 0.05)),
        inside(metal("Ag", 0.25), translate(0, -1.3, 0.35), "Rotate 90 0 1 0",
               shape("cylinder", float_radius=[0.35], float_zmin=[-1], float_zmax=[1])))), (0, -5, 3.2), (0.1, -0.1, 0.45), reference_spp=4096)


def motion():
    moves = []
    for i, x in enumerate(np.arange(-2.7, 2.8, 0.9)):
        start, end = (x, 0.5 * (i % 3), 0.5), (x + 0.5, 0.5 * (i % 3) - 0.3, 0.5 + 0.5 * (i % 2))
        moves.append(inside(
            "ActiveTransform StartTime", translate(*start), "ActiveTransform EndTime", translate(*end), "ActiveTransform All",
            f"Rotate {40 * i} 0.3 0.5 1", diffuse(*((0.7, 0.25, 0.1), (0.15, 0.5, 0.6), (0.75, 0.7, 0.6))[i % 3]),
            shape("sphere", float_radius=[0.42]) if i % 2 else
            shape("bilinearmesh", integer_indices=(0, 1, 2, 3), point3_P=(-0.5, -0.4, 0, 0.5, -0.4, 0, -0.5, 0.4, 0.1, 0.5, 0.4, 0))))
    return Scene("motion", "motion blur", "\n".join((
        lamp((-1, -2, 4), (0, 2, 0), (2, 0, 0), (9, 8.4, 7.5)), 'LightSource "infinite" "rgb L" [ 0.2 0.24 0.3 ]',
        inside(checkered("tiles", 50, (0.65, 0.65, 0.6), (0.2, 0.2, 0.24)), floor()), *moves)),
        (0, -5, 3), (0.2, 0, 0.3), more=' "float shutteropen" 0 "float shutterclose" 1', reference_spp=4096)


def skin():
    def flesh(reflectance, mfp):
        return (f'Material "subsurface" "rgb reflectance" {numbers(reflectance)} "rgb mfp" {numbers(mfp)} "float roughness" 0.3 '
                '"float eta" 1.33')
    return Scene("skin", "light below surfaces", "\n".join((
        lamp((-2.5, -2, 3), (0, 1.6, 0), (1.6, 0, 0.4), (11, 10, 9)), lamp((1.6, 2, 1.5), (1, -0.4, 0), (0, 0, 1), (8, 9, 12)),
        'LightSource "infinite" "rgb L" [ 0.12 0.13 0.15 ]', inside(diffuse(0.45, 0.43, 0.4), floor()),
        sphere(-1.2, 0, 0.8, 0.8, flesh((0.75, 0.5, 0.4), (0.3, 0.12, 0.07))),
        sphere(0.6, 0.3, 0.8, 0.8, flesh((0.8, 0.85, 0.8), (0.06, 0.08, 0.07))),
        inside(flesh((0.4, 0.65, 0.35), (0.1, 0.2, 0.1)), block((0.9, -1.5, 0), (1.7, -0.7, 0.8), 30),
               block((-1, -1.9, 0), (0.1, -1.3, 0.25), -10)))), (0, -4.6, 2.6), (0.1, -0.3, 0.45), depth=6)


def hair():
    pick, strands = random.Random("hair"), []
    for _ in range(5000):
        z, angle = pick.uniform(-0.2, 1), pick.uniform(0, 2 * math.pi)
        r = math.sqrt(1 - z * z)
        x, y = r * math.cos(angle), r * math.sin(angle)
        side, fall = pick.uniform(-0.25, 0.25), pick.uniform(0.3, 0.7)
        points = [k for t in (0, 1 / 3, 2 / 3, 1) for k in (
            x * (1 + 0.5 * t) - y * side * t, y * (1 + 0.5 * t) + x * side * t, z * (1 + 0.5 * t) - fall * t * t)]
        strands.append(shape("curve", point3_P=points, float_width0=[0.012], float_width1=[0.003]))
    return Scene("hair", "hair", "\n".join((
        lamp((-3, -2, 3), (0, 1.5, 0), (1.5, 0, 0.6), (14, 13, 12)), lamp((2, 1, 2), (1, -1, 0), (0, 0, 1.5), (8, 9, 12)),
        'LightSource "infinite" "rgb L" [ 0.25 0.27 0.3 ]', inside(diffuse(0.5, 0.48, 0.45), "Translate 0 0 -1.2", floor()),
        sphere(0, 0, 0, 0.99, diffuse(0.35, 0.2, 0.13)),
        inside('Material "hair" "float eumelanin" 0.8 "float beta_m" 0.25 "float beta_n" 0.3', *strands))),
        (0, -4, 1.4), (0, 0, 0.1), 38, depth=6)


def room():
    leaves = []
    pick = random.Random("room")
    for _ in range(160):
        x, z, turn = pick.uniform(-1.3, 1.3), pick.uniform(0.8, 2.5), pick.uniform(-50, 50)
        leaves.append(inside(translate(x, 2.6 + pick.uniform(0, 0.6), z), f"Rotate {turn:.3g} 1 1 0", shape("disk", float_radius=[0.11])))
    return Scene("room", "room behind a window with leaves", "\n".join((
        lamp((-2, 4.2, 0.4), (4, 0, 0), (0, 0, 3), (30, 32, 34)),
        inside(checkered("tiles", 8, (0.6, 0.5, 0.38), (0.42, 0.3, 0.2)), patch((-3, -4, 0), (6, 0, 0), (0, 6, 0))),
        inside(diffuse(0.7, 0.68, 0.62), patch((-3, -4, 3), (0, 6, 0), (6, 0, 0)), patch((-3, -4, 0), (6, 0, 0), (0, 0, 3)),
               patch((-3, 2, 0), (1.7, 0, 0), (0, 0, 3)), patch((1.3, 2, 0), (1.7, 0, 0), (0, 0, 3)),
               patch((-1.3, 2, 0), (2.6, 0, 0), (0, 0, 0.7)), patch((-1.3, 2, 2.6), (2.6, 0, 0), (0, 0, 0.4))),
        inside(diffuse(0.55, 0.2, 0.12), patch((-3, -4, 0), (0, 6, 0), (0, 0, 3))),
        inside(diffuse(0.25, 0.4, 0.5), patch((3, -4, 0), (0, 0, 3), (0, 6, 0))),
        inside(diffuse(0.2, 0.4, 0.1), *leaves),
        inside('Material "coateddiffuse" "float roughness" 0.2 "rgb reflectance" [ 0.35 0.2 0.1 ]',
               block((-1.8, -0.6, 0.65), (0.2, 0.6, 0.75), 12), block((-1.7, -0.5, 0), (-1.6, -0.4, 0.65)), block((0, 0.3, 0), (0.1, 0.4, 0.65))),
        sphere(-0.8, 0, 1.05, 0.3, diffuse(0.75, 0.75, 0.7)), sphere(1.6, 0.5, 0.5, 0.5, metal("Cu", 0.2)))),
        (0.6, -3.7, 1.6), (-0.1, 1, 1.1), 60, depth=8)


# Nothing was chosen or tuned on these, but on others.
SCENES = {scene.name: scene for scene in (penumbra(), depth(), metals(), skin(), hair(), room())}
PROBES = (motion(), SCENES["skin"], SCENES["room"])  # between them they draw all that a path can draw


@dataclasses.dataclass(frozen=True)
class View:
    """A crop of a scene's picture, [x0, x1) x [y0, y1)."""

    scene: str
    name: str
    x0: int
    y0: int
    size: tuple = CROP

    @property
    def bounds(self):
        """As pbrt wants them."""
        return self.x0, self.x0 + self.size[0], self.y0, self.y0 + self.size[1]

    @property
    def label(self):
        return f"{self.scene} {self.name}"


def crops(scene, purpose):
    """The CROPS views of a scene. A hash of their names places them. purpose: "fresh", as no other was left."""
    views = []
    for k in range(CROPS):
        digest = hashlib.sha256(f"{scene.removesuffix('-fixed')} {purpose} {k}".encode()).digest()
        place = [int.from_bytes(digest[4 * i:4 * i + 4], "little") for i in range(2)]
        views.append(View(scene, f"{purpose} {'abcdefgh'[k]}", place[0] % (WIDTH - CROP[0]), place[1] % (HEIGHT - CROP[1])))
    return views


# ---- Files

def sphere_of_square(size):
    """The direction of each pixel of a square image light, (size, size, 3): pbrt's equal-area octahedral mapping."""
    v, u = np.meshgrid(*(2 * (np.arange(size) + 0.5) / size - 1,) * 2, indexing="ij")
    a, b = np.abs(u), np.abs(v)
    signed = 1 - (a + b)
    r = 1 - np.abs(signed)
    phi = ((b - a) / np.maximum(r, 1e-9) + 1) * math.pi / 4
    side = r * np.sqrt(np.maximum(2 - r * r, 0))
    return np.stack([np.copysign(np.cos(phi), u) * side, np.copysign(np.sin(phi), v) * side, np.copysign(1 - r * r, signed)], -1)


def sky_image():
    """A pale sky over dark ground, a broad sun and two bright panels."""
    d = sphere_of_square(SKY_SIZE)
    up = d[..., 2:]
    sky = np.where(up > 0, np.array([0.25, 0.4, 0.75]) + (1 - up) ** 3 * np.array([0.5, 0.35, 0.1]), np.array([0.12, 0.1, 0.08]))
    for direction, cosine, light in (((0.5, -0.6, 0.62), 0.992, (60, 52, 40)), ((-0.8, -0.3, 0.5), 0.95, (3, 4, 6)),
                                     ((0.1, 0.9, 0.4), 0.97, (7, 5, 3))):
        toward = d @ (np.array(direction) / np.linalg.norm(direction))
        sky = sky + np.clip((toward - cosine) / (1 - cosine) * 3, 0, 1)[..., None] * np.array(light)
    return sky.astype(np.float32)


def write_files(folder, scene, sampler, line):
    """Writes a scene with a sampler's line, and the image it may use; returns the path of the scene."""
    if SKY in scene.world and not (Path(folder) / SKY).exists():
        write_exr(Path(folder) / SKY, sky_image(), {})
    path = Path(folder) / f"{scene.name}-{sampler}.pbrt"
    write_text(path, scene.text(line))
    return path
