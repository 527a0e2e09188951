# SPDX-License-Identifier: Apache-2.0
from pathtracer_driver import pathtracer
from scene_files import even_sky

__all__ = ["even_sky", "pathtracer"]
