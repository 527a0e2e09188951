# SPDX-License-Identifier: Apache-2.0
"""The committed WGSL files are translations of the GLSL files."""

import subprocess
import sys

from conftest import ROOT


def test_committed_files_are_up_to_date():
    tool = ROOT / "libbn" / "tools" / "make_wgsl.py"
    done = subprocess.run([sys.executable, tool, "--check"], stderr=subprocess.PIPE, text=True, check=False)
    assert done.returncode == 0, done.stderr
