# SPDX-License-Identifier: Apache-2.0
"""Compares the samplers on rendered scenes: `scripts/bench renders` writes evidence/results/renders.*

A change to one sampler re-renders only that sampler.
"""

import numpy as np

from ..base.page import write_page
from ..base.plots import STYLES, finish, plt, save, style
from ..base.tables import md_table
from ..measure import compare, statistics
from ..measure.compare import Comparison, row_of
from ..measure.image_error import LUMINANCE, MEASURES, measure_name
from ..samplers import variants
from ..samplers.variants import NAMES
from . import models, views
from .judge import COUNTS, Cells, Run, plan, render_references
from .renderer import REFERENCE_PARTS

HEADLINE = "displayed_2.1"
TABLES = (HEADLINE, "displayed_1.0", "displayed", "rmse_2.1", "rmse_1.0", "rmse")
TO_REACH = (4, 16)  # sample counts of the base whose error is to be reached
TO_WHITE = "samples for white noise's error, displayed_2.1"  # in the CSV


class Report:
    """cells: judge.Cells; references: {view: judge.Reference}."""

    def __init__(self, options, cells, references):
        self.options, self.cells, self.references = options, cells, references
        self.labels, self.counts = options.labels, options.counts
        self.compared = Comparison(cells, references, self.labels)
        self.others = tuple(label for label in self.labels if label != "sobol")

    def over(self, label, measure, views=None):
        return lambda spp: self.compared.over(label, spp, measure, views)

    def table(self, measure, views=None, counts=None):
        """One row per sampler."""
        return compare.table("error over padded Sobol'", [spp for spp in counts or self.counts if spp in self.counts], {
            NAMES.get(label, label): self.over(label, measure, views) for label in self.others})

    def scenes_table(self, label):
        scenes = self.compared.by_scene()
        return compare.table(f"{NAMES.get(label, label)} over padded Sobol'", self.counts, {scene: self.over(label, HEADLINE, views) for scene, views in scenes.items()})

    def found(self, label, measure, views=None):
        """{sample count: Estimate}."""
        return {spp: own for spp in self.counts if (own := self.over(label, measure, views)(spp))}

    def groups(self):
        """{name: views}: the built-in scenes and the third-party models."""
        views = self.compared.views
        return {"built-in scenes": tuple(view for view in views if view.scene not in models.MODELS),
                "third-party models": tuple(view for view in views if view.scene in models.MODELS)}

    # ---- Samples to an error

    def to_white(self):
        """{sampler: Estimate} of the number of samples needed for the error of 16 samples of white noise, divided by 16."""
        white = Comparison(self.cells, self.references, self.labels, "white")
        return {label: own for label in self.labels if (own := white.samples_for(label, 16, HEADLINE, self.counts))}

    def reach_table(self):
        """The number of samples that each sampler needs for the error of padded Sobol' at TO_REACH samples, and of white noise at 16."""
        white, rows = self.to_white(), []
        for label in self.labels:
            found = [self.compared.samples_for(label, spp, HEADLINE, self.counts) for spp in TO_REACH if spp in self.counts]
            rows.append([NAMES.get(label, label), *(f"{own.value * spp:.1f}" if own else "" for own, spp in zip(found, TO_REACH)),
                         f"{16 * (own := white[label]).value:.1f} ({16 * own.low:.1f} to {16 * own.high:.1f})" if label in white else ""])
        return md_table(["samples for the error of", *(f"{spp} of padded Sobol'" for spp in TO_REACH if spp in self.counts), "16 of white noise"], rows)

    def rows(self):
        found = self.compared.rows(self.counts, MEASURES, (HEADLINE,))
        for label, own in self.to_white().items():
            found.append(row_of(own, TO_WHITE, "", label, 16))
        return found

    # ---- Tests

    def losses(self):
        """{(scene, spp, measure): p-value of a one-sided test that blue has higher error than padded Sobol', adjusted for multiple tests}."""
        chances = {}
        for (scene, crops), spp, measure in ((part, spp, measure) for part in self.compared.by_scene().items() for spp in self.counts
                                             for measure in ("rmse", "rmse_1.0", "rmse_2.1")):
            logs, _ = self.compared.logs_of("blue", spp, measure, crops)
            if logs:
                chances[scene, spp, measure] = statistics.chance(list(logs.values()))
        return dict(zip(chances, statistics.holm(list(chances.values()))))

    def biases(self):
        """{(scene, label): adjusted p-value of a test that the mean luminance at the largest sample count differs from that of the references}."""
        chances, spp = {}, max(self.counts)
        for (scene, crops), label in ((part, label) for part in self.compared.by_scene().items() for label in self.labels):
            means = [self.cells.get(view, label, spp, "mean") or [] for view in crops]
            if len(means[0]) > 1:
                wanted = sum(float(np.mean(self.references[view].picture.astype(np.float64) @ LUMINANCE)) for view in crops)
                error = np.sqrt(sum(self.references[view].mean_error ** 2 for view in crops))
                chances[scene, label] = statistics.chance_of_mean(means, wanted, error, REFERENCE_PARTS)
        return dict(zip(chances, statistics.holm(list(chances.values()))))

    # ---- The page

    def gains(self):
        """{scene: error of `blue` at 16 samples}, the lowest first."""
        found = {scene: own.value for scene, views in self.compared.by_scene().items() if (own := self.compared.over("blue", 16, HEADLINE, views))}
        return dict(sorted(found.items(), key=lambda item: item[1]))

    def draw(self, axis, measure, title):
        """Errors over sample counts."""
        for label in self.others:
            found = self.found(label, measure)
            axis.plot(list(found), [own.value for own in found.values()], **{**style(label, self.labels), "label": NAMES.get(label, label).replace("`", "")})
        axis.axhline(1, color="0.4", linewidth=1)
        finish(axis, title, "samples per pixel")

    def plot(self, path):
        figure, axes = plt.subplots(1, 2, figsize=(12, 4.4), sharey=True)
        for axis, measure in zip(axes, (HEADLINE, "displayed")):
            self.draw(axis, measure, measure_name(measure))
            found = self.found("blue", measure)
            axis.fill_between(list(found), [own.low for own in found.values()], [own.high for own in found.values()],
                              color=STYLES["blue"][0], alpha=.15, linewidth=0)
        axes[0].set_ylabel("error over padded Sobol'")
        axes[0].legend(fontsize="small", ncols=2)
        save(figure, path)

    def left_out(self):
        """{sample count: crops whose reference is too noisy}, for the main measure."""
        return {spp: own.left_out for spp, own in self.found("blue", HEADLINE).items() if own.left_out}


def rejected(chances):
    return [at for at, value in chances.items() if value <= statistics.FALSE_ALARMS]


# ---- The command

def measured(options):
    """(Cells, references)."""
    work = Run(options.pathtracer, "renders", options.jobs)
    references = render_references(options.pathtracer, options.chosen, options.reference_spp)
    return Cells(work.results(references, plan(options.chosen, options.labels, options.counts, options.seeds))), references


def run(arguments):
    options = views.parse_options("renders", __doc__, arguments, COUNTS)
    cells, references = measured(options)
    report = Report(options, cells, references)
    report.plot(options.out / "renders.png")
    compare.write(options.out / "renders.csv", report.rows())
    write_page(options.out / "renders.md", globals(), report=report, options=options, crop=next(iter(references)).size, has_peers=set(variants.PEERS) & set(options.labels))
