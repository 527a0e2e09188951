# SPDX-License-Identifier: Apache-2.0
"""Converts .blend, OBJ, PLY, STL, FBX, USD, Alembic and Collada files to GLB, which the path tracer reads.

Blender reads the file and writes the GLB. Area lights become emissive surfaces, and the world becomes an EXR file beside the GLB. One line
lists what could not be converted, another the options to render with. The first run installs Blender as a Python module (bpy).
"""

import argparse
import json
import math
import os
import re
import shutil
import struct
import subprocess
import sys
import tempfile
from pathlib import Path

from evidence.base.atomic_write import written_beside
from evidence.base.command import CommandError, run_or_say_why

GLTF = (".gltf", ".glb")
FORMATS = (".blend", ".obj", ".ply", ".stl", ".fbx", ".usd", ".usda", ".usdc", ".usdz", ".abc", ".dae")
BPY = "bpy==4.5.15"
SIZE = "a download of 400 MB, 1 GB on disk"
FAR = 16  # move a mesh to the origin if it is this many times its size away


# ---- Blender

def blender(program):
    """The Python that has Blender's module, installed if needed."""
    folder = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "libbn" / "blender-4.5"
    python, complete = folder / "bin/python", folder / "complete"
    if complete.is_file() and complete.read_text() == BPY:
        return python
    base = next(filter(None, (shutil.which(name) for name in (os.environ.get("PYTHON311"), "python3.11") if name)), None)
    if not base:
        raise CommandError("Blender's Python module needs Python 3.11; install it, or set PYTHON311 to its path")
    print(f"{program}: installing Blender 4.5 ({BPY}: {SIZE}) into {folder}; this happens once", file=sys.stderr, flush=True)
    complete.unlink(missing_ok=True)
    for command in ([base, "-m", "venv", "--clear", folder], [python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", BPY]):
        done = subprocess.run([*map(str, command)], stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False)
        if done.returncode:
            said = (done.stderr.strip() or done.stdout.strip() or "no message").splitlines()[-1]
            raise CommandError(f"cannot install Blender: {said}; remove {folder} and try again, or export the scene as glTF yourself")
    complete.write_text(BPY)
    return python


def messages(text):
    """The importers' and the exporter's warnings in Blender's output. Some are not about losses."""
    found = re.findall(r"(?:WARN|ERROR) \(io[.\w]*\): (?:\S+\.cc:\d+ )?(?:\w+: )?(.*)|\| (?:WARNING|ERROR): (.*)|^(?:Warning|Error): (.*)", text, re.M)
    lines = (re.sub(r"\s+", " ", max(match, key=len)).strip(" .") for match in found)
    return {line for line in lines if line and not any(part in line for part in ("active Vertex Color", "Draco", "has no primitives"))}


# ---- What Blender would lose

def centre_of(low, high):
    """A point near the middle of far coordinates, with few digits; None if they are not far."""
    middle = [(a + b) / 2 for a, b in zip(low, high)]
    extent = max(b - a for a, b in zip(low, high))
    return [float(round(m)) for m in middle] if max(map(abs, middle)) > FAR * max(extent, 1.0) else None


def moved_text(data, keyword):
    """Moves the vertices of a text, such as the lines "v x y z", to the origin. Returns the text and where it was, or None."""
    pattern = re.compile(rb"^(\s*" + keyword + rb"[ \t]+)(\S+)[ \t]+(\S+)[ \t]+(\S+)", re.M)
    low, high = [math.inf] * 3, [-math.inf] * 3
    try:
        for match in pattern.finditer(data):
            for i in range(3):
                value = float(match[i + 2])
                low[i], high[i] = min(low[i], value), max(high[i], value)
    except ValueError:
        return data, None  # Blender says what is wrong
    centre = centre_of(low, high) if low[0] < math.inf else None
    if not centre:
        return data, None
    place = lambda match: match[1] + b" ".join(repr(float(match[i + 2]) - centre[i]).encode() for i in range(3))
    return pattern.sub(place, data), centre


PLY_TYPES = {"char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2", "ushort": "u2", "uint16": "u2", "int": "i4", "int32": "i4",
             "uint": "u4", "uint32": "u4", "float": "f4", "float32": "f4", "double": "f8", "float64": "f8"}


def moved_ply(data):
    """Like moved_text, for the vertices of a PLY file if they are its first element."""
    import numpy as np

    header, end, body = data.partition(b"end_header\n")
    text = header.decode("latin-1")
    first = re.search(r"^element (\w+) (\d+)\s*\n((?:(?:property|comment) .*\n)*)", text, re.M)
    properties = re.findall(r"^property (\w+) (\w+)\s*$", first[3], re.M) if first and first[1] == "vertex" and "property list" not in first[3] else []
    names = [name for _, name in properties]
    if not end or not {"x", "y", "z"} <= {*names}:
        return data, None
    if "format ascii" in text:
        lines = body.split(b"\n")
        rows = [line.split() for line in lines[:int(first[2])]]
        places = [names.index(c) for c in "xyz"]
        values = np.array([[float(row[p]) for p in places] for row in rows])
    else:
        order = "<" if "binary_little_endian" in text else ">"
        table = np.frombuffer(body, [(name, order + PLY_TYPES[kind]) for kind, name in properties], int(first[2])).copy()
        values = np.stack([table[c].astype(float) for c in "xyz"], -1)
    centre = centre_of(values.min(0).tolist(), values.max(0).tolist()) if len(values) else None
    if not centre:
        return data, None
    if "format ascii" in text:
        for row, value in zip(rows, values - centre):
            for place, number in zip(places, value):
                row[place] = repr(float(number)).encode()
        return header + end + b"\n".join([b" ".join(row) for row in rows] + lines[len(rows):]), centre
    for i, c in enumerate("xyz"):
        table[c] = values[:, i] - centre[i]
    return header + end + table.tobytes() + body[table.nbytes:], centre


def with_corners(data):
    """A PLY file with one vertex per corner if its faces have texture coordinates, as MeshLab writes them; other files as they are."""
    import numpy as np

    header, end, body = data.partition(b"end_header\n")
    elements, kinds = [], {"i1": "b", "u1": "B", "i2": "h", "u2": "H", "i4": "i", "u4": "I", "f4": "f", "f8": "d"}
    for words in map(str.split, header.decode("latin-1").splitlines()):
        if words[:1] == ["element"]:
            elements.append((words[1], int(words[2]), {}))
        elif words[:1] == ["property"] and elements:
            elements[-1][2][words[-1]] = (PLY_TYPES[words[-2]], PLY_TYPES[words[2]] if words[1] == "list" else None)
    if [name for name, *_ in elements[:2]] != ["vertex", "face"] or "texcoord" not in elements[1][2]:
        return data
    (_, count, vertex), (_, faces, face) = elements[:2]
    index = next((name for name in ("vertex_indices", "vertex_index") if name in face), None)
    if not index or any(of for _, of in vertex.values()):
        return data
    table = np.zeros(count, [(name, "<" + kind) for name, (kind, _) in vertex.items()])
    if b"format ascii" in header:
        words = iter(body.split())
        read = lambda kind, n: [float(next(words)) for _ in range(n)]
        table[:] = [tuple(read("", len(vertex))) for _ in range(count)]
    else:
        order, at = "<" if b"binary_little_endian" in header else ">", table.nbytes
        table[:] = np.frombuffer(body, [(name, order + kind) for name, (kind, _) in vertex.items()], count)

        def read(kind, n):
            nonlocal at
            values = struct.unpack_from(f"{order}{n}{kinds[kind]}", body, at)
            at += n * int(kind[1])
            return values

    corners, coordinates, sizes = [], [], []
    for _ in range(faces):
        row = {name: read(kind, 1 if of is None else int(read(of, 1)[0])) for name, (kind, of) in face.items()}
        sizes.append(len(row[index]))
        corners.extend(map(int, row[index]))
        coordinates.extend(row["texcoord"])
    if len(coordinates) != 2 * len(corners):
        return data
    result = np.zeros(len(corners), [*table.dtype.descr, ("s", "<f4"), ("t", "<f4")])
    for name in vertex:
        result[name] = table[name][corners]
    result["s"], result["t"] = np.reshape(coordinates, (-1, 2)).T
    names = {kind: name for name, kind in PLY_TYPES.items()}
    properties = "".join(f"property {names[kind[1:]]} {name}\n" for name, kind in result.dtype.descr)
    comments = b"".join(re.findall(rb"^comment .*\n", header, re.M)).decode("latin-1")
    text = (f"ply\nformat binary_little_endian 1.0\n{comments}element vertex {len(corners)}\n{properties}element face {faces}\n"
            "property list uchar int vertex_indices\nend_header\n")
    starts = np.cumsum([0, *sizes])
    return text.encode("latin-1") + result.tobytes() + b"".join(
        struct.pack(f"<B{n}i", n, *range(start, start + n)) for start, n in zip(starts.tolist(), sizes))


def mtl_files(data, folder):
    """The MTL files of an OBJ's text, and the text with one name per line."""
    found = []

    def split(match):
        name = match[1].decode("utf-8", "surrogateescape").strip()
        name = (name if (folder / name).is_file() else re.split(r"\s+#", name)[0]).strip('"').replace("\\", "/")
        names = re.split(r"(?<=\.mtl)\s+", name, flags=re.I)
        names = [name] if (folder / name).is_file() or len(names) < 2 else names
        found.extend(folder / each for each in names)
        return b"\n".join(b"mtllib " + each.encode("utf-8", "surrogateescape") for each in names)

    return re.sub(rb"^mtllib[ \t]+([^\r\n]*)", split, data, flags=re.M), found


def mtl_corrections(text):
    """{material: {input of the Principled BSDF: value}} for materials with illum 3 or more, which Blender takes for metal, and with Tf, which it
    takes for glass. Only what is not opaque is glass, and what refracts without saying how opaque it is."""
    result = {}
    for part in re.split(r"^\s*newmtl\s+", text, flags=re.M)[1:]:
        name, _, lines = part.partition("\n")
        words = {line.split()[0].lower(): line.split()[1:] for line in lines.splitlines() if len(line.split()) > 1}

        def numbers(key, default, words=words):
            try:
                return [float(word) for word in words[key] if not word.startswith("-halo")] or default
            except (KeyError, ValueError):
                return default

        illum, cover = words.get("illum", ["2"])[0], numbers("d", [1 - numbers("tr", [0.0])[-1]])[-1]
        index, colour, shine = numbers("ni", [1.5])[-1], numbers("kd", [0.8] * 3), numbers("ks", [0.0])
        if illum not in "3456789" and "tf" not in words:
            continue
        says_cover = "d" in words or "tr" in words
        if illum in "4679" and (cover < 1 or (not says_cover and illum in "67" and index > 1)):
            tint = numbers("tf", [1.0])
            result[name.strip()] = {"Transmission Weight": 1.0, "Metallic": 0.0, "Alpha": 1.0, "IOR": index, "Roughness": 0.0, "Specular IOR Level": 0.5,
                                    "Base Color": tint if len(tint) == 3 else tint[:1] * 3}
        elif "pm" not in words:
            mirror = max(shine) > 0 and max(colour) < 0.01 and "map_kd" not in words
            result[name.strip()] = {"Transmission Weight": 0.0, "Metallic": float(mirror), **({"Base Color": (shine * 3)[:3]} if mirror else {})}
    return result


def prepared(path, folder):
    """Returns (the file for Blender to read, where its coordinates were, more of its request)."""
    suffix, more = path.suffix.lower(), {}
    if suffix not in (".obj", ".ply", ".stl"):
        return path, None, more
    data = before = path.read_bytes()
    if suffix == ".ply":
        texture = re.search(rb"^comment TextureFile[ \t]+([^\r\n]+)", data[:10000], re.M)
        more = {"texture": str(path.parent / os.fsdecode(texture[1].strip()))} if texture else {}
        try:
            data, centre = moved_ply(with_corners(data))
        except (ValueError, KeyError, IndexError, StopIteration, struct.error):
            data, centre = before, None  # Blender says what is wrong
    else:
        data, centre = moved_text(data, b"v" if suffix == ".obj" else b"vertex") if b"\0" not in data[:1000] else (data, None)
    if suffix == ".obj":
        data, libraries = mtl_files(data.removeprefix(b"\xef\xbb\xbf"), path.parent)
        texts = [file.read_bytes().decode("utf-8", "replace") for file in libraries if file.is_file()]
        names = {name for text in texts for name in re.findall(r"^\s*newmtl\s+(.*?)\s*$", text, re.M)}
        plain = lambda match: match[0] if match[0][7:].decode("utf-8", "replace").strip() in names else match[1]
        data = re.sub(rb"^(usemtl[ \t]+[^\r\n]*?)[ \t]+#[^\r\n]*", plain, data, flags=re.M)  # Blender takes comments for part of the name
        more = {"mtl": {name: kind for text in texts for name, kind in mtl_corrections(text).items()}}
    if data == before:
        return path, None, more
    # Other files are found by their relative names.
    for real, links in ((path.parent.parent, folder / "up"), (path.parent, folder / "up" / "here")):
        links.mkdir()
        for entry in real.iterdir():
            if entry != path and not (links.name == "up" and entry.name == "here"):
                (links / entry.name).symlink_to(entry)
    copy = folder / "up" / "here" / path.name
    copy.write_bytes(data)
    return copy, centre, more


# ---- The result

def parts_of(glb):
    """A GLB's JSON, and the rest of its bytes."""
    length = int.from_bytes(glb[12:16], "little")
    return json.loads(glb[20:20 + length]), glb[20 + length:]


def glb_of(tree, rest):
    text = json.dumps(tree, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    return b"glTF" + (2).to_bytes(4, "little") + (20 + len(text) + len(rest)).to_bytes(4, "little") + len(text).to_bytes(4, "little") + b"JSON" + text + rest


def move(tree, centre):
    """Moves the scene by a translation, in double precision."""
    scene = tree["scenes"][tree.get("scene", 0)]
    tree["nodes"].append({"translation": centre, "children": scene["nodes"]})
    scene["nodes"] = [len(tree["nodes"]) - 1]


def camera_number(tree, name):
    """The path tracer's number of the camera whose node has this name."""
    cameras, open_nodes = [], list(reversed(tree["scenes"][tree.get("scene", 0)]["nodes"]))
    while open_nodes:
        node = tree["nodes"][open_nodes.pop()]
        if "camera" in node and tree["cameras"][node["camera"]]["type"] == "perspective":
            cameras.append(node)
        open_nodes.extend(reversed(node.get("children", [])))
    return next((i for i, node in enumerate(cameras) if name == node.get("name")), 0)


def options_for(tree, report, world, is_blend):
    """The options of the path tracer that the GLB cannot hold."""
    options, brightest = [], report.get("brightest")
    if report.get("camera") and camera_number(tree, report["camera"]):
        options += ["--camera", str(camera_number(tree, report["camera"]))]
    if brightest:
        options += ["--env", str(world)]
    elif is_blend:
        options += ["--env", "none"]
    if report.get("lens"):
        options += ["--lens", f"{report['lens']:.6g}", "--focus", f"{report['focus']:.6g}"]
    return options


def write_if_changed(path, data):
    """The demo recognizes an unchanged file by its time stamp."""
    if not path.is_file() or path.read_bytes() != data:
        with written_beside(path) as beside:
            beside.write_bytes(data)


def convert(path, output, program="to-gltf"):
    """Writes the GLB and, if the file has a world, an EXR beside it. Returns (what is lost, the options to render with, Blender's report)."""
    path, output = Path(path), Path(output)
    if path.suffix.lower() not in (*FORMATS, *GLTF):
        raise CommandError(f"{path} is none of {', '.join(FORMATS)}")
    python = blender(program)
    with tempfile.TemporaryDirectory(prefix="libbn-") as name:
        folder = Path(name)
        source, centre, more = prepared(path.resolve(), folder)
        files = {key: str(folder / value) for key, value in (("output", "scene.glb"), ("world", "world.exr"), ("report", "report.json"))}
        (folder / "request.json").write_text(json.dumps({"source": str(source), **files, **more}))
        done = subprocess.run([python, Path(__file__).with_name("blender_scene.py"), folder / "request.json"], cwd=folder, stdin=subprocess.DEVNULL,
                              capture_output=True, text=True, errors="replace", check=False)
        said = messages(done.stdout + done.stderr)
        if not Path(files["report"]).is_file() or not Path(files["output"]).is_file():
            last = sorted(said) or (done.stderr.strip() or done.stdout.strip() or "no message").splitlines()[-1:]
            raise CommandError(f"Blender cannot read {path}: {last[0].replace(str(folder), '').strip()}")
        report = json.loads(Path(files["report"]).read_text())
        tree, rest = parts_of(Path(files["output"]).read_bytes())
        if not any(mesh["primitives"] for mesh in tree.get("meshes", [])):
            raise CommandError(f"{path} has no triangles" + (f" ({'; '.join(sorted(said))})" if said else ""))
        if centre:
            move(tree, centre)
        write_if_changed(output, glb_of(tree, rest))
        world = output.with_suffix(".world.exr")
        if report.get("brightest"):
            write_if_changed(world, Path(files["world"]).read_bytes())
        options = options_for(tree, report, world, path.suffix.lower() == ".blend")
    low, high = report["bounds"]
    if max(abs(a + b) / 2 for a, b in zip(low, high)) > 1e4 * max(max(b - a for a, b in zip(low, high)), 1e-30):
        report["lost"].append("the last digits of coordinates so far from the origin")
    missing = [line.removesuffix(", which is missing") for line in report["lost"]]
    said = {line for line in said if not any(f"{name}'" in line for name in missing)}  # is said once
    return sorted({*report["lost"], *said}), options, report


def scene_for(path, folder, program):
    """(the path to a file that the path tracer reads, options for it, lines about it): this file, or its conversion in the folder."""
    path = Path(path)
    if path.suffix.lower() in GLTF or not path.is_file():
        return str(path), [], []
    output = Path(folder) / "scene" / f"{path.stem}.glb"  # the demo checks the files beside it
    lost, options, _ = convert(path, output, program)
    lines = [f"{output} is {path} as glTF" + (f", with {' '.join(options)}" if options else "")]
    return str(output), options, lines + ([f"{path}: conversion to glTF loses {', '.join(lost)}"] if lost else [])


def run(arguments):
    parser = argparse.ArgumentParser(prog="scripts/to-gltf", description=f"{__doc__} scripts/demo converts files by itself.")
    parser.add_argument("file", type=Path, help=f"the file: {', '.join(FORMATS)}")
    parser.add_argument("-o", dest="output", type=Path, metavar="OUT.glb", help="the GLB (default: FILE with the suffix .glb)")
    options = parser.parse_args(arguments)
    if not options.file.is_file():
        raise CommandError(f"there is no file {options.file}")
    output = options.output or options.file.with_suffix(".glb")
    if output.suffix.lower() != ".glb" or output.resolve() == options.file.resolve():
        raise CommandError(f"-o takes another file named .glb, not {output}")
    lost, more, _ = convert(options.file, output)
    print(f"to-gltf: wrote {output}" + (f", without: {', '.join(lost)}" if lost else ""))
    if more:
        print(f"to-gltf: render it with --scene {output} {' '.join(more)}")


if __name__ == "__main__":
    run_or_say_why(run, sys.argv[1:], "to-gltf")
