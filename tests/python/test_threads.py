# SPDX-License-Identifier: Apache-2.0
"""The extension releases the GIL, and results do not depend on threads."""

import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from helpers import HAS_PACKAGE
from onnx_file import convolution
from reference import white

import bluenoise
from bluenoise import _core as core


@pytest.fixture
def no_forced_switches():
    """Ensures that another thread gets the GIL only if the running thread releases it."""
    before = sys.getswitchinterval()
    sys.setswitchinterval(1000.0)
    yield
    sys.setswitchinterval(before)


# These call only functions of the extension, because NumPy also releases the GIL.
RANKS = white((256, 256))
X = np.arange(2**18, dtype=np.int32)
INDEX = np.zeros(2**18, np.uint32)
DRAWS = np.empty((256, 256, 4, 4), np.float32)
IMAGE = np.full((512, 512, 1), 0.5, np.float32)
SAMPLER = core.Sampler(0, 0, 0, None)
SHORT = core.AnnealOptions()
SHORT.sweeps = 1
WORK = {
    "create": lambda: core.Sampler(core.sampler_types["mask"], 0, 0, RANKS),
    "sample": lambda: SAMPLER.sample(X, X, INDEX, INDEX, DRAWS.reshape(-1, 4)),
    "block": lambda: SAMPLER.block(0, 0, 0, 0, DRAWS),
    "void_and_cluster": lambda: core.void_and_cluster(RANKS[None].copy(), core.VoidAndClusterOptions(), None),
    "relax": lambda: core.relax(RANKS[None, :128, :128].copy(), core.RelaxOptions(), None),
    "anneal": lambda: core.anneal(RANKS[None].copy(), SHORT, None),
    "ranks_to_float": lambda: core.ranks_to_float(RANKS.reshape(-1), RANKS.size),
    "mask_error": lambda: core.mask_error(RANKS, 1.0),
    "power_spectrum": lambda: core.power_spectrum(RANKS),
    "neural_noise": lambda: core.neural_noise(0, 0, 512, 512, 0),
    "dither": lambda: core.dither(IMAGE, 2, False, True, None),
}
if HAS_PACKAGE:
    NETWORK = bluenoise.NeuralGenerator(convolution(np.full((1, 3, 3), 0.1)))
    WORK["neural_mask"] = lambda: NETWORK._core.mask(RANKS.copy(), 0, None)
    WORK["neural_window"] = lambda: NETWORK._core.window(0, 0, IMAGE[:, :, 0], 0)


@pytest.mark.parametrize("name", sorted(WORK))
def test_work_releases_the_gil(name, no_forced_switches):
    """A second thread increments a counter. The counter increases during a call only if the call releases the GIL. The call is
    repeated because a busy machine may not schedule the second thread in time."""
    ticks = 0
    stop = False

    def count():
        nonlocal ticks
        while not stop:
            ticks += 1
            time.sleep(0)

    other = threading.Thread(target=count)
    other.start()
    try:
        for _ in range(1000):
            before = ticks
            WORK[name]()
            if ticks > before + 1:
                return
        pytest.fail("no other thread ran during 1000 calls")
    finally:
        stop = True
        other.join()


def test_results_do_not_depend_on_threads():
    sampler = bluenoise.Sampler("blue", seed=6)
    expected = sampler.block(0, 0, 64, 64, 0, 16)

    def draw(row):
        return sampler.block(0, row, 64, 1, 0, 16)[0]

    with ThreadPoolExecutor(4) as pool:
        np.testing.assert_array_equal(list(pool.map(draw, range(64))), expected)
        for make in [bluenoise.mask] + ([NETWORK.mask] if HAS_PACKAGE else []):
            masks = list(pool.map(lambda seed: make((64, 64), seed=seed % 3), range(12)))
            np.testing.assert_array_equal(masks, [make((64, 64), seed=seed % 3) for seed in range(12)])
