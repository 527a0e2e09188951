# SPDX-License-Identifier: Apache-2.0
"""The source distribution contains everything a wheel needs, and nothing else."""

import os
import re
import sys

import pytest
from conftest import ROOT, run

pytest.importorskip("scikit_build_core")

# The top-level files and folders. The folders in WHOLE are included completely.
TOP = {"CHANGELOG.md", "CMakeLists.txt", "CMakePresets.json", "CITATION.cff", "LICENSE", "LICENSES", "PKG-INFO", "README.md",
       "REUSE.toml", "SECURITY.md", "THIRD-PARTY.md", "bindings", "libbn", "pyproject.toml", "tests"}
WHOLE = ("bindings", "libbn", "tests/c", "tests/python", "tests/quality", "tests/shaders", "tests/simd")


def backend(command, folder):
    """Runs a hook of the build backend in a folder while git on the PATH fails. Returns the hook's result."""
    (folder.parent / "bin").mkdir(exist_ok=True)
    git = folder.parent / "bin" / "git"
    git.write_text("#!/bin/sh\nexit 1\n")
    git.chmod(0o755)
    program = f"import scikit_build_core.build as b; print('is', b.{command})"
    out = run(sys.executable, "-c", program, cwd=folder, env={**os.environ, "PATH": f"{git.parent}:{os.environ['PATH']}"})
    return re.search(r"^is (.+)$", out, re.M)[1]


@pytest.fixture(scope="module")
def unpacked(tmp_path_factory):
    """The source distribution, unpacked outside the checkout."""
    folder = tmp_path_factory.mktemp("sdist")
    program = f"import os, scikit_build_core.build as b; os.chdir({str(ROOT)!r}); print(b.build_sdist({str(folder)!r}))"
    run(sys.executable, "-c", program, cwd=folder)
    (archive,) = folder.glob("libbn-*.tar.gz")
    assert archive.stat().st_size < 1 << 20
    run("tar", "xf", archive, "-C", folder)
    return folder / archive.name[:-len(".tar.gz")]


def files_below(folder):
    return {path.relative_to(folder).as_posix() for path in folder.rglob("*")
            if path.is_file() and "__pycache__" not in path.parts}


def test_sdist_contains_all_sources_and_nothing_else(unpacked):
    assert {path.name for path in unpacked.iterdir()} == TOP
    for part in WHOLE:
        assert files_below(unpacked / part) == files_below(ROOT / part) != set()
    suffixes = {path.rpartition(".")[2] for path in files_below(unpacked)}
    assert not suffixes & {"o", "a", "so", "pyc", "whl"}


def test_metadata_contains_licences_and_description(unpacked):
    name = backend(f"prepare_metadata_for_build_wheel({str(unpacked.parent)!r})", unpacked)
    metadata = (unpacked.parent / name / "METADATA").read_text(encoding="utf-8")
    assert "License-Expression: Apache-2.0 AND CC0-1.0 AND BSD-3-Clause\n" in metadata
    assert "Name: libbn\n" in metadata
    assert (ROOT / "bindings" / "README.md").read_text(encoding="utf-8") in metadata
    licences = {path.read_text() for path in (unpacked.parent / name / "licenses").rglob("*") if path.is_file()}
    assert licences == {(ROOT / path).read_text() for path in ("LICENSE", "libbn/data/LICENSE", "THIRD-PARTY.md")}


def test_cmake_configures_the_sdist(unpacked, tmp_path):
    run("cmake", "-S", unpacked, "-B", tmp_path, "-DBN_BUILD_PYTHON=ON", f"-DPython_EXECUTABLE={sys.executable}",
        f"-Dpybind11_DIR={run(sys.executable, '-m', 'pybind11', '--cmakedir').strip()}")
