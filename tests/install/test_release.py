# SPDX-License-Identifier: Apache-2.0
"""Every file has a licence, and libbn/data/SHA256SUMS contains the hashes of all tables and networks."""

import hashlib
import shutil

import pytest
from conftest import ROOT, run


def test_every_file_has_a_licence():
    reuse = shutil.which("reuse")
    if reuse is None:
        pytest.skip("reuse is not installed")
    run(reuse, "--root", ROOT, "lint", cwd=ROOT)


def test_every_table_and_network_has_its_checksum():
    listed = (ROOT / "libbn/data/SHA256SUMS").read_text().splitlines()
    data = (path for path in (ROOT / "libbn/data").iterdir() if path.suffix in (".u16", ".u32", ".onnx"))
    assert sorted(listed) == sorted(f"{hashlib.sha256(path.read_bytes()).hexdigest()}  {path.name}" for path in data)
