# SPDX-License-Identifier: Apache-2.0
"""How many times smaller one sampler's error is than another's, over many scenes and views, with bootstrap intervals.

A gain is the geometric mean, over scenes, of the geometric means over their views and seeds. Its 95 % interval comes from
a hierarchical bootstrap that resamples scenes, views within scenes and seeds within views, so it covers what other
scenes, views and seeds of the same kind would give. The bootstrap has a fixed seed: equal rows give equal intervals.
"""

import csv
import dataclasses
import io
import math

import numpy as np

from .files import write_text
from .peers import PEERS

DRAWS, BOOTSTRAP_SEED, LEVEL = 2000, 20_231, 0.95
# A ratio counts only where the smaller error is at least this many times the reference's own error.
REFERENCE_MARGIN = 3.0
BEST_PEER, BEST_PEER_EACH = "best of OpenQMC", "best of OpenQMC in each view"
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


def bootstrap(groups, draws=DRAWS, seed=BOOTSTRAP_SEED):
    """(mean, low, high) of a list of groups of arrays: a mean of means of means, resampled at every level."""
    rng = np.random.default_rng(seed)
    scene_count, most_views = len(groups), max(len(group) for group in groups)
    most_seeds = max(len(own) for group in groups for own in group)
    values = np.zeros((scene_count, most_views, most_seeds))
    views, seeds = np.zeros(scene_count, int), np.ones((scene_count, most_views), int)
    for s, group in enumerate(groups):
        views[s] = len(group)
        for v, own in enumerate(group):
            seeds[s, v] = len(own)
            values[s, v, :len(own)] = own
    mean = float(np.mean([np.mean([np.mean(own) for own in group]) for group in groups]))

    s = rng.integers(scene_count, size=(draws, scene_count, 1))
    v = (rng.random((draws, scene_count, most_views)) * views[s]).astype(int)
    k = (rng.random((draws, scene_count, most_views, most_seeds)) * seeds[s, v][..., None]).astype(int)
    drawn = values[s[..., None], v[..., None], k]
    used = np.arange(most_seeds) < seeds[s, v][..., None]
    of_views = (drawn * used).sum(-1) / used.sum(-1)
    used = np.arange(most_views) < views[s]
    means = ((of_views * used).sum(-1) / used.sum(-1)).mean(-1)
    low, high = np.quantile(means, [(1 - LEVEL) / 2, (1 + LEVEL) / 2])
    return mean, float(low), float(high)


class Gains:
    """Error ratios between samplers. cells: judge.Cells; references: {view: judge.Reference}."""

    def __init__(self, cells, references, labels):
        self.cells, self.references, self.labels = cells, references, labels
        self.views = tuple(references)
        self.peers = tuple(label for label in labels if label in PEERS)
        self._gains = {}  # shared by tables, plots and CSV rows

    def is_judged(self, view, label, spp, measure):
        """Whether the reference is accurate enough for this cell. FLIP has no such test."""
        errors, own = self.cells.get(view, label, spp, measure), self.references[view].own.get(measure, 0.0)
        return math.sqrt(np.mean(np.square(errors))) >= REFERENCE_MARGIN * own

    def _best(self, views, spp, measure):
        """The peer with the smallest geometric-mean error over these views, or None."""
        found = {}
        for peer in self.peers:
            errors = [self.cells.get(view, peer, spp, measure) for view in views]
            if all(errors):
                found[peer] = np.mean([np.mean(np.log(own)) for own in errors])
        return min(found, key=found.get) if found else None

    def best_peer(self, spp, measure):
        return self._best(self.views, spp, measure)

    def logs(self, view, label, spp, measure, than):
        """Log error ratios, one per seed; None if either sampler was not measured."""
        if than == BEST_PEER:
            than = self.best_peer(spp, measure)
        elif than == BEST_PEER_EACH:
            than = self._best((view,), spp, measure)
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
        scenes, left_out = {}, 0
        for view in views or self.views:
            logs = self.logs(view, label, spp, measure, than)
            if logs is None:
                continue
            if self.is_judged(view, label, spp, measure):
                scenes.setdefault(view.scene, []).append(logs)
            else:
                left_out += 1
        if not scenes:
            return None
        mean, low, high = (math.exp(value) for value in bootstrap(list(scenes.values())))
        return Gain(mean, low, high, len(scenes), sum(map(len, scenes.values())), left_out)

    def left_out(self, spp, measure, label="blue"):
        return [view for view in self.views
                if self.cells.get(view, label, spp, measure) and not self.is_judged(view, label, spp, measure)]

    def thans(self):
        """The samplers that blue is compared with."""
        return ("white", "sobol", *((BEST_PEER, BEST_PEER_EACH) if self.peers else ()))

    def rows(self, counts, measures, labels=("blue",)):
        """Every gain as a dict with FIELDS, for a CSV that other commands read."""
        rows = []
        for measure in measures:
            for spp in counts:
                for label in labels:
                    for than in self.thans():
                        gain = self.gain(label, spp, measure, than) if label in self.labels else None
                        if gain:
                            rows.append({"measure": measure, "spp": spp, "sampler": label, "than": than,
                                         "gain": f"{gain.value:.6f}", "low": f"{gain.low:.6f}", "high": f"{gain.high:.6f}",
                                         "scenes": gain.scenes, "views": gain.views, "left_out": gain.left_out})
        return rows


def write_rows(path, rows):
    out = io.StringIO()
    writer = csv.DictWriter(out, FIELDS, lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    write_text(path, out.getvalue())


def read_rows(path):
    """{(measure, spp, sampler, than): Gain} from a file written by write_rows()."""
    with open(path, newline="", encoding="utf-8") as file:
        return {(row["measure"], int(row["spp"]), row["sampler"], row["than"]): Gain(
            float(row["gain"]), float(row["low"]), float(row["high"]), int(row["scenes"]), int(row["views"]),
            int(row["left_out"])) for row in csv.DictReader(file)}
