# SPDX-License-Identifier: Apache-2.0
"""libbn for Windows, compiled with MinGW and run under Wine: the single-file forms beside <windows.h>, and file names in UTF-8. Without
MinGW the tests are skipped; without Wine they only compile. scripts/platforms runs the C tests there."""

import os
import re
import shutil

import pytest
from conftest import CACHED, ROOT, cmake_build, run
from test_guests import DRAW, FLAGS, included

CC, CXX = "x86_64-w64-mingw32-gcc", "x86_64-w64-mingw32-g++"

pytestmark = pytest.mark.skipif(shutil.which(CC) is None, reason="MinGW is not installed (Debian: gcc-mingw-w64-x86-64-posix)")


HEADERS = "#include <winsock2.h>\n#include <windows.h>\n"


@pytest.mark.parametrize("before, name, after", [
    (HEADERS, "bn.c", ""), ("", "bn.c", f"{HEADERS}#include <ole2.h>\n"), (HEADERS, "bn_draws.h", "#include <ole2.h>\n")],
    ids=["bn.c after", "bn.c before", "bn_draws.h between"])
def test_one_source_with_windows_h(before, name, after, amalgamation, tmp_path):
    """bn.c includes <windows.h> itself."""
    (tmp_path / "unity.c").write_text(before + included(amalgamation, name) + after + DRAW)
    run(CC, *FLAGS, "-fsyntax-only", "unity.c", cwd=tmp_path)


@pytest.mark.skipif(shutil.which(CXX) is None, reason="MinGW's C++ compiler is not installed (Debian: g++-mingw-w64-x86-64-posix)")
def test_cpp_header_with_windows_h(amalgamation, tmp_path):
    (tmp_path / "main.cpp").write_text(f"{HEADERS}#include <bn/bn.hpp>\n#include <ole2.h>\n{DRAW}")
    run(CXX, "-std=c++17", *FLAGS, "-fno-exceptions", "-fno-rtti", "-I", amalgamation, "-fsyntax-only", tmp_path / "main.cpp")


def test_same_bits(amalgamation, windows, tmp_path):
    """bn.c for draws and dithering, and bn_draws.h for draws, with the compiler's own flags."""
    (tmp_path / "draws.c").write_text(included(amalgamation, "bn_draws.h"))
    for path in (amalgamation / "bn.c", "draws.c"):
        run(*CACHED, CC, "-O1", "-c", path, cwd=tmp_path)
    for test, library in (("test_draw_hashes", "bn"), ("test_dither", "bn"), ("test_draw_hashes", "draws")):
        program = tmp_path / f"{test}-{library}.exe"
        run(CC, f'-DBN_TESTS_DIR="{ROOT}/tests"', "-I", amalgamation, ROOT / f"tests/c/{test}.c", tmp_path / f"{library}.o", "-o", program)
        assert re.search(r"[1-9]\d* checks, 0 failed", windows(program))


PATHS = r"""
#include <bn/neural.h>
#include <stdio.h>
#include <stdlib.h>

static void try_open(const char *model, const char *runtime) {
    bn_neural_options options = bn_neural_options_default();
    bn_neural *neural = NULL;
    options.model_path = model;
    options.runtime_path = runtime;
    printf("%d\n", (int)bn_neural_open(&options, &neural));
    fflush(stdout);
}

int main(void) {
    try_open(u8"plain.onnx", u8"plain.dll");
    try_open(u8"Jörg €/模型 𝄞.onnx", u8"Jörg €/𝄞.dll");
    _wputenv(L"BN_ONNXRUNTIME=Jörg €\\𝄞.dll");
    try_open(u8"plain.onnx", NULL);
    try_open(u8"missing é.onnx", NULL);
    try_open("J\xf6rg \x80/m.onnx", NULL); /* the code page of Western Europe */
    try_open(u8"plain.onnx", u8"é.dll");
    printf("%u\n", (unsigned)bn_thread_count());
    return 0;
}
"""
RUNTIME = """
#include <stdio.h>
__declspec(dllexport) const void *OrtGetApiBase(void) {
    printf("loaded ");
    fflush(stdout);
    return NULL; /* not a usable runtime */
}
"""


def test_paths_are_utf_8(windows, tmp_path):
    cmake_build(ROOT, tmp_path / "build", "-DCMAKE_SYSTEM_NAME=Windows", "-DCMAKE_SYSTEM_PROCESSOR=AMD64", f"-DCMAKE_C_COMPILER={CC}",
                "-DBN_BUILD_TESTS=OFF", "-DBN_BUILD_TOOLS=OFF", "-DBN_SMALL_DATA=ON", "-DBN_WERROR=ON")
    (tmp_path / "paths.c").write_text(PATHS, encoding="utf-8")
    (tmp_path / "runtime.c").write_text(RUNTIME)
    run(CC, "-std=c11", "-I", ROOT / "libbn/include", "paths.c", *(tmp_path / "build").rglob("libbn.a"), "-o", "paths.exe", cwd=tmp_path)
    run(CC, "-shared", "runtime.c", "-o", "plain.dll", cwd=tmp_path)
    (tmp_path / "Jörg €").mkdir()
    shutil.copy(tmp_path / "plain.dll", tmp_path / "Jörg €" / "𝄞.dll")
    for name in ("plain.onnx", "Jörg €/模型 𝄞.onnx"):
        (tmp_path / name).write_text("a model")
    printed = windows("./paths.exe", cwd=tmp_path).split("\n")
    # RUNTIME: the model was read, and the library loaded or not. IO: there is no such model.
    assert printed[:6] == ["loaded 6", "loaded 6", "loaded 6", "7", "7", "6"]
    assert 1 <= int(printed[6]) <= len(os.sched_getaffinity(0))
