# SPDX-License-Identifier: Apache-2.0
"""Ratios of errors over seeds: geometric means, 95 % intervals, and tests of pictures, corrected for their number.

Errors of different pictures vary by factors, so all statistics use logarithms: the mean log ratio over n seeds gives the
geometric mean, and Student's t with n - 1 degrees of freedom gives its interval. Means over scenes add the variances of
independent scenes, with Welch-Satterthwaite degrees of freedom.
"""

import dataclasses
import math

import numpy as np
from scipy import stats

from ..renders.renderer import REFERENCE_PARTS
from .image_error import LUMINANCE

LEVEL = 0.95


@dataclasses.dataclass(frozen=True)
class Ratio:
    """A geometric mean as log_mean with its standard error (NaN for a single seed)."""

    log_mean: float
    standard_error: float
    freedom: float

    @property
    def value(self):
        return math.exp(self.log_mean)

    def bound(self, share):
        """The bound below which the true value lies with probability `share`."""
        return math.exp(self.log_mean + stats.t.ppf(share, self.freedom) * self.standard_error)

    @property
    def low(self):
        return self.bound((1 - LEVEL) / 2)

    @property
    def high(self):
        return self.bound((1 + LEVEL) / 2)

    def chance_below_one(self):
        """One-sided p-value of a ratio this low if the true ratio is 1; 1 for a single seed."""
        if not self.freedom >= 1 or math.isnan(self.standard_error):
            return 1.0
        if self.standard_error == 0:
            return 0.0 if self.log_mean < 0 else 1.0
        return float(stats.t.cdf(self.log_mean / self.standard_error, self.freedom))

    def chance_of_one(self):
        """Two-sided p-value of a ratio this far from 1 if the true ratio is 1."""
        return 2 * min(self.chance_below_one(), Ratio(-self.log_mean, self.standard_error, self.freedom).chance_below_one())

    def smallest(self, level, power):
        """The smallest |log| of a true ratio that a one-sided test at `level` tells from 1 with the probability `power`."""
        return float(stats.t.ppf(1 - level, self.freedom) + stats.t.ppf(power, self.freedom)) * self.standard_error


def ratio(above, below):
    """The Ratio of two lists of errors, paired by seed."""
    if len(above) != len(below) or not above:
        raise ValueError(f"{len(above)} and {len(below)} errors cannot be paired")
    if min(*above, *below) <= 0:
        raise ValueError("errors must be positive")
    logs = np.log(above) - np.log(below)
    error = float(np.std(logs, ddof=1) / math.sqrt(len(logs))) if len(logs) > 1 else math.nan
    return Ratio(float(np.mean(logs)), error, len(logs) - 1)


def geometric_mean(ratios):
    variances = [r.standard_error**2 for r in ratios]
    total = sum(variances)
    shares = sum(v * v / r.freedom for v, r in zip(variances, ratios) if r.freedom > 0)
    freedom = total * total / shares if shares > 0 else sum(r.freedom for r in ratios)
    return Ratio(sum(r.log_mean for r in ratios) / len(ratios), math.sqrt(total) / len(ratios), freedom)


def worse_cells(cells):
    """(certain, suspected) names of a {name: Ratio}, most certain first.

    Certain ones are below 1 after Holm's correction for the number of cells: if no true ratio is below 1, the probability
    that any is named is at most FALSE_ALARMS. Suspected ones have a 95 % interval below 1, as 2.5 % of all cells would
    by chance.
    """
    chances = sorted((cell.chance_below_one(), str(name), name) for name, cell in cells.items())
    certain = []
    for i, (chance, _, name) in enumerate(chances):
        if chance > FALSE_ALARMS / (len(chances) - i):
            break
        certain.append(name)
    suspected = [name for chance, _, name in chances[len(certain):] if chance < (1 - LEVEL) / 2]
    return certain, suspected


def seconds_to_error(seconds, errors, wanted):
    """The time at which a progressive run first reaches an error, by log-log interpolation between its sample counts.
    Its first time if the first error is small enough already. Past its last count, up to twice that, the error is taken to fall by the
    root of the time, as white noise's does; NaN further on."""
    for i, error in enumerate(errors):
        if error <= wanted:
            if i == 0:
                return seconds[0]
            share = math.log(errors[i - 1] / wanted) / math.log(errors[i - 1] / error)
            return math.exp((1 - share) * math.log(seconds[i - 1]) + share * math.log(seconds[i]))
    more = (errors[-1] / wanted) ** 2
    return seconds[-1] * more if more <= 2 else math.nan


# ---- Two tests of rendered pictures: whether means are those of the references, and whether blue's error is above sobol's
# Each cell pools all crops and seeds of a scene, and one more cell all scenes, so that it has tens of degrees of freedom. All cells of
# a test together raise a false alarm with a probability of at most FALSE_ALARMS. The smallest effect of a cell is the one that
# it finds with the probability POWER.

FALSE_ALARMS, POWER = 0.01, 0.9
ALL = "all scenes"


def by_scene(views):
    scenes = {}
    for view in views:
        scenes.setdefault(view.scene, []).append(view)
    return scenes


def with_mean(found):
    """{scene: Ratio} with one more for all scenes, if there are several."""
    return {**found, ALL: geometric_mean(list(found.values()))} if len(found) > 1 else found


def bias_of(cells, references, views, label, spp):
    """The mean luminance of a sampler's pictures over that of the references as a Ratio; None with fewer than two seeds, or in
    the dark. The variances of seeds and references add, with Welch and Satterthwaite's degrees of freedom."""
    difference = total = variance = shares = 0.0
    for view in views:
        means, reference = cells.get(view, label, spp, "mean") or [], references[view]
        if len(means) < 2:
            return None
        wanted = float(np.mean(reference.picture.astype(np.float64) @ LUMINANCE))
        own, other = float(np.var(means, ddof=1)) / len(means), reference.mean_error**2
        difference, total = difference + float(np.mean(means)) - wanted, total + wanted
        variance += own + other
        shares += own**2 / (len(means) - 1) + other**2 / (REFERENCE_PARTS - 1)
    if total <= 0 or shares <= 0:
        return None
    return Ratio(math.log1p(difference / total), math.sqrt(variance) / total, variance**2 / shares)


def share_of(log):
    """A logarithm of a ratio as a share; infinite beyond a factor of 1000, as with one or two degrees of freedom."""
    return math.expm1(log) if log < math.log(1000) else math.inf


def biases(cells, references, labels, spp):
    """{(scene, label): Ratio}."""
    found = {}
    for label in labels:
        own = {scene: bias_of(cells, references, views, label, spp) for scene, views in by_scene(references).items()}
        own = {scene: bias for scene, bias in own.items() if bias}
        found.update({(scene, label): bias for scene, bias in with_mean(own).items()})
    return found


def biased(found):
    """The cells of biases() whose mean is not the reference's."""
    return [at for at, bias in found.items() if bias.chance_of_one() < FALSE_ALARMS / len(found)]


def smallest_bias(bias, count):
    """The smallest relative difference that one of `count` cells finds, either way."""
    return share_of(bias.smallest(FALSE_ALARMS / (2 * count), POWER))


def against_sobol(cells, views, counts, measures):
    """{(scene, spp, measure): Ratio} of sobol's error to blue's, over the crops in which both have one."""
    found = {}
    for spp in counts:
        for measure in measures:
            own = {}
            for scene, same in by_scene(views).items():
                pairs = [[cells.get(view, label, spp, measure) or [0] for label in ("sobol", "blue")] for view in same]
                pairs = [(sobol, blue) for sobol, blue in pairs if min(*sobol, *blue) > 0]
                ratios = [ratio(sobol[:len(blue)], blue[:len(sobol)]) for sobol, blue in pairs]
                if ratios:
                    own[scene] = geometric_mean(ratios)
            found.update({(scene, spp, measure): cell for scene, cell in with_mean(own).items()})
    return found


def smallest_loss(cell, count):
    """The smallest share by which blue's error can be above sobol's so that one of `count` cells finds it."""
    return share_of(cell.smallest(FALSE_ALARMS / count, POWER))
