# SPDX-License-Identifier: Apache-2.0
"""Makes the scripts' packages and the helpers of the path tracer's tests importable."""

import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / folder) for folder in (".", "scripts", "tests/pathtracer")]

from pathtracer_driver import pathtracer
from scene_files import even_sky

__all__ = ["even_sky", "pathtracer"]
