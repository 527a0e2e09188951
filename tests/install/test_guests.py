# SPDX-License-Identifier: Apache-2.0
"""The single-file forms of libbn share a source file with other code, as in unity builds: bn.c and bn_draws.h compile after any headers,
macros and globals, and change nothing for the code after them. The C++ header compiles with the flags of engines."""

import platform
import re
import subprocess
from pathlib import Path

import pytest
from conftest import CACHED, CC, COMPILERS, CPP, CXX, ROOT, run
from test_amalgamation import LOOPS, program
from test_header import INCLUDE, KEPT

FILES = ["bn.c", "bn_draws.h"]
AVX2 = ["-mavx2"] if platform.machine() == "x86_64" else []
# Macros of <windows.h>, Xlib.h, Qt, Apple's and Unreal's headers, and globals with the names of our parameters.
HOSTILE = """
#define far
#define near
#define small char
#define interface struct
#define min(a, b) ((a) < (b) ? (a) : (b))
#define max(a, b) ((a) > (b) ? (a) : (b))
#define None 0L
#define Bool int
#define Status int
#define Success 0
#define check(x) (x)
#define verify(x) (x)
#define signals public
#define emit
#define BIT(n) (1u << (n))
#define ONE 1
#define TYPES 3
#define PART 4
static int x, y, key, domain, count, width, bits;
static float u[4];
int use_globals(void);
int use_globals(void) { return x + y + key + domain + count + width + bits + (u[0] > 0); }
"""
# The C++ library itself does not compile after min and max.
STANDARD = "".join(f"#include <{name}>\n" for name in ("array", "cstdint", "stdexcept", "string", "vector"))
FLAGS = ["-Werror", "-Wall", "-Wextra", "-Wshadow", "-Wconversion", "-Wsign-conversion", "-Wcast-qual", "-Wredundant-decls", "-Wundef"]
CXX_FLAGS = [*FLAGS, "-Wold-style-cast", "-Wzero-as-null-pointer-constant", "-fno-exceptions", "-fno-rtti"]
DRAW = """
int draw(void);
int draw(void) {
    bn_sampler sampler = bn_sampler_make(7);
    bn_path path = bn_path_start(1, 2, 3, 0);
    bn_ray ray = bn_path_ray(&path, 1);
    float drawn[4];
    bn_ray_draw(&sampler, &ray, drawn);
    return bn_sampler_init(&sampler, BN_SAMPLER_SOBOL, 7) != BN_SUCCESS || bn_ray_next_1d(&sampler, &ray) == drawn[0];
}
"""


def included(folder, name):
    return f'#define BN_DRAWS_IMPLEMENTATION\n#include "{folder / name}"\n'


def system_headers(text):
    names = set(re.findall(r"^#include <([\w/]+\.h)>$", text, re.M)) - {"arm_neon.h", "emmintrin.h", "immintrin.h"}
    return "".join(f"#include <{name}>\n" for name in sorted(names)) + ("#include <immintrin.h>\n" if AVX2 else "")


@pytest.mark.parametrize("name", FILES)
def test_no_name_remains(name, amalgamation, tmp_path):
    """A program may give each identifier of the file, other than those of libbn and the C library, another meaning."""
    text = (amalgamation / name).read_text()
    code = re.sub(r'/\*.*?\*/|"[^"\n]*"|#include [^\n]*', " ", text, flags=re.S)
    identifiers = sorted(word for word in set(re.findall(r"\b[A-Za-z_]\w*", code)) if not word.lower().startswith("bn_"))
    assert len(identifiers) > 100

    def refused(before):
        source = tmp_path / "names.c"
        declared = "".join(f"enum {{ {name} }}; struct {name} {{ int a; }};\n" for name in identifiers)
        source.write_text(f'{before}\n#line 1 "names"\n{declared}')
        done = subprocess.run(["gcc", "-std=gnu11", *AVX2, "-fsyntax-only", "-fmax-errors=0", source],
                              capture_output=True, text=True, check=False, env={"LC_ALL": "C", "PATH": "/usr/bin:/bin"})
        return {identifiers[int(line) - 1] for line in re.findall(r"^names:(\d+):\d+: error", done.stderr, re.M)}

    taken = refused(system_headers(text))
    assert "sizeof" in taken and "pixel" not in taken
    assert refused(system_headers(text) + included(amalgamation, name)) - taken == set()


@pytest.mark.parametrize("compiler", COMPILERS)
@pytest.mark.parametrize("name", FILES)
def test_no_macro_remains(name, compiler, amalgamation, tmp_path):
    source = tmp_path / "macros.c"

    def macros(text):
        source.write_text(text)
        return set(re.findall(r"^#define (\w+)", run(compiler, *AVX2, "-dM", "-E", source), re.M))

    headers = system_headers((amalgamation / name).read_text())
    left = macros(headers + included(amalgamation, name)) - macros(headers)
    assert [macro for macro in left if not KEPT.fullmatch(macro) and not macro.startswith("BN_DRAWS_")] == []


USER = """
static int forgotten(void) { return 1; }
double mine(double a, double b, double c) { double x_ = a * b + c; { double x_ = a; (void)x_; } return x_; }
"""


@pytest.mark.parametrize("compiler", COMPILERS)
@pytest.mark.parametrize("name", FILES)
def test_one_source_with_other_code(name, compiler, amalgamation, tmp_path):
    """The file compiles after any code. After the file, the compiler fuses and warns as before; in it, it does neither, even if all the
    warnings are on. With AVX2, the results of bn.c are the same."""
    (tmp_path / "unity.c").write_text(HOSTILE + included(amalgamation, name) + DRAW + USER)
    fuse = [*AVX2, "-mfma", *(["-fexpensive-optimizations"] if compiler == "gcc" else [])] if AVX2 else []
    said = run(*CACHED, compiler, "-std=gnu11", "-O1", *fuse, *FLAGS[1:], "-S", "unity.c", "-o", "unity.s", cwd=tmp_path)
    assert sorted(re.findall(r"\[-W([\w-]+)\]", said)) == ["shadow", "unused-function"]
    run(compiler, "-c", "unity.s", "-o", "unity.o", cwd=tmp_path)
    text = (tmp_path / "unity.s").read_text()
    if AVX2:
        assert "vfmadd" in re.search(r"^mine:(.*?)\bret", text, re.M | re.S)[1] and text.count("vfm") == 1
    if not AVX2 or {"avx2", "fma"} <= set(Path("/proc/cpuinfo").read_text().split()):
        (tmp_path / "main.c").write_text("int draw(void);\nint main(void) { return draw(); }\n")
        run(compiler, "main.c", "unity.o", "-lm", "-o", "unity", cwd=tmp_path)
        run(tmp_path / "unity")
        for test in LOOPS if AVX2 and name == "bn.c" else ():
            assert "ymm" in text
            run(program(amalgamation, compiler, ROOT / "tests" / f"{test}.c", tmp_path / "unity.o"))


@pytest.mark.parametrize("compiler", COMPILERS)
@pytest.mark.parametrize("standard", ["c++11", "c++20"])
def test_headers_compile_after_any_code(standard, compiler, amalgamation, tmp_path):
    more = "#include <bn/bn_choose.h>\n#include <bn/bn.h>\n" + ("" if standard == "c++11" else "#include <bn/bn.hpp>\n")
    useless = ["-Wuseless-cast"] if compiler == "gcc" else []
    for first in ("<bn/bn_path.h>", f'"{amalgamation}/bn_draws.h"'):
        (tmp_path / "engine.cpp").write_text(f"{STANDARD}{HOSTILE}#include {first}\n{more}{DRAW}")
        run(CPP[compiler], f"-std={standard}", *CXX_FLAGS, *useless, "-I", INCLUDE,
            "-fsyntax-only", tmp_path / "engine.cpp")


def test_implementation_after_other_inclusions(amalgamation, tmp_path):
    """A header may have included bn_draws.h before, and a later one may include it again while the macro is still defined."""
    header = f'#include "{amalgamation}/bn_draws.h"\n'
    (tmp_path / "one.c").write_text(header + included(amalgamation, "bn_draws.h") + header + DRAW)
    (tmp_path / "two.c").write_text(header + DRAW.replace("int draw(", "int main("))
    run(CC, "-Werror", "-Wall", "-Wextra", "one.c", "two.c", "-o", "program", cwd=tmp_path)
    run(tmp_path / "program")
    (tmp_path / "unity.cpp").write_text(included(amalgamation, "bn_draws.h"))
    done = subprocess.run([CXX, "-fsyntax-only", tmp_path / "unity.cpp"], capture_output=True, text=True, check=False)
    assert done.returncode != 0 and "C11 source" in done.stderr


WITHOUT_EXCEPTIONS = """#include <bn/bn.hpp>
int main(int argc, char **) {
    uint16_t ranks[16 * 16] = {};
    const bn_mask mask = bn_mask_u16(ranks, 16, 16); // not a permutation
    bn_sampler made;
    if (bn_sampler_init_mask(&made, &mask, 1) != BN_ERROR_BAD_DATA) return 1;
    if (bn_sampler_init(&made, BN_SAMPLER_SOBOL, 1) != BN_SUCCESS) return 1;
    const bn::Sampler sampler(made);
    if (sampler.sample_1d(1, 2, 3) != bn::Sampler(bn::Type::sobol, 1).sample_1d(1, 2, 3)) return 1;
    if (argc > 1) bn::Sampler::from_mask(mask);
    return 0;
}
"""


@pytest.mark.parametrize("compiler", COMPILERS)
def test_cpp_header_without_exceptions(compiler, static_library, tmp_path):
    (tmp_path / "main.cpp").write_text(WITHOUT_EXCEPTIONS)
    run(CPP[compiler], "-std=c++14", *CXX_FLAGS, *static_library.pkg_config("--cflags"),
        tmp_path / "main.cpp", "-o", tmp_path / "main", *static_library.pkg_config("--libs"))
    run(tmp_path / "main")
    done = subprocess.run([tmp_path / "main", "fail"], capture_output=True, text=True, check=False)
    assert done.returncode == -6 and "terminate called" in done.stderr


MODULE = """module;
#include <bn/bn.hpp>
export module numbers;
export inline float number(unsigned long long seed, int x, int y) {
    return bn::PathSampler(bn::Sampler(seed).get(), bn_path_start(x, y, 0, 0)).ray(1).draw()[0];
}
"""


@pytest.mark.parametrize("compiler", [name for name in COMPILERS if name != "cc"])
def test_cpp_modules(compiler, static_library, tmp_path):
    """A module can use the headers in its global module fragment, and export inline functions that draw."""
    if compiler == "gcc" and int(run("gcc", "-dumpversion").partition(".")[0]) < 14:
        pytest.skip("modules of this GCC lose the static variables of inline functions")
    cflags = [*static_library.pkg_config("--cflags"), "-pthread"]
    (tmp_path / "numbers.cppm").write_text(MODULE)
    (tmp_path / "main.cpp").write_text("import numbers;\nint main() { return number(1, 2, 3) == number(1, 2, 4); }\n")
    if compiler == "gcc":
        command = ["g++", "-std=c++20", "-fmodules-ts", *cflags, "-x", "c++", "numbers.cppm", "main.cpp"]
    else:
        run("clang++", "-std=c++20", *cflags, "--precompile", "numbers.cppm", "-o", "numbers.pcm", cwd=tmp_path)
        command = ["clang++", "-std=c++20", "-pthread", "-fprebuilt-module-path=.", "numbers.pcm", "main.cpp"]
    run(*command, "-o", "program", "-x", "none", *static_library.pkg_config("--libs"), cwd=tmp_path)
    run(tmp_path / "program")
