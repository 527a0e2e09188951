# SPDX-License-Identifier: Apache-2.0
"""Each public header compiles on its own, without warnings, in the oldest and newest C and C++ standards."""

import itertools
import re
import subprocess

import pytest
from conftest import COMPILERS, ROOT, run

INCLUDE = ROOT / "libbn" / "include"
HEADERS = sorted(path.name for path in (INCLUDE / "bn").glob("*.h"))
STRICT = ["-pedantic", "-Werror", "-Wall", "-Wextra", "-Wconversion", "-Wsign-conversion", "-Wundef", "-Wshadow", "-fsyntax-only",
          "-DBN_SHOW_WARNINGS"]


@pytest.mark.parametrize("compiler", COMPILERS)
@pytest.mark.parametrize(("header", "standard"), [
    *itertools.product(HEADERS, ("c99", "c17", "c++11", "c++20")), *itertools.product(["bn.hpp"], ("c++14", "c++20"))])
def test_headers_compile_alone(header, standard, compiler, tmp_path):
    language = "c++" if standard.startswith("c++") else "c"
    source = tmp_path / "alone.c"
    # The second include detects a broken include guard.
    source.write_text(2 * f"#include <bn/{header}>\n" + f"typedef {'bn::Sampler' if header == 'bn.hpp' else 'bn_result'} used;\n")
    old = ["-Wstrict-prototypes"] if language == "c" else ["-Wold-style-cast"] if header not in ("bn_draw.h", "bn_path.h", "bn.hpp") else []
    run(compiler, "-x", language, f"-std={standard}", *STRICT, *old, "-I", INCLUDE, source)


@pytest.mark.parametrize("compiler", COMPILERS)
def test_cpp_header_error_names_the_required_standard(compiler, tmp_path):
    source = tmp_path / "old.cpp"
    source.write_text("#include <bn/bn.hpp>\n")
    done = subprocess.run([compiler, "-x", "c++", "-std=c++11", "-fsyntax-only", "-I", INCLUDE, source],
                          capture_output=True, text=True, check=False)
    errors = [line for line in done.stderr.splitlines() if ": error:" in line.partition("#")[0]]
    assert len(errors) == 1 and "needs C++14" in errors[0]


@pytest.mark.parametrize("header", HEADERS)
def test_headers_include_only_allowed_headers(header):
    includes = set(re.findall(r'^\s*#\s*include\s*[<"](.+?)[>"]', (INCLUDE / "bn" / header).read_text(),
                              re.MULTILINE))
    # Three headers share code with shaders, and bn_draw.h uses SSE2 if the compiler targets it.
    more = {"bn_draw.h": {"bn/bn_device.h", "bn/bn_draw.glsl", "emmintrin.h"},
            "bn_path.h": {"bn/bn_draw.h", "bn/bn_device.h", "bn/bn_path.glsl"},
            "bn_choose.h": {"bn/bn_device.h", "bn/bn_choose.glsl"}}
    assert includes <= {"stddef.h", "stdint.h", "bn/bn.h"} | more.get(header, set())


# Macros that may remain defined: include guards and constants. Each header undefines all others at its end.
KEPT = re.compile(r"BN_(\w+_(H|GLSL|AT|KEY)|API|VERSION_\w+|DOMAIN_ROOT|DRAW_TABLE_VERSION|WORD_COUNT)")
# A program that uses the names of library draws and inline draws for its own members.
NAMES = """
struct renderer {
    void (*bn_sample_4d)(const bn_sampler *, int32_t, int32_t, uint32_t, uint32_t, float *);
    void (*bn_draw_4d)(const bn_sampler *, int32_t, int32_t, uint32_t, uint32_t, float *);
};
struct renderer made(void) { struct renderer r = {bn_sample_4d, bn_draw_4d}; return r; }
"""


@pytest.mark.parametrize("compiler", COMPILERS)
@pytest.mark.parametrize("language", ["c", "c++"])
def test_no_internal_macro_remains_defined(language, compiler, tmp_path):
    """Neither macros that redefine functions nor the portability macros of the shared code remain defined."""
    source = tmp_path / "names.c"
    source.write_text("".join(f"#include <bn/{header}>\n" for header in HEADERS if header != "bn_device.h") + NAMES)
    run(compiler, "-x", language, "-Wall", "-Wextra", "-Werror", "-fsyntax-only", "-I", INCLUDE, source)
    macros = re.findall(r"^#define (bn_\w+|BN_\w+)", run(compiler, "-x", language, "-dM", "-E", "-I", INCLUDE, source),
                        re.MULTILINE | re.IGNORECASE)
    assert len(macros) > 20 and [name for name in macros if not KEPT.fullmatch(name)] == []


INLINE = """#include <bn/bn.hpp>
inline float first(const bn::Sampler &s) { return bn::PathSampler(s, 1, 2, 3).ray(0).draw()[0]; }
float (*used)(const bn::Sampler &) = first;
"""


def test_inline_functions_have_external_linkage(tmp_path):
    """A program's inline functions and modules may call them. With internal linkage, each file would have its own copy."""
    (tmp_path / "inline.cpp").write_text(INLINE)
    run("c++", "-std=c++14", "-O0", "-c", "-I", INCLUDE, tmp_path / "inline.cpp", "-o", tmp_path / "inline.o")
    local = [line.split()[-1] for line in run("nm", tmp_path / "inline.o").splitlines() if " t " in line]
    assert [name for name in local if "bn_" in name] == []
