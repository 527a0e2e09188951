# SPDX-License-Identifier: Apache-2.0
"""Runs the path tracer's binary, reads what it writes and compares it."""

import os
import signal
import subprocess

import numpy as np
import OpenEXR
import pytest
from scipy import stats

SCENES = ("cornell", "penumbra", "glossy", "lens", "motion", "glass", "interior", "fog", "furnace")
SAMPLERS = ("blue", "sobol", "white", "zorder", "mask")
OPENQMC = ("openqmc-pmjbn", "openqmc-sobolbn", "openqmc-latticebn")  # in builds with it
PEERS = ("sobol-global", *OPENQMC)


class PathTracer:
    def __init__(self, binary, folder):
        self.binary = str(binary)
        self.folder = folder
        self.count = 0
        self.has_address_sanitizer = b"__asan_init" in binary.read_bytes()

    def run(self, *arguments, timeout=60, **options):
        """Runs the program; returns the CompletedProcess with its output as text."""
        return subprocess.run(
            [self.binary, *map(str, arguments)], capture_output=True, text=True, timeout=timeout, cwd=self.folder, **options
        )

    def success(self, *arguments, **options):
        """Runs what must succeed; returns the CompletedProcess."""
        done = self.run(*arguments, **options)
        assert done.returncode == 0, done.stderr
        return done

    def failure(self, *arguments, said=(), **options):
        """Runs what must fail and leave no file; returns its one line on stderr, which has all the words of `said`."""
        before = sorted(os.listdir(self.folder))
        done = self.run(*arguments, **options)
        assert done.returncode == 1 and done.stdout == "", done
        assert done.stderr.startswith("pathtracer: ") and done.stderr.endswith("\n"), done.stderr
        assert done.stderr.count("\n") == 1, done.stderr
        assert sorted(os.listdir(self.folder)) == before
        for word in said:
            assert word in done.stderr, done.stderr
        return done.stderr

    def start(self, *arguments, **streams):
        """Starts the program; returns the Popen. In the background of a script interrupts are ignored, and children
        inherit that: this one heeds them."""

        def heed():
            for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
                signal.signal(number, signal.SIG_DFL)

        return subprocess.Popen([self.binary, *map(str, arguments)], cwd=self.folder, preexec_fn=heed, **streams)

    def needs(self, sampler):
        """Skips the test if the path tracer is built without a sampler that may be left out."""
        if sampler in ("sobol-global", *OPENQMC) and sampler not in self.run("--list").stdout.split():
            pytest.skip(f"the path tracer is built without {sampler}")

    def render(self, *arguments):
        """Renders to a new file; returns its path."""
        self.count += 1
        path = self.folder / f"render-{self.count}.exr"
        self.success(*arguments, "-o", path)
        return path

    def image(self, *arguments):
        """Renders; returns the linear image, float32 (height, width, 3)."""
        return read_exr(self.render(*arguments))[0]


def read_exr(path):
    """The image, float32 (height, width, 3), and the header of an EXR file."""
    with OpenEXR.File(str(path)) as file:
        channels = file.channels()
        pixels = channels["RGBA" if "RGBA" in channels else "RGB"].pixels
        return np.array(pixels[..., :3]), dict(file.header())


def read_layers(path):
    """All channels of an EXR file by name, each (height, width)."""
    with OpenEXR.File(str(path), separate_channels=True) as file:
        return {name: np.array(channel.pixels) for name, channel in file.channels().items()}


def assert_same(layers, wanted, variance=0.0):
    """The same channels, equal to the bit; those of variances up to a relative error."""
    assert sorted(layers) == sorted(wanted)
    for name, values in wanted.items():
        if variance and name.startswith("variance"):
            np.testing.assert_allclose(layers[name], values, rtol=variance)
        else:
            assert np.array_equal(layers[name], values), name


def assert_near(layers, wanted, rtol=1e-6):
    """The same counts, and all else within the rounding of means that went through single precision."""
    assert np.array_equal(layers["count"], wanted["count"])
    for name, values in wanted.items():
        # Of means of samples that cancel, the error is relative to the samples.
        scale = max(1.0, float(np.abs(values.astype(np.float64)).max()))
        tolerance = 1e-5 if name.startswith("variance") else rtol
        np.testing.assert_allclose(layers[name], values, rtol=tolerance, atol=1e-6 * scale, err_msg=name)


def part_means(image):
    """The means of an image of 24 x 24 pixels and of its four quarters, for each channel: (15,)."""
    image = image.astype(np.float64)
    quarters = image.reshape(2, 12, 2, 12, 3).mean(axis=(1, 3)).ravel()
    return np.concatenate([image.mean(axis=(0, 1)), quarters])


def assert_equal_means(one, other, false_alarms):
    """Welch's t-tests over the first axis, the seeds; the rate of false alarms is that of all of them together."""
    p_values = stats.ttest_ind(one, other, equal_var=False).pvalue
    assert np.nanmin(p_values) * np.size(p_values) > false_alarms
