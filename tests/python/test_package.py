# SPDX-License-Identifier: Apache-2.0
"""The installed package: its version, public names, type stubs, files and imports."""

import doctest
import importlib
import importlib.metadata
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from helpers import run_python

import bluenoise

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "bindings" / "bluenoise"


def test_version_matches_the_header():
    header = (ROOT / "libbn" / "include" / "bn" / "bn.h").read_text()
    version = ".".join(re.findall(r"^#define BN_VERSION_(?:MAJOR|MINOR|PATCH) (\d+)$", header, re.M))
    assert bluenoise.__version__ == version
    assert importlib.metadata.version("libbn") == version


def test_public_names_exist_and_are_documented():
    listed = (ROOT / "bindings" / "api.md").read_text(encoding="utf-8")
    for name in bluenoise.__all__:
        value = getattr(bluenoise, name)
        assert re.search(rf"\b{name}\b", listed) or name == "__version__", name
        if name not in ("__version__", "NeuralProvider", "PointsMethod", "SamplerType"):
            assert value.__doc__, name
    for name in ("sample", "block", "qmc"):
        assert getattr(bluenoise.Sampler, name).__doc__


def test_docstring_examples():
    for name in ("_choose", "_dither", "_frames", "_masks", "_path", "_points", "_sampler", "arrays"):
        failed, tried = doctest.testmod(importlib.import_module(f"bluenoise.{name}"))
        assert failed == 0 < tried, name


def test_wheel_contains_only_the_package():
    files = importlib.metadata.files("libbn")
    top = {file.parts[0] for file in files if ".." not in file.parts}
    assert {name for name in top if not name.endswith(".dist-info")} == {"bluenoise"}
    suffixes = {file.suffix for file in files if file.parts[0] == "bluenoise"} - {".pyc"}
    assert suffixes <= {".py", ".pyi", ".typed", ".so", ".pyd"}
    assert sum(file.suffix in (".so", ".pyd") for file in files) == 1


def test_import_loads_no_optional_packages():
    program = "import sys, bluenoise; print({'scipy', 'PIL', 'matplotlib', 'onnxruntime'} & set(sys.modules))"
    assert run_python(program).stdout == "set()\n"


def test_subinterpreters_are_rejected():
    program = (
        "try: import _interpreters as i\n"
        "except ImportError: import _xxsubinterpreters as i\n"
        "print(i.run_string(i.create(), 'import bluenoise') or '')"
    )
    found = run_python(program)
    assert "cannot be imported in a subinterpreter" in found.stdout + found.stderr


def test_missing_mitsuba_error_names_the_extra():
    found = run_python("import sys; sys.modules['drjit'] = None; import bluenoise.mitsuba")
    assert "pip install 'mitsuba>=3.9'" in found.stderr.splitlines()[-1]


def read_extension(*command):
    if not shutil.which(command[0]) or not sys.platform.startswith("linux"):
        pytest.skip(f"needs {command[0]} on Linux")
    return subprocess.run([*command, bluenoise._core.__file__], capture_output=True, text=True, check=True).stdout


def test_extension_exports_only_its_init_function():
    out = read_extension("nm", "-D", "--defined-only")
    assert [line.split()[-1] for line in out.splitlines()] == ["PyInit__core"]


def test_extension_links_only_system_libraries():
    out = read_extension("readelf", "-d")
    needed = set(re.findall(r"\(NEEDED\).*\[(.+?)\]", out))
    system = re.compile(r"(lib(c|m|dl|pthread|stdc\+\+|gcc_s|c\.musl-\w+)|ld-linux[\w-]*)\.so")
    assert {name for name in needed if not system.match(name)} == set()
    assert "RUNPATH" not in out and "RPATH" not in out


def test_stub_matches_the_extension():
    stub = (PACKAGE / "_core.pyi").read_text()
    named = set(re.findall(r"^(?:def |class )?(\w+)(?=[(:])", stub, re.M))
    have = {n for n in dir(bluenoise._core) if not n.startswith("__") or n == "__version__"}
    assert named == have
