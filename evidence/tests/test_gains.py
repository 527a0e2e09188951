# SPDX-License-Identifier: Apache-2.0
"""Ratios over seeds and gains over scenes, views and seeds, with their intervals and tests, on synthetic data and by hand."""

import math
import types

import numpy as np
import pytest

from evidence.measure import gains
from evidence.measure.ratios import Ratio, geometric_mean, ratio, seconds_to_error, worse_cells
from evidence.renders import views


def test_a_gain_is_a_mean_of_means():
    groups = [[[1.0, 3.0], [4.0]], [[5.0]]]
    mean, low, high = gains.bootstrap(groups)
    assert mean == pytest.approx((3 + 5) / 2) and 1 <= low < mean < high <= 5
    assert gains.bootstrap(groups) == (mean, low, high)


def test_intervals_hold_what_they_are_of():
    """200 trials over 40 scenes, which a bootstrap covers by 93 to 94 %: fewer than 178 hits have a probability of 1 in 5000."""
    rng, hits = np.random.default_rng(5), 0
    for _ in range(200):
        groups = [[scene + 0.2 * rng.standard_normal(3) for _ in range(2)] for scene in rng.standard_normal(40)]
        _, low, high = gains.bootstrap(groups, draws=300)
        hits += low <= 0 <= high
    assert 178 <= hits < 200


def test_crops_of_one_picture_are_not_so_many_pictures():
    """With the same spread over pictures, four crops of each of two pictures say less than eight pictures: the bootstrap keeps
    crops of a picture together."""
    few = gains.bootstrap([[[[level]] * 4 for level in (-1, 1)]])
    many = gains.bootstrap([[[[level]] for level in 4 * (-1, 1)]])
    assert few[2] - few[1] > 1.9 and many[2] - many[1] < 1.6
    views_of = [views.View("a", name, 8, 8, (camera,), crop=(i, 0, i + 1, 1)) for name, camera, i in (
        ("b-1", "b", 0), ("b-2", "b", 1), ("c-1", "c", 0))]
    assert gains.nested(dict(zip(views_of, ([1], [2], [3])))) == [[[[1], [2]], [[3]]]]


CORE = views.crops("core")
SIZES = len({view.scene for view in CORE}), len(CORE)  # scenes, views


class MadeUp:
    """Errors: white 1, sobol .5, the peers .4 and .2 or vice versa, blue .25."""

    def __init__(self, own=0.0):
        self.views = views.crops("core")
        self.references = {view: types.SimpleNamespace(own={"rmse_2.1": own}) for view in self.views}
        self.labels = ("white", "sobol", *gains.PEERS, "blue")

    def get(self, view, label, spp, measure):
        swapped = view.name[-1] in "34"
        errors = {"white": 1, "sobol": 0.5, gains.PEERS[0]: 0.2 if swapped else 0.4,
                  gains.PEERS[1]: 0.39 if swapped else 0.2, "blue": 0.25}
        return [errors[label] * factor for factor in (0.9, 1.0, 1.1)] if label in errors else None

    def gains(self):
        return gains.Gains(self, self.references, self.labels)


def test_gains_against_each():
    found = MadeUp().gains()
    white = found.gain("blue", 4, "rmse_2.1", "white")
    assert white.value == pytest.approx(4) and white.low < 4.0001 and (white.scenes, white.views) == SIZES
    assert found.gain("blue", 4, "rmse_2.1", "sobol").value == pytest.approx(2)
    # On the mean the second peer is better. The third was not measured.
    assert found.best_peer(4, "rmse_2.1") == gains.PEERS[1]
    assert found.gain("blue", 4, "rmse_2.1", gains.BEST_PEER).value == pytest.approx((0.39 * 0.2) ** 0.5 / 0.25)
    assert found.gain("zorder", 4, "rmse_2.1", "white") is None


def test_ratios_under_the_references_own_error_are_left_out():
    assert MadeUp(own=0.08).gains().gain("blue", 4, "rmse_2.1", "white").left_out == 0
    found = MadeUp(own=0.09).gains()
    assert found.gain("blue", 4, "rmse_2.1", "white") is None and len(found.left_out(4, "rmse_2.1")) == SIZES[1]
    assert found.gain("sobol", 4, "rmse_2.1", "white").value == pytest.approx(2)


def test_views_without_noise_are_left_out():
    made_up = MadeUp()
    empty = made_up.views[0]
    real = made_up.get
    made_up.get = lambda view, label, spp, measure: [gains.VISIBLE / 2] * 3 if (view, spp, measure) == (empty, 1, "displayed") else real(
        view, label, spp, measure)
    found = made_up.gains()
    assert empty not in found.views and found.gain("blue", 4, "rmse_2.1", "white").views == SIZES[1] - 1


# ---- Ratios over seeds

def test_ratio_is_the_geometric_mean_over_seeds():
    r = ratio([2.0, 8.0], [1.0, 1.0])
    assert r.value == pytest.approx(4.0)
    # The logarithms are 1 and 3 times log 2, so their mean has the standard error log 2; t of one degree is 12.706.
    assert r.high / r.value == pytest.approx(2**12.7062, rel=1e-3)
    assert r.low * r.high == pytest.approx(16.0)


def test_one_seed_has_a_value_and_no_certainty():
    r = ratio([3.0], [2.0])
    assert r.value == pytest.approx(1.5) and math.isnan(r.low) and r.chance_below_one() == 1


def test_geometric_mean_over_scenes_adds_variances():
    mean = geometric_mean([Ratio(math.log(2), 0.3, 7), Ratio(math.log(8), 0.4, 7)])
    assert mean.value == pytest.approx(4.0)
    assert mean.standard_error == pytest.approx(0.25)
    assert 7 < mean.freedom <= 14
    same = geometric_mean([Ratio(0.5, 0.1, 7)] * 4)
    assert same.freedom == pytest.approx(28)


def test_worse_cells_are_named_and_chance_is_not():
    rng = np.random.default_rng(3)
    cells = {("even", i): ratio(list(np.exp(rng.normal(0, 0.05, 8))), [1.0] * 8) for i in range(100)}
    cells["worse"] = ratio(list(np.exp(rng.normal(-0.5, 0.05, 8))), [1.0] * 8)
    certain, suspected = worse_cells(cells)
    assert certain == ["worse"]
    # 2.5 of 100 by chance; more than ten once in 10,000.
    assert len(suspected) <= 10 and "worse" not in suspected


def test_seconds_to_error_between_two_counts_and_past_the_last():
    seconds, errors = [1.0, 2.0, 4.0, 8.0], [1.0, 0.5, 0.25, 0.125]
    assert seconds_to_error(seconds, errors, 0.25) == pytest.approx(4.0)
    assert seconds_to_error(seconds, errors, 0.25 * math.sqrt(2)) == pytest.approx(2 * math.sqrt(2))
    assert seconds_to_error(seconds, errors, 3.0) == 1.0
    assert seconds_to_error(seconds, errors, 0.1) == pytest.approx(8 * 1.25**2)
    assert math.isnan(seconds_to_error(seconds, errors, 0.08))
