# SPDX-License-Identifier: Apache-2.0
"""Makes the scripts' packages and the helpers of the path tracer's tests importable.

These tests download Blender, so they run only if $BN_BLENDER is set.
"""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / folder) for folder in (".", "scripts", "tests/pathtracer")]

from own_scene import to_gltf
from pathtracer_driver import pathtracer

__all__ = ["pathtracer"]
collect_ignore_glob = [] if os.environ.get("BN_BLENDER") else ["test_*.py"]


@pytest.fixture
def in_blender(tmp_path):
    """Runs a Python program in Blender; returns what it prints."""

    def run(program, *arguments):
        command = [to_gltf.blender("test"), "-c", program, *map(str, arguments)]
        done = subprocess.run(command, cwd=tmp_path, env={**os.environ, "PWD": str(tmp_path)}, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout

    return run
