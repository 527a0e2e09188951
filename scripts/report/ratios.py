# SPDX-License-Identifier: Apache-2.0
"""Ratios of errors over seeds: geometric means, their 95 % intervals, and tests that count how many were made.

Errors of different pictures differ by factors, so everything is done on logarithms: the mean of the logarithms of
the ratios of n seeds is the geometric mean, and Student's t with n - 1 degrees of freedom gives the interval. Means
over scenes add the variances of independent ones (degrees of freedom after Welch and Satterthwaite).
"""

import dataclasses
import math

import numpy as np
from scipy import stats

LEVEL = 0.95


@dataclasses.dataclass(frozen=True)
class Ratio:
    """A geometric mean: log_mean and the standard error of that (NaN from one seed alone)."""

    log_mean: float
    standard_error: float
    freedom: float

    @property
    def value(self):
        return math.exp(self.log_mean)

    def bound(self, share):
        """The value under which the true one lies with the probability `share`."""
        return math.exp(self.log_mean + stats.t.ppf(share, self.freedom) * self.standard_error)

    @property
    def low(self):
        return self.bound((1 - LEVEL) / 2)

    @property
    def high(self):
        return self.bound((1 + LEVEL) / 2)

    def chance_below_one(self):
        """One-sided p-value of so low a ratio, were the true one 1. 1 when there is one seed alone."""
        if not self.freedom >= 1 or math.isnan(self.standard_error):
            return 1.0
        if self.standard_error == 0:
            return 0.0 if self.log_mean < 0 else 1.0
        return float(stats.t.cdf(self.log_mean / self.standard_error, self.freedom))


def ratio(above, below):
    """Of two lists of errors, one pair for each seed."""
    if len(above) != len(below) or not above:
        raise ValueError(f"{len(above)} and {len(below)} errors do not make pairs")
    if min(*above, *below) <= 0:
        raise ValueError("errors are positive")
    logs = np.log(above) - np.log(below)
    error = float(np.std(logs, ddof=1) / math.sqrt(len(logs))) if len(logs) > 1 else math.nan
    return Ratio(float(np.mean(logs)), error, len(logs) - 1)


def geometric_mean(ratios):
    variances = [r.standard_error**2 for r in ratios]
    total = sum(variances)
    shares = sum(v * v / r.freedom for v, r in zip(variances, ratios) if r.freedom > 0)
    freedom = total * total / shares if shares > 0 else sum(r.freedom for r in ratios)
    return Ratio(sum(r.log_mean for r in ratios) / len(ratios), math.sqrt(total) / len(ratios), freedom)


def worse_cells(cells, false_alarms=0.01):
    """Of {name: Ratio}: (certain, suspected) names, most certain first.

    Certain ones are below 1 after Holm's correction for the number of cells: that any is named although no true
    ratio is below 1 has a probability of at most `false_alarms`. Suspected ones have a 95 % interval below 1; of so
    many cells 2.5 % would be there by chance.
    """
    chances = sorted((cell.chance_below_one(), str(name), name) for name, cell in cells.items())
    certain = []
    for i, (chance, _, name) in enumerate(chances):
        if chance > false_alarms / (len(chances) - i):
            break
        certain.append(name)
    suspected = [name for chance, _, name in chances[len(certain):] if chance < (1 - LEVEL) / 2]
    return certain, suspected


def seconds_to_error(seconds, errors, wanted):
    """When a run whose error falls as it goes on first reaches an error, between two counts on straight lines of
    log error over log seconds. NaN if it never does; the first second there is if it is there from the beginning."""
    for i, error in enumerate(errors):
        if error <= wanted:
            if i == 0:
                return seconds[0]
            share = math.log(errors[i - 1] / wanted) / math.log(errors[i - 1] / error)
            return math.exp((1 - share) * math.log(seconds[i - 1]) + share * math.log(seconds[i]))
    return math.nan
