# SPDX-License-Identifier: Apache-2.0
"""Ratios over seeds, their intervals and tests, and times to an error, against values computed by hand."""

import math

import numpy as np
import pytest
from report.measure.ratios import Ratio, geometric_mean, ratio, seconds_to_error, worse_cells


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


def test_interval_holds_the_truth_as_often_as_it_says():
    # 400 trials of 8 seeds: 95 % intervals miss 20 times in the mean, more than 38 times once in 10,000.
    rng = np.random.default_rng(7)
    missed = 0
    for _ in range(400):
        r = ratio(list(np.exp(rng.normal(math.log(1.5), 0.2, 8))), [1.0] * 8)
        missed += not r.low <= 1.5 <= r.high
    assert 4 <= missed <= 38


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
