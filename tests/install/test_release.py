# SPDX-License-Identifier: Apache-2.0
"""Every file has a licence."""

import shutil

import pytest
from conftest import ROOT, run


def test_every_file_has_a_licence():
    reuse = shutil.which("reuse")
    if reuse is None:
        pytest.skip("reuse is not installed")
    run(reuse, "--root", ROOT, "lint", cwd=ROOT)
