# SPDX-License-Identifier: Apache-2.0
"""Installs libbn as a static and as a shared library, and builds programs against them."""

import os
import re
import shutil
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
VERSION = ".".join(re.findall(r"^#define BN_VERSION_(?:MAJOR|MINOR|PATCH) (\d+)$", (ROOT / "libbn/include/bn/bn.h").read_text(), re.M))
CC, CXX = os.environ.get("CC", "cc"), os.environ.get("CXX", "c++")
COMPILERS = [name for name in ("gcc", "clang") if shutil.which(name)] or ["cc"]
CPP = {"gcc": "g++", "clang": "clang++", "cc": CXX}  # the C++ compilers of the same names
# Debian installs its 64-bit Wine outside PATH.
WINE = next((path for name in ("wine64", "wine", "/usr/lib/wine/wine64") if (path := shutil.which(name))), None)
# Many tests build the same library. ccache finds the results of earlier runs, whose folders had other names.
CACHED = ["ccache"] if shutil.which("ccache") else []
if CACHED:
    os.environ.setdefault("CCACHE_BASEDIR", tempfile.gettempdir())
    for language in ("C", "CXX"):
        os.environ.setdefault(f"CMAKE_{language}_COMPILER_LAUNCHER", "ccache")


def run(*command, **options) -> str:
    """Runs a command and returns its output. If it fails, the error message is the whole output."""
    done = subprocess.run([str(part) for part in command], stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True, stdin=subprocess.DEVNULL, **options)
    assert done.returncode == 0, f"{' '.join(map(str, command))}\n{done.stdout}"
    return done.stdout


def listing(page: str, name: str) -> str:
    """The listing in a page of docs/ whose preceding comment contains this name."""
    text = (ROOT / "docs" / page).read_text(encoding="utf-8")
    (found,) = re.findall(rf"^<!-- listing: {re.escape(name)} -->\n```\w+\n(.*?)^```", text, re.MULTILINE | re.DOTALL)
    return found


def cmake_build(source: Path, build: Path, *options: str, target: str = "all") -> None:
    """Builds a CMake project, by default without optimisation, which would take most of the compile time, and without debug information,
    whose paths would make ccache miss."""
    generator = ["-G", "Ninja"] if shutil.which("ninja") else []
    run("cmake", "-S", source, "-B", build, *generator, "-DCMAKE_BUILD_TYPE=Debug", "-DCMAKE_C_FLAGS_DEBUG=", "-DCMAKE_CXX_FLAGS_DEBUG=",
        *options)
    run("cmake", "--build", build, "--parallel", "2", "--target", target)


@dataclass(frozen=True)
class Installed:
    """An installation that was moved to another folder afterwards."""

    kind: str  # "static" or "shared"
    prefix: Path

    @property
    def library(self) -> Path:
        name = "libbn.a" if self.kind == "static" else "libbn.so"
        (path,) = self.prefix.rglob(name)
        return path

    def pkg_config(self, *options: str) -> list:
        (folder,) = self.prefix.rglob("pkgconfig")
        environment = {**os.environ, "PKG_CONFIG_PATH": str(folder)}
        return run("pkg-config", *options, "bn", env=environment).split()

    def compile(self, source: Path, program: Path, *flags: str) -> None:
        """Compiles a C program as a Makefile that uses pkg-config would."""
        run(CC, *flags, source, "-o", program, *self.pkg_config("--cflags", "--libs"), f"-Wl,-rpath,{self.library.parent}")

    def compile_cpp(self, program: Path, *arguments) -> Path:
        """Compiles a C++17 program with warnings as errors and links it with the static library. Returns the program."""
        run(CXX, "-std=c++17", "-Wall", "-Wextra", "-Werror", "-O1", *self.pkg_config("--cflags"), *arguments, "-o", program,
            *self.pkg_config("--libs"))
        return program


def install(kind: str, folder: Path) -> Installed:
    """The static library is the one that scripts/setup builds in build/."""
    build, first, prefix = ROOT / "build", folder / "first", folder / "moved" / "here"
    if kind == "static":
        run("cmake", "--build", build, "--target", "bn")
    else:
        build = folder / "build"
        cmake_build(ROOT, build, "-DCMAKE_BUILD_TYPE=Release", "-DCMAKE_C_FLAGS_RELEASE=-O0 -DNDEBUG", "-DBN_WERROR=ON",
                    "-DBN_BUILD_TESTS=OFF", "-DBN_BUILD_TOOLS=OFF", "-DBN_BUILD_SHARED=ON")
    run("cmake", "--install", build, "--prefix", first)
    prefix.parent.mkdir()
    first.rename(prefix)
    return Installed(kind, prefix)


@pytest.fixture(scope="session")
def static_library(tmp_path_factory) -> Installed:
    return install("static", tmp_path_factory.mktemp("static"))


@pytest.fixture(scope="session")
def shared_library(tmp_path_factory) -> Installed:
    return install("shared", tmp_path_factory.mktemp("shared"))


@pytest.fixture(params=["static", "shared"])
def installed(request) -> Installed:
    return request.getfixturevalue(f"{request.param}_library")


@pytest.fixture(scope="session")
def amalgamation(tmp_path_factory) -> Path:
    """The output of scripts/amalgamate, with and without --draws."""
    folder = tmp_path_factory.mktemp("amalgamation")
    for options in ([], ["--draws"]):
        run(ROOT / "scripts" / "amalgamate", *options, "--output", folder)
    assert sorted(path.name for path in folder.iterdir()) == ["bn", "bn.c", "bn.h", "bn_draws.h"]
    return folder


@pytest.fixture(scope="session")
def windows(tmp_path_factory):
    """Runs a program, if there is Wine, and returns what it prints."""
    environment = {**os.environ, "WINEPREFIX": str(tmp_path_factory.mktemp("wine")), "WINEDEBUG": "-all", "LC_ALL": "C.UTF-8",
                   "WINEDLLOVERRIDES": "mscoree,mshtml,winemenubuilder.exe="}
    server = Path(WINE).resolve().with_name("wineserver") if WINE else None

    def windows(program, **options):
        if WINE is None:
            pytest.skip("compiled, but not run: Wine is not installed (Debian: wine64)")
        done = subprocess.run([WINE, program], env=environment, capture_output=True, text=True, check=False, timeout=300, **options)
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout

    yield windows
    if server is not None and server.exists():
        subprocess.run([server, "-k"], env=environment, check=False)
