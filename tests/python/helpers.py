# SPDX-License-Identifier: Apache-2.0
"""Checks for errors, signals and progress callbacks, a runner for Python programs, and marks for optional dependencies."""

import contextlib
import importlib.util
import os
import signal
import subprocess
import sys

import pytest

import bluenoise

HAS_PACKAGE = importlib.util.find_spec("onnxruntime") is not None
needs_package = pytest.mark.skipif(not HAS_PACKAGE, reason="the onnxruntime package is not installed")
needs_network = pytest.mark.skipif(not hasattr(bluenoise._core, "NeuralGenerator"), reason="built with BN_NEURAL=OFF")
needs_runtime = pytest.mark.skipif(not HAS_PACKAGE and not os.environ.get("BN_ONNXRUNTIME"),
                                   reason="no ONNX Runtime: pip install onnxruntime, or set BN_ONNXRUNTIME")


@contextlib.contextmanager
def refused(error, words):
    """Checks that the block raises this error and that its message contains all words. Yields pytest's record of the error."""
    with pytest.raises(error) as caught:
        yield caught
    assert all(word in str(caught.value) for word in words), str(caught.value)


def run_python(program, **options):
    return subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=120, **options)


def progress_of(call, cancel_at):
    """Calls the function twice: once recording its progress, and once cancelling it. Returns the result and the recorded fractions."""
    fractions = []
    found = call(fractions.append)
    assert fractions == sorted(fractions) and fractions[-1] == 1
    with pytest.raises(bluenoise.CancelledError):
        call(lambda fraction: fraction >= cancel_at)
    return found, fractions


def assert_interrupted(call, signals):
    """Checks that a call runs its signal handlers as each signal arrives, and that it ends when the last handler raises."""
    handled = []

    def handle(*_):
        handled.append(1)
        if len(handled) == signals:
            raise KeyboardInterrupt

    before = signal.signal(signal.SIGALRM, handle)
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.06, 0.06)
        with pytest.raises(KeyboardInterrupt):
            call()
            signal.setitimer(signal.ITIMER_REAL, 0)
        signal.setitimer(signal.ITIMER_REAL, 0)
    finally:
        signal.signal(signal.SIGALRM, before)
