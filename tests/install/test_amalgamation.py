# SPDX-License-Identifier: Apache-2.0
"""The output of scripts/amalgamate: one command compiles bn.c, whose results are bit-identical to the library's. The folder bn/
beside it contains the headers that programs include as <bn/...>."""

import shutil

import pytest
from conftest import CACHED, CC, COMPILERS, CPP, CXX, ROOT, run
from test_readme import program as readmes_program
from test_symbols import DRAWS, declared, symbols

HERE = ROOT / "tests" / "install"
STRICT = ["-std=c11", "-pedantic", "-Werror", "-Wall", "-Wextra", "-Wshadow", "-Wconversion", "-Wsign-conversion"]
LOOPS = ("simd/mask_hashes", "simd/many_equals_single")  # these test each instruction set


@pytest.fixture(scope="session", params=COMPILERS)
def compiled(request, amalgamation):
    """A compiler and the object file it built from bn.c with all warnings as errors."""
    objects = amalgamation / f"{request.param}.o"
    run(*CACHED, request.param, "-O1", "-fPIC", "-ffunction-sections", "-fdata-sections", *STRICT, "-Wcast-qual", "-Wredundant-decls",
        "-c", "bn.c", "-o", objects, cwd=amalgamation)
    return request.param, objects


def program(folder, compiler, source, objects):
    built = folder / f"{compiler}-{source.stem}"
    run(compiler, "-O1", f'-DBN_TESTS_DIR="{ROOT}/tests"', "-I", folder, source, objects, "-o", built, "-lm")
    return built


def test_one_command_compiles_a_program(amalgamation, static_library, tmp_path):
    for name in ("bn.c", "bn.h"):
        shutil.copy(amalgamation / name, tmp_path)
    text = (HERE / "consumer.c").read_text()
    assert "<bn/bn_path.h>" in text
    text = text.replace("<bn/bn_path.h>", '"bn.h"')
    (tmp_path / "main.c").write_text(text)
    assert run(CC, "bn.c", "main.c", "-lm", cwd=tmp_path) == ""
    static_library.compile(HERE / "consumer.c", tmp_path / "expected")
    assert run(tmp_path / "a.out") == run(tmp_path / "expected")


def test_readme_program_compiles_unchanged(amalgamation, compiled, tmp_path):
    (tmp_path / "main.cpp").write_text(readmes_program())
    run(CXX, "-std=c++17", "-I", amalgamation, tmp_path / "main.cpp", compiled[1], "-lm", "-o", tmp_path / "a.out")
    assert len(run(tmp_path / "a.out").splitlines()) == 4


@pytest.mark.parametrize("test", ["c/test_draw_hashes", "c/test_dither", "c/test_float_environment", *LOOPS])
def test_library_tests_pass(test, amalgamation, compiled):
    run(program(amalgamation, compiled[0], ROOT / "tests" / f"{test}.c", compiled[1]))


@pytest.mark.parametrize("compiler", COMPILERS)
def test_draws_only_header(compiler, amalgamation, tmp_path):
    """The single header contains the licences, and the hashes of its draws match the library's."""
    header = amalgamation / "bn_draws.h"
    assert all((ROOT / path).read_text().rstrip() in header.read_text() for path in ("LICENSE", "libbn/data/LICENSE"))
    (tmp_path / "draws.c").write_text(f'#define BN_DRAWS_IMPLEMENTATION\n#include "{header}"\n')
    run(compiler, "-O1", *STRICT, "-DBN_SHOW_WARNINGS", "-c", "draws.c", cwd=tmp_path)
    (tmp_path / "bn").mkdir()
    for name in ("bn.h", "bn_path.h", "bn_choose.h"):
        (tmp_path / "bn" / name).write_text(f'#include "{header}"\n')
    run(program(tmp_path, compiler, ROOT / "tests/c/test_draw_hashes.c", tmp_path / "draws.o"))
    external = symbols("-g", "--defined-only", tmp_path / "draws.o")
    assert "bn_sampler_init" in external and [name for name in external if not name.startswith("bn_")] == []


def test_symbols(amalgamation, compiled, tmp_path):
    external = symbols("-g", "--defined-only", compiled[1])
    wanted = {name for name in declared() if not name.startswith("bn_neural")}
    assert wanted <= external
    assert [name for name in external if not name.startswith("bn_")] == []
    run(compiled[0], "-shared", compiled[1], "-o", tmp_path / "plugin.so", "-lm")
    assert symbols("-D", "--defined-only", tmp_path / "plugin.so") - {"_init", "_fini"} == wanted


def test_headers_compile_as_cpp(amalgamation, compiled, tmp_path):
    run(CPP[compiled[0]], "-std=c++17", "-pedantic", "-Werror", "-Wall", "-Wextra", "-I", amalgamation, HERE / "consumer_hpp.cpp",
        compiled[1], "-o", tmp_path / "consumer", "-lm")
    assert run(tmp_path / "consumer").splitlines()[-1] == "0"


def test_unused_data_is_not_linked(amalgamation, compiled, tmp_path):
    (tmp_path / "draws.c").write_text(DRAWS)
    run(compiled[0], "-Wl,--gc-sections", "-I", amalgamation, compiled[1], tmp_path / "draws.c", "-o", tmp_path / "draws", "-lm")
    run(tmp_path / "draws")
    assert {name for name in symbols(tmp_path / "draws") if name.startswith("bn_data_")} == {"bn_data_mask_64"}


def test_warns_about_fast_math(amalgamation, compiled):
    command = [compiled[0], "-fsyntax-only", amalgamation / "bn.c"]
    assert run(*command) == ""
    for option in ("-ffast-math", "-Ofast"):
        assert "Add -fno-fast-math" in run(*command, option)
    assert run(*command, "-ffast-math", "-DBN_ALLOW_FAST_MATH") == ""
