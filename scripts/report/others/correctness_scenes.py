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
    built_in: str | None = None  # the path tracer's scene of this name, which the parts repeat, instead of an OBJ
    fog: object = None  # a Fog that surrounds the parts


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


def fog_parts():
    """The pergola of the path tracer's scene `fog`, from the same numbers."""
    stone, ground, black = Material("lambert", (0.42, 0.38, 0.33)), Material("lambert", (0.28, 0.26, 0.24)), Material("lambert", (0.02,) * 3)
    boxes = []
    for z in (-1.6, 1.2):
        for i in range(4):
            x = -2.55 + 1.7 * i
            boxes += [box((x, 1.2, z), (0.11, 1.2, 0.11)), box((x, 0.07, z), (0.19, 0.07, 0.19))]
        boxes.append(box((0, 2.5, z), (2.9, 0.1, 0.12)))
    boxes += [box((-2.72 + 0.68 * i, 2.66, -0.2), (0.16, 0.06, 1.9)) for i in range(9)]

    def lamp_towards(radiance, middle, target, side):
        middle, target = np.array(middle, float), np.array(target, float)
        normal = (target - middle) / np.linalg.norm(target - middle)
        x = np.cross((0, 1, 0), normal)
        x *= 0.5 * side / np.linalg.norm(x)
        y = np.cross(normal, x)
        return Part((quad(middle - x - y, middle + x - y, middle + x + y, middle - x + y),), black, radiance)

    return (Part((quad((-40, 0, 40), (40, 0, 40), (40, 0, -40), (-40, 0, -40)),), ground),
            *(Part(faces, stone) for faces in boxes),
            lamp_towards((1700, 950, 400), (-4.2, 7.6, -6.5), (0.2, 0.8, 0), 0.7),
            lamp_towards((80, 150, 270), (6.8, 5.6, 0.8), (0, 0.8, 0.4), 0.8))


@dataclasses.dataclass(frozen=True)
class Fog:
    """The medium of the scene `fog`: a box of cells, linear between their middles."""

    low: tuple = (-6, -0.1, -6)
    high: tuple = (6, 4.4, 6)
    size: tuple = (96, 40, 96)
    albedo: tuple = (0.92, 0.94, 0.96)
    anisotropy: float = 0.5

    def density(self):
        """At the middles of the cells: (z, y, x)."""
        axes = [low + (high - low) * (np.arange(count) + 0.5) / count for low, high, count in zip(self.low, self.high, self.size)]
        z, y, x = np.meshgrid(axes[2], axes[1], axes[0], indexing="ij")
        sin = np.sin
        qx = x + 0.9 * sin(1.1 * z + 0.5) + 0.4 * sin(2.3 * y)
        qy = 1.6 * y + 0.5 * sin(1.3 * x + 0.7 * z)
        qz = z + 0.8 * sin(0.9 * x - 0.4) + 0.4 * sin(1.9 * y + 1)
        waves = (sin(1.3 * qx + 0.3) * sin(1.5 * qy) * sin(1.2 * qz) + 0.5 * sin(2.9 * qx + qz) * sin(3.1 * qz - qy + 1)
                 + 0.25 * sin(6.1 * qy + qx) * sin(5.7 * qz + 2.1 * qx))
        return 0.16 * np.maximum(0.45 + 0.7 * waves, 0.04) * np.exp(-np.maximum(y, 0) / 1.8) + 0.012

    def for_mitsuba(self, mitsuba):
        """A box whose inside is the medium."""
        transform = mitsuba.ScalarTransform4f()
        size = [high - low for low, high in zip(self.low, self.high)]
        grid = {"type": "gridvolume", "grid": mitsuba.VolumeGrid(self.density()[..., None].astype(np.float32)),
                "to_world": transform.translate(list(self.low)).scale(size)}
        medium = {"type": "heterogeneous", "sigma_t": grid, "phase": {"type": "hg", "g": self.anisotropy},
                  "albedo": {"type": "constvolume", "value": {"type": "rgb", "value": list(self.albedo)}}}
        middle = [(low + high) / 2 for low, high in zip(self.low, self.high)]
        return {"type": "cube", "to_world": transform.translate(middle).scale([side / 2 for side in size]),
                "bsdf": {"type": "null"}, "interior": medium}


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
    Scene("fog", "the path tracer's own scene `fog`: a medium of varying density, two lamps", fog_parts(),
          ((-0.6, 2, 8.8), (0, 1.2, 0), 29.684453), built_in="fog", fog=Fog()),
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
