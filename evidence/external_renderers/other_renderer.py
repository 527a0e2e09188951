# SPDX-License-Identifier: Apache-2.0
"""The common part of the comparisons in other renderers: running their programs, references, options, and the report."""

import dataclasses
import functools
import math
import os
import statistics
import tempfile
from pathlib import Path

import numpy as np

from ..base.command import command_shown, names_of
from ..base.contact_sheet import labelled, preview
from ..base.files import read_exr, write_image, write_text
from ..base.progress import Progress, in_parallel
from ..base.tables import md_table, update_table
from ..measure import compare
from ..measure.compare import MARKED, Comparison
from ..measure.image_error import LUMINANCE, SIGMAS, blurred, displayed, displayed_rmse, rmse
from ..renders.judge import Reference, Run
from ..renders.renderer import REFERENCE_SEED

COUNTS = (1, 2, 3, 4, 6, 8, 16, 32, 64)
KINDS = {"displayed": "as displayed", "exposed": "exposed and displayed", "rmse": "raw"}
MEASURES = tuple(f"{kind}_{sigma}" for kind in KINDS for sigma in reversed(SIGMAS))
EXPOSED = 0.25  # the mean luminance of an exposed image's reference
HEADLINE = ("displayed_2.1", "rmse_2.1")
SPREAD_COUNTS = (1, 4, 16, 64)


def errors(picture, reference):
    """{measure: error} for all of MEASURES: as displayed, exposed and displayed, and raw, each after each blur."""
    stops = np.log2(EXPOSED / max(float(np.mean(reference @ LUMINANCE)), 1e-9))
    pictures = {"rmse": (picture, reference), "displayed": (displayed(picture), displayed(reference)),
                "exposed": (displayed(picture, stops), displayed(reference, stops))}
    return {f"{kind}_{sigma}": rmse(*pictures[kind], sigma) for kind in KINDS for sigma in SIGMAS}


def shown_and_raw(pictures, reference, sigma=2.1):
    """(error as displayed, raw error) after the blur: root mean squares over images."""
    found = [(displayed_rmse(picture, reference, sigma=sigma), rmse(picture, reference, sigma)) for picture in pictures]
    return np.sqrt(np.mean(np.square(found), 0))


def name_of(measure):
    kind, _, sigma = measure.partition("_")
    return KINDS[kind] + (f", after sigma {sigma}" if float(sigma) else ", unblurred")


@dataclasses.dataclass(frozen=True)
class Task:
    """All images of one view, sampler and seed or, with a threshold, one adaptive image. The sampler is tuned for each image's sample
    count, or for `told`."""

    view: object
    sampler: str
    seed: int
    counts: tuple
    threshold: float = 0.0
    told: int = 0

    @property
    def label(self):
        return f"{self.sampler} {self.told or self.threshold}" if self.told or self.threshold else self.sampler

    @property
    def cost(self):
        # Starting a program takes as long as about ten samples.
        return self.view.size[0] * self.view.size[1] * sum(count + 10 for count in self.counts)


class OtherRun(Run):
    """Renders tasks in another renderer, or finds their results in a cache folder. References come from a sampler that hashes pixel, dimension
    and seed and have separate seeds, so their errors are independent of every other.

    A subclass implements key(), reference_key(view, spp), and render(task, spp, seed, out), which returns CPU seconds. `reference` names
    the sampler of references, whose seeds are REFERENCE_SEED and REFERENCE_SEED + 1.
    """

    def more(self, task, spp):
        """Additional figures for a task's row."""
        return {}

    def rendered(self, task, spp, seed, **more):
        """(CPU seconds, picture)."""
        with tempfile.TemporaryDirectory(prefix="libbn-") as folder:
            out = Path(folder) / "out.exr"
            return self.render(task, spp, seed, out, **more), read_exr(out)[0]

    def measure(self, task, reference):
        rows = []
        for spp in task.counts:
            seconds, picture = self.rendered(task, spp, task.seed)
            rows.append({"spp": spp, "seconds": seconds, "mean": float(np.mean(picture @ LUMINANCE)),
                         **errors(picture, reference.picture), **self.more(task, spp)})
        return rows, {}

    def reference_of(self, view, spp):
        """The mean of two images of spp / 2 samples; half their difference is its own error."""
        def halves():
            both = [self.rendered(Task(view, self.reference, 0, ()), spp // 2, REFERENCE_SEED + half) for half in range(2)]
            return [{"seconds": sum(seconds for seconds, _ in both)}], {"halves": np.array([picture for _, picture in both])}

        (row,), arrays = self.store.get(self.reference_key(view, spp), halves)
        first, second = arrays["halves"]
        return Reference((first + second) / 2, {name: error / 2 for name, error in errors(first, second).items()}, spp, row["seconds"])

    def references(self, counts):
        """{view: Reference}, rendered `jobs` at a time with the given sample counts {view: count}."""
        found = {}
        with Progress(sum(counts.values()), "spp") as progress:
            for view, reference in in_parallel(self.jobs, lambda view: self.reference_of(view, counts[view]), counts):
                found[view] = reference
                progress(f"reference of {view.label}", sum(counts[view] for view in found))
        return {view: found[view] for view in counts}


def write_picture(path, pictures, reference, part, sigma=2.1):
    """Writes a part (left, top, width, height) of the images {name: array} and of the reference side by side, and below them the same parts
    after the blur. The number above each image is its error as a whole, as displayed after the blur, relative to that of the last image."""
    errors = [displayed_rmse(picture, reference, sigma=sigma) for picture in pictures.values()]
    columns = {f"{name}\n{error / errors[-1]:.2f}": picture for (name, picture), error in zip(pictures.items(), errors)}
    left, top, width, height = part
    figure = labelled({text: [preview(shown[top:top + height, left:left + width]) for shown in (picture, blurred(displayed(picture), sigma))]
                       for text, picture in {**columns, "reference\n0": reference}.items()}, 40, 14)
    write_image(path, figure, quality=95, subsampling=0)


# ---- Options

def add_options(parser, name, scenes, seeds, counts=COUNTS):
    parser.set_defaults(counts=counts)
    parser.add_argument("--scenes", type=names_of("scene", scenes), default=tuple(scenes), metavar="NAME,...",
                        help=f"scenes to render: {', '.join(scenes)}")
    parser.number("--spp", max(counts), "largest sample count")
    parser.number("--seeds", seeds, "number of images per sampler")
    parser.add_argument("--quick", action="store_true", help="try the setup with 2 seeds, up to 16 samples and noisier references")
    parser.number("--jobs", os.cpu_count() or 1, "number of single-threaded processes to run in parallel", ": one per core")
    parser.add_argument("--out", type=Path, help="folder for the report (default: evidence/results for the whole comparison, which also updates "
                        f"the table in examples/{name}/README.md, else out/{name})")
    parser.hidden("--guide", f"examples/{name}/README.md")
    parser.add_argument("--program", metavar="FILE", required=True, help="the renderer, built with the patch from examples/")


def finish_options(parser, options, name, arguments, whole=()):
    """whole: other options that must keep their defaults in a whole comparison. Only whole comparisons go to evidence/results."""
    is_whole = not options.quick and all(getattr(options, one) == parser.get_default(one) for one in ("scenes", "spp", "seeds", *whole))
    if options.quick:
        options.seeds, options.spp = min(options.seeds, 2), min(options.spp, 16)
    options.counts = tuple(n for n in options.counts if n <= options.spp)
    options.out = options.out or Path("evidence/results" if is_whole else f"out/{name}")
    options.command = command_shown(name, arguments)


# ---- The report

class OtherReport:
    """A page about another renderer. A subclass defines TITLE, INTRO, METHOD, SCENES ({name: scene with a description `what`}), SPREAD (the
    samplers that the scene-by-scene tables compare with `blue`) and answer(). It may add further sections().

    options: from finish_options(); references: {view: Reference}; samplers: the samplers compared (CPU times are relative to the first, and
    the last is blue); thans: {sampler that blue is compared with: its name}; sets: {title: scenes that the figures cover}."""

    def __init__(self, options, cells, references, samplers, thans, sets):
        self.options, self.cells, self.references, self.counts = options, cells, references, options.counts
        self.samplers, self.thans, self.sets = tuple(samplers), thans, {}
        for title, scenes in sets.items():
            own = Comparison(cells, {view: reference for view, reference in references.items() if view.scene in scenes}, self.samplers, "blue")
            if own.views:
                self.sets[title] = own
        self.title, self.compared = next(iter(self.sets.items()))

    def name(self, label):
        return self.thans.get(label, f"`{label}`")

    def ratios(self, own, measure, counts=None, thans=None):
        """One row per sampler: its error relative to blue."""
        return compare.table("error over `blue`'s, at spp", counts or self.counts, {
            name: functools.partial(own.over, than, measure=measure) for than, name in (thans or self.thans).items()})

    def both(self, own, than, spp):
        """The error relative to blue as displayed, with the raw error in brackets."""
        shown, raw = (own.over(than, spp, measure) for measure in HEADLINE)
        return f"{shown.value:.2f} ({raw.value:.2f})" if shown and raw else ""

    def summary(self, thans=None):
        """The guide's tables, one for each set: errors as displayed, with raw errors in brackets."""
        parts = []
        for title, own in self.sets.items():
            rows = [[name, *(self.both(own, than, spp) for spp in self.counts)] for than, name in (thans or self.thans).items()]
            scenes = len({view.scene for view in own.views})
            crops = f", {len(own.views)} crops" if len(own.views) > scenes else ""
            parts.append(f"{title} ({self.options.seeds} seeds; {scenes} scenes{crops} rendered):\n\n"
                         + md_table(["error over `blue`'s, at spp", *map(str, self.counts)], rows))
        return "\n\n".join(parts)

    def scenes_table(self, own, measure, than):
        """One row per scene: the ratio at SPREAD_COUNTS, and its range over crops."""
        counts, rows = [n for n in SPREAD_COUNTS if n in self.counts], []
        for scene, views in own.by_scene().items():
            row = [f"{scene}: {self.SCENES[scene].what}"]
            for spp in counts:
                whole = own.over(than, spp, measure, views)
                each = [one.value for one in (own.over(than, spp, measure, (view,)) for view in views) if one]
                spread = f" ({min(each):.2f} to {max(each):.2f})" if len(each) > 1 else ""
                row.append(f"{whole.value:.2f}{spread}" if whole else "")
            rows.append(row)
        return md_table([f"{self.name(than)} over `blue`", *map(str, counts)], rows)

    def rate(self, view, label):
        """CPU seconds per sample of all pixels, excluding program start-up."""
        first, last = self.counts[0], self.counts[-1]
        seconds = [statistics.median(self.cells.get(view, label, spp, "seconds")) for spp in (first, last)]
        return max((seconds[1] - seconds[0]) / max(last - first, 1), 1e-9)

    def time(self, label):
        """CPU time per sample relative to the first sampler: the geometric mean over views."""
        return statistics.geometric_mean(self.rate(view, label) / self.rate(view, self.samplers[0]) for view in self.references)

    def times_table(self):
        rows = [[self.name(label), f"{self.time(label):.2f}",
                 f"{statistics.median(1e6 * self.rate(view, label) / math.prod(view.size) for view in self.references):.2f}"]
                for label in self.samplers]
        return md_table(["sampler", f"CPU time over {self.name(self.samplers[0])}'s, mean over images", "median, µs per sample"], rows)

    def sections(self):
        """Further sections as {heading: lines}."""
        return {}

    def text(self):
        parts = [self.TITLE, "", self.answer(), "", self.INTRO, MARKED, ""]
        for title, own in self.sets.items():
            parts += [f"## {title}", ""]
            for measure in MEASURES:
                if any(own.over(self.samplers[0], spp, measure) for spp in self.counts):
                    parts += [f"{name_of(measure).capitalize()}:", "", self.ratios(own, measure), ""]
        for heading, lines in self.sections().items():
            parts += [f"## {heading}", "", *lines, ""]
        parts += ["## Scene by scene", "", f"{name_of(HEADLINE[0]).capitalize()}. Brackets show the range over a scene's crops if it has several.", ""]
        for own in self.sets.values():
            for than in self.SPREAD:
                parts += [self.scenes_table(own, HEADLINE[0], than), ""]
        return "\n".join([
            *parts, "## Time", "", "Single-threaded CPU time, excluding program start-up. The machine may have been running other jobs, so ignore differences of "
            "a few per cent.", "", self.times_table(), "",
            "## How it was measured", "", f"Generated by `{self.options.command}` with {self.options.seeds} seeds. {self.METHOD}"]) + "\n"

    def write(self, name, guide):
        """Writes NAME.md and NAME.csv, and prints the report. In evidence/results, also updates the guide's table. Returns whether it did."""
        compare.write(self.options.out / f"{name}.csv", [
            {**row, "scene": title} for title, own in self.sets.items() for row in own.rows(self.counts, MEASURES)])
        text = self.text()
        write_text(self.options.out / f"{name}.md", text)
        whole = self.options.out.resolve() == Path("evidence/results").resolve()
        if whole:
            update_table(self.options.guide, f"scripts/bench {name}", guide)
        print(text)
        return whole
