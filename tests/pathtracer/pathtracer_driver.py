# SPDX-License-Identifier: Apache-2.0
"""Runs the path tracer, and reads and compares its images."""

import os
import pathlib
import re
import signal
import subprocess
import time
from typing import get_args

import numpy as np
import OpenEXR
import pytest

import bluenoise

DEFAULT_BINARY = pathlib.Path(__file__).resolve().parents[2] / "build/examples/pathtracer/pathtracer"
SCENES = ("cornell", "penumbra", "glossy", "lens", "motion", "glass", "interior", "fog", "furnace")
SAMPLERS = get_args(bluenoise.SamplerType)
PLUGINS = [*map(str, DEFAULT_BINARY.parents[2].glob("evidence/plugins/sobol_global.so"))]  # built if Boost is found


class PathTracer:
    """Runs the path tracer in a folder. A `Gltf` object among the arguments is saved as scene.glb first."""

    def __init__(self, binary, folder):
        self.binary = str(binary)
        self.folder = folder
        self.count = 0
        self.has_address_sanitizer = b"__asan_init" in binary.read_bytes()

    def command(self, arguments):
        return [self.binary, *(str(a.save(self.folder / "scene.glb") if hasattr(a, "save") else a) for a in arguments)]

    def run(self, *arguments, timeout=60, **options):
        """Returns the CompletedProcess, whose output is text."""
        return subprocess.run(self.command(arguments), capture_output=True, text=True, timeout=timeout, cwd=self.folder, **options)

    def success(self, *arguments, **options):
        """Runs a command that must succeed; returns the CompletedProcess."""
        done = self.run(*arguments, **options)
        assert done.returncode == 0, done.stderr
        return done

    def failure(self, *arguments, said=(), **options):
        """Runs a command that must fail and leave no file. Returns its one line on stderr, which must contain all strings in `said`."""
        command = self.command(["-o", "out.exr", *arguments])[1:]
        before = sorted(os.listdir(self.folder))
        done = self.run(*command, **options)
        assert done.returncode == 1 and done.stdout == "", done
        assert done.stderr.startswith("pathtracer: ") and done.stderr.endswith("\n") and done.stderr.count("\n") == 1, done.stderr
        assert sorted(os.listdir(self.folder)) == before
        for word in [said] if isinstance(said, str) else said:
            assert word in done.stderr, done.stderr
        return done.stderr

    def start(self, *arguments, **streams):
        """Starts the program with default signal handling; returns the Popen. Without this, it would inherit the ignored signals of a
        test run in the background."""

        def heed():
            for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
                signal.signal(number, signal.SIG_DFL)

        return subprocess.Popen(self.command(arguments), cwd=self.folder, preexec_fn=heed, **streams)

    def interrupt(self, number, *arguments, seconds=0.2, **streams):
        """Starts a long run and sends a signal `seconds` after the program has installed its handler; returns the Popen."""
        program = self.start(*arguments, "--quiet", **streams)
        caught, status = 0, pathlib.Path(f"/proc/{program.pid}/status")
        while program.poll() is None and not caught >> (number - 1) & 1:
            time.sleep(0.01)
            caught = int(re.search(r"SigCgt:\s*(\w+)", status.read_text())[1], 16)
        time.sleep(seconds)
        program.send_signal(number)
        return program

    def render(self, *arguments):
        """Renders to a new file; returns its path. `self.said` is the output on stderr."""
        self.count += 1
        path = self.folder / f"render-{self.count}.exr"
        self.said = self.success(*arguments, "-o", path).stderr
        return path

    def image(self, *arguments):
        """Renders, and returns the linear image as float32 (height, width, 3)."""
        return read_exr(self.render(*arguments))[0]

    def header(self, *arguments):
        return read_exr(self.render(*arguments))[1]

    def layers(self, *arguments):
        return read_layers(self.render(*arguments))


@pytest.fixture
def pathtracer(tmp_path):
    """Runs the binary under test in a temporary folder. $BN_PATHTRACER overrides the binary in the default build folder."""
    binary = pathlib.Path(os.environ.get("BN_PATHTRACER", DEFAULT_BINARY)).absolute()
    if "BN_PATHTRACER" not in os.environ and not binary.exists():
        pytest.skip(f"no path tracer at {binary}; build it or set BN_PATHTRACER")
    return PathTracer(binary, tmp_path)


def read_exr(path):
    """Returns an EXR file's image as float32 (height, width, 3), and its header."""
    with OpenEXR.File(str(path)) as file:
        channels = file.channels()
        pixels = channels["RGBA" if "RGBA" in channels else "RGB"].pixels
        return np.array(pixels[..., :3]), dict(file.header())


def read_layers(path):
    """Returns all channels of an EXR file by name, each of shape (height, width)."""
    with OpenEXR.File(str(path), separate_channels=True) as file:
        return {name: np.array(channel.pixels) for name, channel in file.channels().items()}


def assert_same(layers, wanted, variance=0.0):
    """Asserts that all channels are bit-identical, except for variances, which may have the relative error `variance`."""
    assert sorted(layers) == sorted(wanted)
    for name, values in wanted.items():
        if variance and name.startswith("variance"):
            np.testing.assert_allclose(layers[name], values, rtol=variance)
        else:
            assert np.array_equal(layers[name], values), name


def assert_near(layers, wanted, rtol=1e-6):
    """Asserts that the counts are identical and that everything else agrees up to the rounding of stored means to single precision."""
    assert np.array_equal(layers["count"], wanted["count"])
    for name, values in wanted.items():
        # If samples cancel in a mean, the mean's error is relative to the samples.
        scale = max(1.0, float(np.abs(values.astype(np.float64)).max()))
        tolerance = 1e-5 if name.startswith("variance") else rtol
        np.testing.assert_allclose(layers[name], values, rtol=tolerance, atol=1e-6 * scale, err_msg=name)


def block_means(layers, blocks):
    """Returns the means of `blocks` x `blocks` blocks and, for independent samples, their variances, each of shape (blocks, blocks, 3)."""
    height, width = layers["count"].shape
    means = lambda name: np.stack([layers[name.format(c)] for c in "RGB"], -1, dtype=np.float64)
    blocks_of = lambda values: values.reshape(blocks, height // blocks, blocks, width // blocks, 3)
    variances = blocks_of(means("variance.{}") / layers["count"][..., None]).sum(axis=(1, 3))
    return blocks_of(means("{}")).mean(axis=(1, 3)), variances / (height * width // blocks**2) ** 2


def assert_equal_means(layers, wanted, bias, blocks=2):
    """Compares the means of an image and its blocks in z-tests that detect the relative bias `bias`. The false-alarm rate is 1 in 10,000.
    The variances are computed from the pixels' variances, which is exact for white noise and too high for other samplers."""
    for count in (1, blocks):
        (means, variances), (expected, others) = (block_means(image, count) for image in (layers, wanted))
        deviation = np.sqrt(variances + others)
        assert (np.abs(means - expected) <= 4.5 * deviation).all(), f"{means / expected}, {(means - expected) / deviation} deviations"
        assert count > 1 or (6 * deviation < bias * expected).all(), f"too weak a test: {6 * deviation / expected}"
