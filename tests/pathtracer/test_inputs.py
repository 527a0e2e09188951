# SPDX-License-Identifier: Apache-2.0
"""The files that a picture is made of: --list-inputs, and pictures whose files have changed meanwhile."""

import hashlib
import json
import os
import subprocess

import numpy as np
import pytest
from pathtracer_driver import read_exr
from PIL import Image
from scene_files import SMALL, Gltf, encoded, floor, write_environment

OUT = ["-o", "out.exr"]


def write_image(path, colour=200):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(encoded(np.full((4, 4, 3), colour)))


def write_obj(folder, first_line, **material_files):
    """A triangle for each material file, of the material that has its name."""
    text = first_line + "v 0 0 0\nv 1 0 0\nv 0 0 -1\nvt 0 0\n"
    for name, lines in material_files.items():
        (folder / f"{name}.mtl").write_text(f"newmtl {name}\n{lines}")
        text += f"usemtl {name}\nf 1/1 2/1 3/1\n"
    (folder / "scene.obj").write_text(text)
    return folder / "scene.obj"


def external_images(g, *uris):
    """A quad for each image, with it as base colour."""
    for uri in uris:
        texture = g.add("textures", source=g.add("images", uri=uri))
        material = g.material(pbr={"baseColorTexture": {"index": texture}})
        quad = np.array([[-1, 0, 1], [1, 0, 1], [1, 0, -1], [-1, 0, -1]], np.float32)
        indices = np.array([0, 1, 2, 0, 2, 3], np.uint16)
        g.node(mesh=g.mesh(quad, indices, material, TEXCOORD_0=quad[:, ::2].copy()))
    return g


def gltf_with_escapes(folder):
    names = ["jpg/base.png", "\u00e9.png", "a b.png", "per%cent.png"]
    g = external_images(Gltf(), "jpg/base.png", "\u00e9.png", "a%20b.png", "per%25cent.png")
    data = bytes(g.bytes)
    text = json.dumps(g.document(uri="my mesh.bin"))
    text = text.replace("jpg/base", "jpg\\/base").replace("my mesh", "my\\u0020mesh")
    assert "\\u00e9" in text
    (folder / "scene.gltf").write_text(text)
    (folder / "my mesh.bin").write_bytes(data)
    return "scene.gltf", [*names, "my mesh.bin"]


def glb_with_images(folder):
    external_images(Gltf(), "t/a.png", "b.png").save(folder / "scene.glb")
    return "scene.glb", ["t/a.png", "b.png"]


def obj_with_maps(folder):
    maps = {"map_Kd": "my wood.png", "norm": "n.png", "map_Pr": "p.png", "map_Pm": "q.png", "map_d": "d.png"}
    write_obj(folder, "mtllib one.mtl two.mtl three.mtl\n",
              one="".join(f"{word} {name}\n" for word, name in maps.items()),
              two="map_Kd -s 1 1 1 t\\deep\\d.png\n", three="Ke 2 2 2\nmap_Ke C:\\theirs\\e.png\n")
    return "scene.obj", ["one.mtl", "two.mtl", "three.mtl", *maps.values(), "t/deep/d.png", "e.png"]


@pytest.mark.parametrize("write", [gltf_with_escapes, glb_with_images, obj_with_maps])
def test_all_files_are_listed(pathtracer, write):
    """What is listed is what is read: without any one of the files there is no scene, or another list."""
    folder = pathtracer.folder
    scene, names = write(folder)
    for name in names:
        if name.endswith(".png"):
            write_image(folder / name)
    write_image(folder / "mask.png")
    write_environment(folder / "sky.exr", 1.0)
    names = sorted([scene, *names, "mask.png", "sky.exr"], key=str.encode)
    options = ["--scene", scene, "--env", "sky.exr", "--sampler", "mask", "--mask", "mask.png"]
    listed = pathtracer.success(*options, "--list-inputs").stdout
    wanted = [f"{hashlib.sha256((folder / name).read_bytes()).hexdigest()}  {name}\n" for name in names]
    assert listed.splitlines(keepends=True) == wanted
    assert read_exr(pathtracer.render(*options, *SMALL, "--spp", 1))[1]["inputs"] == listed
    for name in names:
        (folder / name).rename(folder / "aside")
        done = pathtracer.run(*options, "--list-inputs")
        if name.endswith(".mtl"):
            assert done.returncode == 0 and name not in done.stdout
        else:
            assert done.returncode == 1 and done.stderr.count("\n") == 1
        (folder / "aside").rename(folder / name)


def test_sizes_and_names_of_any_kind(pathtracer):
    """Of a file in pieces too; sha256sum can check the list, whatever the names."""
    folder = pathtracer.folder
    for size in (0, 1, 1 << 20, (1 << 20) + 1):
        (folder / "m.png").write_bytes(bytes(range(251)) * (size // 251) + bytes(size % 251))
        line = pathtracer.success("--mask", "m.png", "--list-inputs").stdout
        assert line == f"{hashlib.sha256((folder / 'm.png').read_bytes()).hexdigest()}  m.png\n"
    for name in ["a b.png", "back\\slash.png", "line\nbreak.png", "\u00e9.png", "sub/../a b.png", "./-o.png"]:
        (folder / "sub").mkdir(exist_ok=True)
        (folder / name).write_bytes(b"x")
        listed = pathtracer.success("--mask", name, "--list-inputs").stdout
        assert listed.count("\n") == 1
        done = subprocess.run(["sha256sum", "--check", "--strict", "--quiet"], input=listed, text=True, cwd=folder,
                              capture_output=True, check=False)
        assert done.returncode == 0, (listed, done.stderr)
    assert pathtracer.success("--scene", "cornell", "--env", "sky", "--list-inputs").stdout == ""
    # Attributes of an EXR are UTF-8: what is not becomes escapes.
    rng = np.random.default_rng(4)
    fixed = [b"\xe4.png", b"\xc3\xa9.png", b"\xc0\x80", b"\xf4\x90\x80\x80", b"\xf0\x9f\x98\x80", b"\xe2\x82"]
    for name in [*fixed, *(bytes(rng.integers(0x30, 256, 3, dtype=np.uint8)) for _ in range(30))]:
        (folder / os.fsdecode(name)).write_bytes(b"x")
        listed = subprocess.run([pathtracer.binary, "--mask", name, "--list-inputs"], cwd=folder, capture_output=True,
                                check=True).stdout
        try:
            name.decode()
            assert b"\\x" not in listed or name.startswith(b"\xc2")  # controls above ASCII
        except UnicodeDecodeError:
            assert b"\\x" in listed
        listed.decode()


@pytest.fixture
def scene(pathtracer):
    """Arguments, and the files that can change: (name, function that changes it)."""
    folder = pathtracer.folder
    write_obj(folder, "mtllib m.mtl\n", m="map_Kd wood.png\nnorm bumps.png\n")
    write_image(folder / "wood.png")
    write_image(folder / "bumps.png", (128, 128, 255))
    write_environment(folder / "sky.exr", 1.0)
    Image.fromarray(np.arange(64, dtype=np.uint8).reshape(8, 8)).save(folder / "mask.png")

    def append(name, data):
        (folder / name).write_bytes((folder / name).read_bytes() + data)

    changes = {
        "scene.obj": lambda: append("scene.obj", b"v 1 1 1\nf 1 2 4\n"),
        "m.mtl": lambda: append("m.mtl", b"Kd 0.1 0.2 0.3\n"),
        "wood.png": lambda: write_image(folder / "wood.png", 90),
        "bumps.png": lambda: write_image(folder / "bumps.png", (200, 128, 200)),
        "sky.exr": lambda: write_environment(folder / "sky.exr", 2.0),
        "mask.png": lambda: Image.fromarray(np.arange(64, dtype=np.uint8)[::-1].reshape(8, 8)).save(folder / "mask.png"),
    }
    return [*SMALL, "--scene", "scene.obj", "--env", "sky.exr", "--sampler", "mask", "--mask", "mask.png"], changes


def test_no_output_replaces_a_file_of_the_scene(pathtracer, scene):
    """The preview of wood.exr would be the texture."""
    arguments, _ = scene
    before = (pathtracer.folder / "wood.png").read_bytes()
    (pathtracer.folder / "link.png").symlink_to("bumps.png")
    for output, file in (("wood.exr", "wood.png"), ("link.exr", "bumps.png")):
        pathtracer.failure(*arguments, "--spp", 1, "-o", output, said=["the preview of -o", file, "--scene reads"])
    assert (pathtracer.folder / "wood.png").read_bytes() == before


def test_pictures_of_changed_files_are_refused(pathtracer, scene):
    arguments, changes = scene
    before = pathtracer.render(*arguments, "--spp", 1)
    for name, change in changes.items():
        data = (pathtracer.folder / name).read_bytes()
        change()
        after = pathtracer.render(*arguments, "--spp", 1, "--first-sample", 1)
        pathtracer.failure("--merge", before, after, *OUT, said=[before.name, after.name, f"the contents of {name}"])
        (pathtracer.folder / name).write_bytes(data)
    pathtracer.success("--merge", before, pathtracer.render(*arguments, "--spp", 1, "--first-sample", 1), *OUT)


def test_a_list_that_a_picture_makes_up_reaches_no_terminal(pathtracer, scene):
    arguments, _ = scene
    before, after = (pathtracer.render(*arguments, "--spp", 1, "--first-sample", n) for n in (0, 1))
    before.write_bytes(before.read_bytes().replace(b"  wood.png\n", b"  \x1b[31m.gg\n", 1))
    message = pathtracer.failure("--merge", after, before, *OUT)
    assert "?[31m.gg, which only one" in message and "\x1b" not in message


def test_a_picture_of_one_file_may_be_read_from_another_folder(pathtracer):
    """Names count as they are given: the same scene under another name is another picture still."""
    folder = pathtracer.folder
    for name in ("one", "two"):
        (folder / name).mkdir()
        floor().save(folder / name / "scene.glb")
    parts = []
    for first, name in enumerate(("one", "two")):
        parts.append(folder / name / "part.exr")
        done = subprocess.run([pathtracer.binary, "--scene", "scene.glb", *map(str, SMALL), "--spp", "1", "--first-sample",
                               str(first), "-o", "part.exr"], cwd=folder / name, capture_output=True, check=False)
        assert done.returncode == 0
    pathtracer.success("--merge", *parts, *OUT)
