# SPDX-License-Identifier: Apache-2.0
"""With Vulkan and OpenGL drivers, draws, paths and choices in WGSL, GLSL and HLSL are bit-identical to the library's. Without a GPU, Mesa's
software drivers run the shaders."""

import os
import platform
import re
import shutil

import devices
import dxc
import numpy as np
import pytest
from conftest import GLSLANG, HERE, INCLUDE, need, need_module, need_opengl, need_wgpu, run

RESULTS = ["path draws", *(f"bits {d}" for d in range(4)), *(f"float {d}" for d in range(4)), "bn_choose", "its remainder",
           "bn_choose_u32", "its remainder", "bn_choose_cdf", "its remainder", "pair or path"]


# The textures that replace buffers: {name: (width, number type)}. With a width of 0, all data is in one row.
TEXTURES = {"bn_words": (64, "u4"), "bn_cdf": (0, "f4"), "cases": (4096, "u4")}


def compare(run_shader, code, cases, first=0):
    asked, expected = cases.asked.reshape(-1, 16), cases.expected.reshape(-1, 16)  # for all seeds
    result = run_shader(code, [cases.words.tobytes(), cases.cdf.tobytes(), asked.tobytes()], asked.nbytes, len(asked))
    different = np.argwhere((np.frombuffer(result, "<u4").reshape(expected.shape) != expected)[:, first:])
    assert len(different) == 0, (
        f"{len(different)} words differ, first {RESULTS[first + different[0][1]]} of case {asked[different[0][0]]}")


def with_texts(source):
    """GLSL or HLSL code with its includes replaced with the files' texts."""
    def text(line):
        (path,) = (folder / line[1] for folder in (INCLUDE / "bn", HERE) if (folder / line[1]).exists())
        return with_texts(path.read_text())

    return re.sub(r'^#include "(\S+)"$', text, source, flags=re.M)


TYPES = {"uint": "u32", "float": "f32", "vec2": "vec2f", "vec4": "vec4f", "bn_uint2": "vec2u", "bn_uint4": "vec4u", "bn_pan": "bn_pan"}


def wgsl():
    """A translation of answer.glsl, draw.wgsl and the library's WGSL files."""
    def variables(found):
        indent, of, names = found.groups()
        return "\n".join(f"{indent}var {each}{'' if '=' in each else ': ' + TYPES[of]};" for each in re.split(r", (?=\w+ = )", names))

    answer = re.sub("^#.*\n", "", (HERE / "answer.glsl").read_text(), flags=re.M)
    for pattern, new in ((r"void answer\(.*\)", "fn answer()"), (r"^( +)(\w+) (\w+(?: = .*)?);$", variables), (r", left\)", ", &left)"),
                         (r"= (.*) \? (\w+) : (\w+);", r"= select(\3, \2, \1);"), (r"^( +if \(.*\)) (\w.*;)$", r"\1 { \2 }")):
        answer = re.sub(pattern, new, answer, flags=re.M)
    texts = [HERE / "draw.wgsl", *(INCLUDE / "bn" / f"{name}.wgsl" for name in ("bn_draw", "bn_path", "bn_choose", "bn_choose_cdf"))]
    return "\n".join([answer, *(path.read_text() for path in texts)])


def spirv(folder, source, *options):
    need(GLSLANG, "glslangValidator")
    run(GLSLANG, "-V", "-S", "comp", *options, "-o", folder / "draw.spv", source)
    return (folder / "draw.spv").read_bytes()


def test_glsl(cases, tmp_path):
    need_wgpu()
    source = tmp_path / "draw.comp"
    source.write_text(with_texts((HERE / "draw.comp").read_text()))
    compare(devices.run_wgpu, spirv(tmp_path, source), cases)


@pytest.mark.parametrize(("name", "version"), [
    ("draw.comp", "430"), ("draw.comp", "310 es"), ("draw.frag", "330"), ("draw.frag", "300 es")])
def test_glsl_versions(name, version, tmp_path):
    need(GLSLANG, "glslangValidator")
    source = re.sub("^#version .*", f"#version {version}", (HERE / name).read_text())
    (tmp_path / name).write_text(with_texts(source))
    run(GLSLANG, tmp_path / name)


def test_glsl_in_opengl(cases):
    need_opengl()
    compare(devices.run_opengl, with_texts((HERE / "draw.comp").read_text()), cases)


@pytest.mark.parametrize("version", ["300 es", "330"])
def test_glsl_with_textures(cases, version):
    """The tables are textures, as in WebGL 2."""
    need_opengl()

    def run_fragments(code, buffers, result_size, threads):
        textures = {name: (width or len(data) // 4, kind, data) for (name, (width, kind)), data in zip(TEXTURES.items(), buffers)}
        return devices.run_fragments(code, textures, 4096, result_size)

    # With textures, Mesa needs many minutes to compile all path draws.
    source = (HERE / "draw.frag").read_text().replace("#version 300 es", f"#version {version}\n#define NO_PATH_DRAWS")
    compare(run_fragments, with_texts(source), cases, first=1)


def test_hlsl(cases, tmp_path):
    need_wgpu()
    code = spirv(tmp_path, HERE / "draw.hlsl", "-D", "-e", "main", f"-I{INCLUDE / 'bn'}")
    compare(devices.run_wgpu, code, cases)


def dxc_compiled(*arguments):
    if (platform.system(), platform.machine()) != ("Linux", "x86_64"):
        pytest.skip("the package with DXC has it only for x86-64 Linux")
    library = os.environ.get("BN_DXC")
    need(library and os.path.exists(library), "DXC in BN_DXC")
    return dxc.compile_hlsl(library, with_texts((HERE / "draw.hlsl").read_text()), "-E", "main", "-WX", *arguments)


def test_hlsl_in_dxc(cases):
    compare(devices.run_wgpu, dxc_compiled("-T", "cs_6_0", "-spirv"), cases)


@pytest.mark.parametrize("model", ["6_0", "6_6"])
@pytest.mark.parametrize("optimisation", ["-O3", "-Od"])
def test_dxc_makes_dxil(model, optimisation):
    assert dxc_compiled("-T", f"cs_{model}", optimisation, "-Wno-ignored-attributes").startswith(b"DXBC")


def test_hlsl_in_slang(cases, tmp_path):
    """Compiles HLSL for the CPU with a different compiler."""
    need_module("slangpy")
    for name in ("bn_draw", "bn_path", "bn_choose"):
        for language in ("glsl", "hlsl"):
            shutil.copy(INCLUDE / "bn" / f"{name}.{language}", tmp_path)
    shutil.copy(HERE / "answer.glsl", tmp_path)
    path = tmp_path / "draw.slang"
    path.write_text((HERE / "draw.hlsl").read_text().replace("void main(", "void draw_all("))
    compare(devices.run_slang, path, cases)
