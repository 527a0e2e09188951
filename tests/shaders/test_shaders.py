# SPDX-License-Identifier: Apache-2.0
"""Draws and choices in WGSL, GLSL and HLSL on a Vulkan driver, a software one where there is no GPU, equal the library's."""

import devices
import numpy as np
from conftest import GLSLANG, HERE, INCLUDE, need, need_module, need_vulkan, run

RESULTS = ["domain", *(f"bits {d}" for d in range(4)), *(f"float {d}" for d in range(4)), "bn_choose", "what it left",
           "bn_choose_u32", "what it left", "bn_choose_cdf", "what it left", "-"]


def compare(run_shader, code, cases):
    for words, asked, expected in zip(cases.words, cases.asked, cases.expected):
        result = run_shader(code, [words.tobytes(), cases.cdf.tobytes(), asked.tobytes()], asked.nbytes, len(asked))
        different = np.argwhere(np.frombuffer(result, "<u4").reshape(expected.shape) != expected)
        assert len(different) == 0, (
            f"{len(different)} words differ, first {RESULTS[different[0][1]]} of case {asked[different[0][0]]}")


def with_texts(source, names):
    for name in names:
        line = f'#include "{name}"'
        assert source.count(line) == 1, line
        source = source.replace(line, (INCLUDE / "bn" / name).read_text())
    return source


def spirv(folder, source, *options):
    need(GLSLANG, "glslangValidator")
    run(GLSLANG, "-V", "-S", "comp", *options, "-o", folder / "draw.spv", source)
    return (folder / "draw.spv").read_bytes()


def test_the_cases_reach_everything(cases):
    kind, x, y, index = (cases.asked[0][:, i] for i in range(4))
    for each in range(3):
        of_kind = kind == each
        assert (x[of_kind] >> 31).any() and {0x7fffffff, 0x80000000} <= set(y[of_kind])
        assert {0, 255, 256, 2**32 - 1} <= set(index[of_kind])
    assert np.count_nonzero(cases.expected[:, :, 9]) * 4 > cases.expected[:, :, 9].size
    assert cases.expected[:, :, 13].max() > 8 and len(cases.asked[0]) > 50000


def test_wgsl(cases):
    need_vulkan()
    need_module("wgpu")
    texts = [HERE / "draw.wgsl", *(INCLUDE / "bn" / f"{name}.wgsl" for name in ("bn_draw", "bn_choose", "bn_choose_cdf"))]
    compare(devices.run_wgsl, "\n".join(path.read_text() for path in texts), cases)


def test_glsl(cases, tmp_path):
    need_vulkan()
    need_module("vulkan")
    source = tmp_path / "draw.comp"
    source.write_text(with_texts((HERE / "draw.comp").read_text(), ["bn_draw.glsl", "bn_choose.glsl"]))
    compare(devices.run_spirv, spirv(tmp_path, source), cases)


def test_hlsl(cases, tmp_path):
    need_vulkan()
    need_module("vulkan")
    code = spirv(tmp_path, HERE / "draw.hlsl", "-D", "-e", "main", f"-I{INCLUDE / 'bn'}")
    compare(devices.run_spirv, code, cases)
