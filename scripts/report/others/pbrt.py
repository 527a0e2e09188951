# SPDX-License-Identifier: Apache-2.0
"""Compares `blue` with pbrt-v4's own samplers, in pbrt-v4: `scripts/bench pbrt --pbrt DIR` writes docs/report/pbrt.md

DIR is a checkout of pbrt-v4 with submodules at the commit that pbrt_build.py names; it stays as it is. The first run
builds pbrt for a quarter of an hour. Crops of the scenes in pbrt_scenes.py are rendered with every sampler at 1 to 64
samples per pixel and several seeds, and measured against references. Pictures, references and the build are cached in
~/.cache/libbn ($XDG_CACHE_HOME): an interrupted run resumes, and a change of libbn renders only `blue` again.
"""

import argparse
import dataclasses
import hashlib
import os
import sys
import tempfile
import threading
from pathlib import Path

import numpy as np

from ..base.command import positive, run_or_say_why
from ..base.files import read_exr
from ..base.progress import Progress
from ..measure import gains
from ..measure.image_error import LUMINANCE, SIGMAS, displayed, rmse
from ..renders.judge import Cells, Run, Store
from ..renders.renderer import cache_folder
from .other_renderer import command_shown, processor_seconds, reference_of_halves, references_of, write_picture, write_report
from .pbrt_build import COMMIT, build
from .pbrt_report import FIELDS, Report
from .pbrt_scenes import CROP, HELD_OUT, SCENES, TUNING, crops, write_files

# pbrt's samplers, then libbn's. Lines of a scene file; sample counts and seeds are options of pbrt.
SAMPLERS = {name: f'Sampler "{name}"' for name in
            ("independent", "stratified", "halton", "paddedsobol", "sobol", "zsobol", "pmj02bn", "blue")}
VIEWS = {"final": SCENES, "tuning": TUNING, "fresh": HELD_OUT}
COUNTS = (1, 2, 3, 4, 6, 8, 16, 32, 64)
SEEDS = 8
MINUTES = 75  # of the whole comparison on two cores
# zsobol rounds sample counts down to powers of two.
ROUNDED = {("zsobol", 3): 2, ("zsobol", 6): 4}
# References come from a sampler that hashes pixel, dimension and seed: with another seed, its errors are independent of all
# others', its own with other seeds included.
REFERENCE_LINE = SAMPLERS["paddedsobol"]
REFERENCE_SEED = 1_000_003
PROBES = ("motion", "skin", "room")  # between them they draw all that a path can draw
# What --picture shows: a part of a scene's middle, its samplers, and where in it the part begins.
PICTURE, PICTURE_SCENE, PICTURE_SPP = "docs/pbrt.jpg", "penumbra", 6
PICTURE_BOUNDS, PICTURE_PART = (460, 780, 280, 520), (104, 60, 96, 96)
PICTURE_SAMPLERS = ("independent", "zsobol", "blue")
MEASURES = tuple(f"{kind}_{sigma}" for kind in ("displayed", "displayed_luminance", "rmse", "luminance") for sigma in SIGMAS)


def errors(picture, reference):
    """{measure: error} for all of MEASURES: as displayed and raw, of RGB and of luminance, after each blur."""
    pictures = {"rmse": (picture, reference), "displayed": (displayed(picture), displayed(reference))}
    pictures["luminance"] = [np.asarray(image, np.float64) @ LUMINANCE for image in pictures["rmse"]]
    pictures["displayed_luminance"] = [image @ LUMINANCE for image in pictures["displayed"]]
    return {name: rmse(*pictures[name.rpartition("_")[0]], float(name.rpartition("_")[2])) for name in MEASURES}


# ---- Running pbrt

def render(program, scene_file, bounds, spp, seed, out):
    """Renders into `out`; returns the processor seconds."""
    command = [str(program), "--quiet", "--nthreads", "1", "--spp", str(spp), "--seed", str(seed),
               "--pixelbounds", ",".join(map(str, bounds)), "--outfile", str(out), str(scene_file)]
    return processor_seconds(command, f"pbrt failed on {scene_file}")


@dataclasses.dataclass(frozen=True)
class Task:
    """All pictures of one view, sampler and seed."""

    view: object
    label: str
    seed: int
    counts: tuple

    @property
    def cost(self):
        # Starting pbrt takes as long as about eight samples.
        return CROP[0] * CROP[1] * sum(count + 8 for count in self.counts)


class Files:
    """The scenes as files, one per sampler, in a folder that is removed at the end."""

    def __init__(self):
        self._folder = tempfile.TemporaryDirectory(prefix="libbn-pbrt-")
        self._lock, self._paths = threading.Lock(), {}

    def path(self, scene, name, line):
        with self._lock:
            if (scene, name) not in self._paths:
                self._paths[scene, name] = write_files(self._folder.name, SCENES[scene], name, line)
            return self._paths[scene, name]

    def close(self):
        self._folder.cleanup()


class Builds:
    """Identifies a sampler by the pixels of small pictures that it renders."""

    def __init__(self, program, files, store):
        self.program, self.files, self.store = program, files, store
        self._sha256 = hashlib.sha256(Path(program).read_bytes()).hexdigest()
        self._found = {}

    def key(self, label):
        if label not in self._found:
            key = {"probe": [label, SAMPLERS[label], [SCENES[name].text("") for name in PROBES]], "program": self._sha256}
            found = self.store.load(key)
            if not found:
                found = self._probe(label), {}
                self.store.save(key, *found)
            self._found[label] = found[0]
        return self._found[label]

    def _probe(self, label):
        digest = hashlib.sha256()
        with tempfile.TemporaryDirectory(prefix="libbn-") as folder:
            out = Path(folder) / "probe.exr"
            for name in PROBES:
                for spp, bounds in ((1, (560, 720, 440, 584)), (3, (600, 640, 500, 540)), (64, (620, 640, 500, 518))):
                    render(self.program, self.files.path(name, label, SAMPLERS[label]), bounds, spp, 1, out)
                    digest.update(read_exr(out)[0].tobytes())
        return digest.hexdigest()

    def estimate(self, samples):
        # About 300,000 samples a second and core.
        return sum(samples.values()) / 3e5 / (os.cpu_count() or 1)


class PbrtRun(Run):
    """Renders tasks, or finds their results in the cache."""

    def __init__(self, program, jobs):
        self.program, self.jobs = program, jobs
        self.store = Store(cache_folder() / "pbrt" / "results")
        self.files = Files()
        self.builds = Builds(program, self.files, self.store)

    def key(self, task, reference):
        return {"scene": SCENES[task.view.scene].text(SAMPLERS[task.label]), "bounds": task.view.bounds, "seed": task.seed,
                "counts": task.counts, "build": self.builds.key(task.label)}

    def measure(self, task, reference):
        path, rows = self.files.path(task.view.scene, task.label, SAMPLERS[task.label]), []
        with tempfile.TemporaryDirectory(prefix="libbn-") as folder:
            out = Path(folder) / "out.exr"
            for spp in task.counts:
                seconds = render(self.program, path, task.view.bounds, spp, task.seed, out)
                picture = read_exr(out)[0]
                rows.append({"spp": spp, "seconds": seconds, "mean": float(np.mean(picture @ LUMINANCE)),
                             **errors(picture, reference.picture)})
        return rows, {}

    def reference(self, view, spp):
        """The mean of two pictures of spp / 2 samples; half their difference is its own error."""
        scene = SCENES[view.scene]
        key = {"reference": scene.text(REFERENCE_LINE), "bounds": view.bounds, "spp": spp, "build": self.builds.key("paddedsobol")}
        path = self.files.path(view.scene, "reference", REFERENCE_LINE)

        def half(number, out):
            return render(self.program, path, view.bounds, spp // 2, REFERENCE_SEED + number, out)

        return reference_of_halves(self.store, key, spp, half, errors)

    def references(self, views, share):
        """{view: Reference}, `jobs` at a time."""
        pixels = CROP[0] * CROP[1]
        spp = {view: max(64, int(SCENES[view.scene].reference_spp * share) // 2 * 2) for view in views}
        return references_of(views, lambda view: self.reference(view, spp[view]), self.jobs,
                             Progress(sum(spp.values()) * pixels, "samples"), lambda view: spp[view] * pixels)


class PbrtCells(Cells):
    """Results by view, sampler and the count that was asked for."""

    def get(self, view, label, spp, measure):
        return super().get(view, label, ROUNDED.get((label, spp), spp), measure)


def rows_of(cells, views):
    """One row per view, sampler and count: root mean squares over seeds, for a CSV."""
    rows = []
    for (view, label, spp), cell in cells.values.items():
        if view in views:
            rows.append({"scene": view.scene, "view": view.name, "sampler": label, "spp": spp, "seeds": len(cell["seconds"]),
                         "seconds": f"{np.median(cell['seconds']):.4g}",
                         **{name: f"{np.sqrt(np.mean(np.square(cell[name]))):.6g}" for name in MEASURES}})
    return rows


def make_picture(program, path, reference_spp):
    scene = SCENES[PICTURE_SCENE]
    with tempfile.TemporaryDirectory(prefix="libbn-pbrt-") as folder:
        def picture(name, spp, seed, line):
            out = Path(folder) / "out.exr"
            render(program, write_files(folder, scene, name, line), PICTURE_BOUNDS, spp, seed, out)
            return read_exr(out)[0]

        pictures = {name: picture(name, PICTURE_SPP, 1, SAMPLERS[name]) for name in PICTURE_SAMPLERS}
        reference = picture("reference", reference_spp, REFERENCE_SEED, REFERENCE_LINE)
    write_picture(path, pictures, reference, PICTURE_PART, 3)


# ---- The command

def parse_options(arguments):
    parser = argparse.ArgumentParser(
        prog="scripts/bench pbrt", description=__doc__.splitlines()[0], formatter_class=argparse.RawDescriptionHelpFormatter, epilog=f"""
Get the checkout with:
  git clone --recursive https://github.com/mmp/pbrt-v4 DIR && git -C DIR checkout {COMMIT} &&
  git -C DIR submodule update --init --recursive
It stays as it is: a copy of it is patched and built in ~/.cache/libbn/pbrt, in a quarter of an hour on two cores. The whole
comparison then takes about {MINUTES} minutes on two cores the first time. Builds, references and results are cached there: a run
that was interrupted resumes, and a change of libbn renders only `blue` again.""")
    parser.add_argument("--pbrt", metavar="DIR", required=True, help="a checkout of pbrt-v4 with its submodules, see below")
    parser.add_argument("--views", choices=tuple(VIEWS), default="final",
                        help="final: all scenes, the views of the report (default); tuning: views of half of the scenes to choose by; "
                        "fresh: others of the held-out scenes, by which nothing was chosen")
    parser.add_argument("--scenes", metavar="NAME,...", help=f"only these: {', '.join(SCENES)}")
    parser.add_argument("--samplers", metavar="NAME,...", help=f"only these: {', '.join(SAMPLERS)}; without blue, only fills the cache")
    parser.add_argument("--spp", type=positive, default=max(COUNTS), metavar="N", help="largest sample count (default 64)")
    parser.add_argument("--seeds", type=positive, default=SEEDS, metavar="N", help=f"pictures of each sampler (default {SEEDS})")
    parser.add_argument("--quick", action="store_true",
                        help="a trial of some minutes once pbrt is built: one crop of a scene, 2 seeds, to 16 samples, poorer references")
    parser.add_argument("--jobs", type=positive, default=os.cpu_count() or 1, metavar="N",
                        help="processes at a time, one thread each (default: one per core)")
    parser.add_argument("--out", type=Path, help="folder for the report (default: docs/report for the whole comparison, which also updates "
                        "the table in examples/pbrt/README.md, else the folder of --pages)")
    parser.add_argument("--pages", type=Path, default=Path("out/pbrt"), metavar="FOLDER",
                        help="folder for the CSV of all figures (default out/pbrt)")
    parser.add_argument("--picture", metavar="FILE", nargs="?", const=PICTURE,
                        help=f"only make the picture of {PICTURE_SPP} samples per pixel (default {PICTURE})")
    parser.add_argument("--guide", type=Path, default=Path("examples/pbrt/README.md"), help=argparse.SUPPRESS)
    parser.add_argument("--program", type=Path, help=argparse.SUPPRESS)
    options = parser.parse_args(arguments)
    # Only the whole comparison goes to docs/report.
    options.whole = options.views == "final" and not options.quick and all(
        getattr(options, name) == parser.get_default(name)
        for name in ("scenes", "samplers", "spp", "seeds"))
    for name, known in (("scenes", VIEWS[options.views]), ("samplers", SAMPLERS)):
        chosen = getattr(options, name).split(",") if getattr(options, name) else list(known)
        for one in chosen:
            if one not in known:
                parser.error(f"--{name}: {one!r} is none of {', '.join(known)}")
        setattr(options, name, chosen)
    if options.quick:
        options.seeds, options.spp = min(options.seeds, 2), min(options.spp, 16)
    options.crops, options.reference_share = (1, 0.125) if options.quick else (None, 1.0)
    options.out = options.out or (Path("docs/report") if options.whole else options.pages)
    options.command = command_shown("scripts/bench pbrt", arguments, "--pbrt")
    return options


def run(arguments):
    options = parse_options(arguments)
    built = build(options.pbrt, options.jobs) if not options.program else None
    if options.picture:
        return make_picture(options.program or built.program, options.picture, SCENES[PICTURE_SCENE].reference_spp // 8)
    work = PbrtRun(options.program or built.program, options.jobs)
    try:
        views = [view for name in options.scenes for view in crops(name, options.views)[:options.crops]]
        references = work.references(views, options.reference_share)
        tasks = [Task(view, label, seed, tuple(n for n in COUNTS if n <= options.spp and (label, n) not in ROUNDED))
                 for view in views for label in options.samplers for seed in range(1, options.seeds + 1)]
        cells = PbrtCells(work.results(references, tasks))
    finally:
        work.files.close()
    if "blue" not in options.samplers:
        return print(f"Rendered without `blue`, to be compared later: {len(tasks)} runs are in the cache.", file=sys.stderr)
    report = Report(options, cells, references, built.remarks if built else (), [n for n in COUNTS if n <= options.spp])
    if write_report(options, "pbrt", report, rows_of(cells, set(views)), FIELDS + MEASURES, references):
        gains.write_rows(options.out / "pbrt_headline.csv", report.headline_rows())


def main(arguments=None):
    run_or_say_why(run, arguments)


if __name__ == "__main__":
    main()
