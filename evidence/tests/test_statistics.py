# SPDX-License-Identifier: Apache-2.0
"""Compares statistics with known values and with SciPy, and samplers on synthetic errors."""

import math
import types

import numpy as np
import pytest
from scipy import stats

from evidence.measure import compare, statistics
from evidence.renders import views


def test_bootstrap_mean_and_interval():
    groups = [[[1.0, 3.0], [4.0]], [[5.0]]]
    mean, low, high = statistics.bootstrap(groups)
    assert mean == pytest.approx((3 + 5) / 2) and 1 <= low < mean < high <= 5
    # Four crops each of two images carry less information than eight images.
    few, many = (statistics.bootstrap(made) for made in ([[[[level]] * 4 for level in (-1, 1)]], [[[[level]] for level in 4 * (-1, 1)]]))
    assert few[2] - few[1] > 1.9 and many[2] - many[1] < 1.6


def test_bootstrap_intervals_cover_the_mean():
    """With 40 scenes, 93 to 94% of bootstrap intervals cover the mean. Fewer than 178 hits in 200 trials have a probability of 1/5000."""
    rng, hits = np.random.default_rng(5), 0
    for _ in range(200):
        groups = [[scene + 0.2 * rng.standard_normal(3) for _ in range(2)] for scene in rng.standard_normal(40)]
        _, low, high = statistics.bootstrap(groups, 300)
        hits += low <= 0 <= high
    assert 178 <= hits < 200


def test_holm_matches_r_and_statsmodels():
    assert statistics.holm([0.01, 0.04, 0.03, 0.005]) == pytest.approx([0.03, 0.06, 0.06, 0.02])
    assert statistics.holm([0.5, 0.9, 0.4]) == pytest.approx([1, 1, 1])


def test_p_values_match_scipy():
    rng = np.random.default_rng(2)
    one, two, many = rng.normal(0.1, 1, 6), rng.normal(0.1, 1, 6), rng.normal(0.3, 2, 40)
    assert statistics.chance([one]) == pytest.approx(stats.ttest_1samp(one, 0, alternative="greater").pvalue)
    # With a common variance, the mean of two groups is half the difference between the first group and the negated second group.
    assert statistics.chance([one, two]) == pytest.approx(stats.ttest_ind(one, -two, alternative="greater").pvalue)
    assert statistics.chance([[1.0]]) == 1
    assert statistics.chance_of_mean([one], many.mean(), many.std(ddof=1) / math.sqrt(40), 40) == pytest.approx(stats.ttest_ind(one, many, equal_var=False).pvalue)
    # False alarms remain rare even if groups of two have little spread by chance.
    alarms = sum(statistics.chance_of_mean(rng.normal(1, 1, (4, 2)), 4, 0.1, 32) < 0.01 for _ in range(400))
    assert alarms <= 12


def test_ratios_are_paired_by_seed():
    found = statistics.ratio([2.0, 8.0], [1.0, 1.0])
    # The log ratios are 1 and 3 times log 2, so the standard error of their mean is log 2. t with one degree of freedom is 12.706.
    assert found.value == pytest.approx(4) and found.high / found.value == pytest.approx(2**12.7062, rel=1e-3) and found.low * found.high == pytest.approx(16)
    paired = statistics.ratio([1.0, 2.0, 3.0], [2.0, 4.01, 6.0])
    assert paired.significant and not statistics.ratio([1.0, 2.0, 3.0], [6.0, 4.01, 2.0]).significant
    single = statistics.ratio([3.0], [2.0])
    assert math.isnan(single.low) and not single.significant and single.text() == "1.50"


@pytest.mark.parametrize(("errors", "wanted", "samples"), [
    ([1, 1 / 2, 1 / 4, 1 / 8], 2**-1.5, 2**1.5), ([1, 1 / 2, 1 / 4, 1 / 8], 1.1, math.nan), ([1, 1 / 2, 1 / 4, 1 / 8], 0.1, math.nan),
    ([1, 1 / 2, 1 / 4, 1 / 2], 2**-1.5, 2**1.5)])  # the first sample count that reaches the error, even if a larger one has a higher error
def test_samples_to_reach_an_error(errors, wanted, samples):
    assert statistics.samples_to_error([1, 2, 4, 8], errors, wanted) == pytest.approx(samples, nan_ok=True)


# ---- Comparisons

CROPS = [view for scene in ("lens", "glossy", "fog") for view in views.crops("development", (scene,), (64, 48), (8, 8))]
FACTORS = {"white": 4.0, "sobol": 1.0, "blue": 0.5, "openqmc-pmjbn": 0.6, "openqmc-sobolbn": 0.7}
SEEDS = (0.5, 1.0, 2.0)  # each seed scales all samplers' errors by a common factor


def compared(own=0.0, **more):
    def get(view, label, spp, measure):
        factor = {**FACTORS, **more}.get(label)
        return factor and [factor * seed * spp**-0.5 for seed in SEEDS]

    references = {view: types.SimpleNamespace(own={"rmse": own}) for view in CROPS}
    return compare.Comparison(types.SimpleNamespace(get=get), references, tuple(FACTORS))


def test_errors_are_relative_to_the_baseline_with_the_same_seed():
    found = compared().over("blue", 4, "rmse")
    assert (found.value, found.low, found.high) == pytest.approx((0.5, 0.5, 0.5)) and found.significant and (found.scenes, found.crops) == (3, 12)
    assert compared().over("white", 4, "rmse").text() == "**4.00**" and compared().over("zorder", 4, "rmse") is None
    assert compared().over("blue", 1, "rmse", base="white").value == pytest.approx(1 / 8)


def test_errors_near_the_references_own_error_are_left_out():
    assert compared(own=0.07).over("blue", 4, "rmse").left_out == 0
    assert compared(own=0.12).over("blue", 4, "rmse") is None and compared(own=0.12).over("white", 4, "rmse") is not None
    # The root mean square of SEEDS is 1.32, so these errors are 1.06e-3 and 0.93e-3; 1e-3 is visible.
    assert len(compared(white=8e-4).views) == len(CROPS)
    dark = compared(white=7e-4)
    assert dark.views == () and dark.over("blue", 4, "rmse") is None


def test_a_single_number_has_no_interval():
    view = CROPS[0]
    one, two = statistics.estimate({view: [math.log(0.5)]}), statistics.estimate({view: [math.log(0.5), math.log(0.6)]})
    assert one.value == pytest.approx(0.5) and math.isnan(one.low) and math.isnan(one.high) and not one.significant and one.text() == "0.50"
    assert two.low < two.value < two.high and two.significant


def test_samples_to_match_the_baseline_error():
    counts = (1, 2, 4, 8, 16, 64)
    assert compared().samples_for("blue", 16, "rmse", counts).value == pytest.approx(1 / 4)
    assert compared().samples_for("white", 16, "rmse", counts) is None


def test_rows_cover_all_scenes_and_each_scene():
    rows = compared().rows((1, 4), ("rmse",), ("rmse",))
    assert len(rows) == 4 * 2 * 4 and {row["scene"] for row in rows} == {"", "lens", "glossy", "fog"}
    assert {row["error"] for row in rows if row["sampler"] == "blue"} == {"0.5000"}
