# SPDX-License-Identifier: Apache-2.0
"""Compares `blue` with pbrt-v4's own samplers, in pbrt-v4: `scripts/bench pbrt --pbrt DIR --luxcore DIR` writes docs/report/pbrt.md

DIR are checkouts of pbrt-v4, with submodules, and of LuxCoreRender, at the commits that pbrt_build.py and lux_scenes.py name; they stay
as they are. The first run builds pbrt for a quarter of an hour. Crops of LuxCoreRender's scenes and of ours are rendered with every
sampler at 1 to 64 samples per pixel and several seeds, and measured against references. Pictures, references and the build are cached in
~/.cache/libbn ($XDG_CACHE_HOME): an interrupted run resumes, and a change of libbn renders only `blue` again.
"""

import argparse
import dataclasses
import hashlib
import sys
import tempfile
import threading
from pathlib import Path

from ..base.files import read_exr
from ..measure import gains
from ..renders.judge import Cells
from . import lux_scenes
from .other_renderer import REFERENCE_SEED, OtherRun, add_options, finish_options, processor_seconds, write_picture, write_report
from .pbrt_build import COMMIT, build
from .pbrt_report import Report
from .pbrt_scenes import CROP, HELD_OUT, SCENES, TUNING, crops, write_files

# pbrt's samplers, then libbn's. Lines of a scene file; sample counts and seeds are options of pbrt.
SAMPLERS = {name: f'Sampler "{name}"' for name in ("independent", "sobol", "zsobol", "pmj02bn", "blue")}
VIEWS = {"held-out": {**dict.fromkeys(lux_scenes.SCENES), **HELD_OUT}, "tuning": TUNING}
COUNTS = (1, 2, 3, 4, 6, 16, 64)
SEEDS = 4
MINUTES = 30  # of the whole comparison on two cores
# zsobol rounds sample counts down to powers of two.
ROUNDED = {("zsobol", 3): 2, ("zsobol", 6): 4}
REFERENCE_LINE = 'Sampler "paddedsobol"'
PROBES = ("motion", "skin", "room")  # between them they draw all that a path can draw
# What --picture shows: a part of a scene's middle, its samplers, and where in it the part begins.
PICTURE, PICTURE_SCENE, PICTURE_SPP = "docs/pbrt.jpg", "penumbra", 6
PICTURE_BOUNDS, PICTURE_PART = (460, 780, 280, 520), (60, 30, 200, 190)
PICTURE_SAMPLERS = ("independent", "zsobol", "blue")


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

    def __init__(self, luxcore):
        self._folder = tempfile.TemporaryDirectory(prefix="libbn-pbrt-")
        if luxcore:
            SCENES.update(lux_scenes.scenes(luxcore, self._folder.name))
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
            key = {"probe": [label, SAMPLERS.get(label, REFERENCE_LINE), [SCENES[name].text("") for name in PROBES]], "program": self._sha256}
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
                    render(self.program, self.files.path(name, label, SAMPLERS.get(label, REFERENCE_LINE)), bounds, spp, 1, out)
                    digest.update(read_exr(out)[0].tobytes())
        return digest.hexdigest()


class PbrtRun(OtherRun):
    """Renders tasks, or finds their results in the cache."""

    def __init__(self, program, jobs, luxcore):
        super().__init__(program, "pbrt", jobs)
        self.files = Files(luxcore)
        self.builds = Builds(program, self.files, self.store)

    def key(self, task, reference):
        return {"scene": SCENES[task.view.scene].text(SAMPLERS[task.label]), "bounds": task.view.bounds, "seed": task.seed,
                "counts": task.counts, "build": self.builds.key(task.label)}

    def render(self, task, spp, seed, out):
        line = REFERENCE_LINE if task.label == "reference" else SAMPLERS[task.label]
        return render(self.program, self.files.path(task.view.scene, task.label, line), task.view.bounds, spp, seed, out)

    def reference_key(self, view, spp):
        return {"reference": SCENES[view.scene].text(REFERENCE_LINE), "bounds": view.bounds, "spp": spp, "build": self.builds.key("reference")}

    def reference_task(self, view, spp):
        return Task(view, "reference", 0, ())


class PbrtCells(Cells):
    """Results by view, sampler and the count that was asked for."""

    def get(self, view, label, spp, measure):
        return super().get(view, label, ROUNDED.get((label, spp), spp), measure)


def make_picture(program, path, reference_spp):
    scene = SCENES[PICTURE_SCENE]
    with tempfile.TemporaryDirectory(prefix="libbn-pbrt-") as folder:
        def picture(name, spp, seed, line):
            out = Path(folder) / "out.exr"
            render(program, write_files(folder, scene, name, line), PICTURE_BOUNDS, spp, seed, out)
            return read_exr(out)[0]

        pictures = {name: picture(name, PICTURE_SPP, 1, SAMPLERS[name]) for name in PICTURE_SAMPLERS}
        reference = picture("reference", reference_spp, REFERENCE_SEED, REFERENCE_LINE)
    write_picture(path, pictures, reference, PICTURE_PART)


# ---- The command

def parse_options(arguments):
    parser = argparse.ArgumentParser(
        prog="scripts/bench pbrt", description=__doc__.splitlines()[0], formatter_class=argparse.RawDescriptionHelpFormatter, epilog=f"""
Get the checkout with:
  git clone --recursive https://github.com/mmp/pbrt-v4 DIR && git -C DIR checkout {COMMIT} &&
  git -C DIR submodule update --init --recursive
and that of LuxCoreRender with:
  git clone https://github.com/LuxCoreRender/LuxCore DIR && git -C DIR checkout {lux_scenes.COMMIT}
The first stays as it is: a copy of it is patched and built in ~/.cache/libbn/pbrt, in a quarter of an hour on two cores. The whole
comparison then takes about {MINUTES} minutes on two cores the first time. Builds, references and results are cached there: a run
that was interrupted resumes, and a change of libbn renders only `blue` again.""")
    parser.add_argument("--pbrt", metavar="DIR", required=True, help="a checkout of pbrt-v4 with its submodules, see below")
    parser.add_argument("--luxcore", metavar="DIR", help="a checkout of LuxCoreRender, for its scenes")
    parser.add_argument("--views", choices=tuple(VIEWS), default="held-out",
                        help="held-out: scenes and crops that nothing was chosen by (default); tuning: scenes of ours to choose by")
    parser.add_argument("--samplers", metavar="NAME,...", help=f"only these: {', '.join(SAMPLERS)}; without blue, only fills the cache")
    add_options(parser, "pbrt", {**VIEWS["held-out"], **TUNING}, SEEDS)
    parser.add_argument("--picture", metavar="FILE", nargs="?", const=PICTURE,
                        help=f"only make the picture of {PICTURE_SPP} samples per pixel (default {PICTURE})")
    options = parser.parse_args(arguments)
    finish_options(parser, options, "pbrt", arguments, ("samplers", "views"), {"scenes": VIEWS[options.views], "samplers": SAMPLERS})
    options.counts = tuple(n for n in COUNTS if n <= options.spp)
    if not options.luxcore:
        options.scenes = [name for name in options.scenes if name not in lux_scenes.SCENES]
    options.crops, options.reference_share = (1, 0.125) if options.quick else (None, 1.0)
    return options


def run(arguments):
    options = parse_options(arguments)
    built = build(options.pbrt, options.jobs) if not options.program else None
    if options.picture:
        return make_picture(options.program or built.program, options.picture, SCENES[PICTURE_SCENE].reference_spp // 8)
    work = PbrtRun(options.program or built.program, options.jobs, options.luxcore)
    try:
        views = [view for name in options.scenes for view in crops(name, "fresh" if options.views == "held-out" else "tuning")[:options.crops]]
        references = work.references(views, {
            view: max(64, int(SCENES[view.scene].reference_spp * options.reference_share) // 2 * 2) for view in views})
        tasks = [Task(view, label, seed, tuple(n for n in options.counts if (label, n) not in ROUNDED))
                 for view in views for label in options.samplers for seed in range(1, options.seeds + 1)]
        cells = PbrtCells(work.results(references, tasks))
    finally:
        work.files.close()
    if "blue" not in options.samplers:
        return print(f"Rendered without `blue`, to be compared later: {len(tasks)} runs are in the cache.", file=sys.stderr)
    report = Report(options, cells, references, built.remarks if built else ())
    if write_report(options, "pbrt", report, views):
        gains.write_rows(options.out / "pbrt_headline.csv", report.headline_rows())
