# SPDX-License-Identifier: Apache-2.0
"""Plug-in samplers: shared libraries with the functions in examples/sampler_plugin/sampler_plugin.h, and Python functions

    draw(seed, x, y, index, decision, dimensions)   or   draw(seed, x, y, index, decision, dimensions, samples)

that return an array (..., dimensions) of numbers in [0, 1) for arrays of pixels and sample indices. With the last argument, the sampler
is tuned for that number of samples. If the function has an attribute `counts`, the sampler has only these numbers of samples."""

import ctypes
import dataclasses
import functools
import hashlib
import importlib.util
import inspect
import os
from collections.abc import Callable
from pathlib import Path

import numpy as np

from ..base.command import CommandError, output_of

BUILD = Path(os.environ.get("BN_PATHTRACER", Path(__file__).parents[2] / "build/examples/pathtracer/pathtracer")).absolute().parents[2] / "evidence"
PROGRAM, FOLDER = BUILD / "programs/draw_plugin", BUILD / "plugins"  # the latter holds the plug-ins for comparison


@dataclasses.dataclass(frozen=True)
class Plugin:
    """file: FILE or FILE:ARGUMENT, as the path tracer takes it. function: of a Python file, or None. tuned: whether draws depend on the
    number of samples. counts: the numbers of samples that the sampler has; empty: all."""

    file: str
    function: Callable | None
    tuned: bool
    counts: tuple = ()

    def key(self):
        return key_of(self.file)

    def numbers(self, seed, size, first, count, decision, dimensions, samples=0, x0=0, y0=0):
        """float32 [size rows][size pixels][count samples][dimensions], from pixel (x0, y0) on."""
        shape = size, size, count, dimensions
        if not self.function:
            given = (PROGRAM, self.file, seed, samples, decision, dimensions, size, first, count, x0, y0)
            found = np.frombuffer(output_of(list(map(str, given)), "see docs/bench.md"), np.float32).reshape(shape)
        else:
            y, x, index = np.ogrid[y0:y0 + size, x0:x0 + size, first:first + count]
            found = np.asarray(self.function(seed, x, y, index, decision, dimensions, *[samples] * self.tuned), np.float32)
        if found.shape != shape or not np.all((found >= 0) & (found < 1)):
            raise CommandError(f"{self.file} returned an array of shape {found.shape}, or numbers outside [0, 1); the shape must be {shape}")
        return found

    def way(self, size):
        """A draw() for integrands.py: member m of a family is the four numbers of the decision of ray m."""
        @functools.lru_cache(4)
        def draw(run, count, member):
            return self.numbers(run, size, 0, count, 4 * member if member < 3 else 16, 4, count)
        return draw

    @functools.lru_cache(1)  # noqa: B019
    def frames(self, dimensions, seed, size):
        return self.numbers(seed, size, 0, 128, 2 if dimensions == 1 else 0, max(dimensions, 2))[..., :dimensions]

    def frame(self, frame, dimensions, seed, size):
        """The numbers of ray 0 in one frame, whose number is the sample index: a source for scripts/bench realtime."""
        return self.frames(dimensions, seed, size)[:, :, frame]


def key_of(file, folder="."):
    """A hash of everything that the numbers of FILE or FILE:ARGUMENT depend on, seen from a folder."""
    found = hashlib.sha256()
    for part in file.split(":", 1):
        path = Path(folder) / part
        for each in sorted(path.iterdir()) if path.is_dir() else [path]:
            found.update(each.read_bytes() if each.is_file() else part.encode())
    return found.hexdigest()


def load(file):
    """The Plugin in FILE.so, FILE.so:ARGUMENT or FILE.py:function."""
    path, _, rest = str(file).partition(":")
    path = os.path.abspath(path)
    if path.endswith(".py"):
        spec = importlib.util.spec_from_file_location(Path(path).stem, path)
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        function = getattr(module, rest, None)
        if not callable(function):
            raise CommandError(f"{path} has no function '{rest}'; name it as {Path(path).name}:FUNCTION")
        return Plugin(f"{path}:{rest}", function, len(inspect.signature(function).parameters) > 6, getattr(function, "counts", ()))
    try:
        is_tuned = getattr(ctypes.CDLL(path), "sampler_plugin_is_tuned", lambda: 0)
    except OSError as error:
        raise CommandError(f"cannot load the sampler: {error}") from None
    return Plugin(path + (f":{rest}" if rest else ""), None, bool(is_tuned()))
