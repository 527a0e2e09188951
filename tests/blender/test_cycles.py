# SPDX-License-Identifier: Apache-2.0
"""Cycles renders the same glTF scenes as the path tracer, and the means of both images must agree."""

import functools
import json
import subprocess
from pathlib import Path

import numpy as np
import pytest
import scene_files as files
from own_scene import to_gltf
from pathtracer_driver import read_exr
from scene_files import DOWN, FOUR, LARGE_FOUR, QUAD, Gltf, add_floor, ball, over_floor

SIZE, SPP = 32, 512
PLAIN = {"KHR_materials_specular": {"specularFactor": 0}}


def surface(**material):
    """A ball of one material over a grey floor."""

    def scene(g):
        properties = {"pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 1, **material.get("pbr", {})}}
        node = ball(g, g.add("materials", **properties, **{name: value for name, value in material.items() if name != "pbr"}), 48)
        g.json["nodes"][node]["translation"] = [0, 1, 0]
        g.quads([4 * QUAD], g.material((0.4, 0.4, 0.4)))

    return scene


def floor_with(texture=None, **material):
    def scene(g):
        info = material.pop("info", {})
        pbr = {} if texture is None else {"baseColorTexture": {"index": g.texture(texture, magFilter=9728), **info}}
        add_floor(g, (1, 1, 1), 2 * QUAD, pbr=pbr, **{name: value(g) if callable(value) else value for name, value in material.items()})

    return scene


def lit(kind, intensity, **light):
    def scene(g):
        g.quads([4 * QUAD], g.material((0.5, 0.5, 0.5)))
        g.light(kind, intensity, (1, 0.8, 0.6), **light)

    return scene


def lamp(g):
    g.quads([3 * QUAD], g.material((0.5, 0.5, 0.5)))
    g.quads([0.5 * QUAD[::-1] + np.float32([0.5, 1.5, 0])], g.material((0, 0, 0), **g.glow((5, 4, 3), 5)))


def lamp_with_picture(g):
    g.quads([3 * QUAD], g.material((0.5, 0.5, 0.5)))
    picture = {"index": g.texture(FOUR, magFilter=9728)}
    corners, coordinates = QUAD[[0, 3, 2, 1]] * 0.5 + np.float32([0.5, 1, 0]), files.QUAD_COORDINATES[[0, 3, 2, 1]]
    add_floor(g, (0, 0, 0), corners, coordinates, **g.glow((8, 8, 8), 8), emissiveTexture=picture)


TRANSFORM = {"extensions": {"KHR_texture_transform": {"offset": [0.3, 0.1], "scale": [1.5, 0.7], "rotation": 0.4}}}
ALPHA = np.dstack([LARGE_FOUR, np.full((32, 32), 255)])
ALPHA[:16, :16, 3] = 0
LEAN = np.round(255 * (0.5 + 0.5 * np.array([[[0.4, 0.2, 0.894]]]))).astype(np.uint8)
DARK = {"baseColorFactor": [0.1, 0.1, 0.1, 1], "roughnessFactor": 0.3}
GLASS = {"KHR_materials_transmission": {"transmissionFactor": 1}}
SPOT = {"translation": [0, 3, 0], "rotation": DOWN, "light": {"spot": {"innerConeAngle": 0.59, "outerConeAngle": 0.6}}}
# {name: (scene, whether it has a sky, tolerance)}. Cycles darkens normal maps where light grazes the surface below them.
SCENES = {
    "diffuse": (surface(extensions=PLAIN, pbr={"baseColorFactor": [0.7, 0.4, 0.2, 1]}), True, 0.02),
    "coat": (surface(pbr={"baseColorFactor": [0.7, 0.4, 0.2, 1], "roughnessFactor": 0.3}), True, 0.02),
    "metal": (surface(pbr={"baseColorFactor": [0.9, 0.7, 0.3, 1], "metallicFactor": 1, "roughnessFactor": 0.1}), True, 0.02),
    "rough metal": (surface(pbr={"baseColorFactor": [0.9, 0.7, 0.3, 1], "metallicFactor": 1, "roughnessFactor": 0.7}), True, 0.02),
    "specular factor": (surface(pbr=DARK, extensions={"KHR_materials_specular": {"specularFactor": 0.5}}), True, 0.02),
    "specular colour": (surface(pbr=DARK, extensions={"KHR_materials_specular": {"specularColorFactor": [1, 0.5, 0.2]}}), True, 0.02),
    "index 1.8": (surface(pbr=DARK, extensions={"KHR_materials_ior": {"ior": 1.8}}), True, 0.02),
    "glass": (surface(pbr={"roughnessFactor": 0}, extensions=GLASS), True, 0.02),
    "rough glass": (surface(pbr={"roughnessFactor": 0.4}, extensions=GLASS), True, 0.02),
    "texture": (floor_with(LARGE_FOUR), True, 0.02),
    "texture transform": (floor_with(LARGE_FOUR, info=TRANSFORM), True, 0.02),
    "normal map": (floor_with(normalTexture=lambda g: {"index": g.texture(LEAN)}), True, 0.03),
    "alpha mask": (floor_with(ALPHA.astype(np.uint8), alphaMode="MASK"), True, 0.02),
    "lamp": (lamp, False, 0.02),
    "textured lamp": (lamp_with_picture, False, 0.02),
    "point light": (lit("point", 20, translation=[1, 2, 0]), False, 0.02),
    "spot light": (lit("spot", 20, **SPOT), False, 0.02),
    "sun": (lit("directional", 3, rotation=[-0.5, 0, 0, np.sqrt(0.75)]), False, 0.02),
}


def sky(path):
    """A bright and a dark half with a coloured lamp; texels are large, so both programs see the same values."""
    texels = np.tile(np.float32([0.3, 0.4, 0.6]), (16, 32, 1))
    texels[:, 20:] = [0.6, 0.5, 0.4]
    texels[3:5, 4:7] = [20, 15, 9]
    return files.write_exr(path, RGB=texels)


@functools.lru_cache(maxsize=1)
def rendered(folder, program):
    """Renders all scenes in Cycles, in one process."""
    requests = []
    for name, (build, has_sky, _) in SCENES.items():
        g = Gltf()
        build(g)
        for material in g.json["materials"]:
            material["doubleSided"] = True  # as in Cycles
        turn = 0.5 * np.arctan2(2.2, 3.5)
        g.camera(0.5, translation=[0, 3, 4.5], rotation=[-np.sin(turn), 0, 0, np.cos(turn)]) if "floor" not in name else over_floor(g)
        requests.append({"file": str(g.save(folder / f"{name}.glb")), "env": str(sky(folder / "sky.exr")) if has_sky else None,
                         "output": str(folder / f"{name} cycles.exr"), "size": SIZE, "spp": SPP, "bounces": 16})
    (folder / "request.json").write_text(json.dumps(requests))
    command = [program, Path(__file__).with_name("render_in_cycles.py"), folder / "request.json"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    return {name: request for name, request in zip(SCENES, requests)}


@pytest.mark.parametrize("name", SCENES)
def test_means_agree(pathtracer, name, tmp_path_factory):
    folder = tmp_path_factory.getbasetemp() / "cycles"
    folder.mkdir(exist_ok=True)
    request = rendered(folder, to_gltf.blender("test"))[name]
    options = ["--env", request["env"] or "none", "--size", f"{SIZE}x{SIZE}", "--spp", SPP, "--max-depth", 16]
    image = pathtracer.image("--scene", request["file"], *options)
    wanted = read_exr(request["output"])[0].mean((0, 1))
    ratio = image.mean((0, 1)) / wanted
    print(name + ":", ", ".join(f"{value:.3f}" for value in ratio), "times Cycles' mean")
    np.testing.assert_allclose(ratio, 1, atol=SCENES[name][2])
