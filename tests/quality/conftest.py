# SPDX-License-Identifier: Apache-2.0
"""Half-planes as integrands, and access to C functions."""

import ctypes
import os
import subprocess
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]


def part(a, b, c):
    """The area of the part of the unit square where a x + b y < c. Neither a nor b may be zero."""
    c, a, b = c - min(a, 0) - min(b, 0), abs(a), abs(b)
    above = [np.maximum(0, c - less) ** 2 for less in (0, a, b, a + b)]
    return (above[0] - above[1] - above[2] + above[3]) / (2 * a * b)


def plane_through(x, y, a, b):
    """Returns a, b and c of the half-plane a x + b y < c whose edge passes through a point, and its area within the unit square."""
    c = a * x + b * y
    return float(a), float(b), float(c), part(a, b, c)


def plane_at_angle(x, y, angle):
    return plane_through(x, y, np.cos(angle), np.sin(angle))


def well_spread(number):
    """The point with this number in a well-spread sequence in the unit square."""
    return (0.5 + np.array([0.7548776662466927, 0.5698402909980532]) * number) % 1


def blur_gain(sigma, radius=7):
    """The fraction of white noise's variance that remains after a blur along both axes."""
    kernel = np.exp(-0.5 * (np.arange(-radius, radius + 1) / sigma) ** 2)
    return ((kernel / kernel.sum()) ** 2).sum() ** 2


@pytest.fixture(scope="session")
def compiled(tmp_path_factory):
    """function(C source) -> a ctypes library of its functions."""
    def library(text):
        path = tmp_path_factory.mktemp("compiled") / "library.so"
        subprocess.run([os.environ.get("CC", "cc"), "-O2", "-shared", "-fPIC", f"-I{ROOT}/libbn/include", f"-I{ROOT}", "-x", "c", "-",
                        "-o", path], input=text, text=True, check=True)
        return ctypes.CDLL(str(path))

    return library
