# SPDX-License-Identifier: Apache-2.0
"""Scenes with third-party models: each model stands on a floor, either alone under the sky or in a room with a lamp.

The models come from the gradio pip package and the sweethome3d-furniture and assimp-testmodels Debian packages, which are downloaded once
and unpacked into ~/.cache/libbn/models. The packages contain their licences.
"""

import sys
import zipfile

import numpy as np

from ..base.atomic_write import written_beside
from ..base.cache import cache_folder
from ..base.command import output_of

GRADIO = "gradio==6.31.0"
DEBIAN = ("sweethome3d-furniture", "assimp-testmodels")
FURNITURE = "usr/share/sweethome3d/furniture/{}.sh3f"
# {name: (archive within a package or "", file, whether the model stands in a room)}.
MODELS = {
    "duck": ("", "gradio/media_assets/models3d/Duck.glb", True),
    "fox": ("", "gradio/media_assets/models3d/Fox.gltf", False),
    "engine": ("", "usr/share/assimp/models/glTF2/2CylinderEngine-glTF-Binary/2CylinderEngine.glb", True),
    "kitchenaid": (FURNITURE.format("BlendSwap-CC-0"), "blendswap-cc-0/kitchenaid/kitchenaid.obj", False),
    "chessboard": (FURNITURE.format("BlendSwap-CC-BY"), "blendswap-cc-by/chessboard/chessboard.obj", True),
    "spider_plant": (FURNITURE.format("BlendSwap-CC-BY"), "blendswap-cc-by/spider_plant/spider_plant.obj", False),
}
CAMERA = ((1.3, 1.0, 2.0), (0, 0.35, 0), 34.0)  # of all scenes; the longest side of a model is 1
FLOOR, WALL, LAMP = 8.0, 2.4, 0.45  # half widths
HEIGHT = 2.6


def unpacked():
    """The folder with the packages' files."""
    folder = cache_folder() / "models"
    if not (folder / "complete").exists():
        folder.mkdir(parents=True, exist_ok=True)
        print(f"bench: downloading {GRADIO}, {' and '.join(DEBIAN)} (170 MB) for their models", file=sys.stderr)
        for command in ([sys.executable, "-m", "pip", "download", "--no-deps", "--quiet", GRADIO], ["apt-get", "download", *DEBIAN],
                        ["sh", "-ec", 'for package in *.deb; do dpkg -x "$package" .; done']):
            output_of(command, "these scenes need the network, apt-get and dpkg", cwd=folder)
        for archive in (next(folder.glob("gradio-*.whl")), *(folder / name for name, *_ in MODELS.values() if name)):
            with zipfile.ZipFile(archive) as file:
                file.extractall(folder, [name for name in file.namelist() if archive.suffix == ".sh3f" or "/models3d/" in name])
        (folder / "complete").touch()
    return folder


def quad(corner, a, b):
    """Positions of a parallelogram that faces the direction a x b."""
    corner, a, b = (np.array(v, float) for v in (corner, a, b))
    return np.array([corner, corner + a, corner + a + b, corner + b])


def surroundings(in_room):
    """[(positions, colour, emission)]."""
    if not in_room:
        return [(quad((-FLOOR, 0, FLOOR), (2 * FLOOR, 0, 0), (0, 0, -2 * FLOOR)), (0.5, 0.5, 0.5), 0)]
    w, h = 2 * WALL, HEIGHT
    return [(quad((-WALL, 0, WALL), (w, 0, 0), (0, 0, -w)), (0.6, 0.6, 0.6), 0), (quad((-WALL, h, -WALL), (w, 0, 0), (0, 0, w)), (0.75, 0.75, 0.75), 0),
            (quad((-WALL, 0, -WALL), (w, 0, 0), (0, h, 0)), (0.7, 0.7, 0.7), 0), (quad((WALL, 0, WALL), (-w, 0, 0), (0, h, 0)), (0.7, 0.7, 0.7), 0),
            (quad((-WALL, 0, WALL), (0, 0, -w), (0, h, 0)), (0.7, 0.3, 0.2), 0), (quad((WALL, 0, -WALL), (0, 0, w), (0, h, 0)), (0.2, 0.35, 0.7), 0),
            (quad((-LAMP, h - 0.05, -LAMP), (2 * LAMP, 0, 0), (0, 0, 2 * LAMP)), (0.8, 0.8, 0.8), 14)]


def stage(data, bounds, in_room):
    """The bytes of a GLB, with the model's bounding box moved to the floor and its longest side scaled to 1."""
    from own_scene import to_gltf

    tree, rest = to_gltf.parts_of(data)
    blob, (low, high) = bytearray(rest[8:]), np.array(bounds)
    scale = 1 / max(high - low)

    def add(name, value):
        tree.setdefault(name, []).append(value)
        return len(tree[name]) - 1

    def accessor(values, kind, component, target, **more):
        blob.extend(b"\0" * (-len(blob) % 4))
        view = add("bufferViews", {"buffer": 0, "byteOffset": len(blob), "byteLength": values.nbytes, "target": target})
        blob.extend(values.tobytes())
        return add("accessors", {"bufferView": view, "componentType": component, "count": len(values), "type": kind, **more})

    roots = [add("nodes", {"children": tree["scenes"][tree.get("scene", 0)]["nodes"], "scale": [scale] * 3,
                           "translation": [-scale * (low[0] + high[0]) / 2, -scale * low[1], -scale * (low[2] + high[2]) / 2]})]
    for corners, colour, emission in surroundings(in_room):
        corners = corners.astype("<f4")
        positions = accessor(corners, "VEC3", 5126, 34962, min=corners.min(0).tolist(), max=corners.max(0).tolist())
        indices = accessor(np.array([0, 1, 2, 0, 2, 3], "<u2"), "SCALAR", 5123, 34963)
        extensions = {"KHR_materials_specular": {"specularFactor": 0.0}}
        if emission:
            extensions["KHR_materials_emissive_strength"] = {"emissiveStrength": emission}
        material = add("materials", {"pbrMetallicRoughness": {"baseColorFactor": [*colour, 1], "metallicFactor": 0}, "extensions": extensions,
                                     "emissiveFactor": [1, 1, 1] if emission else [0, 0, 0]})
        mesh = add("meshes", {"primitives": [{"attributes": {"POSITION": positions}, "indices": indices, "material": material}]})
        roots.append(add("nodes", {"mesh": mesh}))
    tree["scenes"], tree["scene"] = [{"nodes": roots}], 0
    tree["extensionsUsed"] = sorted({*tree.get("extensionsUsed", []), "KHR_materials_specular", "KHR_materials_emissive_strength"})
    blob.extend(b"\0" * (-len(blob) % 4))
    tree["buffers"] = [{"byteLength": len(blob)}]
    return to_gltf.glb_of(tree, len(blob).to_bytes(4, "little") + b"BIN\0" + blob)


def scene(name):
    """The path to a scene's GLB, created if needed. It has its own folder because the path tracer counts all files beside it as inputs."""
    path = cache_folder() / "models" / "scenes" / name / f"{name}.glb"
    if not path.is_file():
        from own_scene import to_gltf

        model = unpacked() / MODELS[name][1]
        plain = path.parent.parent / f"{name}.plain.glb"
        *_, report = to_gltf.convert(model, plain, "bench")
        data = stage(plain.read_bytes(), report["bounds"], MODELS[name][2])
        with written_beside(path) as beside:
            beside.write_bytes(data)
        plain.unlink()
    return str(path)
