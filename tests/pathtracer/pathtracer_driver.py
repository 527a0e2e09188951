# SPDX-License-Identifier: Apache-2.0
"""Runs the path tracer's binary and reads what it writes."""

import subprocess

import numpy as np
import OpenEXR


class PathTracer:
    def __init__(self, binary, folder):
        self.binary = str(binary)
        self.folder = folder
        self.count = 0

    def run(self, *arguments, timeout=60, **options):
        """Runs the program; returns the CompletedProcess with its output as text."""
        return subprocess.run(
            [self.binary, *map(str, arguments)],
            capture_output=True,
            text=True,
            timeout=timeout,
            cwd=self.folder,
            **options,
        )

    def render(self, *arguments):
        """Renders to a new file; returns its path."""
        self.count += 1
        path = self.folder / f"render-{self.count}.exr"
        done = self.run(*arguments, "-o", path)
        assert done.returncode == 0, done.stderr
        return path

    def image(self, *arguments):
        """Renders; returns the linear picture, float32 (height, width, 3)."""
        return read_exr(self.render(*arguments))[0]


def read_exr(path):
    """The picture, float32 (height, width, 3), and the header of an EXR file."""
    with OpenEXR.File(str(path)) as file:
        channels = file.channels()
        pixels = channels["RGBA" if "RGBA" in channels else "RGB"].pixels
        return np.array(pixels[..., :3]), dict(file.header())


def read_layers(path):
    """All channels of an EXR file by name, each (height, width)."""
    with OpenEXR.File(str(path), separate_channels=True) as file:
        return {name: np.array(channel.pixels) for name, channel in file.channels().items()}
