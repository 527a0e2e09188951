# SPDX-License-Identifier: Apache-2.0
"""The files that a picture is made of: --list-inputs, and parts whose files have changed meanwhile."""

import json
import os
import subprocess
import zlib

import numpy as np
import pytest
from pathtracer_driver import read_exr
from scene_files import SMALL, Gltf, add_floor, encoded, floor, write_environment

OUT = ["-o", "out.exr"]


def write_image(path, colour=200):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(encoded(np.full((4, 4, 3), colour)))


def gltf_with_escapes(folder):
    g = Gltf()
    for uri in ("jpg/base.png", "\u00e9.png", "a%20b.png", "per%25cent.png"):
        add_floor(g, pbr={"baseColorTexture": {"index": g.add("textures", source=g.add("images", uri=uri))}})
    text = json.dumps(g.document(uri="my mesh.bin"))
    (folder / "scene.gltf").write_text(text.replace("jpg/base", "jpg\\/base").replace("my mesh", "my\\u0020mesh"))
    (folder / "my mesh.bin").write_bytes(g.bytes)
    return "scene.gltf", ["jpg/base.png", "\u00e9.png", "a b.png", "per%cent.png", "my mesh.bin"]


def test_all_files_are_listed(pathtracer):
    """What is listed is what is read: without any one of the files there is no scene, or another list."""
    folder = pathtracer.folder
    scene, names = gltf_with_escapes(folder)
    for name in names:
        if name.endswith(".png"):
            write_image(folder / name)
    write_image(folder / "mask.png")
    write_environment(folder / "sky.exr", 1.0)
    textures = [name for name in names if name.endswith(".png")]
    names = sorted([scene, *names, "mask.png", "sky.exr"], key=str.encode)
    options = ["--scene", scene, "--env", "sky.exr", "--sampler", "mask", "--mask", "mask.png"]
    listed = pathtracer.success(*options, "--list-inputs").stdout
    data = [(folder / name).read_bytes() for name in names]
    wanted = [f"{zlib.crc32(d):08x}-{len(d)}  {name}\n" for d, name in zip(data, names)]
    assert listed.splitlines(keepends=True) == wanted
    assert read_exr(pathtracer.render(*options, *SMALL, "--spp", 1))[1]["inputs"] == listed
    for name in names:
        (folder / name).rename(folder / "aside")
        done = pathtracer.run(*options, "--list-inputs")
        # A texture that is missing is only named.
        assert name not in done.stdout and done.returncode == (name not in textures)
        (folder / "aside").rename(folder / name)


def test_names_of_any_kind(pathtracer):
    """One line for each, whatever the names; what is no UTF-8, as attributes have to be, becomes escapes."""
    folder = pathtracer.folder
    (folder / "sub").mkdir()
    for name in ["a b.png", "back\\slash.png", "line\nbreak.png", "\u00e9.png", "sub/../a b.png", "./-o.png"]:
        (folder / name).write_bytes(b"x")
        listed = pathtracer.success("--mask", name, "--list-inputs").stdout
        assert listed.count("\n") == 1 and listed.endswith("  " + name.replace("\\", "\\\\").replace("\n", "\\n") + "\n"), listed
    assert pathtracer.success("--scene", "cornell", "--env", "sky", "--list-inputs").stdout == ""
    for name in [b"\xe4.png", b"\xc3\xa9.png", b"\xc0\x80", b"\xf4\x90\x80\x80", b"\xf0\x9f\x98\x80", b"\xe2\x82"]:
        (folder / os.fsdecode(name)).write_bytes(b"x")
        listed = subprocess.run([pathtracer.binary, "--mask", name, "--list-inputs"], cwd=folder, capture_output=True, check=True)
        assert (b"\\x" in listed.stdout) == ("\ufffd" in name.decode(errors="replace"))
        listed.stdout.decode()


@pytest.fixture
def scene(pathtracer):
    """Arguments, and the files that they name."""
    folder = pathtracer.folder
    g = Gltf()
    wood, bumps = (g.add("textures", source=g.add("images", uri=uri)) for uri in ("wood.png", "bumps.png"))
    add_floor(g, pbr={"baseColorTexture": {"index": wood}}, normalTexture={"index": bumps})
    (folder / "scene.gltf").write_text(json.dumps(g.document(uri="m.bin")))
    (folder / "m.bin").write_bytes(g.bytes)
    write_image(folder / "wood.png")
    write_image(folder / "bumps.png", (128, 128, 255))
    write_environment(folder / "sky.exr", 1.0)
    write_image(folder / "mask.png")
    names = ["scene.gltf", "m.bin", "wood.png", "bumps.png", "sky.exr", "mask.png"]
    return [*SMALL, "--spp", 1, "--scene", "scene.gltf", "--env", "sky.exr", "--sampler", "mask", "--mask", "mask.png"], names


def test_no_output_replaces_a_file_of_the_scene(pathtracer, scene):
    """The preview of wood.exr would be the texture."""
    (pathtracer.folder / "link.png").symlink_to("bumps.png")
    for output, file in (("wood.exr", "wood.png"), ("link.exr", "bumps.png")):
        pathtracer.failure(*scene[0], "-o", output, said=["the preview of -o", file, "--scene reads"])


def test_pictures_of_changed_files_are_refused(pathtracer, scene):
    arguments, names = scene
    before = pathtracer.render(*arguments)
    for name in names:
        data = (pathtracer.folder / name).read_bytes()
        (pathtracer.folder / name).write_bytes(data + b"\n ")
        after = pathtracer.render(*arguments, "--first-sample", 1)
        pathtracer.failure("--merge", before, after, *OUT, said=[before.name, after.name, f"the contents of {name}"])
        (pathtracer.folder / name).write_bytes(data)
    after = pathtracer.render(*arguments, "--first-sample", 1)
    pathtracer.success("--merge", before, after, *OUT)
    # A list that a picture makes up reaches no terminal.
    before.write_bytes(before.read_bytes().replace(b"  wood.png\n", b"  \x1b[31m.gg\n", 1))
    pathtracer.failure("--merge", after, before, "-o", "new.exr", said=["?[31m.gg, which only one"])


def test_a_picture_of_one_file_may_be_read_from_another_folder(pathtracer):
    """Names count as they are given: the same scene under another name is another picture still."""
    parts = []
    for first, name in enumerate(("one", "two")):
        folder = pathtracer.folder / name
        folder.mkdir()
        floor().save(folder / "scene.glb")
        parts.append(folder / "part.exr")
        subprocess.run([pathtracer.binary, "--scene", "scene.glb", *map(str, SMALL), "--spp", "1", "--first-sample", str(first),
                        "-o", "part.exr"], cwd=folder, capture_output=True, check=True)
    pathtracer.success("--merge", *parts, *OUT)
