# SPDX-License-Identifier: Apache-2.0
"""Runs in Blender's Python: renders files in Cycles.

    python render_in_cycles.py REQUEST.json

The request is a list of {"file": .glb or .blend, "env": an EXR or None, "output": .exr, "size": pixels, "spp"}.
"""

import json
import sys
from pathlib import Path

import bpy


def set_sky(scene, path):
    """A latitude-longitude EXR as the world, turned as OpenEXR says: the centre is glTF's +z."""
    world = scene.world = bpy.data.worlds.new("sky")
    world.use_nodes = True
    tree = world.node_tree
    image, mapping, place = (tree.nodes.new(f"ShaderNode{name}") for name in ("TexEnvironment", "Mapping", "TexCoord"))
    image.image, image.interpolation = bpy.data.images.load(path), "Closest"
    mapping.inputs["Rotation"].default_value[2] = 1.5707963267948966
    tree.links.new(place.outputs["Generated"], mapping.inputs["Vector"])
    tree.links.new(mapping.outputs["Vector"], image.inputs["Vector"])
    tree.links.new(image.outputs["Color"], tree.nodes["Background"].inputs["Color"])


def render(request):
    if request["file"].endswith(".blend"):
        bpy.ops.wm.open_mainfile(filepath=request["file"], load_ui=False)
    else:
        bpy.ops.wm.read_factory_settings(use_empty=True)
        bpy.ops.import_scene.gltf(filepath=request["file"], export_import_convert_lighting_mode="COMPAT")
        scene = bpy.context.scene
        scene.camera = next(item for item in scene.objects if item.type == "CAMERA")
        for light in bpy.data.lights:
            if light.type == "SUN":
                light.angle = 0
            else:
                light.shadow_soft_size = 0
        if request["env"]:
            set_sky(scene, request["env"])
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    cycles = scene.cycles
    cycles.samples, cycles.pixel_filter_type, cycles.filter_width = request["spp"], "BOX", 1.0
    cycles.use_denoising = cycles.use_adaptive_sampling = False
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.blur_glossy = 0
    for kind in ("max", "diffuse", "glossy", "transmission"):
        setattr(cycles, f"{kind}_bounces", request["bounces"])
    cycles.transparent_max_bounces = 64
    settings = scene.render
    settings.resolution_x = settings.resolution_y = request["size"]
    settings.resolution_percentage = 100
    settings.image_settings.file_format, settings.image_settings.color_depth = "OPEN_EXR", "32"
    settings.filepath = request["output"]
    bpy.ops.render.render(write_still=True)


if __name__ == "__main__":
    for one in json.loads(Path(sys.argv[1]).read_text()):
        render(one)
