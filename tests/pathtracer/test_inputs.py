# SPDX-License-Identifier: Apache-2.0
"""The files that an image is made of: --list-inputs, and parts whose files have changed meanwhile."""

import json
import subprocess
import zlib

import numpy as np
import pytest
from pathtracer_driver import read_exr
from scene_files import SMALL, Gltf, add_floor, encoded, floor, write_environment

OUT = ["-o", "out.exr"]


@pytest.fixture
def scene(pathtracer):
    """Arguments, and the files that they name."""
    folder = pathtracer.folder
    names = ["sub/wood.png", "bump map.png", "\u00e9.png", "per%cent.png"]
    g = Gltf()
    for uri in ("sub/wood.png", "bump%20map.png", "\u00e9.png", "per%25cent.png"):
        add_floor(g, pbr={"baseColorTexture": {"index": g.add("textures", source=g.add("images", uri=uri))}})
    text = json.dumps(g.document(uri="my mesh.bin"))
    (folder / "scene.gltf").write_text(text.replace("sub/wood", "sub\\/wood").replace("my mesh", "my\\u0020mesh"))
    (folder / "my mesh.bin").write_bytes(g.bytes)
    (folder / "sub").mkdir()
    for name in names:
        (folder / name).write_bytes(encoded(np.full((4, 4, 3), 200)))
    write_environment(folder / "sky.exr", 1.0)
    return ["--scene", "scene.gltf", "--env", "sky.exr", *SMALL, "--spp", 1], ["scene.gltf", "my mesh.bin", "sky.exr", *names]


def test_all_files_are_listed(pathtracer, scene):
    """What is listed is what is read: without any one of the files there is no scene, or another list."""
    folder, (options, names) = pathtracer.folder, scene
    names = sorted(names, key=str.encode)
    listed = pathtracer.success(*options, "--list-inputs").stdout
    data = [(folder / name).read_bytes() for name in names]
    assert listed.splitlines(keepends=True) == [f"{zlib.crc32(d):08x}-{len(d)}  {name}\n" for d, name in zip(data, names)]
    assert read_exr(pathtracer.render(*options))[1]["inputs"] == listed
    for name in names:
        (folder / name).rename(folder / "aside")
        done = pathtracer.run(*options, "--list-inputs")
        # A texture that is missing is only named.
        assert name not in done.stdout and done.returncode == (not name.endswith(".png"))
        (folder / "aside").rename(folder / name)


def test_no_output_replaces_a_file_of_the_scene(pathtracer, scene):
    """The preview of wood.exr would be the texture."""
    (pathtracer.folder / "link.png").symlink_to("bump map.png")
    for output, file in (("sub/wood.exr", "wood.png"), ("link.exr", "bump map.png")):
        pathtracer.failure(*scene[0], "-o", output, said=["the preview of -o", file])


def test_images_of_changed_files_are_refused(pathtracer, scene):
    arguments, names = scene
    before = pathtracer.render(*arguments)
    for name in names:
        data = (pathtracer.folder / name).read_bytes()
        (pathtracer.folder / name).write_bytes(data + b"\n ")
        after = pathtracer.render(*arguments, "--first-sample", 1)
        pathtracer.failure("--merge", before, after, *OUT, said=[before.name, after.name, name])
        pathtracer.failure("--resume", before, "--spp", 2, *OUT, said=[name])
        (pathtracer.folder / name).write_bytes(data)
    after = pathtracer.render(*arguments, "--first-sample", 1)
    pathtracer.success("--merge", before, after, *OUT)
    # A list that an image makes up reaches no terminal.
    before.write_bytes(before.read_bytes().replace(b"  sub/wood.png\n", b"  \x1b[31mwoo.png\n", 1))
    pathtracer.failure("--merge", after, before, "-o", "new.exr", said=["?[31mwoo.png"])


def test_an_image_of_one_file_may_be_read_from_another_folder(pathtracer):
    parts = []
    for first, name in enumerate(("one", "two")):
        folder = pathtracer.folder / name
        folder.mkdir()
        floor().save(folder / "scene.glb")
        parts.append(folder / "part.exr")
        subprocess.run([pathtracer.binary, "--scene", "scene.glb", *map(str, SMALL), "--spp", "1", "--first-sample", str(first),
                        "-o", "part.exr"], cwd=folder, capture_output=True, check=True)
    pathtracer.success("--merge", *parts, *OUT)
