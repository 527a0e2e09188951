# SPDX-License-Identifier: Apache-2.0
"""The tests of rendered pictures find a planted effect of the size that they state, and rarely one that is not there.

Every rate is over 200 trials with fixed seeds. A true rate of 90 % gives fewer than 160 or all 200 once in 10,000 times; a true
rate of at most 1 % gives more than 9 about as rarely.
"""

import statistics
import types

import numpy as np
import pytest

from evidence.measure import ratios
from evidence.measure.ratios import worse_cells
from evidence.renders import views

TRIALS, SEEDS, COUNTS, MEASURES = 200, 12, (1, 4, 16), ("rmse", "rmse_2.1")
LABELS = ("white", "sobol", "blue")
VIEWS = [view for scene in ("lens", "glossy") for view in views.crops("core", (scene,), (64, 48), (8, 8))]
REFERENCES = {view: types.SimpleNamespace(picture=np.ones((8, 8, 3), np.float32), mean_error=0.0005) for view in VIEWS}


class MadeUp:
    """Errors and means of every view, sampler and seed, with noise; `planted` is a factor for one sampler in one scene, at one
    count or all."""

    def __init__(self, seed, planted=1.0, label="blue", scene="lens", spp=None):
        self.rng, self.planted, self.at = np.random.default_rng(seed), planted, (label, scene, spp)

    def get(self, view, label, spp, measure):
        planted = self.planted if (label, view.scene) == self.at[:2] and self.at[2] in (None, spp) else 1.0
        if measure == "mean":
            return list(planted * (1 + 0.004 * self.rng.standard_normal(SEEDS)) + 0.0005 * self.rng.standard_normal())
        return list(planted * np.exp(0.08 * self.rng.standard_normal(SEEDS)) / spp)


def biases(**planted):
    return [ratios.biases(MadeUp(seed, **planted), REFERENCES, LABELS, 16) for seed in range(TRIALS)]


def losses(**planted):
    return [ratios.against_sobol(MadeUp(seed, **planted), VIEWS, COUNTS, MEASURES) for seed in range(TRIALS)]


@pytest.mark.parametrize("direction", [1, -1])
def test_a_bias_of_the_stated_size_is_found(direction):
    cell, before = ("lens", "sobol"), biases()
    assert set(before[0]) == {(scene, label) for scene in ("lens", "glossy", ratios.ALL) for label in LABELS}
    assert sum(bool(ratios.biased(found)) for found in before) <= 9
    smallest = statistics.median(ratios.smallest_bias(found[cell], len(found)) for found in before)
    assert 0.002 < smallest < 0.006
    after = biases(planted=1 + direction * smallest, label=cell[1], scene=cell[0])
    assert 160 <= sum(cell in ratios.biased(found) for found in after) < TRIALS
    assert not any(("glossy", "sobol") in ratios.biased(found) for found in after[:20])


def test_a_loss_of_the_stated_size_is_found():
    cell, before = ("lens", 4, "rmse_2.1"), losses()
    assert len(before[0]) == 3 * len(COUNTS) * len(MEASURES)
    assert sum(bool(worse_cells(found)[0]) for found in before) <= 9
    smallest = statistics.median(ratios.smallest_loss(found[cell], len(found)) for found in before)
    assert 0.03 < smallest < 0.12
    after = losses(planted=1 + smallest, spp=4)
    assert 160 <= sum(cell in worse_cells(found)[0] for found in after) < TRIALS
    # Where blue is better by as much, nothing is worse.
    assert sum(bool(worse_cells(found)[0]) for found in losses(planted=1 / (1 + smallest))) <= 9
