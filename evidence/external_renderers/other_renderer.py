# SPDX-License-Identifier: Apache-2.0
"""The common part of the comparisons in other renderers: running their programs, references, options, and the report."""

import dataclasses
import functools
import math
import statistics
import tempfile
from pathlib import Path

import numpy as np

from ..base.command import command_shown, core_count, names_of
from ..base.contact_sheet import labelled, preview
from ..base.files import read_exr, write_image
from ..base.page import write_page
from ..base.progress import Progress, in_parallel
from ..base.tables import md_table, update_table
from ..measure import compare
from ..measure.compare import Comparison
from ..measure.image_error import LUMINANCE, SIGMAS, blurred, displayed, displayed_rmse, rmse
from ..renders.judge import Reference, Run
from ..renders.renderer import REFERENCE_SEED

SEEDS = 2
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
    """All images of one view, sampler and seed. The sampler is tuned for each image's sample count, or for `tuned_for`."""

    view: object
    sampler: str
    seed: int = 0
    counts: tuple = ()
    tuned_for: int = 0

    @property
    def label(self):
        return f"{self.sampler} {self.tuned_for}" if self.tuned_for else self.sampler

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

    def rendered(self, task, spp, seed):
        """(CPU seconds, picture)."""
        with tempfile.TemporaryDirectory(prefix="libbn-") as folder:
            out = Path(folder) / "out.exr"
            return self.render(task, spp, seed, out), read_exr(out)[0]

    def measure(self, task, reference):
        rows = []
        for spp in task.counts:
            seconds, picture = self.rendered(task, spp, task.seed)
            rows.append({"spp": spp, "seconds": seconds, "mean": float(np.mean(picture @ LUMINANCE)), **errors(picture, reference.picture)})
        return rows, {}

    def reference_of(self, view, spp):
        """The mean of two images of spp / 2 samples; half their difference is its own error."""
        def halves():
            both = [self.rendered(Task(view, self.reference), spp // 2, REFERENCE_SEED + half) for half in range(2)]
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

def options_of(parser, name, arguments, scenes, counts):
    """The options of a comparison, with counts and command. Only the comparison of all scenes goes to evidence/results and the guide."""
    parser.add_argument("--scenes", type=names_of("scene", scenes), default=tuple(scenes), metavar="NAME,...",
                        help=f"scenes to render: {', '.join(scenes)}")
    parser.number("--seeds", SEEDS, "number of images per sampler")
    parser.number("--jobs", core_count(), "number of single-threaded processes to run in parallel", ": one per core")
    parser.add_argument("--out", type=Path, help="folder for the report (default: evidence/results for all scenes, which also updates "
                        f"the table in examples/{name}/README.md, else out/{name})")
    parser.hidden("--guide", f"examples/{name}/README.md")
    parser.add_argument("--program", metavar="FILE", required=True, help="the renderer, built with the patch from examples/")
    options = parser.parse_args(arguments)
    options.out = options.out or Path("evidence/results" if options.scenes == tuple(scenes) else f"out/{name}")
    options.name, options.counts, options.command = name, counts, command_shown(name, arguments)
    return options


# ---- The report

class OtherReport:
    """The tables of a page about another renderer, whose template extends other_renderer.md.in.

    references: {view: Reference}; thans: {sampler that blue is compared with: its name}, of which the page's CPU times are relative to the
    first; sets: {title: scenes that the figures cover}; scenes: {name: scene with a description `what`}."""

    def __init__(self, options, cells, references, thans, sets, scenes):
        self.options, self.cells, self.references, self.thans, self.scenes, self.counts = options, cells, references, thans, scenes, options.counts
        self.samplers = (*thans, "blue")
        compared = {title: Comparison(cells, {view: own for view, own in references.items() if view.scene in names}, self.samplers, "blue")
                    for title, names in sets.items()}
        self.sets = {title: own for title, own in compared.items() if own.views}
        self.compared = next(iter(self.sets.values()))

    def ratios(self, own, measure, thans=None, counts=None):
        """One row per sampler: its error relative to blue."""
        return compare.table("error over `blue`'s, at spp", counts or self.counts, {
            name: functools.partial(own.over, than, measure=measure) for than, name in (thans or self.thans).items()})

    def both(self, head, own, counts, thans):
        """One row per sampler: its error relative to blue as displayed, with the raw error in brackets."""
        def cell(than, spp):
            shown, raw = (own.over(than, spp, measure) for measure in HEADLINE)
            return f"{shown.value:.2f} ({raw.value:.2f})" if shown and raw else ""

        return md_table([head, *map(str, counts)], [[name, *(cell(than, spp) for spp in counts)] for than, name in thans.items()])

    def scenes_table(self, own, than):
        """One row per scene: the ratio at SPREAD_COUNTS, and its range over crops."""
        def cell(spp, views):
            whole = own.over(than, spp, HEADLINE[0], views)
            each = [one.value for one in (own.over(than, spp, HEADLINE[0], (view,)) for view in views) if one]
            spread = f" ({min(each):.2f} to {max(each):.2f})" if len(each) > 1 else ""
            return f"{whole.value:.2f}{spread}" if whole else ""

        counts = [n for n in SPREAD_COUNTS if n in self.counts]
        return md_table([f"{self.thans[than]} over `blue`", *map(str, counts)], [
            [f"{scene}: {self.scenes[scene].what}", *(cell(spp, views) for spp in counts)] for scene, views in own.by_scene().items()])

    def rate(self, view, label):
        """CPU seconds per sample of all pixels, excluding program start-up."""
        first, last = self.counts[0], self.counts[-1]
        seconds = [statistics.median(self.cells.get(view, label, spp, "seconds")) for spp in (first, last)]
        return max((seconds[1] - seconds[0]) / max(last - first, 1), 1e-9)

    def times_table(self):
        base, rows = self.samplers[0], []
        for label in self.samplers:
            over = statistics.geometric_mean(self.rate(view, label) / self.rate(view, base) for view in self.references)
            median = statistics.median(1e6 * self.rate(view, label) / math.prod(view.size) for view in self.references)
            rows.append([self.thans.get(label, "`blue`"), f"{over:.2f}", f"{median:.2f}"])
        return md_table(["sampler", f"CPU time over {self.thans[base]}'s, mean over images", "median, µs per sample"], rows)

    def summary(self, thans):
        """The guide's tables, one for each set."""
        parts = []
        for title, own in self.sets.items():
            scenes = len({view.scene for view in own.views})
            crops = f", {len(own.views)} crops" if len(own.views) > scenes else ""
            parts.append(f"{title} ({self.options.seeds} seeds; {scenes} scenes{crops} rendered):\n\n"
                         + self.both("error over `blue`'s, at spp", own, self.counts, thans))
        return "\n\n".join(parts)

    def write(self, names, guide, **more):
        """Writes the CSV file and the page, whose template sees `names` and `more`. In evidence/results, also updates the guide's table. Returns
        whether it did."""
        options = self.options
        compare.write(options.out / f"{options.name}.csv", [
            {**row, "scene": title} for title, own in self.sets.items() for row in own.rows(options.counts, MEASURES)])
        write_page(options.out / f"{options.name}.md", {**globals(), **names}, report=self, options=options, **more)
        whole = options.out.resolve() == Path("evidence/results").resolve()
        if whole:
            update_table(options.guide, f"scripts/bench {options.name}", guide)
        return whole
