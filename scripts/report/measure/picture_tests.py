# SPDX-License-Identifier: Apache-2.0
"""Two tests of rendered pictures: whether means are those of the references, and whether blue's error is above sobol's.

Each cell pools all crops and seeds of a scene, and one more cell all scenes, so that it has tens of degrees of freedom. All cells of
a test together raise a false alarm with a probability of at most FALSE_ALARMS. The smallest effect of a cell is the one that
it finds with the probability POWER.
"""

import math

import numpy as np

from ..renders.renderer import REFERENCE_PARTS
from .image_error import LUMINANCE
from .ratios import Ratio, geometric_mean, ratio

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
