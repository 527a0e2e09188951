# SPDX-License-Identifier: Apache-2.0
"""Compares `blue` with pbrt-v4's own samplers: `scripts/bench pbrt --program FILE --luxcore DIR` writes evidence/results/pbrt.*

FILE is pbrt with the patch from examples/pbrt, and DIR is a checkout of LuxCoreRender at the commit named in lux_scenes.py.
"""

import argparse
import tempfile

from ..base.cache import cache_folder
from ..base.command import Parser
from ..base.tables import md_table
from ..renders.judge import Cells
from ..renders.renderer import REFERENCE_SEED, processor_seconds
from . import lux_scenes, other_renderer, pbrt_scenes
from .other_renderer import HEADLINE, Task

# The scene-file lines of pbrt's samplers, then libbn's. Sample counts and seeds are command-line options of pbrt.
SAMPLERS = {name: f'Sampler "{name}"' for name in ("independent", "sobol", "zsobol", "pmj02bn", "blue")}
LINES = {**SAMPLERS, "reference": 'Sampler "paddedsobol"'}  # hashes pixel, dimension and seed
COUNTS = (1, 2, 3, 4, 6, 16)
MINUTES = 15  # of CPU time
PBRT_COMMIT = "5f7a606806a4ac7b939131ded9d7a30ebd02416e"  # the commit that the patch applies to
# zsobol rounds sample counts down to powers of two.
ROUNDED = {("zsobol", 3): 2, ("zsobol", 6): 4}
# What --picture shows: the scene, the samplers, and the origin of a part of the image's middle.
PICTURE, PICTURE_SPP = "docs/pbrt.jpg", 6
PICTURE_VIEW, PICTURE_PART = pbrt_scenes.view_of("penumbra", "picture", 512, 302, (216, 206)), (8, 8, 200, 190)
PICTURE_SAMPLERS = ("independent", "zsobol", "blue")
SCENES = {**pbrt_scenes.OWN}  # the scenes of lux_scenes.scenes() are added
SPREAD = ("zsobol", "sobol")  # the samplers that the scene-by-scene tables compare with `blue`
SETS = {"Fixed wavelengths": tuple(name + lux_scenes.FIXED for name in lux_scenes.SCENES),
        "Four random wavelengths": tuple(lux_scenes.SCENES)}


# ---- Running pbrt

def bounds(view):
    """A crop's bounds in pbrt's order."""
    x0, y0, x1, y1 = view.crop
    return x0, x1, y0, y1


class PbrtRun(other_renderer.OtherRun):
    reference = "reference"

    def key(self, task, reference):
        return {"scene": SCENES[task.view.scene].text(SAMPLERS[task.label]), "bounds": bounds(task.view), "seed": task.seed,
                "counts": task.counts, "program": self.sha256}

    def render(self, task, spp, seed, out):
        with tempfile.TemporaryDirectory(prefix="libbn-pbrt-") as folder:
            path = pbrt_scenes.write_files(folder, SCENES[task.view.scene], task.sampler, LINES[task.sampler])
            command = [self.program, "--quiet", "--nthreads", "1", "--spp", str(spp), "--seed", str(seed),
                       "--pixelbounds", ",".join(map(str, bounds(task.view))), "--outfile", out, path]
            return processor_seconds(command, f"pbrt failed on {task.view.scene}")

    def reference_key(self, view, spp):
        return {"reference": SCENES[view.scene].text(LINES["reference"]), "bounds": bounds(view), "spp": spp, "program": self.sha256}


class PbrtCells(Cells):
    """Results by view, sampler and requested sample count."""

    def get(self, view, label, spp, measure):
        return super().get(view, label, ROUNDED.get((label, spp), spp), measure)


def make_picture(work, path):
    pictures = {name: work.rendered(Task(PICTURE_VIEW, name), PICTURE_SPP, 1)[1] for name in PICTURE_SAMPLERS}
    _, reference = work.rendered(Task(PICTURE_VIEW, work.reference), SCENES[PICTURE_VIEW.scene].reference_spp // 16, REFERENCE_SEED)
    other_renderer.write_picture(path, pictures, reference, PICTURE_PART)


# ---- The report

def answer(report):
    """The main table."""
    return md_table(["sampler, at spp", *map(str, report.counts)], [
        [f"`{than}`, {title.lower()}", *(gain.text() if (gain := own.over(than, spp, HEADLINE[0])) else "" for spp in report.counts)]
        for title, own in report.sets.items() for than in ("zsobol", "sobol", "pmj02bn")])


# ---- The command

def run(arguments):
    parser = Parser("pbrt", __doc__, formatter_class=argparse.RawDescriptionHelpFormatter, epilog=f"""
examples/pbrt/README.md explains how to add the sampler to pbrt-v4. To get the LuxCoreRender checkout, run:
  git clone https://github.com/LuxCoreRender/LuxCore DIR && git -C DIR checkout {lux_scenes.COMMIT}
The comparison takes {MINUTES} minutes of CPU time. References and results are cached in ~/.cache/libbn, so an interrupted run resumes.""")
    parser.add_argument("--luxcore", metavar="DIR", help="LuxCoreRender checkout that contains the scenes")
    parser.add_argument("--picture", metavar="FILE", nargs="?", const=PICTURE,
                        help=f"only make the image at {PICTURE_SPP} samples per pixel (default {PICTURE})")
    options = other_renderer.options_of(parser, "pbrt", arguments, sum(SETS.values(), ()), COUNTS)
    work = PbrtRun(options.program, "pbrt/results", options.jobs)
    if options.picture:
        return make_picture(work, options.picture)
    if not options.luxcore:
        parser.error("--luxcore must name a LuxCoreRender checkout")
    SCENES.update(lux_scenes.scenes(options.luxcore, cache_folder() / "pbrt"))
    views = [view for name in options.scenes for view in pbrt_scenes.crops(name)]
    references = work.references({view: SCENES[view.scene].reference_spp // 4 for view in views})
    tasks = [Task(view, label, seed, tuple(n for n in options.counts if (label, n) not in ROUNDED))
             for view in views for label in SAMPLERS for seed in range(1, options.seeds + 1)]
    thans = {name: f"`{name}`" for name in SAMPLERS if name != "blue"}
    report = other_renderer.OtherReport(options, PbrtCells(work.results(references, tasks)), references, thans, SETS, SCENES)
    report.write(globals(), report.summary(thans))
