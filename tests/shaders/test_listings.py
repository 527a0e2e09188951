# SPDX-License-Identifier: Apache-2.0
"""The examples of docs/shaders.md compile as they stand there."""

import os
import re

import pytest
from conftest import GLSLANG, HERE, INCLUDE, ROOT, need, need_module, need_vulkan, run
from test_device_code import compile_with_nvrtc
from test_shaders import with_texts

GUIDE = (ROOT / "docs" / "shaders.md").read_text(encoding="utf-8")


def listing(name):
    (text,) = re.findall(rf"^<!-- listing: {re.escape(name)} -->\n```\w+\n(.*?)^```", GUIDE, re.MULTILINE | re.DOTALL)
    return text


def test_upload(tmp_path):
    (tmp_path / "upload.c").write_text(listing("upload.c"))
    run(os.environ.get("CC", "cc"), "-std=c99", "-Wall", "-Wextra", "-Werror", "-I", INCLUDE, "-c", tmp_path / "upload.c",
        "-o", tmp_path / "upload.o")


@pytest.mark.parametrize("name", ["example.comp", "path.comp"])
def test_glsl(tmp_path, name):
    need(GLSLANG, "glslangValidator")
    (tmp_path / "a.comp").write_text(with_texts(listing(name)))
    run(GLSLANG, tmp_path / "a.comp")
    run(GLSLANG, "-V", "-o", tmp_path / "a.spv", tmp_path / "a.comp")


def test_hlsl(tmp_path):
    need(GLSLANG, "glslangValidator")
    (tmp_path / "a.hlsl").write_text(listing("example.hlsl"))
    run(GLSLANG, "-D", "-V", "-S", "comp", "-e", "main", f"-I{INCLUDE / 'bn'}", "-o", tmp_path / "a.spv", tmp_path / "a.hlsl")


def test_wgsl():
    need_vulkan()
    need_module("wgpu")
    import wgpu

    texts = "".join((INCLUDE / "bn" / name).read_text() for name in ("bn_draw.wgsl", "bn_choose.wgsl"))
    device = wgpu.gpu.request_adapter_sync().request_device_sync()
    device.create_shader_module(code=listing("example.wgsl") + texts)


def test_cuda(tmp_path):
    assert ".entry draw(" in compile_with_nvrtc(listing("example.cu").encode())


def test_metal(tmp_path):
    """As C++, without the attributes; C++ has no vectors of vectors either."""
    text = re.sub(r" \[\[[^]]*\]\]", "", listing("example.metal")).replace("float4(u.xy,", "float4(u.x, u.y,")
    stand_ins = (HERE / "metal_in_cpp.h").read_text()
    (tmp_path / "metal_stdlib").write_text(stand_ins)
    (tmp_path / "a.cpp").write_text(text)
    run(os.environ.get("CXX", "c++"), "-std=c++17", "-Wall", "-Wextra", "-Werror", "-Dkernel=", "-I", tmp_path,
        "-I", INCLUDE / "bn", "-c", tmp_path / "a.cpp", "-o", tmp_path / "a.o")
