# SPDX-License-Identifier: Apache-2.0
"""Converts OBJ, PLY, STL, OFF and other meshes to GLB, which the path tracer reads.

trimesh reads the file; MTL materials become glTF materials. One line lists what could not be converted.
"""

import argparse
import io
import re
import sys
from pathlib import Path

from evidence.base.atomic_write import written_beside
from evidence.base.command import CommandError, run_or_say_why

GLTF = (".gltf", ".glb")
BYTE_ORDER_MARK = b"\xef\xbb\xbf"
COMMENT = re.compile(rb"\s+#.*")
GLASS = ("4", "6", "7", "9")  # values of illum
TEXTURES = {"map_ke": "emissiveTexture", "norm": "normalTexture"}
READ = {"name", "image", "ka", "kd", "ks", "ns", "ke", "ni", "tf", "tr", "d", "illum", "pr", "pm", "map_kd", "options", *TEXTURES}
OPTIONS = re.compile(r"^(?:-\w+(?:\s+(?:[-+.\deE]+|on|off))*\s+)+")  # options before the name of a texture


def resolver_of(trimesh, path, lost):
    """Finds the files that a mesh refers to, including those with Windows paths, and records missing files."""

    class Resolver(trimesh.resolvers.FilePathResolver):
        def get(self, name):
            name = re.sub(r"^[A-Za-z]:.*/", "", str(name).strip().strip('"').replace("\\", "/"))
            try:
                data = super().get(name)
            except (OSError, ValueError):
                names = name.split()
                if len(names) > 1 and all(each.lower().endswith(".mtl") for each in names):
                    return b"\n".join(map(self.get_or_nothing, names))
                lost.add(f"{name}, which is missing")
                raise
            if not name.lower().endswith(".mtl"):
                return data
            return b"\n".join(map(plain, data.removeprefix(BYTE_ORDER_MARK).splitlines()))

        def get_or_nothing(self, name):
            try:
                return self.get(name)
            except (OSError, ValueError):
                return b""

    def plain(line):
        """trimesh treats the options of map_Kd as part of its name, and drops all materials if a colour is a single number."""
        one = re.match(rb"\s*(k[ades]|tf)\s+(\S+)\s*$", line, re.I)
        if one:
            return one[1] + 3 * (b" " + one[2])
        spectrum = re.match(rb"\s*((?:k[ades]|tf)\s+(?:xyz|spectral))\b", line, re.I)
        if spectrum:
            lost.add(spectrum[1].decode())
        if re.match(rb"\s*newmtl\s", line):
            return COMMENT.sub(b"", line)
        words = re.match(rb"\s*map_kd\s+(.*)", line, re.I)
        text = words[1].decode("utf-8", "replace") if words else ""
        options = OPTIONS.match(text)
        return b"options " + options[0].encode() + b"\nmap_kd " + text[options.end():].encode() if options else line

    return Resolver(str(path))


def transform_of(options):
    """KHR_texture_transform for the options of an MTL texture, where v points up."""
    pair = {"-s": [1.0, 1.0], "-o": [0.0, 0.0]}
    for name, values in re.findall(r"(-[so])((?:\s+[-+.\deE]+)+)", " ".join(options)):
        numbers = [float(v) for v in values.split()[:2]]
        pair[name][:len(numbers)] = numbers
    (su, sv), (u, v) = pair["-s"], pair["-o"]
    return {"scale": [su, sv], "offset": [u, 1 - sv - v]}


def converted(trimesh, source, own_resolver, lost):
    """Converts an MTL material to glTF: the material, its extensions, its exact factors and its texture transform."""
    from PIL import Image

    mtl = {name: value for name, value in source.kwargs.items() if value not in (None, [])}
    image = source.image if source.kwargs else None  # trimesh creates one for a mesh without a material

    def number(name, default):
        try:
            return float(mtl[name][-1]) if name in mtl else default  # d may be preceded by an option
        except ValueError:
            lost.add(" ".join([name, *mtl[name]]))
            return default

    lost.update(sorted(name for name in mtl if name not in READ))
    # A texture is multiplied by the colour if there is one.
    colour = list(mtl.get("kd", [0.6 if image is None else 1.0] * 3))
    emission = [float(v) for v in mtl.get("ke", [float("map_ke" in mtl)] * 3)]
    cover = number("d", 1 - number("tr", 0.0))
    glass = mtl.get("illum", ["0"])[0] in GLASS or cover < 0.5
    if cover < 1 and not glass:
        lost.add("d, as partial transparency")
    shine = max(mtl.get("ks", [0.0]))
    metal = shine > 0 and max(colour) < 0.01 and image is None
    extensions = {}
    if "pr" not in mtl and "pm" not in mtl and (shine == 0 or mtl.get("illum", ["2"])[0] in ("0", "1")):
        extensions["KHR_materials_specular"] = {"specularFactor": 0.0}
    if glass:
        extensions = {"KHR_materials_transmission": {"transmissionFactor": 1.0}, "KHR_materials_ior": {"ior": number("ni", 1.5)}}
        colour = [float(v) for v in mtl.get("tf", [])] or [1.0, 1.0, 1.0]
    if max(emission) > 1:
        extensions["KHR_materials_emissive_strength"] = {"emissiveStrength": max(emission)}
        emission = [v / max(emission) for v in emission]
    textures = {}
    for name, meant in TEXTURES.items():
        if name in mtl:
            try:
                textures[meant] = Image.open(trimesh.util.wrap_as_stream(own_resolver.get(OPTIONS.sub("", " ".join(mtl[name])))))
            except (OSError, ValueError):
                continue
    # The roughness whose lobe is as wide as that of the Blinn-Phong exponent.
    rough = 0.0 if glass else (2 / (float(mtl.get("ns", 0)) + 2)) ** 0.25
    material = trimesh.visual.material.PBRMaterial(
        baseColorFactor=[255] * 4, metallicFactor=number("pm", 1.0 if metal else 0.0),
        roughnessFactor=number("pr", rough), emissiveFactor=emission, baseColorTexture=image, doubleSided=True, **textures)
    # trimesh rounds factors to bytes.
    factors = {"baseColorFactor": [*(mtl["ks"] if metal else colour), 1.0]}
    return material, extensions, factors, transform_of(mtl["options"]) if "options" in mtl else None


def convert(path, output):
    """Writes the GLB. Returns a list of what could not be converted."""
    import trimesh

    lost, more = set(), {}
    own_resolver = resolver_of(trimesh, path, lost)
    is_obj = path.suffix.lower() == ".obj" and path.is_file()
    text = path.read_bytes().removeprefix(BYTE_ORDER_MARK) if is_obj else b""
    text = re.sub(rb"^(?:usemtl|mtllib)[ \t].*", lambda line: COMMENT.sub(b"", line[0]), text, flags=re.M)
    coloured = re.search(rb"^v(?:[ \t]+\S+){6}", text, re.M)

    def loaded(**options):
        # trimesh drops all vertex colours if one vertex has none, so such vertices become white.
        complete = re.sub(rb"^(v(?:[ \t]+[^\s#]+){3})[ \t]*(?=\r?$)", rb"\1 1 1 1", text, flags=re.M) if coloured else text
        return trimesh.load_scene(io.BytesIO(complete) if is_obj else str(path), file_type="obj" if is_obj else None,
                                  resolver=own_resolver, process=False, **options)

    try:
        scene = loaded()
        # trimesh keeps vertex colours only if it reads no materials.
        plain = loaded(skip_materials=True).geometry if coloured else {}
    except Exception as error:  # the exception types vary as much as the formats
        raise CommandError(f"trimesh cannot read {path}: {str(error).splitlines()[0] if str(error) else type(error).__name__}") from None
    if not any(len(getattr(mesh, "faces", ())) for mesh in scene.geometry.values()):
        raise CommandError(f"{path} has no triangles")
    if re.search(rb"^f(?:[ \t]+\S+){5}", text, re.M):
        lost.add("the shape of concave polygons")
    if re.search(rb"^[lp][ \t]", text, re.M):
        lost.add("lines and points")
    known = {}
    for key, mesh in scene.geometry.items():
        if mesh.visual.kind == "vertex" and (mesh.visual.vertex_colors[:, 3] < 255).any():
            lost.add("vertex alpha")
        source = getattr(mesh.visual, "material", None)
        if not isinstance(source, trimesh.visual.material.SimpleMaterial):
            continue
        if id(source) not in known:
            name = f"{len(known)} {source.kwargs.get('name', source.name) or ''}".strip()
            known[id(source)], *more[name] = converted(trimesh, source, own_resolver, lost)
            known[id(source)].name = name
        mesh.visual = trimesh.visual.TextureVisuals(uv=mesh.visual.uv, material=known[id(source)])
        if coloured and key in plain and len(plain[key].vertices) == len(mesh.vertices):
            mesh.visual.vertex_attributes["color"] = plain[key].visual.vertex_colors
        elif coloured:
            lost.add("vertex colours of objects with multiple materials")

    def finish(tree):
        used = set()
        for material in tree.get("materials", []):
            extensions, factors, transform = more.get(material.get("name"), ({}, {}, None))
            material["pbrMetallicRoughness"].update(factors)
            texture = material["pbrMetallicRoughness"].get("baseColorTexture")
            if transform and texture:
                texture["extensions"] = {"KHR_texture_transform": transform}
                used.add("KHR_texture_transform")
            material["extensions"] = extensions
            used.update(extensions)
        grey = {"pbrMetallicRoughness": {"baseColorFactor": [0.6, 0.6, 0.6, 1], "metallicFactor": 0}, "doubleSided": True,
                "extensions": {"KHR_materials_specular": {"specularFactor": 0.0}}}
        for primitive in (p for mesh in tree["meshes"] for p in mesh["primitives"] if "material" not in p):
            white = {**grey, "pbrMetallicRoughness": {"metallicFactor": 0}}
            tree.setdefault("materials", []).append(white if "COLOR_0" in primitive["attributes"] else grey)
            primitive["material"] = len(tree["materials"]) - 1
            used.add("KHR_materials_specular")
        tree["extensionsUsed"] = sorted({*tree.get("extensionsUsed", []), *used})

    data = trimesh.exchange.gltf.export_glb(scene, tree_postprocessor=finish)
    if not output.is_file() or output.read_bytes() != data:  # its time stamp tells the demo that it has not changed
        with written_beside(output) as beside:
            beside.write_bytes(data)
    return sorted(lost)


def scene_for(path, folder, program):
    """The path to a file that the path tracer reads: this file, or its conversion in the folder, which is reported."""
    path = Path(path)
    if path.suffix.lower() in GLTF or not path.is_file():
        return str(path)
    output = Path(folder) / "scene" / f"{path.stem}.glb"  # the demo checks the files beside it
    lost = convert(path, output)
    print(f"{program}: {output} is {path} as glTF" + (f", without: {', '.join(lost)}" if lost else ""), flush=True)
    return str(output)


def run(arguments):
    parser = argparse.ArgumentParser(prog="scripts/to-gltf", description=f"{__doc__} scripts/demo converts meshes by itself.")
    parser.add_argument("file", type=Path, help="a mesh in a format that trimesh reads")
    parser.add_argument("-o", dest="output", type=Path, metavar="OUT.glb", help="the GLB (default: FILE with the suffix .glb)")
    options = parser.parse_args(arguments)
    if not options.file.is_file():
        raise CommandError(f"there is no file {options.file}")
    output = options.output or options.file.with_suffix(".glb")
    if output.suffix.lower() != ".glb" or output.resolve() == options.file.resolve():
        raise CommandError(f"-o takes another file named .glb, not {output}")
    lost = convert(options.file, output)
    print(f"to-gltf: wrote {output}" + (f", without: {', '.join(lost)}" if lost else ""))


if __name__ == "__main__":
    run_or_say_why(run, sys.argv[1:], "to-gltf")
