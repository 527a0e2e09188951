# SPDX-License-Identifier: Apache-2.0
"""Checks the estimate of visible noise and the stop rule: `scripts/bench stop` writes evidence/results/stop.*"""

import dataclasses
import itertools
import math
import statistics
import tempfile
from pathlib import Path

import numpy as np
import OpenEXR

import bluenoise

from ..base.files import read_numbers, write_rows
from ..base.page import write_page
from ..base.plots import STYLES, finish, plt, save
from ..base.tables import md_table, update_table
from ..measure.image_error import visible_error
from ..samplers import variants
from ..samplers.variants import NAMES
from . import times, views
from .judge import Run, Task, render_references
from .renderer import progressive, run_pathtracer

COUNTS = (2, 4, 8, 16, 32, 64, 128)
CAP = 256  # samples per pixel at which the stop rules give up
BLOCK = 16  # pixels per side: where noise is judged, and the blocks in which the tracer stops, to which crops are aligned
STEPS = (1.0, 2.0)  # thresholds of --visible-noise
LEVELS = (0.04, 0.06, 0.08, 0.12, 0.16, 0.24)  # thresholds of --noise
PER_PIXEL = ("sobol", "blue")  # samplers shown with --noise
FIELDS = ("what", "scene", "sampler", "at", "estimate", "noise", "noise_95", "samples", "capped")


def rms(values):
    return math.sqrt(np.mean(np.square(values)))


def block_noise(image, reference, exposure):
    """The noise of each block of BLOCK x BLOCK pixels, in steps of an 8-bit display."""
    squares = visible_error(image, reference, exposure) ** 2
    high, wide = (extent // BLOCK * BLOCK for extent in squares.shape[:2])
    return np.sqrt(squares[:high, :wide].reshape(high // BLOCK, BLOCK, wide // BLOCK, BLOCK, -1).mean((1, 3, 4))).ravel()


@dataclasses.dataclass(frozen=True)
class StopTask(Task):
    """A run that stops by a rule: --visible-noise or --noise."""

    rule: str = ""
    level: float = 0.0

    @property
    def cost(self):
        return self.view.pixels * CAP // 4


class Stops(Run):
    """A progressive run gives a row per sample count; a run that stops gives one."""

    def key(self, task, reference):
        return {**super().key(task, reference), "rule": getattr(task, "rule", ""), "level": getattr(task, "level", 0), "cap": CAP, "format": 2}

    def measure(self, task, reference):
        return (self.stopped if isinstance(task, StopTask) else self.estimated)(task, reference), {}

    def estimated(self, task, reference):
        rows, first = [], None
        for spp, picture, _ in progressive(self.program, task.view.request(task.label, CAP, task.seed), (1, *task.counts), 1):
            if first is not None:
                noise = bluenoise.visible_noise(first, 2 * picture - first, exposure=2.0**reference.exposure, window=1023)
                rows.append({"spp": spp, "estimate": float(noise[0, 0]), "noise": rms(visible_error(picture, reference.picture, reference.exposure))})
            first = picture
        return rows

    def stopped(self, task, reference):
        request = dataclasses.replace(task.view.request(task.label, CAP, task.seed), exposure=reference.exposure)
        with tempfile.TemporaryDirectory(prefix="libbn-") as folder:
            path = Path(folder) / "stopped.exr"
            run_pathtracer(self.program, [*request.arguments(), task.rule, task.level, "--min-spp", 4, "--threads", 1, "--quiet", "-o", path])
            with OpenEXR.File(str(path), separate_channels=True) as file:
                layers = {name: np.array(channel.pixels) for name, channel in file.channels().items()}
        picture = np.stack([layers[name] for name in "RGB"], axis=-1)
        return [{"spp": 0, "samples": float(layers["count"].mean()), "capped": float((layers["count"] == CAP).mean()),
                 "blocks": block_noise(picture, reference.picture, reference.exposure).tolist()}]


def aligned(view):
    """The view with its crop moved and extended to the tracer's blocks, so that no pixel outside it is rendered."""
    (width, height), (x, y) = ((extent + BLOCK - 1) // BLOCK * BLOCK for extent in view.size), view.crop[:2]
    x, y = (min(start, limit - extent) // BLOCK * BLOCK for start, limit, extent in zip((x, y), (view.width, view.height), (width, height)))
    return dataclasses.replace(view, crop=(x, y, x + width, y + height))


# ---- The report

class Report:
    """results: {task: (rows, pictures)}; references: {view: judge.Reference}; found: {(what, scene, sampler, at): figures}, the rows of stop.csv."""

    def __init__(self, options, results, references):
        self.options, self.references, self.labels = options, references, options.labels
        self.scenes = tuple(dict.fromkeys(view.scene for view in references))
        self.times = times.over(read_numbers(Path("evidence/results/times.csv")), "sobol")
        self.found, groups = {}, {}
        for task, (rows, _) in results.items():
            reference = references[task.view]
            own = rms(visible_error(reference.first_half, 2 * reference.picture - reference.first_half, reference.exposure)) / 2
            key = getattr(task, "rule", "estimate"), task.view.scene, task.label
            for row in rows:
                groups.setdefault((*key, getattr(task, "level", row["spp"])), []).append({**row, "own": own})
        for (scene, label), (what, levels) in itertools.product(itertools.product(self.scenes, self.labels), {"estimate": options.counts, **RULES}.items()):
            self.found.update({(what, scene, label, at): (self.estimated if what == "estimate" else self.stopped)(groups[what, scene, label, at])
                               for at in levels if (what, scene, label, at) in groups})

    @staticmethod
    def estimated(rows):
        """The reference's own noise is subtracted from the measured noise."""
        true = np.mean([row["noise"] ** 2 - row["own"] ** 2 for row in rows])
        return {"estimate": rms([row["estimate"] for row in rows]), "noise": math.sqrt(max(true, 1e-12))}

    @staticmethod
    def stopped(rows):
        blocks = np.concatenate([row["blocks"] for row in rows])
        return {"noise": rms(blocks), "noise_95": float(np.percentile(blocks, 95)), **{name: float(np.mean([row[name] for row in rows])) for name in ("samples", "capped")}}

    def rows(self):
        return [{"what": what, "scene": scene, "sampler": label, "at": f"{at:.4g}", **{name: f"{value:.4g}" for name, value in own.items()}}
                for (what, scene, label, at), own in self.found.items()]

    def of(self, what, label, at, scenes=None):
        return [self.found[what, scene, label, at] for scene in (self.scenes if scenes is None else scenes)]

    def ratios(self, label, spp):
        return [own["estimate"] / own["noise"] for own in self.of("estimate", label, spp)]

    def estimates_table(self):
        lines = []
        for label in self.labels:
            cells = [self.ratios(label, spp) for spp in self.options.counts]
            lines.append([NAMES.get(label, label), *(f"{np.median(cell):.2f} ({min(cell):.2f} to {max(cell):.2f})" for cell in cells)])
        return md_table(["estimated over true noise", *map(str, self.options.counts)], lines)

    def late_ratios(self, label):
        """Estimated over true noise from 8 samples on."""
        return [ratio for spp in self.options.counts if spp >= 8 for ratio in self.ratios(label, spp)]

    def summary(self):
        """(number of late ratios, share in 0.8 .. 1.5, lowest, highest)."""
        found = [ratio for label in self.labels for ratio in self.late_ratios(label)]
        return len(found), np.mean([0.8 <= ratio <= 1.5 for ratio in found]), min(found), max(found)

    def left(self, rule, level, labels):
        """The noise left in each scene that did not reach the cap."""
        return [own["noise_95"] for label in labels for own in self.of(rule, label, level) if own["capped"] <= 0.05] or [math.nan]

    def below_cap(self, level, labels, rule="--visible-noise"):
        """The scenes in which at most 5% of the pixels reached the cap, with every sampler."""
        return [scene for scene in self.scenes if all(self.found[rule, scene, label, level]["capped"] <= 0.05 for label in labels)]

    def samples(self, label, level, scenes, rule="--visible-noise"):
        """The geometric mean of a sampler's samples over scenes."""
        return statistics.geometric_mean([own["samples"] for own in self.of(rule, label, level, scenes)] or [math.nan])

    def time_over(self, label, base):
        """CPU time per sample over the base's (times.py)."""
        return self.times.get(label, math.nan) / self.times[base]

    def over(self, label, base, level, rule="--visible-noise"):
        """(a sampler's samples over the base's, number of scenes): over the scenes in which neither reached the cap."""
        scenes = self.below_cap(level, (label, base), rule)
        return self.samples(label, level, scenes, rule) / self.samples(base, level, scenes, rule), len(scenes)

    def stop_table(self, level):
        lines = []
        for scene in self.scenes:
            cells = [self.found["--visible-noise", scene, label, level] for label in self.labels]
            lines.append([scene, *(f"{row['samples']:.1f} ({row['noise_95']:.2f}{', capped' if row['capped'] > 0.05 else ''})" for row in cells)])
        for base in ("sobol", "white"):
            found = {label: self.over(label, base, level) for label in self.labels}
            lines.append([f"samples over {NAMES[base]}", *(f"{value:.2f} ({count} scenes)" for value, count in found.values())])
            lines.append([f"CPU time over {NAMES[base]}", *(f"{value * self.time_over(label, base):.2f}" for label, (value, _) in found.items())])
        return md_table([f"samples until {level:g} step{'s' * (level != 1)} (noise left)", *(NAMES.get(label, label) for label in self.labels)], lines)

    def guide_table(self):
        """The table of docs/stop.md: geometric means over the scenes in which none of the samplers reached the cap."""
        lines = []
        for level in STEPS:
            scenes = self.below_cap(level, variants.ALWAYS)
            base = self.samples("sobol", level, scenes)
            for label in variants.ALWAYS:
                samples, left = self.samples(label, level, scenes), [own["noise_95"] for own in self.of("--visible-noise", label, level, scenes)]
                lines.append([f"{level:g} step{'s' * (level != 1)} ({len(scenes)} scenes), {NAMES[label]}", f"{samples:.1f}",
                              f"{samples / base * self.time_over(label, 'sobol'):.2f}", f"{np.median(left):.2f}", f"{max(left):.2f}"])
        return md_table(["each block stops below", "samples per pixel", "CPU time over padded Sobol'",
                         "noise left: median scene", "worst scene"], lines)

    def best_level(self, label):
        """The threshold of --noise that leaves one step in the median of the scenes."""
        return min(LEVELS, key=lambda level: abs(math.log(np.median([own["noise_95"] for own in self.of("--noise", label, level)]))))

    def rules_table(self):
        lines = []
        for label in PER_PIXEL:
            for rule, level in (("--noise", self.best_level(label)), ("--visible-noise", 1.0)):
                rows, left = self.of(rule, label, level), self.left(rule, level, (label,))
                lines.append([f"{NAMES[label]}, `{rule} {level:g}`", f"{np.mean([row['samples'] for row in rows]):.1f}", f"{min(left):.2f}", f"{np.median(left):.2f}",
                              f"{max(left):.2f}", f"{max(left) / min(left):.1f}", f"{len(left)}"])
        return md_table(["rule", "samples, mean", "noise left: lowest scene", "median scene", "highest scene", "highest over lowest", "scenes below the cap"], lines)

    def plot(self, path):
        figure, axes = plt.subplots(1, 2, figsize=(9, 3.8), sharex=True, sharey=True)
        for axis, rule in zip(axes, RULES):
            for label in PER_PIXEL:
                level = self.best_level(label) if rule == "--noise" else 1.0
                rows = self.of(rule, label, level)
                axis.plot([row["samples"] for row in rows], [row["noise_95"] for row in rows], color=STYLES[label][0], marker=STYLES[label][1],
                          linestyle="", label=f"{label}, {rule} {level:g}")
            axis.axhline(1, color="grey", linewidth=0.8)
            finish(axis, rule, "samples per pixel")
            axis.legend(frameon=False)
        axes[0].set_ylabel("noise left, steps (95% of the blocks)")
        save(figure, path)


RULES = {"--visible-noise": STEPS, "--noise": LEVELS}


def run(arguments):
    options = views.parse_options("stop", __doc__, arguments, COUNTS, crop=(64, 64), seeds=1, spp=max(COUNTS))
    chosen = tuple(dict.fromkeys(aligned(view) for view in options.chosen))
    references = render_references(options.pathtracer, chosen, options.reference_spp)
    tasks = [Task(view, label, seed, options.counts) for view in chosen for label in options.labels for seed in range(options.seeds)]
    tasks += [StopTask(view, label, seed, (), False, rule, level) for view in chosen for seed in range(options.seeds) for rule, levels in RULES.items()
              for label in (options.labels if rule == "--visible-noise" else PER_PIXEL) for level in levels]
    report = Report(options, Stops(options.pathtracer, "stop", options.jobs).results(references, tasks), references)
    report.plot(options.out / "stop.png")
    write_rows(options.out / "stop.csv", FIELDS, report.rows())
    write_page(options.out / "stop.md", globals(), report=report, options=options)
    if options.out == Path("evidence/results"):
        update_table(Path("docs/stop.md"), "scripts/bench stop", report.guide_table())
