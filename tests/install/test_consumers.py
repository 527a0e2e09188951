# SPDX-License-Identifier: Apache-2.0
"""Projects that use libbn in each way shown in the README."""

import json
import os
import re
import shlex
import shutil
import subprocess

import pytest
from conftest import CXX, ROOT, VERSION, Installed, cmake_build, listing, run
from test_readme import examples
from test_readme import program as readmes_program

HERE = ROOT / "tests" / "install"


@pytest.fixture(scope="session")
def expected(static_library, tmp_path_factory) -> str:
    """The consumer's expected output, which does not depend on how libbn is linked."""
    program = tmp_path_factory.mktemp("expected") / "consumer"
    static_library.compile(HERE / "consumer.c", program)
    return run(program)


def cpp(expected: str) -> str:
    """The expected output of consumer_hpp.cpp: the same numbers, and no violated guarantee."""
    return "".join(expected.splitlines(keepends=True)[:5]) + "0\n"


def test_find_package(installed, expected, tmp_path):
    """The project also contains the README's program and CMake listing, and tries versions that the package must refuse."""
    (tmp_path / "main.cpp").write_text(readmes_program())
    (tmp_path / "listing.cmake").write_text(examples("cmake")[0])
    major, minor, _ = map(int, VERSION.split("."))
    cmake_build(HERE / "find_package", tmp_path / "build", f"-DCMAKE_PREFIX_PATH={installed.prefix}", f"-DEXAMPLE={tmp_path}",
                f"-DWRONG_VERSIONS={major}.{minor + 1};{major + 1}.0;0.0")
    assert run(tmp_path / "build" / "consumer") == expected
    assert run(tmp_path / "build" / "consumer_hpp") == cpp(expected)
    assert len(run(tmp_path / "build" / "example").splitlines()) == 4
    assert installed.pkg_config("--modversion")[0] == VERSION


def test_pkg_config(installed, expected, tmp_path):
    """The paths follow a moved installation. A static library also needs pthread and dl, which old C libraries keep separate."""
    installed.compile(HERE / "consumer.c", tmp_path / "consumer", "-std=c99", "-Wall", "-Werror")
    assert run(tmp_path / "consumer") == expected
    static = {"-pthread", "-lm", "-ldl"} if installed.kind == "static" else set()
    assert {word for word in installed.pkg_config("--libs") if word[:2] != "-L"} == {"-lbn", *static}
    paths = [word[2:] for word in installed.pkg_config("--cflags", "--libs") if word[:2] in ("-I", "-L")]
    assert paths
    assert all(os.path.realpath(path).startswith(f"{installed.prefix}/") for path in paths)


@pytest.mark.skipif(not shutil.which("meson") or not shutil.which("ninja"), reason="Meson or Ninja is not installed")
def test_meson(static_library, expected, tmp_path):
    (tmp_path / "meson.build").write_text("project('renderer', 'c', default_options: ['c_std=c99', 'werror=true'])\n"
                                          f"{listing('porting.md', 'meson.build')}executable('renderer', 'renderer.c', dependencies: bn)\n")
    shutil.copy(HERE / "consumer.c", tmp_path / "renderer.c")
    environment = {**os.environ, "PKG_CONFIG_PATH": str(static_library.library.parent / "pkgconfig")}
    run("meson", "setup", "build", cwd=tmp_path, env=environment)
    run("meson", "compile", "-C", "build", cwd=tmp_path, env=environment)
    assert run(tmp_path / "build" / "renderer") == expected


@pytest.fixture(scope="module")
def install_small(tmp_path_factory):
    """Installs the library without networks into custom folders. All installations share one build."""
    build = tmp_path_factory.mktemp("build")

    def install_small(folder, lib, include):
        cmake_build(ROOT, build, "-DBN_NEURAL=OFF", "-DBN_SMALL_DATA=ON", "-DBN_BUILD_TESTS=OFF", "-DBN_BUILD_TOOLS=OFF",
                    f"-DCMAKE_INSTALL_PREFIX={folder / 'prefix'}", f"-DCMAKE_INSTALL_LIBDIR={lib}", f"-DCMAKE_INSTALL_INCLUDEDIR={include}")
        run("cmake", "--install", build)
        return Installed("static", folder / "prefix" / lib)  # an absolute `lib` replaces the prefix

    return install_small


@pytest.mark.parametrize(("lib", "include", "language"), [("lib/some-arch", "include", "CXX"), ("{0}/a/lib", "{0}/b/include", "C")],
                         ids=["nested", "absolute"])
def test_custom_install_folders(lib, include, language, expected, install_small, tmp_path):
    """Debian installs libraries in a nested folder. Other systems use separate prefixes for libraries and headers. The projects that find
    the library have a single language; a C++-only project sets no C standard."""
    made = install_small(tmp_path, lib.format(tmp_path), include.format(tmp_path))
    made.compile(HERE / "consumer.c", tmp_path / "consumer")
    assert run(tmp_path / "consumer") == expected
    cmake_build(HERE / "part", tmp_path / "found", "-DWAY=find_package", f"-DLANGUAGE={language}", f"-Dbn_DIR={made.prefix}/cmake/bn")
    assert run(tmp_path / "found" / "consumer") == (expected if language == "C" else cpp(expected))


# Settings that a parent project may use for its own sources. As many as possible are combined.
SETTINGS = {
    "add_subdirectory": ["-DCMAKE_UNITY_BUILD=ON", "-DCMAKE_C_STANDARD=90", "-DCMAKE_C_STANDARD_REQUIRED=ON", "-DCMAKE_C_EXTENSIONS=OFF",
                         "-DCMAKE_C_FLAGS=-Werror -Wall -Wextra -Wpedantic -Wconversion -Wsign-conversion -Wundef "
                         "-Wmissing-prototypes -Wdeclaration-after-statement", "-DCMAKE_COMPILE_WARNING_AS_ERROR=ON",
                         "-DCMAKE_C_CLANG_TIDY=false", "-DCMAKE_C_CPPCHECK=false", "-DCMAKE_DEBUG_POSTFIX=d",
                         "-DCMAKE_ARCHIVE_OUTPUT_DIRECTORY=lib"],
    "fetch_content": ["-DCMAKE_UNITY_BUILD=ON", "-DCMAKE_CXX_STANDARD=17", "-DCMAKE_INTERPROCEDURAL_OPTIMIZATION=ON",
                      "-DCMAKE_C_VISIBILITY_PRESET=hidden", "-DBUILD_SHARED_LIBS=ON", "-DCMAKE_C_FLAGS=-ffast-math -funsigned-char"],
}


def test_fetch_content_of_a_branch(expected, tmp_path):
    """Uses the listing of docs/porting.md with a shallow clone of a repository, in a C++-only project that has its own settings."""
    repository, project = tmp_path / "libbn", tmp_path / "project"
    for name in run("git", "-C", ROOT, "ls-files", "CMakeLists.txt", "LICENSE", "libbn").splitlines():
        (repository / name).parent.mkdir(parents=True, exist_ok=True)
        (repository / name).write_bytes((ROOT / name).read_bytes())
    guide = (ROOT / "docs/porting.md").read_text(encoding="utf-8")
    (listing,) = re.findall(r"```cmake\n(include\(FetchContent\)\n.*?)```", guide, re.DOTALL)
    identity = ("-c", "user.name=test", "-c", "user.email=test@localhost", "-c", "commit.gpgsign=false")
    for arguments in (["init", "-q", "-b", "main"], ["add", "."], [*identity, "commit", "-q", "-m", "Test"]):
        run("git", "-C", repository, *arguments)
    project.mkdir()
    (project / "CMakeLists.txt").write_text("cmake_minimum_required(VERSION 3.21)\nproject(renderer LANGUAGES CXX)\n"
                                            f"add_executable(renderer {HERE}/consumer_hpp.cpp)\n{listing}")
    cmake_build(project, tmp_path / "build", f"-DLIBBN_REPOSITORY=file://{repository}", "-DBN_SMALL_DATA=ON", *SETTINGS["fetch_content"])
    assert run(tmp_path / "build" / "renderer") == cpp(expected)


def test_parent_project_settings_do_not_affect_the_library(expected, tmp_path):
    for name in ("bn/bn.h", "bn/bn_draw.h", "base/memory.h", "simd/simd.h"):  # headers with the same names as libbn's
        (tmp_path / "headers" / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "headers" / name).write_text("#error not this one\n")
    cmake_build(HERE / "part", tmp_path / "build", "-DWAY=add_subdirectory", "-DLANGUAGE=C", f"-DBN_SOURCE_DIR={ROOT}",
                "-DBN_SMALL_DATA=ON", f"-DHEADERS={tmp_path / 'headers'}", *SETTINGS["add_subdirectory"])
    assert run(tmp_path / "build" / "consumer") == expected


def test_flags_follow_the_options(tmp_path):
    """Configures one folder repeatedly: which options build a shared library, optimise the library and turn off fast math."""
    def flags(source, *options):
        run("cmake", "-S", HERE / "part", "-B", tmp_path, "-DWAY=add_subdirectory", "-DLANGUAGE=C", f"-DBN_SOURCE_DIR={ROOT}",
            "-DCMAKE_EXPORT_COMPILE_COMMANDS=ON", "-UBUILD_SHARED_LIBS", "-UBN_BUILD_SHARED", *options)
        commands = json.loads((tmp_path / "compile_commands.json").read_text())
        (command,) = [shlex.split(each["command"]) for each in commands if each["file"].endswith(source)]
        return command

    for options, shared in (([], False), (["-DBUILD_SHARED_LIBS=ON"], True), (["-DBUILD_SHARED_LIBS=ON", "-DBN_BUILD_SHARED=OFF"], False),
                            (["-DBUILD_SHARED_LIBS=OFF", "-DBN_BUILD_SHARED=ON"], True)):
        assert ("-DBN_SHARED" in flags("consumer.c", *options)) == shared
    assert "-O2" in flags("src/sampler/sampler.c")  # there is no build type
    for option in ("-ffast-math", "-Ofast"):
        command = flags("src/masks/dither.c", f"-DCMAKE_C_FLAGS={option}")
        macros = run(*command[:command.index("-o")], "-dM", "-E", command[-1])
        assert option in command and "__OPTIMIZE__" in macros and "__FAST_MATH__" not in macros
    assert "-O2" not in flags("src/sampler/sampler.c", "-DCMAKE_BUILD_TYPE=Debug")


def test_library_without_networks(expected, install_small, tmp_path):
    without = install_small(tmp_path, "lib", "include")
    (header,) = (tmp_path / "prefix").rglob("bn.h")
    (pkgconfig,) = (tmp_path / "prefix").rglob("bn.pc")
    assert not (header.parent / "neural.h").exists() and "-ldl" not in pkgconfig.read_text()
    symbols = run("nm", "-g", without.library)
    assert "bn_void_and_cluster" in symbols
    for name in ("bn_neural", "bn_data_neural", "bn_runtime", "dlopen", "fopen", "setenv"):
        assert not re.search(rf"\b{name}", symbols), name  # fesetenv is not one of them
    # A program that needs networks gets an error message with the reason instead of an undefined symbol.
    (tmp_path / "wants.c").write_text(f'#include "{ROOT}/libbn/include/bn/neural.h"\n')
    found = subprocess.run(["cc", "-DBN_NO_NEURAL", "-I", header.parents[1], "-fsyntax-only", tmp_path / "wants.c"],
                           capture_output=True, text=True, check=False)
    assert found.returncode != 0 and "BN_NEURAL=OFF" in found.stderr


def test_installed_files_have_licences_and_do_not_name_the_source_tree(installed):
    for path in installed.prefix.rglob("*"):
        if path.is_file() and not re.search(r"\.a$|\.so", path.name):
            assert str(ROOT) not in path.read_text(), path
    installed_texts = [path.read_text() for path in installed.prefix.rglob("LICENSE*")]
    for licence in ("LICENSE", "libbn/data/LICENSE"):
        assert (ROOT / licence).read_text() in installed_texts


def test_cpp_under_the_address_sanitizer(static_library, tmp_path):
    """The program moves a class that contains a Sampler and a SequentialSampler referring to it, and frees the original."""
    program = static_library.compile_cpp(tmp_path / "program", "-O0", "-fsanitize=address,undefined", "-fno-sanitize-recover",
                                         HERE / "consumer_hpp.cpp")
    assert run(program).splitlines()[-1] == "0"


CPP11 = """#include "numbers.h"
#include <bn/bn_path.h>
#include <cstdio>
int main() {
    Numbers numbers(7);
    numbers.start(3, 4, 5);
    numbers.start_ray(1);
    float pair[2], u[4];
    const float number = numbers.get_1d();
    numbers.get_2d(pair);
    const bn_sampler sampler = bn_sampler_make(7);
    const bn_path path = bn_path_start(3, 4, 5, 0);
    const bn_ray ray = bn_path_ray(&path, 1);
    bn_ray_draw(&sampler, &ray, u);
    std::printf("%d\\n", pair[0] == u[0] && pair[1] == u[1] && number == u[2]);
}
"""


def test_cpp11_program_wraps_the_cpp_header(static_library, tmp_path):
    """Follows the comment of bn.hpp: only one file is compiled as C++14."""
    comment = (ROOT / "libbn" / "include" / "bn" / "bn.hpp").read_text(encoding="utf-8").partition("#ifndef")[0]
    header, source = (re.sub(r"^//     ", "", text, flags=re.MULTILINE)
                      for text in re.findall(r"(//     // numbers\.\w+, C\+\+.*\n(?://     .*\n)+)", comment))
    (tmp_path / "numbers.h").write_text("#include <cstdint>\n#include <memory>\n" + header)
    (tmp_path / "numbers.cpp").write_text('#include "numbers.h"\n#include <bn/bn.hpp>\n' + source)
    (tmp_path / "main.cpp").write_text(CPP11)
    for name, standard in (("numbers", "c++14"), ("main", "c++11")):
        run(CXX, f"-std={standard}", "-Wall", "-Wextra", "-Werror", *static_library.pkg_config("--cflags"),
            "-c", tmp_path / f"{name}.cpp", "-o", tmp_path / f"{name}.o")
    assert run(static_library.compile_cpp(tmp_path / "program", tmp_path / "main.o", tmp_path / "numbers.o")) == "1\n"
