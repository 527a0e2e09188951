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
    """A properties file as nested dicts; values are lists of words."""
    tree = {}
    for line in path.read_text(encoding="utf-8").splitlines():
        name, equals, value = line.partition("=")
        if equals and not line.startswith("#"):
            node, *parts = tree, *name.strip().split(".")
            for part in parts:
                node = node.setdefault(part, {})
            node[""] = [value.strip().strip('"')] if value.strip()[-4:].strip('"') in (".ply", ".exr", ".png") else value.replace('"', " ").split()
    return tree["scene"]


def word(node, *path, default=""):
    for part in path:
        node = node.get(part, {})
    return node.get("", [default])[0]


def floats(node, *path, default):
    for part in path:
        node = node.get(part, {})
    return [float(value) for value in node.get("", default)]


class Converter:
    def __init__(self, checkout, name, folder):
        self.checkout, self.place, self.out = checkout, checkout / "scenes" / Path(name).parent, folder
        self.tree = read(checkout / "scenes" / f"{name}.scn")
        self.lines = []

    def file(self, name):
        """The path to one of the scene's files, or None if the checkout lacks it."""
        return next((path for path in (self.checkout / name, self.place / name) if path.is_file()), None)

    def colour(self, node, name, default):
        """A colour parameter: numbers, or the image of a texture."""
        words = node.get(name, {}).get("", default)
        texture = self.tree.get("textures", {}).get(words[0], {}) if isinstance(words[0], str) else {}
        if texture and word(texture, "type") == "imagemap" and (path := self.file(word(texture, "file"))):
            self.lines.append(f'Texture "{words[0]}" "spectrum" "imagemap" "string filename" "{path}"')
            return "texture", f'"{words[0]}"'
        if texture:
            words = texture.get("value", {}).get("", default)
        values = [float(value) for value in words]
        return "rgb", numbers(np.clip(values if len(values) == 3 else values[:1] * 3, 0, 1))

    def material(self, name):
        """The lines of a material; None for a material that light passes through."""
        node = self.tree.get("materials", {}).get(name, {})
        kind = word(node, "type", default="matte")
        if kind == "null":
            return None
        if kind == "mix":
            parts = [self.material(word(node, part)) for part in ("material1", "material2")]
            amount = word(node, "amount")
            if None in parts or amount[:1].isalpha():
                return parts[1] or parts[0]
            for part, lines in zip("12", parts):
                self.lines.append(lines.replace("Material ", f'MakeNamedMaterial "{name} {part}" "string type" ', 1))
            return f'Material "mix" "string materials" [ "{name} 1" "{name} 2" ] "float amount" {amount}'
        if kind in ("mirror", "metal", "metal2"):
            exponent = floats(node, "exp", default=[0])[0]
            rough = (2 / (exponent + 2)) ** 0.5 if exponent else floats(node, "uroughness", default=[0.1])[0] if kind != "mirror" else 0
            return f'Material "conductor" "{{}} reflectance" {{}} "float roughness" {rough:.6g}'.format(*self.colour(node, "kr", [0.75]))
        if kind in ("glass", "roughglass"):
            rough = floats(node, "uroughness", default=[0.1])[0] if kind == "roughglass" else 0
            return f'Material "dielectric" "float eta" {floats(node, "iorinside", default=[1.5])[0]} "float roughness" {rough}'
        if kind == "archglass":
            return 'Material "thindielectric"'
        base = self.colour(node, "basecolor" if kind == "disney" else "kd", [0.5])
        if kind in ("matte", "roughmatte"):
            return 'Material "diffuse" "{} reflectance" {}'.format(*base)
        if kind == "mattetranslucent":
            return ('Material "diffusetransmission" "{} reflectance" {}'.format(*self.colour(node, "kr", [0.5]))
                    + ' "{} transmittance" {}'.format(*self.colour(node, "kt", [0.5])))
        rough = word(node, "uroughness", default="0.1")
        return f'Material "coateddiffuse" "{{}} reflectance" {{}} "float roughness" {0.1 if rough[:1].isalpha() else rough}'.format(*base)

    def add_object(self, node):
        shape = self.tree.get("shapes", {}).get(word(node, "shape"), node)
        path, material = self.file(word(shape, "ply")), self.material(word(node, "material"))
        if not path or not material:
            return
        lines = [material]
        emission = self.tree["materials"].get(word(node, "material"), {}).get("emission", {})
        if "" in emission and emission[""][0] not in ("0", "0.0"):
            light = [1.0] if emission[""][0][:1].isalpha() else [float(value) for value in emission[""]]
            gain = floats(emission, "gain", default=[1, 1, 1]) if light != [1.0] else [1, 1, 1]
            lines.append(f'AreaLightSource "diffuse" "bool twosided" true "rgb L" {numbers(np.array(light) * gain)}')
        if "transformation" in node:
            lines.append(f'ConcatTransform {numbers(floats(node, "transformation", default=[]))}')
        self.lines.append(inside(*lines, f'Shape "plymesh" "string filename" "{path}"'))

    def add_light(self, node):
        gain, kind = floats(node, "gain", default=[1, 1, 1]), word(node, "type", default="infinite")
        place, target = (numbers(floats(node, part, default=[0, 0, 0])) for part in ("position", "target"))
        if kind == "infinite":
            picture = read_exr(self.file(word(node, "file")))[0]
            d = sphere_of_square(SKY_SIZE)
            x = ((np.arctan2(d[..., 1], d[..., 0]) / (2 * np.pi)) % 1 * picture.shape[1]).astype(int)
            y = (np.arccos(np.clip(d[..., 2], -1, 1)) / np.pi * picture.shape[0]).astype(int)
            path = self.out / f"{self.place.name}.exr"
            write_exr(path, picture[y.clip(0, picture.shape[0] - 1), x.clip(0, picture.shape[1] - 1)] * np.float32(gain), {})
            self.lines.append(f'LightSource "infinite" "string filename" "{path}"')
        elif kind == "constantinfinite":
            self.lines.append(f'LightSource "infinite" "rgb L" {numbers(np.array(floats(node, "color", default=[1, 1, 1])) * gain)}')
        elif kind in ("point", "sphere"):
            self.lines.append(f'LightSource "point" "point3 from" {place} "rgb I" {numbers(gain)}')
        elif kind == "spot":
            self.lines.append(f'LightSource "spot" "point3 from" {place} "point3 to" {target} "rgb I" {numbers(gain)}')
        elif SKY_LIGHT not in self.lines:
            self.lines.append(SKY_LIGHT)

    def scene(self, name):
        camera, tree = self.tree["camera"], self.tree
        look = floats(camera, "lookat", default=[]) or floats(camera, "lookat", "orig", default=[]) + floats(camera, "lookat", "target", default=[])
        lights = [*tree.get("lights", {}).values(), *([tree["infinitelight"]] if "infinitelight" in tree else []),
                  *([{"type": {"": ["sky"]}}] if {"sunlight", "skylight"} & set(tree) else [])]
        for light in lights:
            self.add_light(light)
        for node in tree["objects"].values():
            self.add_object(node)
        lens = floats(camera, "lensradius", default=[0])[0]
        more = f' "float lensradius" {lens} "float focaldistance" {word(camera, "focaldistance", default="10")}' if lens else ""
        return Scene(name, f"LuxCoreRender's {SCENES[name]}", "\n".join(self.lines), tuple(look[:3]), tuple(look[3:]),
                     min(floats(camera, "fieldofview", default=[45])[0], 90), 6, more)


def scenes(checkout, folder):
    """{name: Scene} for SCENES, and again with FIXED appended to each name, where all samples use the same wavelengths. Writes the images they need
    to a folder."""
    found = {name: Converter(Path(checkout).resolve(), path, Path(folder)).scene(name) for name, path in SCENES.items()}
    option = 'Option "disablewavelengthjitter" true\n'
    return {**found, **{name + FIXED: dataclasses.replace(scene, name=name + FIXED, before=option) for name, scene in found.items()}}
