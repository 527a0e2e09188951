# SPDX-License-Identifier: Apache-2.0
"""The scenes of `scripts/bench correctness`: geometry in Python, written as OBJ and MTL for the path tracer and as
meshes and a dictionary for Mitsuba. y is up; faces are flat, with corners counter-clockwise as seen from outside.
"""

import dataclasses
import math

import numpy as np
from PIL import Image

TEXTURE_SIZE = 16


@dataclasses.dataclass(frozen=True)
class Material:
    """kind: "lambert", "textured", "glass" or "metal". GGX's alpha is the square of the roughness; 0 is smooth."""

    kind: str
    colour: tuple = (0.7, 0.7, 0.7)
    roughness: float = 0.0
    ior: float = 1.5

    def mtl(self):
        red, green, blue = self.colour
        if self.kind == "glass":
            pr = f"Pr {self.roughness}\n" if self.roughness else ""
            return f"illum 7\nNi {self.ior}\nTf 1 1 1\n{pr}"
        if self.kind == "metal":
            return f"Kd {red} {green} {blue}\nPm 1\nPr {self.roughness}\n"
        if self.kind == "textured":
            return "Kd 1 1 1\nmap_Kd texture.png\n"
        return f"Kd {red} {green} {blue}\n"

    def for_mitsuba(self, folder):
        alpha = self.roughness**2
        if self.kind == "glass":
            smooth = {"type": "dielectric", "int_ior": self.ior, "ext_ior": 1.0}
            return {**smooth, "type": "roughdielectric", "distribution": "ggx", "alpha": alpha} if alpha else smooth
        if self.kind == "metal":
            # Both use Schlick's Fresnel term with the base colour at normal incidence.
            return {"type": "principled", "base_color": {"type": "rgb", "value": list(self.colour)}, "metallic": 1.0,
                    "roughness": self.roughness}
        if self.kind == "textured":
            return {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": {
                "type": "bitmap", "filename": str(folder / "texture.png"), "filter_type": "bilinear"}}}
        return {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": list(self.colour)}}}


@dataclasses.dataclass(frozen=True)
class Part:
    faces: tuple  # each a tuple of corner points
    material: Material
    light: tuple | None = None  # emitted radiance, front side only
    coordinates: tuple = ((0, 0), (1, 0), (1, 1), (0, 1))  # texture coordinates at the corners of each quad


@dataclasses.dataclass(frozen=True)
class Scene:
    name: str
    summary: str
    parts: tuple
    camera: tuple = ((0, 1, 4.6), (0, 1, 0), 32)  # eye, target, vertical angle in degrees
    depth: int = 8  # maximum number of surfaces on a path
    rough: bool = False  # compared with single scattering between facets
    tolerance: float = 0.0  # accepted relative difference between the models


def quad(*corners):
    return tuple(tuple(map(float, corner)) for corner in corners)


def box(middle, half, turn=0.0):
    """Six faces of a cuboid, rotated about the vertical by `turn` degrees."""
    c, s = math.cos(math.radians(turn)), math.sin(math.radians(turn))

    def corner(x, y, z):
        x, z = x * half[0], z * half[2]
        return (middle[0] + c * x + s * z, middle[1] + y * half[1], middle[2] - s * x + c * z)

    sides = (((-1, -1, 1), (1, -1, 1), (1, 1, 1), (-1, 1, 1)), ((1, -1, -1), (-1, -1, -1), (-1, 1, -1), (1, 1, -1)),
             ((1, -1, 1), (1, -1, -1), (1, 1, -1), (1, 1, 1)), ((-1, -1, -1), (-1, -1, 1), (-1, 1, 1), (-1, 1, -1)),
             ((-1, 1, 1), (1, 1, 1), (1, 1, -1), (-1, 1, -1)), ((-1, -1, -1), (1, -1, -1), (1, -1, 1), (-1, -1, 1)))
    return tuple(tuple(corner(*point) for point in side) for side in sides)


def ball(middle, radius, splits=3):
    """A sphere: an octahedron whose triangles are split into four, `splits` times."""
    axes = np.eye(3)
    faces = [(sx * axes[0], sy * axes[1], sz * axes[2]) if sx * sy * sz > 0 else (sy * axes[1], sx * axes[0], sz * axes[2])
             for sx in (1, -1) for sy in (1, -1) for sz in (1, -1)]
    for _ in range(splits):
        split = []
        for a, b, c in faces:
            ab, bc, ca = ((p + q) / np.linalg.norm(p + q) for p, q in ((a, b), (b, c), (c, a)))
            split += [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
        faces = split
    return tuple(tuple(tuple(float(m + radius * x) for m, x in zip(middle, corner)) for corner in face) for face in faces)


def room(left=(0.6, 0.1, 0.08), right=(0.12, 0.42, 0.1), floor=None):
    """Five walls of a box 2 wide and high, open to the front."""
    white = Material("lambert", (0.72, 0.71, 0.68))
    return (Part((quad((-1, 0, 1), (1, 0, 1), (1, 0, -1), (-1, 0, -1)),), floor or white),
            Part((quad((-1, 0, -1), (1, 0, -1), (1, 2, -1), (-1, 2, -1)),), floor or white),
            Part((quad((-1, 2, -1), (1, 2, -1), (1, 2, 1), (-1, 2, 1)),), white),
            Part((quad((-1, 0, 1), (-1, 0, -1), (-1, 2, -1), (-1, 2, 1)),), Material("lambert", left)),
            Part((quad((1, 0, -1), (1, 0, 1), (1, 2, 1), (1, 2, -1)),), Material("lambert", right)))


def lamp(half, radiance, height=1.98):
    """A panel under the ceiling that emits downwards."""
    return Part((quad((-half, height, -half), (half, height, -half), (half, height, half), (-half, height, half)),),
                Material("lambert", (0.5, 0.5, 0.5)), radiance)


WHITE = Material("lambert", (0.72, 0.71, 0.68))
SCENES = (
    Scene("box", "a box with a small lamp and two blocks, Lambertian only", (
        *room(), lamp(0.25, (18, 13, 7)), Part(box((-0.35, 0.6, -0.3), (0.28, 0.6, 0.28), 18), WHITE),
        Part(box((0.4, 0.3, 0.3), (0.28, 0.3, 0.28), -17), WHITE))),
    Scene("texture", "walls with a bilinearly filtered colour texture", (
        *room(floor=Material("textured")), lamp(0.5, (6, 6, 6)))),
    Scene("glass", "a ball and a block of smooth glass under a large lamp", (
        *room(), lamp(0.8, (3, 3, 3)), Part(ball((-0.4, 0.5, 0.1), 0.4), Material("glass")),
        Part(box((0.45, 0.35, 0), (0.25, 0.34, 0.25), 30), Material("glass", ior=1.33))), depth=12),
    Scene("metal", "blocks and a ball of GGX metal, roughness 0.3, 0.5 and 0.4", (
        *room(), lamp(0.6, (5, 5, 5)),
        Part(box((-0.5, 0.45, -0.3), (0.3, 0.45, 0.3), 25), Material("metal", (0.95, 0.64, 0.54), 0.3)),
        Part(box((0.5, 0.3, -0.2), (0.3, 0.3, 0.3), -20), Material("metal", (0.9, 0.9, 0.9), 0.5)),
        Part(ball((0, 0.28, 0.5), 0.27), Material("metal", (1.0, 0.78, 0.34), 0.4))), rough=True, tolerance=0.003),
    Scene("rough-glass", "a ball and a block of GGX glass, roughness 0.3 and 0.5", (
        *room(), lamp(0.8, (3, 3, 3)), Part(ball((-0.4, 0.5, 0.1), 0.4), Material("glass", roughness=0.3)),
        Part(box((0.45, 0.35, 0), (0.25, 0.34, 0.25), 30), Material("glass", roughness=0.5))),
        depth=12, rough=True, tolerance=0.005),
)


def texture():
    """A random picture, without any symmetry."""
    rng = np.random.default_rng(7)
    return Image.fromarray(rng.integers(20, 236, (TEXTURE_SIZE, TEXTURE_SIZE, 3), dtype=np.uint8))


def write_obj(scene, folder, name="scene", with_materials=True):
    """Writes name.obj, and name.mtl and the texture if with_materials; returns the path of the OBJ."""
    lines, materials = ([f"mtllib {name}.mtl"] if with_materials else []), []
    vertices = coordinates = 0
    for i, part in enumerate(scene.parts):
        if with_materials:
            lines.append(f"usemtl m{i}")
            light = "Ke {} {} {}\n".format(*part.light) if part.light else ""
            materials.append(f"newmtl m{i}\n{part.material.mtl()}{light}")
        for face in part.faces:
            lines += [f"v {x!r} {y!r} {z!r}" for x, y, z in face]
            # Split quads, so that both renderers use the same triangles.
            own = part.coordinates[:len(face)]
            lines += [f"vt {u} {v}" for u, v in own]
            for corners in ((0, 1, 2), (0, 2, 3))[:len(face) - 2]:
                lines.append("f " + " ".join(f"{vertices + k + 1}/{coordinates + k + 1}" for k in corners))
            vertices, coordinates = vertices + len(face), coordinates + len(own)
    path = folder / f"{name}.obj"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    if with_materials:
        path.with_suffix(".mtl").write_text("\n".join(materials), encoding="utf-8")
        texture().save(folder / "texture.png")
    return path
