# SPDX-License-Identifier: Apache-2.0
"""Fixtures of all path tracer tests."""

from pathtracer_driver import pathtracer
from scene_files import even_sky

__all__ = ["even_sky", "pathtracer"]
