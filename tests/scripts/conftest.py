# SPDX-License-Identifier: Apache-2.0
"""Makes the scripts' packages importable, and what the tests of the path tracer share."""

import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / folder) for folder in (".", "scripts", "tests/pathtracer")]

from pathtracer_driver import pathtracer
from scene_files import even_sky

__all__ = ["even_sky", "pathtracer"]
