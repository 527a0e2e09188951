# SPDX-License-Identifier: Apache-2.0
"""Writes small glTF and GLB files for the tests. Nothing is checked, so tests can also write invalid files."""

import base64
import io
import json
import struct

import numpy as np
import OpenEXR
import pytest
from PIL import Image

COMPONENT_TYPES = {"int8": 5120, "uint8": 5121, "int16": 5122, "uint16": 5123, "uint32": 5125, "float32": 5126}
QUAD = np.array([[-1, 0, 1], [1, 0, 1], [1, 0, -1], [-1, 0, -1]], np.float32)  # faces up
QUAD_COORDINATES = np.array([[0, 1], [1, 1], [1, 0], [0, 0]], np.float32)  # the image is upright when seen from above
SIX = np.array([0, 1, 2, 0, 2, 3], np.uint16)  # the two triangles of QUAD
DOWN = [-np.sqrt(0.5), 0, 0, np.sqrt(0.5)]  # a node's rotation that makes cameras and lights point down


class Gltf:
    """A glTF file under construction. Tests may change `json` freely before they save it."""

    def __init__(self):
        self.json = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}]}
        self.bytes = bytearray()

    def add(self, kind, **properties):
        """Adds an element to one of the file's lists; returns its index."""
        elements = self.json.setdefault(kind, [])
        elements.append(properties)
        return len(elements) - 1

    def use(self, extension):
        names = self.json.setdefault("extensionsUsed", [])
        if extension not in names:
            names.append(extension)

    def view(self, data, **properties):
        self.bytes += bytes(-len(self.bytes) % 4)
        offset = len(self.bytes)
        self.bytes += data
        return self.add("bufferViews", buffer=0, byteOffset=offset, byteLength=len(data), **properties)

    def accessor(self, values):
        return self.add("accessors", bufferView=self.view(values.tobytes()), componentType=COMPONENT_TYPES[values.dtype.name],
                        count=len(values), type="SCALAR" if values.ndim == 1 else f"VEC{values.shape[1]}")

    def material(self, colour=(0.5, 0.5, 0.5), **properties):
        """Adds a material that is diffuse unless `properties` say otherwise."""
        self.use("KHR_materials_specular")
        pbr = {"baseColorFactor": [*map(float, colour), 1.0], "metallicFactor": 0, **properties.pop("pbr", {})}
        extensions = {"KHR_materials_specular": {"specularFactor": 0}, **properties.pop("extensions", {})}
        return self.add("materials", pbrMetallicRoughness=pbr, extensions=extensions, **properties)

    def glow(self, radiance, strength):
        """The material properties that emit `radiance`, expressed as a factor of at most 1 times `strength`."""
        self.use("KHR_materials_emissive_strength")
        extensions = {"KHR_materials_emissive_strength": {"emissiveStrength": strength}}
        return {"emissiveFactor": [float(c) / strength for c in radiance], "extensions": extensions}

    def mesh(self, positions, indices=None, material=None, mode=None, **attributes):
        """Adds a mesh. Positions, indices and other attributes are arrays or accessor indices."""
        number = lambda a: self.accessor(a) if isinstance(a, np.ndarray) else a
        attributes = {name: number(values) for name, values in {"POSITION": positions, **attributes}.items()}
        primitive = {"attributes": attributes, "indices": number(indices), "material": material, "mode": mode}
        return self.add("meshes", primitives=[{name: value for name, value in primitive.items() if value is not None}])

    def node(self, root=True, **properties):
        number = self.add("nodes", **properties)
        if root:
            self.json["scenes"][0]["nodes"].append(number)
        return number

    def quads(self, quads, material, **node):
        """Adds a node whose mesh is a list of quadrilaterals, with four corners each."""
        corners = np.asarray(quads, np.float32).reshape(-1, 3)
        indices = 4 * np.arange(len(corners) // 4, dtype=np.uint16)[:, None] + SIX
        return self.node(mesh=self.mesh(corners, indices.ravel(), material), **node)

    def camera(self, yfov=0.6, **node):
        camera = self.add("cameras", type="perspective", perspective={"yfov": yfov, "znear": 0.01})
        return self.node(camera=camera, **node)

    def light(self, kind, intensity, color=(1, 1, 1), light=None, **node):
        self.use("KHR_lights_punctual")
        lights = self.json.setdefault("extensions", {}).setdefault("KHR_lights_punctual", {"lights": []})["lights"]
        lights.append({"type": kind, "intensity": intensity, "color": list(color), **(light or {})})
        return self.node(extensions={"KHR_lights_punctual": {"light": len(lights) - 1}}, **node)

    def texture(self, pixels, **sampler):
        """Adds a texture in a buffer view. `pixels` are 8-bit values or the bytes of an image file."""
        data = pixels if isinstance(pixels, bytes) else encoded(pixels)
        picture = self.add("images", bufferView=self.view(data), mimeType="image/png")
        return self.add("textures", source=picture, sampler=self.add("samplers", **sampler))

    def text(self, **buffer):
        """Returns the JSON text. `buffer` adds buffer properties such as the URI."""
        return json.dumps({**self.json, "buffers": [{"byteLength": len(self.bytes), **buffer}]})

    def gltf(self):
        """Returns a glTF file with an embedded buffer."""
        return self.text(uri="data:application/octet-stream;base64," + base64.b64encode(self.bytes).decode()).encode()

    def glb(self):
        text, data = self.text().encode(), self.bytes
        chunks = ((text + b" " * (-len(text) % 4), b"JSON"), (data + bytes(-len(data) % 4), b"BIN\0"))
        whole = b"".join(struct.pack("<I4s", len(chunk), kind) + chunk for chunk, kind in chunks)
        return struct.pack("<4sII", b"glTF", 2, 12 + len(whole)) + whole

    def save(self, path):
        path.write_bytes(self.glb() if path.suffix == ".glb" else self.gltf())
        return path


def encoded(pixels, kind="PNG", **options):
    """Encodes 8-bit pixels or a Pillow image as the bytes of a file."""
    image = pixels if isinstance(pixels, Image.Image) else Image.fromarray(np.asarray(pixels, np.uint8))
    stream = io.BytesIO()
    image.save(stream, kind, quality=95, subsampling=0, **options)
    return stream.getvalue()


def linear(values):
    """Converts 8-bit sRGB values to linear light."""
    v = np.asarray(values) / 255
    return np.where(v <= 0.04045, v / 12.92, ((v + 0.055) / 1.055) ** 2.4)


ROOM_EYE = [0, 1, 4]


def room(scale=1.0, shift=(0, 0, 0)):
    """A floor, a red wall and a lamp that shines down, seen from the front. The root node is scaled, then moved."""
    g = Gltf()
    g.quads([QUAD], g.material())
    g.quads([[[-1, 0, -1], [1, 0, -1], [1, 2, -1], [-1, 2, -1]]], g.material((0.6, 0.1, 0.1)))
    g.quads([0.2 * QUAD[::-1] + np.float32([0, 1.5, 0])], g.material((0, 0, 0), **g.glow((17, 12, 4), 17)))
    g.camera(translation=ROOM_EYE)
    whole = g.json["scenes"][0]
    whole["nodes"] = [g.node(root=False, children=whole["nodes"], scale=[scale] * 3, translation=[*shift])]
    return g


SMALL = ["--size", "24x24", "--threads", 1]
ONE = [*SMALL, "--spp", 1]


def write_exr(path, header=None, **channels):
    """Writes an image from its channels, such as RGB=texels, which are 16-bit or 32-bit floats; returns its path."""
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage, **(header or {})}
    with OpenEXR.File(header, {name: np.ascontiguousarray(texels) for name, texels in channels.items()}) as file:
        file.write(str(path))
    return path


def write_environment(path, colour):
    return write_exr(path, RGB=np.broadcast_to(np.float32(colour), (4, 8, 3)))


@pytest.fixture
def even_sky(tmp_path):
    """A uniform environment of radiance 1, in which a diffuse surface shows its albedo without noise."""
    return write_environment(tmp_path / "even.exr", 1.0)


def picture(pathtracer, scene, *arguments):
    return pathtracer.image("--scene", scene, *SMALL, *arguments)


def over_floor(scene, height=1.0, yfov=0.4):
    """Adds a camera that looks straight down at the origin. The top of the image is towards -z."""
    scene.camera(yfov, translation=[0, height, 0], rotation=DOWN)
    return scene


def floor(albedo=0.5):
    g = Gltf()
    g.quads([QUAD], g.material([albedo] * 3))
    return g


def add_floor(g, colour=(1, 1, 1), corners=QUAD, coordinates=QUAD_COORDINATES, attributes=None, **material):
    """Adds a floor with texture coordinates and a new material."""
    return g.node(mesh=g.mesh(corners, SIX, g.material(colour, **material), TEXCOORD_0=coordinates, **(attributes or {})))


FOUR = np.array([[[255, 0, 0], [0, 255, 0]], [[0, 0, 255], [128, 64, 200]]], np.uint8)
FOUR_COLOURS = linear(FOUR.reshape(4, 3))
LARGE_FOUR = FOUR.repeat(16, axis=0).repeat(16, axis=1)
CORNERS = ((6, 6), (6, 18), (18, 6), (18, 18))  # where a SMALL image shows the four texels of FOUR


def textured_floor(pixels=FOUR, sampler=None, info=None, **floor):
    """A floor with a base-colour texture, which fills the image exactly. Texels are not interpolated unless `sampler` says so."""
    g = Gltf()
    texture = g.texture(pixels, **({"magFilter": 9728} if sampler is None else sampler))
    add_floor(g, pbr={"baseColorTexture": {"index": texture, **(info or {})}}, **floor)
    return over_floor(g, 1, np.pi / 2)


def assert_corners(pathtracer, scene, expected, *arguments, atol=1e-3):
    image = picture(pathtracer, scene, "--spp", 4, "--max-depth", 1, *arguments)
    np.testing.assert_allclose([image[y, x] for y, x in CORNERS], expected, atol=atol)


def ball(g, material, around=24, turned=False):
    """Adds a unit sphere with normals. With `turned`, its winding contradicts them."""
    theta, phi = np.meshgrid(np.linspace(0, np.pi, around + 1), np.linspace(0, 2 * np.pi, 2 * around + 1), indexing="ij")
    n = np.stack([np.sin(theta) * np.cos(phi), np.cos(theta), -np.sin(theta) * np.sin(phi)], axis=-1).reshape(-1, 3).astype(np.float32)
    corners = np.arange(around)[:, None, None] * (2 * around + 1) + np.arange(2 * around)[:, None]
    faces = (corners + [0, 2 * around + 1, 2 * around + 2, 0, 2 * around + 2, 1]).ravel().astype(np.uint16)
    return g.node(mesh=g.mesh(n, faces[::-1] if turned else faces, material, NORMAL=n))
