# SPDX-License-Identifier: Apache-2.0
"""A release is consistent: the port has the same version as bn.h, and every file has a licence."""

import json
import re
import shutil

import pytest
from conftest import ROOT, run


def test_the_port_of_vcpkg_has_the_version_of_the_header():
    header = (ROOT / "libbn/include/bn/bn.h").read_text(encoding="utf-8")
    port = json.loads((ROOT / "scripts/packaging/vcpkg/libbn/vcpkg.json").read_text(encoding="utf-8"))
    assert port["version"] == ".".join(re.findall(r"^#define BN_VERSION_(?:MAJOR|MINOR|PATCH) (\d+)$", header, re.M))


def test_every_file_has_a_licence():
    reuse = shutil.which("reuse")
    if reuse is None:
        pytest.skip("reuse is not installed")
    run(reuse, "--root", ROOT, "lint", cwd=ROOT)
