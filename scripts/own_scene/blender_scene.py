# SPDX-License-Identifier: Apache-2.0
"""Runs in Blender's Python: reads a file, converts what glTF cannot hold, and writes a GLB and the world as an EXR.

    python blender_scene.py REQUEST.json

The request is {"source", "output", "world", "report": paths, "mtl": corrections, "texture": path}. The report receives {"lost": [...],
"bounds", "brightest" (of the world), "camera", "lens", "focus"}. Blender's own messages go to standard output.
"""

import json
import math
import re
import sys
from pathlib import Path

import bpy
from bpy_extras.object_utils import world_to_camera_view
from mathutils import Matrix, Vector

KEEP = {"forward_axis": "NEGATIVE_Z", "up_axis": "Y"}  # with the exporter's y up, coordinates stay as they are
READERS = {
    ".blend": lambda path: bpy.ops.wm.open_mainfile(filepath=path, load_ui=False, use_scripts=False),
    ".obj": lambda path: bpy.ops.wm.obj_import(filepath=path, **KEEP),
    ".ply": lambda path: bpy.ops.wm.ply_import(filepath=path, **KEEP),
    ".stl": lambda path: bpy.ops.wm.stl_import(filepath=path, **KEEP),
    ".fbx": lambda path: bpy.ops.wm.fbx_import(filepath=path),
    ".dae": lambda path: bpy.ops.wm.collada_import(filepath=path),
    ".abc": lambda path: bpy.ops.wm.alembic_import(filepath=path, as_background_job=False),
    **dict.fromkeys((".gltf", ".glb"), lambda path: bpy.ops.import_scene.gltf(filepath=path)),
    **dict.fromkeys((".usd", ".usda", ".usdc", ".usdz"), lambda path: bpy.ops.wm.usd_import(filepath=path)),
}
MESHES = (".obj", ".ply", ".stl", ".fbx", ".dae", ".abc")  # their vertex colours multiply, whatever the material says
# What the exporter understands between a texture and a material.
NODES = {"TEX_IMAGE", "MAPPING", "UVMAP", "TEX_COORD", "NORMAL_MAP", "SEPARATE_COLOR", "SEPRGB", "MIX", "MIX_RGB", "MATH", "RGB", "VALUE", "VERTEX_COLOR",
         "ATTRIBUTE", "REROUTE", "GROUP", "GROUP_INPUT", "GROUP_OUTPUT", "FRAME"}
CORNERS = 64  # of the polygon in place of a disc
SKY_WIDTH, SKY_SAMPLES = 2048, 32  # of a world without images


def principled(tree):
    """A new, black Principled BSDF that only emits or transmits what the caller sets."""
    node = tree.nodes.new("ShaderNodeBsdfPrincipled")
    for name, value in (("Base Color", (0, 0, 0, 1)), ("Specular IOR Level", 0), ("Roughness", 1)):
        node.inputs[name].default_value = value
    return node


def new_material(name):
    """A material, and its only shader."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    shader = principled(tree)
    tree.links.new(shader.outputs[0], tree.nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    return material, shader


def shader_of(material):
    """The node of a material's surface, or None."""
    node = material.node_tree.get_output_node("CYCLES") if material.use_nodes and material.node_tree else None
    links = node.inputs["Surface"].links if node else ()
    return links[0].from_node if links else None


# ---- Materials

# Shaders that a Principled BSDF replaces: {node type: ({input: its input}, {input: value})}.
SIMPLE = {
    "BSDF_DIFFUSE": ({"Color": "Base Color", "Normal": "Normal"}, {}),
    "BSDF_GLOSSY": ({"Color": "Base Color", "Roughness": "Roughness", "Normal": "Normal"}, {"Metallic": 1}),
    "BSDF_GLASS": ({"Color": "Base Color", "Roughness": "Roughness", "IOR": "IOR", "Normal": "Normal"}, {"Transmission Weight": 1, "Specular IOR Level": 0.5}),
    "EMISSION": ({"Color": "Emission Color", "Strength": "Emission Strength"}, {}),
}


def replace_simple_shader(material, shader):
    tree = material.node_tree
    inputs, values = SIMPLE[shader.type]
    new = principled(tree)
    for name, value in values.items():
        new.inputs[name].default_value = value
    for name, own in inputs.items():
        if shader.inputs[name].links:
            tree.links.new(shader.inputs[name].links[0].from_socket, new.inputs[own])
        elif name != "Normal":
            new.inputs[own].default_value = shader.inputs[name].default_value
    tree.links.new(new.outputs[0], shader.outputs[0].links[0].to_socket)
    return new


def nodes_before(socket, reached):
    for link in socket.links:
        if link.from_node not in reached:
            reached.add(link.from_node)
            for own in link.from_node.inputs:
                nodes_before(own, reached)
            if link.from_node.type == "GROUP" and link.from_node.node_tree:
                reached.update(link.from_node.node_tree.nodes)
    return reached


def check_material(material, lost):
    """Replaces shaders that glTF lacks, if possible, and reports the rest."""
    shader = shader_of(material)
    if shader and shader.type in SIMPLE:
        shader = replace_simple_shader(material, shader)
    if not shader or shader.type != "BSDF_PRINCIPLED":
        if material.use_nodes:
            lost.add(f"the surface of material {material.name}" + (f" ({shader.bl_label})" if shader else ""))
        return
    for socket in shader.inputs:
        others = sorted({node.bl_label for node in nodes_before(socket, set()) if node.type not in NODES})
        if others:
            lost.add(f"{', '.join(others)} in {socket.name} of material {material.name}")
    for name in ("Subsurface Weight", "Diffuse Roughness", "Thin Film Thickness"):
        socket = shader.inputs.get(name)
        if socket and (socket.links or socket.default_value > 0):
            lost.add(f"{name} of material {material.name}")
    output = material.node_tree.get_output_node("CYCLES")
    for name in ("Volume", "Displacement"):
        if output.inputs[name].links:
            lost.add(f"{name} of material {material.name}")


def correct_mtl(kinds):
    """Blender reads MTL's illum 3 to 9 as metal and Tf as glass, whatever the opacity."""
    for material in bpy.data.materials:
        kind = kinds.get(re.sub(r"\.\d{3}$", "", material.name)) or kinds.get(material.name)
        shader = shader_of(material)
        if not kind or not shader or shader.type != "BSDF_PRINCIPLED":
            continue
        for name, value in kind.items():
            shader.inputs[name].default_value = [*value, 1] if isinstance(value, list) else value


def default_materials(texture, lost):
    """Gives meshes without a material a grey one, or a white one under vertex colours, or one with the texture that the file names."""
    known = {}
    for mesh in bpy.data.meshes:
        coloured = bool(mesh.color_attributes)
        if any(mesh.materials):
            continue
        if coloured not in known:
            material, shader = new_material("default")
            shader.inputs["Base Color"].default_value = (1, 1, 1, 1) if coloured or texture else (0.8, 0.8, 0.8, 1)
            if texture and Path(texture).is_file():
                image = material.node_tree.nodes.new("ShaderNodeTexImage")
                image.image = bpy.data.images.load(texture)
                material.node_tree.links.new(image.outputs["Color"], shader.inputs["Base Color"])
            elif texture:
                lost.add(f"{Path(texture).name}, which is missing")
            known[coloured] = material
        mesh.materials.clear()
        mesh.materials.append(known[coloured])


# ---- Lights

def colour_of(light, lost):
    """The colour of a light times its power, exposure, temperature and Emission node."""
    colour = Vector(light.color)
    if light.use_temperature:
        colour = Vector(a * b for a, b in zip(colour, light.temperature_color))
    if light.use_nodes and light.node_tree:
        output = light.node_tree.get_output_node("CYCLES")
        node = output.inputs["Surface"].links[0].from_node if output and output.inputs["Surface"].links else None
        if node and node.type == "EMISSION" and not (node.inputs["Color"].links or node.inputs["Strength"].links):
            scale = node.inputs["Strength"].default_value
            colour = Vector(a * b * scale for a, b in zip(colour, node.inputs["Color"].default_value))
        else:
            lost.add(f"the nodes of light {light.name}")
    if not light.normalize:
        lost.add(f"the unnormalized power of light {light.name}")
    return light.energy * 2**light.exposure * colour


def replace_light(item, mesh, area, lost):
    """Replaces a light of power P by the front of a mesh with this area A, in world space, and the radiance P / (pi A)."""
    colour = colour_of(item.data, lost) / (math.pi * max(area, 1e-30))
    strength = max(*colour, 1e-30)
    material, shader = new_material(item.data.name)
    material.use_backface_culling = True
    shader.inputs["Emission Color"].default_value = [*(colour / strength), 1]
    shader.inputs["Emission Strength"].default_value = strength
    mesh.materials.append(material)
    new = bpy.data.objects.new(item.name, mesh)
    new.matrix_world = item.matrix_world
    bpy.context.scene.collection.objects.link(new)
    bpy.data.objects.remove(item)


def emissive_sphere(item, lost):
    """Replaces a point light by a sphere. Blender does not scale its radius. With Blender's "soft falloff", a light of radius r is a disc that
    faces each point, so at distance d it gives d^2 / (d^2 + r^2) of the sphere's light."""
    import bmesh  # bpy makes it importable

    mesh, sphere = bpy.data.meshes.new(item.data.name), bmesh.new()
    bmesh.ops.create_uvsphere(sphere, u_segments=24, v_segments=12, radius=item.data.shadow_soft_size)
    sphere.to_mesh(mesh)
    item.matrix_world = Matrix.Translation(item.matrix_world.translation)
    replace_light(item, mesh, sum(face.area for face in mesh.polygons), lost)


def emissive_rectangle(item, lost):
    """Replaces an area light by a surface that shines to the light's -z."""
    light, size = item.data, Vector((item.data.size, item.data.size))
    if light.shape in ("RECTANGLE", "ELLIPSE"):
        size.y = light.size_y
    if light.shape in ("DISK", "ELLIPSE"):
        turns = [2 * math.pi * i / CORNERS for i in range(CORNERS)]
        # As large as the ellipse, not inside it.
        grow = math.sqrt(2 * math.pi / CORNERS / math.sin(2 * math.pi / CORNERS)) / 2
        corners = [(grow * math.cos(a), -grow * math.sin(a)) for a in turns]
    else:
        corners = [(-0.5, -0.5), (-0.5, 0.5), (0.5, 0.5), (0.5, -0.5)]
    if light.spread < math.pi - 1e-3:
        lost.add(f"the spread of light {light.name}")
    mesh = bpy.data.meshes.new(light.name)
    mesh.from_pydata([(x * size.x, y * size.y, 0) for x, y in corners], [], [range(len(corners))])
    x, y = (item.matrix_world.to_3x3() @ Vector(v) for v in ((size.x, 0, 0), (0, size.y, 0)))
    area = x.cross(y).length * (math.pi / 4 if len(corners) > 4 else 1)
    replace_light(item, mesh, area, lost)


def in_view(scene, item):
    """Whether the camera sees the middle of a light, or an edge of a point light, from a side that shines."""
    if not scene.camera:
        return False
    place, eye = item.matrix_world, scene.camera.matrix_world
    radius, ways = 0, ((0, 0, 0), (1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0))
    if item.data.type == "POINT":
        radius = item.data.shadow_soft_size
    elif (place.to_3x3() @ Vector((0, 0, -1))).dot(eye.translation - place.translation) <= 0:
        return False
    seen = [world_to_camera_view(scene, scene.camera, place.translation + radius * (eye.to_3x3() @ Vector(way))) for way in ways]
    return any(depth > 0 and 0 <= x <= 1 and 0 <= y <= 1 for x, y, depth in seen)


def convert_lights(scene, lost):
    for item in [item for item in scene.objects if item.type == "LIGHT" and not hidden(item)]:
        light = item.data
        if light.type == "AREA" or light.type == "POINT" and light.shadow_soft_size > 0:
            if in_view(scene, item):
                lost.add(f"the invisibility of light {item.name}")
            (emissive_rectangle if light.type == "AREA" else emissive_sphere)(item, lost)
            continue
        light = item.data = light.copy()  # others may have shared it
        colour = colour_of(light, lost)
        strength = max(*colour, 1e-30)
        light.energy, light.color = strength, colour / strength
        light.exposure, light.use_temperature, light.use_nodes = 0, False, False
        if light.type == "SPOT":
            # glTF's edge is a squared ramp, Blender's is a smooth step: with three quarters of the width, the power is the same.
            outer = math.cos(light.spot_size / 2)
            light.spot_blend = 1 - math.acos(min(outer + 0.75 * light.spot_blend * (1 - outer), 1)) / (light.spot_size / 2)
        if light.type == "SUN" and light.angle > 0 or light.type == "SPOT" and light.shadow_soft_size > 0:
            lost.add("the size of sun and spot lights, so their shadows are sharp")


def hidden(item):
    collections = item.users_collection
    return item.hide_render or bool(collections) and all(collection.hide_render for collection in collections)


# ---- The world and the camera

def write_world(world, path, lost):
    """Renders the world as a latitude-longitude EXR. Returns its largest value, or None without a world."""
    if not world:
        return None
    nodes = list(world.node_tree.nodes) if world.use_nodes and world.node_tree else []
    images = [node.image.size[0] for node in nodes if node.type in ("TEX_ENVIRONMENT", "TEX_IMAGE") and node.image]
    others = [node for node in nodes if node.type.startswith("TEX_") and node.type != "TEX_COORD"]
    for node in nodes:
        if node.type == "LIGHT_PATH":
            lost.add("Light Path in the world: it lights as the camera sees it")
        if node.type == "OUTPUT_WORLD" and node.inputs["Volume"].links:
            lost.add("the world's volume")
    width = min(max(images), 8192) if images else SKY_WIDTH if others else 16
    scene = bpy.data.scenes.new("world")
    scene.world = world
    camera = bpy.data.objects.new("world", bpy.data.cameras.new("world"))
    camera.data.type = "PANO"
    camera.data.panorama_type = "EQUIRECTANGULAR"
    camera.matrix_world = Matrix.Rotation(math.pi / 2, 4, "X") @ Matrix.Rotation(math.pi, 4, "Y")
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = width, max(width // 2, 1), 100
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_mode = "RGB"
    scene.render.image_settings.color_depth = "32"
    scene.render.use_stamp_date = scene.render.use_stamp_render_time = scene.render.use_stamp_time = scene.render.use_stamp_filename = False
    cycles = scene.cycles
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    # Images are sampled at the centres of their texels.
    procedural = len(others) > len(images)
    cycles.samples, cycles.filter_width = (SKY_SAMPLES, 1.0) if procedural else (1, 0.01)
    cycles.pixel_filter_type = "BOX" if procedural else "BLACKMAN_HARRIS"
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True, scene=scene.name)
    rendered = bpy.data.images.load(str(path))
    largest = max(rendered.pixels[i] for i in range(len(rendered.pixels)) if i % 4 != 3) if width <= 16 else 1.0
    bpy.data.scenes.remove(scene)
    return largest


def camera_of(scene, lost):
    """{"camera": name, "lens", "focus"} of the active camera."""
    item = scene.camera
    if not item:
        return {}
    camera = item.data
    if camera.type != "PERSP":
        lost.add(f"camera {item.name}, which is {camera.type.lower()}")
        return {}
    if abs(camera.shift_x) + abs(camera.shift_y) > 0:
        lost.add(f"the shift of camera {item.name}")
    found = {"camera": item.name}
    if camera.dof.use_dof:
        eye, ahead = item.matrix_world.translation, item.matrix_world.to_3x3() @ Vector((0, 0, -1))
        target = camera.dof.focus_object
        focus = (target.matrix_world.translation - eye).dot(ahead.normalized()) if target else camera.dof.focus_distance
        found.update(lens=camera.lens / 1000 / (2 * camera.dof.aperture_fstop), focus=focus)
        if camera.dof.aperture_blades or camera.dof.aperture_ratio != 1:
            lost.add(f"the aperture's shape of camera {item.name}")
    return found


# ---- Objects

def make_instances_real(scene):
    """Replaces instances by objects: of collections, particles, vertices and geometry nodes."""
    graph = bpy.context.evaluated_depsgraph_get()
    found, data, parents = [], {}, set()
    for instance in graph.object_instances:
        item = instance.object
        if not instance.is_instance or item.type not in ("MESH", "CURVE", "SURFACE", "FONT", "META", "LIGHT"):
            continue
        parents.add(instance.parent.original)
        key = item.data.as_pointer()
        if key not in data:
            data[key] = item.original.data if item.type == "LIGHT" else bpy.data.meshes.new_from_object(item)
        found.append((item.name, data[key], instance.matrix_world.copy()))
    for parent in parents:
        if parent.instance_type in ("VERTS", "FACES"):
            for child in parent.children:
                child.hide_render = True
        parent.instance_type = "NONE"
    for name, of, place in found:
        new = bpy.data.objects.new(name, of)
        scene.collection.objects.link(new)
        new.matrix_world = place


def check_objects(scene, lost):
    for item in scene.objects:
        if hidden(item):
            continue
        if item.type in ("VOLUME", "CURVES", "POINTCLOUD", "GPENCIL", "GREASEPENCIL"):
            lost.add(f"object {item.name} ({item.type.lower()})")
        if any(system.settings.type == "HAIR" and system.settings.render_type == "PATH" for system in item.particle_systems):
            lost.add(f"the hair of object {item.name}")
    for image in bpy.data.images:
        if image.source == "FILE" and image.users and not image.packed_file and not Path(bpy.path.abspath(image.filepath)).is_file():
            lost.add(f"{Path(image.filepath).name or image.name}, which is missing")


def bounds_of(scene):
    """The lowest and the highest coordinates of the boxes around all meshes, with y up."""
    meshes = (item for item in scene.objects if item.type == "MESH" and not hidden(item))
    points = [item.matrix_world @ Vector(corner) for item in meshes for corner in item.bound_box]
    points = [(p.x, p.z, -p.y) for p in points] or [(0, 0, 0)]
    return [[reach(values) for values in zip(*points)] for reach in (min, max)]


def main(request):
    source, suffix, lost = request["source"], Path(request["source"]).suffix.lower(), set()
    if suffix != ".blend":
        bpy.ops.wm.read_factory_settings(use_empty=True)
    READERS[suffix](source)
    scene = bpy.context.scene
    make_instances_real(scene)
    correct_mtl(request.get("mtl", {}))
    default_materials(request.get("texture"), lost)
    check_objects(scene, lost)
    used = {slot.material for item in scene.objects if not hidden(item) for slot in item.material_slots if slot.material}
    for material in sorted(used, key=lambda material: material.name):
        check_material(material, lost)
    report = camera_of(scene, lost)
    report["brightest"] = write_world(scene.world, request["world"], lost)
    convert_lights(scene, lost)
    bpy.ops.export_scene.gltf(
        filepath=request["output"], export_format="GLB", export_apply=True, export_cameras=True, export_lights=True, export_animations=False,
        export_skins=False, export_morph=False, export_import_convert_lighting_mode="COMPAT", use_renderable=True, use_active_scene=True,
        export_vertex_color="ACTIVE" if suffix in MESHES else "MATERIAL", export_all_vertex_colors=False,
        export_active_vertex_color_when_no_material=suffix in MESHES)
    Path(request["report"]).write_text(json.dumps({**report, "bounds": bounds_of(scene), "lost": sorted(lost)}))


if __name__ == "__main__":
    main(json.loads(Path(sys.argv[1]).read_text()))
