# SPDX-License-Identifier: Apache-2.0
"""Errors of samplers relative to a base (by default padded Sobol') over scenes, images, crops and seeds, with intervals."""

import math

import numpy as np

from ..base import files
from ..base.tables import md_table
from .statistics import estimate, samples_to_error

# A ratio counts only where the smaller error is at least this many times the reference's own error,
REFERENCE_MARGIN = 3.0
# and where one sample of white noise differs from the reference by this much, as displayed. This excludes an empty sky.
VISIBLE = 1e-3
FIELDS = ("measure", "scene", "sampler", "spp", "error", "low", "high", "scenes", "crops", "left_out")


class Comparison:
    """cells: judge.Cells; references: {view: judge.Reference}."""

    def __init__(self, cells, references, labels, base="sobol"):
        self.cells, self.references, self.labels, self.base = cells, references, labels, base
        self.views = tuple(view for view in references if self._is_noisy(view))
        self._found = {}  # shared by tables, plots and rows

    def _is_noisy(self, view):
        errors = self.cells.get(view, "white", 1, "displayed")
        return not errors or math.sqrt(np.mean(np.square(errors))) >= VISIBLE

    def logs(self, view, label, spp, measure, base):
        """Log error ratios, one per seed; None if an error was not measured or is zero, for example where only lights are visible."""
        own, other = self.cells.get(view, label, spp, measure), self.cells.get(view, base, spp, measure)
        count = min(len(own or ()), len(other or ()))
        if not count or min(*own[:count], *other[:count]) <= 0:
            return None
        return np.log(own[:count]) - np.log(other[:count])

    def is_judged(self, view, labels, spp, measure):
        """Whether the reference is accurate enough for these errors."""
        least = min(math.sqrt(np.mean(np.square(self.cells.get(view, label, spp, measure)))) for label in labels)
        return least >= REFERENCE_MARGIN * self.references[view].own.get(measure, 0.0)

    def logs_of(self, label, spp, measure, views=None, base=None):
        """({view: logs}, number of views left out)."""
        base = base or self.base
        found = {view: self.logs(view, label, spp, measure, base) for view in views or self.views}
        found = {view: logs for view, logs in found.items() if logs is not None}
        judged = {view: logs for view, logs in found.items() if self.is_judged(view, (label, base), spp, measure)}
        return judged, len(found) - len(judged)

    def over(self, label, spp, measure, views=None, base=None):
        """The Estimate of a sampler's error relative to the base; None if nothing was measured."""
        key = label, spp, measure, views, base
        if key not in self._found:
            self._found[key] = estimate(*self.logs_of(*key))
        return self._found[key]

    def by_scene(self):
        scenes = {}
        for view in self.views:
            scenes.setdefault(view.scene, []).append(view)
        return {scene: tuple(views) for scene, views in scenes.items()}

    def samples_for(self, label, spp, measure, counts):
        """The number of samples a sampler needs to reach the base's error at `spp`, divided by spp: an Estimate over the views in
        which it reaches this error."""
        found = {}
        for view in self.views:
            own = [self.cells.get(view, label, n, measure) for n in counts]
            wanted = self.cells.get(view, self.base, spp, measure)
            if wanted and all(own) and min(map(min, own)) > 0 and self.is_judged(view, (self.base,), spp, measure):
                at = samples_to_error(counts, [math.exp(np.mean(np.log(values))) for values in own], math.exp(np.mean(np.log(wanted))))
                if not math.isnan(at):
                    found[view] = [math.log(at / spp)]
        return estimate(found, len(self.views) - len(found))

    def rows(self, counts, measures, by_scene=()):
        """Dicts with FIELDS for all scenes together and, for the measures in by_scene, for each scene."""
        found = []
        for measure in measures:
            parts = {"": None, **(self.by_scene() if measure in by_scene else {})}
            for (scene, views), label, spp in ((part, label, spp) for part in parts.items() for label in self.labels if label != self.base for spp in counts):
                if own := self.over(label, spp, measure, views):
                    found.append(row_of(own, measure, scene, label, spp))
        return found


def row_of(own, measure, scene, label, spp):
    return {"measure": measure, "scene": scene, "sampler": label, "spp": spp, **own.ends(), "scenes": own.scenes, "crops": own.crops, "left_out": own.left_out}


def write(path, rows):
    files.write_rows(path, FIELDS, rows)


def table(head, counts, rows):
    """A Markdown table from {name: function(count) -> Estimate or None}; names without an Estimate are left out."""
    found = {name: [of(count) for count in counts] for name, of in rows.items()}
    return md_table([head, *map(str, counts)], [[name, *(own.text() if own else "" for own in line)] for name, line in found.items() if any(line)])
