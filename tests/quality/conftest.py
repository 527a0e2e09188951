# SPDX-License-Identifier: Apache-2.0
"""Half-planes, integrands of these tests, and functions of C."""

import ctypes
import os
import subprocess
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
MIDDLES = (np.arange(4096) + 0.5) / 4096


def plane_through(x, y, a, b):
    """The half-plane a x + b y < c through a point: a, b, c, and its part of the unit square; b is not 0."""
    c = a * x + b * y
    height = np.clip((c - a * MIDDLES) / b, 0, 1)
    return float(a), float(b), float(c), (height if b > 0 else 1 - height).mean()


def plane_at_angle(x, y, angle):
    return plane_through(x, y, np.cos(angle), np.sin(angle))


@pytest.fixture(scope="session")
def compiled(tmp_path_factory):
    """function(a text of C) -> its functions, by ctypes."""
    def library(text):
        path = tmp_path_factory.mktemp("compiled") / "library.so"
        subprocess.run([os.environ.get("CC", "cc"), "-O2", "-shared", "-fPIC", f"-I{ROOT}/libbn/include", f"-I{ROOT}", "-x", "c", "-",
                        "-o", path], input=text, text=True, check=True)
        return ctypes.CDLL(str(path))

    return library
