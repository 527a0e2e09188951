# SPDX-License-Identifier: Apache-2.0
"""Statistics of error ratios. Errors of different crops differ by large factors, so logarithms are averaged.

The 95% interval of a mean over scenes comes from a bootstrap that resamples scenes, images within scenes, crops within images and seeds
within crops. It covers results for similar scenes, crops and seeds. Tests of one scene pool the variance over its crops.
"""

import dataclasses
import math

import numpy as np
from scipy import stats

DRAWS, SEED, LEVEL = 2000, 20_231, 0.95
FALSE_ALARMS = 0.01  # the probability that a set of tests raises a false alarm


@dataclasses.dataclass(frozen=True)
class Estimate:
    """A geometric mean and its interval."""

    value: float
    low: float
    high: float
    scenes: int = 1
    crops: int = 1
    left_out: int = 0  # crops whose reference is too noisy for this ratio

    @property
    def significant(self):
        """Whether the interval excludes 1. An interval of NaN, as from one seed, excludes nothing."""
        return self.low > 1 or self.high < 1

    def ends(self):
        """The value and interval as a CSV file has them."""
        return {"error": f"{self.value:.4f}", "low": f"{self.low:.4f}", "high": f"{self.high:.4f}"}

    def text(self):
        return f"**{self.value:.2f}**" if self.significant else f"{self.value:.2f}"


def mean_of(group):
    """The mean of a list of numbers, or of the means of a list of groups."""
    return float(np.mean([mean_of(part) if isinstance(part, (list, np.ndarray)) else part for part in group]))


def _resampled(groups, draws, rng):
    """`draws` means of groups of groups ... of numbers, resampled at every level."""
    level, chosen, used = [groups], np.zeros(draws, int), []
    while isinstance(level[0], (list, np.ndarray)):
        counts = np.array([len(part) for part in level])
        first, own = np.cumsum(counts) - counts, counts[chosen][..., None]
        used.append(np.arange(counts.max()) < own)
        chosen = first[chosen][..., None] + (rng.random((*chosen.shape, counts.max())) * own).astype(int)
        level = [part for parts in level for part in parts]
    values = np.asarray(level, float)[chosen]
    for mask in reversed(used):
        values = (values * mask).sum(-1) / mask.sum(-1)
    return values


def bootstrap(groups, draws=DRAWS):
    """(mean, low, high) of groups of groups ... of numbers: a mean of means, resampled at every level."""
    low, high = np.quantile(_resampled(groups, draws, np.random.default_rng(SEED)), [(1 - LEVEL) / 2, (1 + LEVEL) / 2])
    return mean_of(groups), float(low), float(high)


def estimate(logs, left_out=0):
    """The Estimate for {view: log ratios, one per seed}; None if it is empty. Views with the same picture are its crops. A single
    number has no interval: its ends are NaN."""
    if not logs:
        return None
    scenes = {}
    for view, numbers in logs.items():
        scenes.setdefault(view.scene, {}).setdefault(getattr(view, "picture", None), []).append(numbers)
    value, low, high = map(math.exp, bootstrap([list(pictures.values()) for pictures in scenes.values()]))
    if sum(map(len, logs.values())) == 1:
        low = high = math.nan
    return Estimate(value, low, high, len(scenes), len(logs), left_out)


def ratio(above, below):
    """The Estimate of the ratio of two lists of errors paired by seed. The interval is Student's, or NaN for a single seed."""
    logs = np.log(above) - np.log(below)
    if len(logs) < 2:
        return Estimate(math.exp(logs[0]), math.nan, math.nan)
    low, high = stats.ttest_1samp(logs, 0).confidence_interval(LEVEL)
    return Estimate(*map(math.exp, (logs.mean(), low, high)))


def chance(groups):
    """One-sided p-value for the hypothesis that the true mean of groups of numbers is at most 0: a t-test whose variance is pooled over the
    groups. Returns 1 if no group has two numbers."""
    groups = [np.asarray(group, float) for group in groups]
    freedom = sum(len(group) - 1 for group in groups)
    if freedom < 1:
        return 1.0
    variance = sum(((group - group.mean()) ** 2).sum() for group in groups) / freedom
    error = math.sqrt(variance * sum(1 / len(group) for group in groups)) / len(groups)
    return float(stats.t.sf(np.mean([group.mean() for group in groups]) / max(error, 1e-300), freedom))


def holm(chances):
    """p-values adjusted for multiple tests (Holm, 1979). The probability that any adjusted value <= FALSE_ALARMS is a false alarm is FALSE_ALARMS."""
    order = np.argsort(chances)
    steps = np.maximum.accumulate((len(chances) - np.arange(len(chances))) * np.asarray(chances, float)[order])
    adjusted = np.empty(len(chances))
    adjusted[order] = np.minimum(steps, 1)
    return adjusted


def chance_of_mean(groups, mean, error, count):
    """Two-sided p-value for the hypothesis that the sum of the groups' true means equals a mean over `count` parts with a given
    standard error: Welch's test, in which the groups have the degrees of freedom of their pooled variance."""
    groups = [np.asarray(group, float) for group in groups]
    freedom = sum(len(group) - 1 for group in groups)
    own = math.sqrt(sum(group.var(ddof=1) / len(group) for group in groups))
    found = stats.ttest_ind_from_stats(sum(group.mean() for group in groups), own * math.sqrt(freedom + 1), freedom + 1, mean, error * math.sqrt(count), count,
                                       equal_var=False)
    return float(found.pvalue)


def samples_to_error(samples, errors, wanted):
    """The number of samples that a progressive run needs to reach an error, by log-log interpolation between sample counts; NaN beyond them."""
    logs = np.minimum.accumulate(np.log(errors))
    if not logs[-1] <= math.log(wanted) <= logs[0]:
        return math.nan
    return math.exp(np.interp(-math.log(wanted), -logs, np.log(samples)))
