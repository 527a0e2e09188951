# SPDX-License-Identifier: Apache-2.0
"""What the comparisons in other people's renderers share: runs of their programs, references, options, and tables."""

import argparse
import dataclasses
import hashlib
import math
import os
import statistics
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

from ..base.bench_options import arguments_that_count
from ..base.command import positive
from ..base.contact_sheet import before_and_after
from ..base.files import read_exr, write_rows, write_text
from ..base.progress import Progress, duration
from ..base.tables import md_table, update_table
from ..base.whole_files import written_beside
from ..measure.image_error import LUMINANCE, SIGMAS, blurred, displayed, displayed_rmse, rmse
from ..renders.judge import Run, Store
from ..renders.renderer import RenderError, cache_folder

COUNTS = (1, 2, 3, 4, 6, 8, 16, 32, 64)
KINDS = {"displayed": "as displayed", "exposed": "exposed and displayed", "rmse": "raw"}
MEASURES = tuple(f"{kind}_{sigma}" for kind in KINDS for sigma in SIGMAS)
EXPOSED = 0.25  # the mean luminance of the reference of an exposed picture
HEADLINE = ("displayed_2.1", "rmse_2.1")
FIELDS = ("scene", "view", "sampler", "spp", "seeds", "seconds", *MEASURES)
# References come from a sampler that hashes pixel, dimension and seed: with seeds of their own, their errors are independent of all
# others'.
REFERENCE_SEED = 1_000_003


def errors(picture, reference):
    """{measure: error} for all of MEASURES: as displayed, exposed before, and raw, after each blur."""
    stops = np.log2(EXPOSED / max(float(np.mean(reference @ LUMINANCE)), 1e-9))
    pictures = {"rmse": (picture, reference), "displayed": (displayed(picture), displayed(reference)),
                "exposed": (displayed(picture, stops), displayed(reference, stops))}
    return {name: rmse(*pictures[name.rpartition("_")[0]], float(name.rpartition("_")[2])) for name in MEASURES}


def name_of(measure):
    kind, _, sigma = measure.rpartition("_")
    return KINDS[kind] + (f", after sigma {sigma}" if float(sigma) else ", unblurred")


def processor_seconds(command, what, environment=None):
    """Runs a program and returns its processor seconds; RenderError has the last line that it wrote."""
    with tempfile.TemporaryFile() as log:
        try:
            process = os.posix_spawn(command[0], command, environment or os.environ, file_actions=[
                (os.POSIX_SPAWN_OPEN, 0, os.devnull, os.O_RDONLY, 0), (os.POSIX_SPAWN_DUP2, log.fileno(), 1),
                (os.POSIX_SPAWN_DUP2, log.fileno(), 2)])
        except OSError as error:
            raise RenderError(f"cannot run {command[0]} ({error.strerror})") from None
        _, status, used = os.wait4(process, 0)
        if status:
            log.seek(0)
            said = log.read().decode(errors="replace").strip().splitlines()
            raise RenderError(f"{what}: {said[-1] if said else f'status {status}'}")
    return used.ru_utime + used.ru_stime


@dataclasses.dataclass(frozen=True)
class Reference:
    picture: np.ndarray
    own: dict  # {measure: its own error}
    spp: int
    seconds: float

    def key(self):
        return hashlib.sha256(self.picture.tobytes()).hexdigest()


class OtherRun(Run):
    """Renders tasks in another renderer, or finds their results in the cache of a folder.

    A subclass has builds, key(), render(task, spp, seed, out), which returns processor seconds, and reference_key(view, spp), and
    reference_task(view, spp), whose seeds are REFERENCE_SEED and the next.
    """

    def __init__(self, program, folder, jobs):
        self.program, self.jobs = program, jobs
        self.store = Store(cache_folder() / folder / "results")

    def more(self, task, spp, out):
        """Further figures of a task, for its row."""
        return {}

    def measure(self, task, reference):
        rows = []
        with tempfile.TemporaryDirectory(prefix="libbn-") as folder:
            out = Path(folder) / "out.exr"
            for spp in task.counts:
                seconds = self.render(task, spp, task.seed, out)
                picture = read_exr(out)[0]
                rows.append({"spp": spp, "seconds": seconds, "mean": float(np.mean(picture @ LUMINANCE)),
                             **errors(picture, reference.picture), **self.more(task, spp, out)})
        return rows, {}

    def reference(self, view, spp):
        """The mean of two pictures of spp / 2 samples; half their difference is its own error."""
        key, task = self.reference_key(view, spp), self.reference_task(view, spp)
        found = self.store.load(key)
        if not found:
            halves, seconds = [], 0.0
            with tempfile.TemporaryDirectory(prefix="libbn-") as folder:
                for half in range(2):
                    out = Path(folder) / "out.exr"
                    seconds += self.render(task, spp // 2, REFERENCE_SEED + half, out)
                    halves.append(read_exr(out)[0])
            found = [{"seconds": seconds}], {"halves": np.array(halves)}
            self.store.save(key, *found)
        (row,), arrays = found
        first, second = arrays["halves"]
        own = {name: error / 2 for name, error in errors(first, second).items()}
        return Reference((first + second) / 2, own, spp, row["seconds"])

    def references(self, views, counts):
        """{view: Reference} with so many samples, {view: count}, `jobs` at a time."""
        progress, done, found, pool = Progress(sum(counts.values()), "spp"), 0, {}, ThreadPoolExecutor(self.jobs)
        try:
            for view, reference in zip(views, pool.map(lambda view: self.reference(view, counts[view]), views)):
                found[view] = reference
                done += counts[view]
                progress(f"reference of {view.label}", done)
        finally:
            pool.shutdown(cancel_futures=True)
            progress.close()
        return found


def rows_of(cells, views):
    """One row per view, sampler and count: root mean squares over seeds, for a CSV."""
    rows = []
    for (view, label, spp), cell in cells.values.items():
        if view in views:
            rows.append({"scene": view.scene, "view": view.name, "sampler": label, "spp": spp, "seeds": len(cell["seconds"]),
                         "seconds": f"{np.median(cell['seconds']):.4g}",
                         **{name: f"{np.sqrt(np.mean(np.square(cell[name]))):.6g}" for name in MEASURES}})
    return rows


def write_picture(path, pictures, reference, part, sigma=2.1):
    """A part (left, top, width, height) of {name: picture} and of the reference side by side, and below after the blur. Printed above each
    is the error of the whole picture, as displayed after the blur, over that of the last."""
    errors = [displayed_rmse(picture, reference, sigma=sigma) for picture in pictures.values()]
    columns = {f"{name}\n{error / errors[-1]:.2f}": picture for (name, picture), error in zip(pictures.items(), errors)}
    figure = before_and_after({**columns, "reference\n0": reference}, part, lambda picture: blurred(displayed(picture), sigma))
    with written_beside(path) as beside:
        figure.save(beside, quality=95, subsampling=0)


def write_report(options, name, report, views):
    """Writes NAME.md and the CSV of all figures, and prints the report. In docs/report the guide's table changes, too; returns whether."""
    write_rows(options.pages / f"{name}.csv", FIELDS, rows_of(report.cells, set(views)))
    text = report.text()
    write_text(options.out / f"{name}.md", text)
    whole = options.out.resolve() == Path("docs/report").resolve()
    if whole:
        update_table(options.guide, f"scripts/bench {name}", report.summary())
    print(text)
    print(f"Written: {options.out}/{name}.md and {options.pages}/{name}.csv. References took "
          f"{duration(sum(reference.seconds for reference in report.references.values()))} of processor time once.", file=sys.stderr)
    return whole


# ---- Options

def add_options(parser, name, scenes, seeds):
    parser.add_argument("--scenes", metavar="NAME,...", help=f"only these: {', '.join(scenes)}")
    parser.add_argument("--spp", type=positive, default=max(COUNTS), metavar="N", help="largest sample count (default 64)")
    parser.add_argument("--seeds", type=positive, default=seeds, metavar="N", help=f"pictures of each sampler (default {seeds})")
    parser.add_argument("--quick", action="store_true", help="a trial once it is built: 2 seeds, to 16 samples, poorer references")
    parser.add_argument("--jobs", type=positive, default=os.cpu_count() or 1, metavar="N",
                        help="processes at a time, one thread each (default: one per core)")
    parser.add_argument("--out", type=Path, help="folder for the report (default: docs/report for the whole comparison, which also updates "
                        f"the table in examples/{name}/README.md, else the folder of --pages)")
    parser.add_argument("--pages", type=Path, default=Path("out") / name, metavar="FOLDER",
                        help=f"folder for the CSV of all figures (default out/{name})")
    for hidden, default in (("--guide", Path("examples") / name / "README.md"), ("--program", None)):
        parser.add_argument(hidden, type=Path, default=default, help=argparse.SUPPRESS)


def finish_options(parser, options, name, arguments, whole, known):
    """whole: the options that the whole comparison leaves alone, which only goes to docs/report; known: {option of names: names}."""
    options.whole = not options.quick and all(getattr(options, one) == parser.get_default(one) for one in ("scenes", "spp", "seeds", *whole))
    for option, names in known.items():
        chosen = getattr(options, option).split(",") if getattr(options, option) else list(names)
        for one in chosen:
            if one not in names:
                parser.error(f"--{option}: {one!r} is none of {', '.join(names)}")
        setattr(options, option, chosen)
    if options.quick:
        options.seeds, options.spp = min(options.seeds, 2), min(options.spp, 16)
    options.counts = tuple(n for n in COUNTS if n <= options.spp)
    options.out = options.out or (Path("docs/report") if options.whole else options.pages)
    options.command = command_shown(f"scripts/bench {name}", arguments, f"--{name}")
    return options


def command_shown(command, arguments, checkout):
    """The command line for the report: `checkout` is the option whose folder is not shown."""
    shown = arguments_that_count(arguments)
    for i, word in enumerate(shown):
        if word in (checkout, "--luxcore"):
            shown[i + 1:i + 2] = ["DIR"]
        elif word == "--program":
            del shown[i:i + 2]
    return " ".join([command, *shown])


# ---- Tables

class OtherReport:
    """options: of finish_options(); references: {view: Reference}. names: {sampler: what it is called}; base: the one that times are
    relative to; pixels: of a view."""

    def __init__(self, options, cells, references, samplers, names, base, pixels):
        self.options, self.cells, self.references, self.counts = options, cells, references, options.counts
        self.samplers, self.own = tuple(samplers), tuple(name for name in samplers if name != "blue")
        self.names, self.base, self.pixels = names, base, pixels

    def name(self, label):
        return self.names.get(label, f"`{label}`")

    def ratios(self, gains, head, thans, counts, measure, cell=lambda gain: gain.text()):
        """One row per sampler and name of `thans`: its error over blue's; measure: one, or several for (raw) in brackets."""
        rows = []
        for than, name in thans:
            if isinstance(measure, str):
                found = [gains.gain("blue", spp, measure, than) for spp in counts]
                rows.append([name, *(cell(gain) if gain else "" for gain in found)])
            else:
                found = [[gains.gain("blue", spp, one, than) for one in measure] for spp in counts]
                rows.append([name, *(f"{shown.value:.2f} ({raw.value:.2f})" if shown and raw else "" for shown, raw in found)])
        return md_table([head, *map(str, counts)], rows)

    def rate(self, view, label):
        """Processor seconds per sample of all pixels, without what starting the program takes."""
        first, last = self.counts[0], self.counts[-1]
        seconds = [statistics.median(self.cells.get(view, label, spp, "seconds")) for spp in (first, last)]
        return max((seconds[1] - seconds[0]) / max(last - first, 1), 1e-9)

    def time(self, label):
        """Processor time per sample over the base's, the geometric mean over views."""
        return math.exp(statistics.mean(math.log(self.rate(view, label) / self.rate(view, self.base)) for view in self.references))

    def times_table(self, head):
        rows = []
        for label in self.samplers:
            micro = [1e6 * self.rate(view, label) / self.pixels for view in self.references]
            rows.append([self.name(label), f"{self.time(label):.2f}", f"{statistics.median(micro):.2f}"])
        return md_table([head, f"processor time over {self.name(self.base)}'s", "median, µs per sample"], rows)

    def rms(self, view, label, spp, measure):
        return math.sqrt(np.mean(np.square(self.cells.get(view, label, spp, measure))))

    def own_share(self, view, measure):
        """A reference's own error over the smallest of any sampler at the largest count."""
        least = min(self.rms(view, label, self.counts[-1], measure) for label in self.samplers)
        return self.references[view].own[measure] / least if least else math.nan
