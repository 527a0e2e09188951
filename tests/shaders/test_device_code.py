# SPDX-License-Identifier: Apache-2.0
"""The CUDA, HIP, Metal and GLSL code runs on the host, and compiles for devices if compilers are installed."""

import ctypes
import importlib.util
import os
import shutil
import subprocess
from pathlib import Path

import pytest
from conftest import HERE, INCLUDE, ROOT, compile_text, need, run

CXX = os.environ.get("CXX", "c++")
# Older GLSL lacks some built-in functions, so this version tests their replacements.
GLSL_VERSION = ["-U__VERSION__", "-D__VERSION__=300"]
WARNINGS = ["-Wall", "-Wextra", "-Werror"]
# Definitions from the CUDA and HIP headers, without which Clang compiles here.
ATTRIBUTES = [f"-D__{name}__=__attribute__(({name}))" for name in ("host", "device", "global")]


@pytest.mark.parametrize("options", [
    *([f"-D{language}", "-DRUN_ON_HOST", "-D__host__=", "-D__device__=", "-x", "c++", HERE / "draw.cu", "-x", "none"]
      for language in ("__CUDACC__", "__HIPCC__")),
    ["-DMETAL", HERE / "on_host.cpp"], ["-DGLSL", *GLSL_VERSION, HERE / "on_host.cpp"]], ids=["cuda", "hip", "metal", "glsl"])
def test_device_code_on_the_host(cases, tmp_path, options):
    library = ROOT / "build" / "libbn" / "libbn.a"
    run(CXX, "-std=c++17", "-O1", *WARNINGS, "-I", INCLUDE, "-I", HERE, *options, library, "-lm", "-pthread", "-ldl",
        "-o", tmp_path / "draw")
    assert run(tmp_path / "draw", cases.folder).endswith(" 0 wrong words\n")


def test_cuda_header_in_c(tmp_path):
    """Functions that take the table words as an argument also work in C."""
    compile_text(tmp_path, "words.c", "#include <bn/bn_draw.h>\nvoid draw(const uint32_t *words, bn_uint2 seed, float u[4]) "
                                      "{ bn_draw_blue_4d(words, seed, -1, 2, 3, 4, u); }\n")


def nvrtc():
    found = importlib.util.find_spec("nvidia.cuda_nvrtc") if importlib.util.find_spec("nvidia") else None
    folders = [Path(folder) / "lib" for folder in found.submodule_search_locations] if found else []
    libraries = [path for folder in folders for path in sorted(folder.glob("libnvrtc.so*"))]
    need(libraries, "NVRTC (Python package nvidia-cuda-nvrtc-cu12)")
    return ctypes.CDLL(str(libraries[0]))


def compile_with_nvrtc(source: bytes, architecture="compute_75", form="PTX") -> bytes:
    """Compiles a source to PTX, or to a CUBIN for an architecture such as sm_75."""
    library, program, size = nvrtc(), ctypes.c_void_p(), ctypes.c_size_t()
    assert library.nvrtcCreateProgram(ctypes.byref(program), source, b"draw.cu", 0, None, None) == 0
    options = [f"--include-path={INCLUDE}".encode(), f"--include-path={HERE}".encode(), f"--gpu-architecture={architecture}".encode()]
    result = library.nvrtcCompileProgram(program, len(options), (ctypes.c_char_p * len(options))(*options))
    library.nvrtcGetProgramLogSize(program, ctypes.byref(size))
    log = ctypes.create_string_buffer(size.value)
    library.nvrtcGetProgramLog(program, log)
    assert result == 0 and log.value == b"", log.value.decode()
    getattr(library, f"nvrtcGet{form}Size")(program, ctypes.byref(size))
    compiled = ctypes.create_string_buffer(size.value)
    getattr(library, f"nvrtcGet{form}")(program, compiled)
    return compiled.raw


def test_nvrtc_compiles():
    # A program may define these types itself, in part differently from libbn.
    types = b"typedef unsigned int uint32_t;\ntypedef unsigned long uint64_t;\n"
    ptx = compile_with_nvrtc(types + (HERE / "draw.cu").read_bytes()).decode()
    # A single instruction reverses bits, and no arithmetic uses double precision.
    assert ".entry draw(" in ptx and "brev.b32" in ptx and ".f64" not in ptx


@pytest.mark.parametrize("language,target", [("cuda", "nvptx64"), ("hip", "amdgcn")])
def test_clang_compiles(language, target, tmp_path):
    clang = shutil.which("clang++")
    need(clang, "clang++")
    need(f"    {target} " in subprocess.run([clang, "--print-targets"], capture_output=True, text=True, check=False).stdout,
         f"clang++ for {target}")
    # Definitions from each language's headers. Below, the names are those of the bit reversal instruction.
    language_options = {"cuda": ["--cuda-gpu-arch=sm_75", "-nocudainc", "-nocudalib", "-D__CUDACC__",
                                 "-Wno-unknown-cuda-version"],
                        "hip": ["--offload-arch=gfx906", "-nogpuinc", "-nogpulib", "-D__HIPCC__"]}[language]
    run(clang, "-x", language, "-std=c++17", "-O1", *WARNINGS, "--cuda-device-only", *language_options, *ATTRIBUTES,
        "-D__brev=__builtin_bitreverse32", "-I", INCLUDE, "-S", "-o", tmp_path / "draw.s", HERE / "draw.cu")
    text = (tmp_path / "draw.s").read_text()
    assert ("brev.b32" if language == "cuda" else "brev_b32") in text and "draw" in text
