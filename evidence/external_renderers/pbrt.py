# SPDX-License-Identifier: Apache-2.0
"""Compares `blue` with pbrt-v4's own samplers: `scripts/bench pbrt --program FILE --luxcore DIR` writes evidence/results/pbrt.*

FILE is pbrt with the patch from examples/pbrt, and DIR is a checkout of LuxCoreRender at the commit named in lux_scenes.py. Renders crops
of its scenes with every sampler at 1 to 16 samples per pixel, and measures them against references. Images and references are cached in
~/.cache/libbn ($XDG_CACHE_HOME), so an interrupted run resumes.
"""

import argparse
import functools
import tempfile

from ..base.cache import cache_folder
from ..base.command import Parser
from ..base.tables import md_table
from ..renders.judge import Cells
from ..renders.renderer import REFERENCE_SEED, processor_seconds
from . import lux_scenes, other_renderer
from .other_renderer import EXPOSED, HEADLINE, Task, name_of
from .pbrt_scenes import CROP, CROPS, HEIGHT, OWN, WIDTH, View, crops, write_files

# The scene-file lines of pbrt's samplers, then libbn's. Sample counts and seeds are command-line options of pbrt.
SAMPLERS = {name: f'Sampler "{name}"' for name in ("independent", "sobol", "zsobol", "pmj02bn", "blue")}
LINES = {**SAMPLERS, "reference": 'Sampler "paddedsobol"'}  # hashes pixel, dimension and seed
COUNTS, SEEDS = (1, 2, 3, 4, 6, 16), 2
MINUTES = 15  # of CPU time
PBRT_COMMIT = "5f7a606806a4ac7b939131ded9d7a30ebd02416e"  # the commit that the patch applies to
# zsobol rounds sample counts down to powers of two.
ROUNDED = {("zsobol", 3): 2, ("zsobol", 6): 4}
# What --picture shows: the scene, the samplers, and the origin of a part of the image's middle.
PICTURE, PICTURE_SPP = "docs/pbrt.jpg", 6
PICTURE_VIEW, PICTURE_PART = View("penumbra", "picture", 512, 302, (216, 206)), (8, 8, 200, 190)
PICTURE_SAMPLERS = ("independent", "zsobol", "blue")
SCENES = {**OWN}  # the scenes of lux_scenes.scenes() are added
SETS = {"Fixed wavelengths": tuple(name + lux_scenes.FIXED for name in lux_scenes.SCENES),
        "Four random wavelengths": tuple(lux_scenes.SCENES)}


# ---- Running pbrt

class PbrtRun(other_renderer.OtherRun):
    reference = "reference"

    def key(self, task, reference):
        return {"scene": SCENES[task.view.scene].text(SAMPLERS[task.label]), "bounds": task.view.bounds, "seed": task.seed,
                "counts": task.counts, "program": self.sha256}

    def render(self, task, spp, seed, out):
        with tempfile.TemporaryDirectory(prefix="libbn-pbrt-") as folder:
            path = write_files(folder, SCENES[task.view.scene], task.sampler, LINES[task.sampler])
            command = [self.program, "--quiet", "--nthreads", "1", "--spp", str(spp), "--seed", str(seed),
                       "--pixelbounds", ",".join(map(str, task.view.bounds)), "--outfile", out, path]
            return processor_seconds(command, f"pbrt failed on {task.view.scene}")

    def reference_key(self, view, spp):
        return {"reference": SCENES[view.scene].text(LINES["reference"]), "bounds": view.bounds, "spp": spp, "program": self.sha256}


class PbrtCells(Cells):
    """Results by view, sampler and requested sample count."""

    def get(self, view, label, spp, measure):
        return super().get(view, label, ROUNDED.get((label, spp), spp), measure)


def make_picture(work, path):
    of = functools.partial(Task, PICTURE_VIEW, seed=0, counts=())
    pictures = {name: work.rendered(of(name), PICTURE_SPP, 1)[1] for name in PICTURE_SAMPLERS}
    _, reference = work.rendered(of(work.reference), SCENES[PICTURE_VIEW.scene].reference_spp // 16, REFERENCE_SEED)
    other_renderer.write_picture(path, pictures, reference, PICTURE_PART)


# ---- The report

class Report(other_renderer.OtherReport):
    TITLE, SCENES, SPREAD = "# In pbrt-v4", SCENES, ("zsobol", "sobol")
    INTRO = f"""Errors on this page are relative to `blue`, the sampler from [examples/pbrt](../../examples/pbrt/README.md), at the same `--spp`, so
**values above 1 mean that `blue` is better**. The errors are geometric means over scenes, crops and seeds.

Each error is a root mean square over pixels and channels, with or without a Gaussian blur, in {CROP[0]}x{CROP[1]}-pixel crops of
{WIDTH}x{HEIGHT}-pixel images. *As displayed* clips the image to 0..1 before the blur. *Exposed and displayed* first scales it so that the
mean luminance of a crop's reference is {EXPOSED}. *Raw* does neither. The crops were placed by hashes of the scenes' names. These scenes were not
used to choose or tune anything.

With *fixed wavelengths* (pbrt's `disablewavelengthjitter` option), all samples of an image use the same four wavelengths, so only the
sampler differs. By default, each path uses four random wavelengths, which are the only source of noise in evenly lit areas. `blue`
distributes them evenly.

`zsobol` rounds sample counts down to powers of two: at 3 and 6 samples, it renders 2 and 4, respectively. `sobol` is one sequence over the whole image.
"""
    METHOD = f"""We used pbrt-v4 at commit `{PBRT_COMMIT[:8]}`. Images are rendered with its neutral sensor (`cie1931`), a one-pixel box filter and the
`volpath` integrator. `--spp` and `--seed` set sample counts and seeds; all other sampler options keep pbrt's defaults. `sobol` uses the same
pixel positions for every seed. The meshes, cameras, lights, constant colours and textures come from LuxCoreRender's scenes. We
replaced skies and suns with our own environment map, and layered and procedural materials with simple ones. Objects whose files are missing
from the checkout are omitted.

Each reference is the mean of two images rendered by `paddedsobol`, which hashes pixel, dimension and seed. References use separate
seeds, so their errors are independent of all other errors. Half the difference between the two images estimates a reference's own error. A
crop counts only if the error of `blue` is at least three times this error."""

    def __init__(self, options, cells, references):
        thans = {name: f"`{name}`" for name in SAMPLERS if name != "blue"}
        super().__init__(options, cells, references, SAMPLERS, thans, SETS)

    def answer(self):
        """The main table."""
        rows = [[f"{self.name(than)}, {title.lower()}", *(gain.text() if (gain := own.over(than, spp, HEADLINE[0])) else "" for spp in self.counts)]
                for title, own in self.sets.items() for than in ("zsobol", "sobol", "pmj02bn")]
        return f"Errors relative to `blue`, {name_of(HEADLINE[0])}:\n\n{md_table(['sampler, at spp', *map(str, self.counts)], rows)}"


# ---- The command

def parse_options(arguments):
    parser = Parser("pbrt", __doc__, formatter_class=argparse.RawDescriptionHelpFormatter, epilog=f"""
examples/pbrt/README.md explains how to add the sampler to pbrt-v4. To get the LuxCoreRender checkout, run:
  git clone https://github.com/LuxCoreRender/LuxCore DIR && git -C DIR checkout {lux_scenes.COMMIT}
The comparison takes {MINUTES} minutes of CPU time. References and results are cached in ~/.cache/libbn, so an interrupted run resumes.""")
    known = sum(SETS.values(), ())
    parser.add_argument("--luxcore", metavar="DIR", help="LuxCoreRender checkout that contains the scenes")
    parser.number("--crops", CROPS, f"number of crops per image, at most {CROPS}")
    other_renderer.add_options(parser, "pbrt", known, SEEDS, COUNTS)
    parser.add_argument("--picture", metavar="FILE", nargs="?", const=PICTURE,
                        help=f"only make the image at {PICTURE_SPP} samples per pixel (default {PICTURE})")
    options = parser.parse_args(arguments)
    if not options.luxcore and not options.picture:
        parser.error("--luxcore must name a LuxCoreRender checkout")
    other_renderer.finish_options(parser, options, "pbrt", arguments)
    options.reference_share = 0.125 if options.quick else 0.25
    return options


def run(arguments):
    options = parse_options(arguments)
    work = PbrtRun(options.program, "pbrt/results", options.jobs)
    if options.picture:
        return make_picture(work, options.picture)
    SCENES.update(lux_scenes.scenes(options.luxcore, cache_folder() / "pbrt"))
    views = [view for name in options.scenes for view in crops(name)[:options.crops]]
    references = work.references({
        view: max(64, int(SCENES[view.scene].reference_spp * options.reference_share) // 2 * 2) for view in views})
    tasks = [Task(view, label, seed, tuple(n for n in options.counts if (label, n) not in ROUNDED))
             for view in views for label in SAMPLERS for seed in range(1, options.seeds + 1)]
    cells = PbrtCells(work.results(references, tasks))
    report = Report(options, cells, references)
    report.write("pbrt", report.summary())
