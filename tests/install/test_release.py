# SPDX-License-Identifier: Apache-2.0
"""Recipes and workflows: what they name exists, and all have the version of bn.h."""

import json
import os
import re
import shutil

import pytest
from conftest import ROOT, run

PACKAGING = ROOT / "scripts" / "packaging"
WORKFLOWS = {path.name: path.read_text(encoding="utf-8") for path in (ROOT / ".github/workflows").glob("*.yml")}
HEADER = (ROOT / "libbn/include/bn/bn.h").read_text(encoding="utf-8")
VERSION = ".".join(re.findall(r"^#define BN_VERSION_(?:MAJOR|MINOR|PATCH) (\d+)$", HEADER, re.M))


def test_the_port_of_vcpkg_has_the_version_of_the_header():
    port = json.loads((PACKAGING / "vcpkg/libbn/vcpkg.json").read_text(encoding="utf-8"))
    assert port["version"] == VERSION
    assert set(port["default-features"]) == set(port["features"]) == {"neural"}


@pytest.mark.parametrize("path", ["vcpkg/libbn/portfile.cmake", "conan/conanfile.py"])
def test_recipes_name_options_that_exist(path):
    setting = r'-D(BN_\w+)=|cache_variables\["(BN_\w+)"\]|FEATURES \w+ (BN_\w+)'
    named = {"".join(groups) for groups in re.findall(setting, (PACKAGING / path).read_text(encoding="utf-8"))}
    options = set(re.findall(r"^(?:option\(|set\((?=\w+ .* CACHE ))(\w+)", (ROOT / "CMakeLists.txt").read_text(encoding="utf-8"), re.M))
    assert len(named) == 5 and named <= options


def test_workflows_name_files_that_exist():
    named = {path for text in WORKFLOWS.values()
             for path in re.findall(r"(?<![\w/])((?:scripts|tests|out|\.github)/[\w./-]+)", text)}
    assert {"scripts/test", "scripts/wheel", "scripts/packaging/conan"} <= named
    assert [path for path in named if not path.startswith("out/") and not (ROOT / path).exists()] == []
    for script in set(re.findall(r"run: .*?(scripts/[\w-]+)(?= |$)", "".join(WORKFLOWS.values()), re.M)):
        assert os.access(ROOT / script, os.X_OK), script


@pytest.mark.parametrize("name", WORKFLOWS)
def test_workflows_pin_what_they_use_and_may_do_little(name):
    used = re.findall(r"uses: (\S+)(.*)", WORKFLOWS[name])
    assert used
    for action, comment in used:
        assert action.startswith("./") or re.fullmatch(r"[\w-]+/[\w-]+@[0-9a-f]{40}", action), action
        assert action.startswith("./") or re.fullmatch(r" # v\d+\.\d+\.\d+", comment), action
    assert "\npermissions: {}\n" in WORKFLOWS[name]
    assert name == "release.yml" or ": write" not in WORKFLOWS[name]


# ---- Licences, and addresses


def test_licences_are_whole_and_known():
    assert (ROOT / "LICENSES/Apache-2.0.txt").read_text() == (ROOT / "LICENSE").read_text()
    assert (ROOT / "libbn/data/LICENSE").read_text().endswith((ROOT / "LICENSES/CC0-1.0.txt").read_text())
    known = {path.stem for path in (ROOT / "LICENSES").iterdir()} | {"BSD-3-Clause"}  # pybind11, in the wheel alone
    for path, key in (("scripts/packaging/vcpkg/libbn/vcpkg.json", r'"license": "(.+)"'), ("pyproject.toml", r'^license = "(.+)"'),
                      ("scripts/packaging/conan/conanfile.py", r'\blicense = "(.+)"')):
        (expression,) = re.findall(key, (ROOT / path).read_text(encoding="utf-8"), re.M)
        assert {"Apache-2.0", "CC0-1.0"} <= set(expression.split(" AND ")) <= known, path


def test_every_file_has_a_licence():
    reuse = shutil.which("reuse")
    if reuse is None:
        pytest.skip("reuse is not installed")
    run(reuse, "--root", ROOT, "lint", cwd=ROOT)
