# SPDX-License-Identifier: Apache-2.0
"""The error of one sampler over another's, over many scenes and views, with bootstrap intervals.

A gain is the geometric mean, over scenes, of the geometric means over their pictures, crops and seeds. Its 95 % interval
comes from a hierarchical bootstrap that resamples scenes, pictures within scenes, crops within pictures and seeds within
crops, so it covers what others of the same kind would give. The bootstrap has a fixed seed: equal rows give equal
intervals.
"""

import dataclasses
import math

import numpy as np

from ..base import files
from ..base.peers import PEERS
from ..base.tables import md_table

DRAWS, BOOTSTRAP_SEED, LEVEL = 2000, 20_231, 0.95
# A ratio counts only where the smaller error is at least this many times the reference's own error.
REFERENCE_MARGIN = 3.0
# Nor does it where white noise at one sample differs from the reference by less, as displayed: in an empty sky, for instance.
VISIBLE = 1e-3
BEST_PEER = "best of OpenQMC"
COMPARED = ("white", "sobol", "sobol-global", "zorder", "mask")
HEADLINE_MEASURES = ("displayed_2.1", "rmse_2.1")
FIELDS = ("measure", "spp", "sampler", "than", "gain", "low", "high", "scenes", "views", "left_out")


@dataclasses.dataclass(frozen=True)
class Gain:
    value: float
    low: float
    high: float
    scenes: int = 1
    views: int = 1
    left_out: int = 0  # views whose reference is too noisy for this ratio

    def text(self):
        """For example "1.83 (1.70 to 1.95)"."""
        return f"{self.value:.2f} ({self.low:.2f} to {self.high:.2f})"


def value_text(gain):
    return f"{gain.value:.2f}"


def table(head, counts, rows, cell=Gain.text):
    """Markdown from {name: function(count) -> Gain or None}; names without any are left out."""
    found = {name: [of(count) for count in counts] for name, of in rows.items()}
    return md_table([head, *map(str, counts)], [
        [name, *(cell(gain) if gain else "" for gain in gains)] for name, gains in found.items() if any(gains)])


def mean_of(group):
    """The mean of a list of numbers, or of the means of a list of groups."""
    return float(np.mean([mean_of(part) if isinstance(part, (list, np.ndarray)) else part for part in group]))


def _resampled(groups, draws, rng):
    """`draws` times the mean of groups of groups ... of numbers, resampled at every level."""
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


def bootstrap(groups, draws=DRAWS, seed=BOOTSTRAP_SEED):
    """(mean, low, high) of groups of groups ... of numbers: a mean of means, resampled at every level."""
    means = _resampled(groups, draws, np.random.default_rng(seed))
    low, high = np.quantile(means, [(1 - LEVEL) / 2, (1 + LEVEL) / 2])
    return mean_of(groups), float(low), float(high)


def nested(found):
    """{view: numbers} as groups of groups for bootstrap(): scenes, pictures, crops, numbers. Views that name no picture are
    crops of one picture of their scene."""
    scenes = {}
    for view, numbers in found.items():
        scenes.setdefault(view.scene, {}).setdefault(getattr(view, "picture", None), []).append(numbers)
    return [list(pictures.values()) for pictures in scenes.values()]


def gain_of(found, left_out=0):
    """The Gain of {view: log ratios}, one per seed; None of nothing."""
    if not found:
        return None
    mean, low, high = (math.exp(value) for value in bootstrap(nested(found)))
    return Gain(mean, low, high, len({view.scene for view in found}), len(found), left_out)


class Gains:
    """Error ratios between samplers, in the views that show noise. cells: judge.Cells; references: {view: judge.Reference}."""

    def __init__(self, cells, references, labels):
        self.cells, self.references, self.labels = cells, references, labels
        self.views = tuple(view for view in references if self._is_noisy(view))
        self.peers = tuple(label for label in labels if label in PEERS)
        self._gains = {}  # shared by tables, plots and CSV rows

    def _is_noisy(self, view):
        errors = self.cells.get(view, "white", 1, "displayed")
        return not errors or math.sqrt(np.mean(np.square(errors))) >= VISIBLE

    def is_judged(self, view, label, spp, measure):
        """Whether the reference is accurate enough for this cell."""
        errors, own = self.cells.get(view, label, spp, measure), self.references[view].own.get(measure, 0.0)
        return math.sqrt(np.mean(np.square(errors))) >= REFERENCE_MARGIN * own

    def best_peer(self, spp, measure):
        """The peer with the smallest geometric-mean error, of those that were measured in every view that counts; None if there is none."""
        views = [view for view in self.views if self.is_judged(view, "blue", spp, measure)]
        found = {peer: [self.cells.get(view, peer, spp, measure) for view in views] for peer in self.peers}
        found = {peer: errors for peer, errors in found.items() if all(errors)}
        whole = [i for i in range(len(views)) if all(min(errors[i]) > 0 for errors in found.values())]
        means = {peer: mean_of([np.log(errors[i]) for i in whole]) for peer, errors in found.items() if whole}
        return min(means, key=means.get) if means else None

    def logs(self, view, label, spp, measure, than):
        """Log error ratios, one per seed; None if either sampler was not measured."""
        if than == BEST_PEER:
            than = self.best_peer(spp, measure)
        own, other = self.cells.get(view, label, spp, measure), self.cells.get(view, than, spp, measure)
        if not own or not other:
            return None
        count = min(len(own), len(other))
        if min(*own[:count], *other[:count], 1) <= 0:
            return None  # a picture without error, such as a scene in which only lights are visible
        return np.log(other[:count]) - np.log(own[:count])

    def gain(self, label, spp, measure, than, views=None):
        """A Gain over these views (default: all); None if nothing was measured or every view is excluded."""
        key = label, spp, measure, than, views
        if key not in self._gains:
            self._gains[key] = self._gain(*key)
        return self._gains[key]

    def _gain(self, label, spp, measure, than, views):
        found = {view: self.logs(view, label, spp, measure, than) for view in views or self.views}
        found = {view: logs for view, logs in found.items() if logs is not None}
        judged = {view: logs for view, logs in found.items() if self.is_judged(view, label, spp, measure)}
        return gain_of(judged, len(found) - len(judged))

    def left_out(self, spp, measure):
        """The views whose reference is too noisy for blue."""
        return [view for view in self.views
                if self.cells.get(view, "blue", spp, measure) and not self.is_judged(view, "blue", spp, measure)]

    def thans(self):
        """The samplers that blue is compared with."""
        return tuple(label for label in COMPARED if label in self.labels) + ((BEST_PEER,) if self.peers else ())

    def rows(self, counts, measures):
        """Every gain of blue as a dict with FIELDS, for a CSV that other commands read."""
        found = [(self.gain("blue", spp, measure, than), measure, spp, "blue", than)
                 for measure in measures for spp in counts for than in self.thans()]
        return [row_of(*row) for row in found if row[0]]


def row_of(gain, measure, spp, label, than):
    """A dict with FIELDS."""
    return {"measure": measure, "spp": spp, "sampler": label, "than": than, "gain": f"{gain.value:.6f}", "low": f"{gain.low:.6f}",
            "high": f"{gain.high:.6f}", "scenes": gain.scenes, "views": gain.views, "left_out": gain.left_out}


def write_rows(path, rows):
    files.write_rows(path, FIELDS, rows)


def read_rows(path):
    """{(measure, spp, sampler, than): Gain} from a file written by write_rows()."""
    return {(row["measure"], row["spp"], row["sampler"], row["than"]): Gain(*(row[name] for name in FIELDS[4:]))
            for row in files.read_numbers(path)}
