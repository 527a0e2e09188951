# SPDX-License-Identifier: Apache-2.0
"""Converts LuxCoreRender's scenes to pbrt: meshes, cameras, lamps, colours and images from its checkout.

The converter reads only the features these scenes use. Our own image replaces skies and suns, and plain colours replace
procedural textures and layers. Objects whose files are missing from the checkout are left out.
"""

import dataclasses
from pathlib import Path

import numpy as np

from ..base.files import read_exr, write_exr
from .pbrt_scenes import SKY_LIGHT, SKY_SIZE, Scene, inside, numbers, sphere_of_square

COMMIT = "d624e0445924c766c32fd9a08df56d3264cbd33f"
# One scene from each folder, chosen before any was rendered.
SCENES = {"kitchen": "kitchen/kitchen", "classroom": "classroom/classroom", "monkey": "bigmonkey/bigmonkey", "luxball": "luxball/luxball-hdr",
          "materials": "simple-mat/simple-mat", "boxes": "simple/simple", "cat": "cat/cat", "lux-cornell": "cornell/cornell",
          "juice": "juice/scene", "pool": "pool/scene", "caustic": "causticcube/scene", "window": "window/scene",
          "coating": "glossycoating/scene", "prism": "psor-cube/psor-cube", "bokeh": "bokeh/scene", "lamps": "manylights/scene"}
FIXED = "-fixed"


def read(path):
    """A properties file as {key: words}, without "scene." in front of the keys."""
    found = {}
    for line in path.read_text(encoding="utf-8").splitlines():
        name, equals, value = line.partition("=")
        if equals and not line.startswith("#"):
            is_file = value.strip()[-4:].strip('"') in (".ply", ".exr", ".png")
            found[name.strip().removeprefix("scene.")] = [value.strip().strip('"')] if is_file else value.replace('"', " ").split()
    return found


class Converter:
    """Nodes are prefixes of keys, such as "materials.glass"."""

    def __init__(self, checkout, name, folder):
        self.checkout, self.place, self.out, self.lines = checkout, checkout / "scenes" / Path(name).parent, folder, []
        self.values = read(checkout / "scenes" / f"{name}.scn")

    def word(self, key, default=""):
        return self.values.get(key, [default])[0]

    def floats(self, key, *default):
        return [float(word) for word in self.values.get(key, default)]

    def nodes(self, group):
        return dict.fromkeys(".".join(key.split(".")[:2]) for key in self.values if key.startswith(f"{group}."))

    def file(self, name):
        """The path to one of the scene's files, or None if the checkout lacks it."""
        return next((path for path in (self.checkout / name, self.place / name) if path.is_file()), None)

    def colour(self, key, default):
        """A colour parameter: numbers, or the image of a texture."""
        words = self.values.get(key, [default])
        texture = f"textures.{words[0]}"
        if self.word(f"{texture}.type") == "imagemap" and (path := self.file(self.word(f"{texture}.file"))):
            self.lines.append(f'Texture "{words[0]}" "spectrum" "imagemap" "string filename" "{path}"')
            return "texture", f'"{words[0]}"'
        if texture in self.nodes("textures"):
            words = self.values.get(f"{texture}.value", [default])
        values = [float(value) for value in words]
        return "rgb", numbers(np.clip(values if len(values) == 3 else values[:1] * 3, 0, 1))

    def material(self, name):
        """The lines of a material; None for a material that light passes through."""
        node = f"materials.{name}"
        kind, rough = self.word(f"{node}.type", "matte"), self.word(f"{node}.uroughness", "0.1")
        if kind == "null":
            return None
        if kind == "mix":
            parts = [self.material(self.word(f"{node}.{part}")) for part in ("material1", "material2")]
            amount = self.word(f"{node}.amount")
            if None in parts or amount[:1].isalpha():
                return parts[1] or parts[0]
            for part, lines in zip("12", parts):
                self.lines.append(lines.replace("Material ", f'MakeNamedMaterial "{name} {part}" "string type" ', 1))
            return f'Material "mix" "string materials" [ "{name} 1" "{name} 2" ] "float amount" {amount}'
        if kind in ("mirror", "metal", "metal2"):
            exponent = self.floats(f"{node}.exp", 0)[0]
            rough = (2 / (exponent + 2)) ** 0.5 if exponent else float(rough) if kind != "mirror" else 0
            return f'Material "conductor" "{{}} reflectance" {{}} "float roughness" {rough:.6g}'.format(*self.colour(f"{node}.kr", 0.75))
        if kind in ("glass", "roughglass"):
            return f'Material "dielectric" "float eta" {self.floats(f"{node}.iorinside", 1.5)[0]} "float roughness" {float(rough) if kind == "roughglass" else 0}'
        if kind == "archglass":
            return 'Material "thindielectric"'
        base = self.colour(f"{node}.{'basecolor' if kind == 'disney' else 'kd'}", 0.5)
        if kind in ("matte", "roughmatte"):
            return 'Material "diffuse" "{} reflectance" {}'.format(*base)
        if kind == "mattetranslucent":
            return 'Material "diffusetransmission" "{} reflectance" {} "{} transmittance" {}'.format(
                *self.colour(f"{node}.kr", 0.5), *self.colour(f"{node}.kt", 0.5))
        return f'Material "coateddiffuse" "{{}} reflectance" {{}} "float roughness" {0.1 if rough[:1].isalpha() else rough}'.format(*base)

    def add_object(self, node):
        name = self.word(f"{node}.material")
        path, material = self.file(self.word(f"shapes.{self.word(f'{node}.shape')}.ply") or self.word(f"{node}.ply")), self.material(name)
        if not path or not material:
            return
        lines, emission = [material], f"materials.{name}.emission"
        if (light := self.word(emission, "0")) not in ("0", "0.0"):
            is_texture = light[:1].isalpha()
            light, gain = ([1.0], [1, 1, 1]) if is_texture else (self.floats(emission), self.floats(f"{emission}.gain", 1, 1, 1))
            lines.append(f'AreaLightSource "diffuse" "bool twosided" true "rgb L" {numbers(np.array(light) * gain)}')
        if f"{node}.transformation" in self.values:
            lines.append(f'ConcatTransform {numbers(self.floats(f"{node}.transformation"))}')
        self.lines.append(inside(*lines, f'Shape "plymesh" "string filename" "{path}"'))

    def add_light(self, node):
        gain, kind = self.floats(f"{node}.gain", 1, 1, 1), self.word(f"{node}.type", "infinite")
        place, target = (numbers(self.floats(f"{node}.{part}", 0, 0, 0)) for part in ("position", "target"))
        if kind == "infinite":
            picture = read_exr(self.file(self.word(f"{node}.file")))[0]
            d = sphere_of_square(SKY_SIZE)
            x = ((np.arctan2(d[..., 1], d[..., 0]) / (2 * np.pi)) % 1 * picture.shape[1]).astype(int)
            y = (np.arccos(np.clip(d[..., 2], -1, 1)) / np.pi * picture.shape[0]).astype(int)
            path = self.out / f"{self.place.name}.exr"
            write_exr(path, picture[y.clip(0, picture.shape[0] - 1), x.clip(0, picture.shape[1] - 1)] * np.float32(gain), {})
            self.lines.append(f'LightSource "infinite" "string filename" "{path}"')
        elif kind == "constantinfinite":
            self.lines.append(f'LightSource "infinite" "rgb L" {numbers(np.array(self.floats(f"{node}.color", 1, 1, 1)) * gain)}')
        elif kind in ("point", "sphere"):
            self.lines.append(f'LightSource "point" "point3 from" {place} "rgb I" {numbers(gain)}')
        elif kind == "spot":
            self.lines.append(f'LightSource "spot" "point3 from" {place} "point3 to" {target} "rgb I" {numbers(gain)}')
        elif SKY_LIGHT not in self.lines:
            self.lines.append(SKY_LIGHT)

    def scene(self, name):
        look = self.floats("camera.lookat") or self.floats("camera.lookat.orig") + self.floats("camera.lookat.target")
        if {"sunlight", "skylight"} & {key.split(".")[0] for key in self.values}:
            self.values["skylight.type"] = ["sky"]
        for light in (*self.nodes("lights"), *(light for light in ("infinitelight", "skylight") if self.nodes(light))):
            self.add_light(light)
        for node in self.nodes("objects"):
            self.add_object(node)
        lens = self.floats("camera.lensradius", 0)[0]
        more = f' "float lensradius" {lens} "float focaldistance" {self.word("camera.focaldistance", "10")}' if lens else ""
        return Scene(name, f"LuxCoreRender's {SCENES[name]}", "\n".join(self.lines), tuple(look[:3]), tuple(look[3:]),
                     min(self.floats("camera.fieldofview", 45)[0], 90), 6, more)


def scenes(checkout, folder):
    """{name: Scene} for SCENES, and again with FIXED appended to each name, where all samples use the same wavelengths. Writes the images they need
    to a folder."""
    found = {name: Converter(Path(checkout).resolve(), path, Path(folder)).scene(name) for name, path in SCENES.items()}
    option = 'Option "disablewavelengthjitter" true\n'
    return {**found, **{name + FIXED: dataclasses.replace(scene, name=name + FIXED, before=option) for name, scene in found.items()}}
