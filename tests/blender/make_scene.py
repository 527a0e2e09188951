# SPDX-License-Identifier: Apache-2.0
"""Runs in Blender's Python: writes s.blend, with an area light, a textured floor, glass, metal, a camera with focus and an HDR world."""

import math

import bpy
import numpy as np


def material(name, **values):
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    shader = made.node_tree.nodes["Principled BSDF"]
    for key, value in values.items():
        shader.inputs[key.replace("_", " ")].default_value = value
    return made, shader


def image(name, pixels, kind):
    made = bpy.data.images.new(name, pixels.shape[1], pixels.shape[0], float_buffer=kind == "OPEN_EXR")
    made.pixels.foreach_set(np.dstack([pixels, np.ones(pixels.shape[:2])]).astype(np.float32).ravel())
    made.filepath_raw, made.file_format = f"//{name}", kind
    made.pack()
    return made


bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
y, x = np.mgrid[0:128, 0:256]
sky = np.stack([0.2 + 0.6 * y / 128, 0.3 + 0.4 * x / 256, 0.5 + 0 * x], -1)
sky[90:100, 60:76] = 30
world = scene.world = bpy.data.worlds.new("world")
world.use_nodes = True
tree = world.node_tree
environment, mapping, place = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("TexEnvironment", "Mapping", "TexCoord"))
environment.image = image("sky.exr", sky, "OPEN_EXR")
mapping.inputs["Rotation"].default_value = (0, 0, 0.7)
tree.links.new(place.outputs["Generated"], mapping.inputs[0])
tree.links.new(mapping.outputs[0], environment.inputs[0])
tree.links.new(environment.outputs[0], tree.nodes["Background"].inputs[0])
tree.nodes["Background"].inputs[1].default_value = 0.4

y, x = np.mgrid[0:64, 0:64]
check = ((x // 8 + y // 8) % 2)[..., None] * [0.6, 0.3, -0.4] + [0.2, 0.3, 0.6]
bpy.ops.mesh.primitive_plane_add(size=8)
floor, shader = material("floor", Roughness=0.6)
texture = floor.node_tree.nodes.new("ShaderNodeTexImage")
texture.image = image("check.png", check, "PNG")
floor.node_tree.links.new(texture.outputs[0], shader.inputs["Base Color"])
bpy.context.object.data.materials.append(floor)
glass = {"Base_Color": (1, 1, 1, 1), "Roughness": 0.0, "IOR": 1.45, "Transmission_Weight": 1}
metal = {"Base_Color": (0.9, 0.7, 0.3, 1), "Roughness": 0.3, "Metallic": 1}
for name, place, radius, values in (("glass", (-0.9, 0, 0.7), 0.7, glass), ("metal", (0.3, -1.2, 0.5), 0.5, metal)):
    bpy.ops.mesh.primitive_uv_sphere_add(segments=64, ring_count=32, radius=radius, location=place)
    bpy.ops.object.shade_smooth()
    bpy.context.object.data.materials.append(material(name, **values)[0])
bpy.ops.mesh.primitive_cube_add(size=1, location=(0.9, 0.2, 0.5), rotation=(0, 0, 0.5))
bpy.context.object.data.materials.append(material("red", Base_Color=(0.7, 0.1, 0.05, 1), Roughness=0.4)[0])
bpy.ops.mesh.primitive_cube_add(size=0.1, location=(0, 40, -5))
unseen, shader = material("unseen")
unseen.node_tree.links.new(unseen.node_tree.nodes.new("ShaderNodeTexNoise").outputs["Color"], shader.inputs["Base Color"])
bpy.context.object.data.materials.append(unseen)
bpy.ops.object.light_add(type="AREA", location=(2, -2, 4), rotation=(0.5, 0.4, 0.2))
light = bpy.context.object.data
light.energy, light.shape, light.size, light.size_y = 200, "RECTANGLE", 1, 0.6
# Small cubes on the corners of a square, by geometry nodes; an instance of a collection
nodes = bpy.data.node_groups.new("cubes", "GeometryNodeTree")
for side in ("INPUT", "OUTPUT"):
    nodes.interface.new_socket("Geometry", in_out=side, socket_type="NodeSocketGeometry")
start, end, points, cube = (nodes.nodes.new(kind) for kind in ("NodeGroupInput", "NodeGroupOutput", "GeometryNodeInstanceOnPoints",
                                                               "GeometryNodeMeshCube"))
cube.inputs["Size"].default_value = (0.3, 0.3, 0.3)
nodes.links.new(start.outputs[0], points.inputs["Points"])
nodes.links.new(cube.outputs[0], points.inputs["Instance"])
nodes.links.new(points.outputs[0], end.inputs[0])
bpy.ops.mesh.primitive_plane_add(size=2, location=(0, 1.5, 0.4))
bpy.context.object.modifiers.new("cubes", "NODES").node_group = nodes
collection = bpy.data.collections.new("posts")
bpy.ops.mesh.primitive_cylinder_add(radius=0.1, depth=1)
post = bpy.context.object
scene.collection.objects.unlink(post)
collection.objects.link(post)
post.data.materials.append(material("post", Base_Color=(0.2, 0.3, 0.6, 1), Roughness=0.8)[0])
instance = bpy.data.objects.new("post", None)
instance.instance_type, instance.instance_collection, instance.location = "COLLECTION", collection, (1.9, 0.5, 0.5)
scene.collection.objects.link(instance)
bpy.ops.object.camera_add(location=(9, 9, 9))
bpy.context.object.name = "Other"
bpy.ops.object.camera_add(location=(0, -6, 2.2), rotation=(math.radians(75), 0, 0))
scene.camera = bpy.context.object
camera = scene.camera.data
camera.lens, camera.dof.use_dof, camera.dof.aperture_fstop, camera.dof.focus_distance = 45, True, 0.4, 5.5
scene.render.resolution_x = scene.render.resolution_y = 64
scene.camera.name = "With focus"
bpy.ops.wm.save_as_mainfile(filepath="s.blend")
