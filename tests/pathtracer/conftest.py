# SPDX-License-Identifier: Apache-2.0
"""The binary under test: $BN_PATHTRACER, else the default build folder's; scripts/ and evidence/ made importable."""

import os
import pathlib
import sys

import pytest
from pathtracer_driver import PathTracer
from scene_files import write_environment

ROOT = pathlib.Path(__file__).resolve().parents[2]
DEFAULT_BINARY = ROOT / "build/examples/pathtracer/pathtracer"
sys.path[:0] = [str(ROOT), str(ROOT / "scripts")]  # for the farm and to-gltf


@pytest.fixture
def pathtracer(tmp_path):
    binary = pathlib.Path(os.environ.get("BN_PATHTRACER", DEFAULT_BINARY)).absolute()
    if "BN_PATHTRACER" not in os.environ and not binary.exists():
        pytest.skip(f"no path tracer at {binary}; build it or set BN_PATHTRACER")
    return PathTracer(binary, tmp_path)


@pytest.fixture
def even_sky(pathtracer):
    """An environment of radiance 1 all around: a diffuse surface in it shows its albedo, without noise."""
    return write_environment(pathtracer.folder / "even.exr", 1.0)
