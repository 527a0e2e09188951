# SPDX-License-Identifier: Apache-2.0
"""The examples of docs/shaders.md and docs/realtime.md compile as they stand there."""

import os
import re

import pytest
from conftest import GLSLANG, HERE, INCLUDE, ROOT, need, need_wgpu, run
from test_device_code import compile_with_nvrtc
from test_shaders import with_texts

GUIDE = "".join((ROOT / "docs" / name).read_text(encoding="utf-8") for name in ("shaders.md", "realtime.md"))


def listing(name):
    (text,) = re.findall(rf"^<!-- listing: {re.escape(name)} -->\n```\w+\n(.*?)^```", GUIDE, re.MULTILINE | re.DOTALL)
    return text


def test_upload(tmp_path):
    (tmp_path / "upload.c").write_text(listing("upload.c"))
    run(os.environ.get("CC", "cc"), "-std=c99", "-Wall", "-Wextra", "-Werror", "-I", INCLUDE, "-c", tmp_path / "upload.c",
        "-o", tmp_path / "upload.o")


def test_cpp(tmp_path):
    (tmp_path / "a.cpp").write_text(listing("realtime.cpp"))
    run(os.environ.get("CXX", "c++"), "-std=c++17", "-Wall", "-Wextra", "-Werror", "-I", INCLUDE, "-c", tmp_path / "a.cpp", "-o",
        tmp_path / "a.o")


@pytest.mark.parametrize("name, define", [("example.comp", ""), ("path.comp", ""), ("realtime.comp", ""),
                                          ("realtime.comp", "#define TABLE_IS_A_TEXTURE\n")])
def test_glsl(tmp_path, name, define):
    need(GLSLANG, "glslangValidator")
    (tmp_path / "a.comp").write_text(with_texts(listing(name)).replace("#version 430\n", f"#version 430\n{define}"))
    run(GLSLANG, tmp_path / "a.comp")
    run(GLSLANG, "-V", "-o", tmp_path / "a.spv", tmp_path / "a.comp")


@pytest.mark.parametrize("name, define", [("example.hlsl", ""), ("realtime.hlsl", ""),
                                          ("realtime.hlsl", "#define TABLE_IS_A_TEXTURE\n")])
def test_hlsl(tmp_path, name, define):
    need(GLSLANG, "glslangValidator")
    (tmp_path / "a.hlsl").write_text(define + listing(name))
    run(GLSLANG, "-D", "-V", "-S", "comp", "-e", "main", f"-I{INCLUDE / 'bn'}", "-o", tmp_path / "a.spv", tmp_path / "a.hlsl")


def test_wgsl():
    need_wgpu()
    import wgpu

    texts = "".join((INCLUDE / "bn" / name).read_text() for name in ("bn_draw.wgsl", "bn_choose.wgsl"))
    device = wgpu.gpu.request_adapter_sync().request_device_sync()
    device.create_shader_module(code=listing("example.wgsl") + texts)


def test_cuda(tmp_path):
    assert ".entry draw(" in compile_with_nvrtc(listing("example.cu").encode())


def test_metal(tmp_path):
    """As C++, without the attributes; C++ has no vectors of vectors either."""
    text = re.sub(r" \[\[[^]]*\]\]", "", listing("example.metal")).replace("float4(u.xy,", "float4(u.x, u.y,")
    words = "#define device\n#define thread\n#define constant const\n"
    (tmp_path / "metal_stdlib").write_text((HERE / "stand_ins.h").read_text() + words)
    (tmp_path / "a.cpp").write_text(text)
    run(os.environ.get("CXX", "c++"), "-std=c++17", "-Wall", "-Wextra", "-Werror", "-Dkernel=", "-I", tmp_path,
        "-I", INCLUDE / "bn", "-c", tmp_path / "a.cpp", "-o", tmp_path / "a.o")
