# SPDX-License-Identifier: Apache-2.0
"""Compares `blue` with pbrt-v4's own samplers, in pbrt-v4: `scripts/bench pbrt --pbrt DIR --luxcore DIR` writes evidence/results/pbrt.md

DIR are checkouts of pbrt-v4, with submodules, and of LuxCoreRender, at the commits that builds.py and lux_scenes.py name; they stay
as they are. The first run builds pbrt for a quarter of an hour. Crops of LuxCoreRender's scenes and of ours are rendered with every
sampler at 1 to 64 samples per pixel and several seeds, and measured against references. Pictures, references and the build are cached in
~/.cache/libbn ($XDG_CACHE_HOME): an interrupted run resumes, and a change of libbn renders only `blue` again.
"""

import argparse
import tempfile
from pathlib import Path

from ..base.cache import cache_folder
from ..base.command import Parser
from ..base.files import read_exr, sha256_of
from ..measure import compare
from ..renders.judge import Cells, pixels_key
from ..renders.renderer import REFERENCE_SEED
from . import builds, lux_scenes, other_renderer
from .other_renderer import EXPOSED, HEADLINE, MEASURES, Task, name_of
from .pbrt_scenes import CROP, CROPS, HEIGHT, PROBES, SCENES, WIDTH, View, crops, write_files

# pbrt's samplers, then libbn's. Lines of a scene file; sample counts and seeds are options of pbrt.
SAMPLERS = {name: f'Sampler "{name}"' for name in ("independent", "sobol", "zsobol", "pmj02bn", "blue")}
LINES = {**SAMPLERS, "reference": 'Sampler "paddedsobol"'}  # which hashes pixel, dimension and seed
COUNTS = (1, 2, 3, 4, 6, 16, 64)
SEEDS = 4
MINUTES = 15  # of processor time, for two crops and seeds and up to 16 samples
# zsobol rounds sample counts down to powers of two.
ROUNDED = {("zsobol", 3): 2, ("zsobol", 6): 4}
# What --picture shows: a part of a scene's middle, its samplers, and where in it the part begins.
PICTURE, PICTURE_SPP = "docs/pbrt.jpg", 6
PICTURE_VIEW, PICTURE_PART = View("penumbra", "picture", 512, 302, (216, 206)), (8, 8, 200, 190)
PICTURE_SAMPLERS = ("independent", "zsobol", "blue")
SPECTRAL = "hair"
SETS = {"Scenes from LuxCoreRender": tuple(lux_scenes.SCENES),
        "The same with fixed wavelengths": tuple(name + lux_scenes.FIXED for name in lux_scenes.SCENES),
        "Scenes of ours": tuple(name for name in SCENES if name != SPECTRAL),
        "Hair": (SPECTRAL,)}


# ---- Running pbrt

def render(program, scene, sampler, bounds, spp, seed, out):
    """Renders into `out`; returns the processor seconds."""
    with tempfile.TemporaryDirectory(prefix="libbn-pbrt-") as folder:
        path = write_files(folder, scene, sampler, LINES[sampler])
        command = [str(program), "--quiet", "--nthreads", "1", "--spp", str(spp), "--seed", str(seed),
                   "--pixelbounds", ",".join(map(str, bounds)), "--outfile", str(out), str(path)]
        return other_renderer.processor_seconds(command, f"pbrt failed on {scene.name}")


class PbrtRun(other_renderer.OtherRun):
    """Renders tasks, or finds their results in the cache."""

    reference = "reference"

    def __init__(self, program, jobs):
        super().__init__(program, "pbrt", jobs)
        self._sha256 = sha256_of(program)

    def build(self, label):
        """Identifies a sampler by the pixels of small pictures that it renders."""
        key = {"probe": [label, LINES[label], [scene.text("") for scene in PROBES]], "program": self._sha256}
        return pixels_key(self.store, key, lambda: self._pictures(label))

    def _pictures(self, label):
        with tempfile.TemporaryDirectory(prefix="libbn-") as folder:
            out = Path(folder) / "probe.exr"
            for scene in PROBES:
                for spp, bounds in ((1, (560, 720, 440, 584)), (3, (600, 640, 500, 540)), (64, (620, 640, 500, 518))):
                    render(self.program, scene, label, bounds, spp, 1, out)
                    yield read_exr(out)[0]

    def key(self, task, reference):
        return {"scene": SCENES[task.view.scene].text(SAMPLERS[task.label]), "bounds": task.view.bounds, "seed": task.seed,
                "counts": task.counts, "build": self.build(task.label)}

    def render(self, task, spp, seed, out):
        return render(self.program, SCENES[task.view.scene], task.sampler, task.view.bounds, spp, seed, out)

    def reference_key(self, view, spp):
        return {"reference": SCENES[view.scene].text(LINES["reference"]), "bounds": view.bounds, "spp": spp, "build": self.build(self.reference)}


class PbrtCells(Cells):
    """Results by view, sampler and the count that was asked for."""

    def get(self, view, label, spp, measure):
        return super().get(view, label, ROUNDED.get((label, spp), spp), measure)


def make_picture(work, path):
    def picture(name, spp, seed):
        return work.rendered(Task(PICTURE_VIEW, name, seed, ()), spp, seed)[1]

    pictures = {name: picture(name, PICTURE_SPP, 1) for name in PICTURE_SAMPLERS}
    reference = picture(work.reference, SCENES[PICTURE_VIEW.scene].reference_spp // 16, REFERENCE_SEED)
    other_renderer.write_picture(path, pictures, reference, PICTURE_PART)


# ---- The report

class Report(other_renderer.OtherReport):
    """remarks: of builds.pbrt()."""

    TITLE, SCENES, SPREAD = "# In pbrt-v4", SCENES, ("zsobol", "sobol")
    INTRO = f"""How the sampler of [examples/pbrt](../../examples/pbrt/README.md) compares with pbrt-v4's own, in pbrt-v4. Figures are error
ratios, pbrt's sampler over `blue`, at the same `--spp`: 1.20 means that pbrt's sampler has 1.20 times the
error of `blue`, less than 1 that `blue` has more. They are geometric means over scenes, crops and seeds.

Errors are root mean squares over the pixels and channels of crops of {CROP[0]}x{CROP[1]} pixels from pictures of {WIDTH}x{HEIGHT}, after
a Gaussian blur or without. *As displayed* clips pictures to 0..1 before the blur; *exposed and displayed* first multiplies them so
that the mean luminance of a crop's reference is {EXPOSED}; *raw* does neither. Hashes of the names place the crops. Nothing was chosen
or tuned by these crops, nor by any of LuxCoreRender's scenes. Two other crops of `{SPECTRAL}` prompted how wavelengths are spread, so it
is apart. A path has four random wavelengths, which `blue` spreads evenly. Where light is even, nothing else is noisy. So all of
LuxCoreRender's crops are shown once more with the same wavelengths in all samples (pbrt's option `disablewavelengthjitter`).

`zsobol` rounds counts down to powers of two: at 3 and 6 it takes 2 and 4 samples. `sobol` is one sequence over the whole picture.
"""
    METHOD = f"""pbrt-v4 is at commit `{builds.PBRT_COMMIT[:8]}`. Its film has its neutral sensor (`cie1931`) and a box filter one pixel wide, the integrator
is `volpath`. `--spp` and `--seed` set counts and seeds, other options of samplers are pbrt's defaults. `sobol` keeps the positions in the
pixel for all seeds. LuxCoreRender's scenes keep their meshes, cameras, lamps, plain colours and images; its skies and suns became an
image of ours, layered and procedural materials simple ones, and what its checkout lacks is left out.

References are means of two pictures by `paddedsobol`. It hashes pixel, dimension and seed, and the references have seeds of their
own, so their errors are independent of all others'. Half the difference of the two pictures is a reference's own error. A crop
counts where the error of `blue` is at least three times that."""

    def __init__(self, options, cells, references, remarks):
        self.METHOD += "".join(f" {remark}" for remark in remarks)
        thans = {name: f"`{name}`" for name in SAMPLERS if name != "blue"}
        super().__init__(options, cells, references, SAMPLERS, thans, SETS)

    def answer(self):
        """Where blue is ahead of pbrt's default and of its global Sobol', and where not."""
        parts = []
        for title, own in self.sets.items():
            found = {than: ", ".join(f"{gain.value:.2f} at {spp}" for spp in self.counts if (gain := own.over(than, spp, HEADLINE[0])))
                     for than in ("zsobol", "sobol")}
            said = "; ".join(f"{self.name(than)} {text}" for than, text in found.items() if text)
            parts.append(f"{title}, {name_of(HEADLINE[0])}, error over `blue`'s: {said}.")
        return "\n\n".join(parts)


# ---- The command

def parse_options(arguments):
    parser = Parser("pbrt", __doc__, formatter_class=argparse.RawDescriptionHelpFormatter, epilog=f"""
Get the checkout with:
  git clone --recursive https://github.com/mmp/pbrt-v4 DIR && git -C DIR checkout {builds.PBRT_COMMIT} &&
  git -C DIR submodule update --init --recursive
and that of LuxCoreRender with:
  git clone https://github.com/LuxCoreRender/LuxCore DIR && git -C DIR checkout {lux_scenes.COMMIT}
The first stays as it is: a copy of it is patched and built in ~/.cache/libbn/pbrt, in 9 minutes of processor time. The report's
comparison, --crops 2 --seeds 2 --spp 16, then takes {MINUTES} minutes of processor time the first time. Builds, references and results are cached there: a run
that was interrupted resumes, and a change of libbn renders only `blue` again.""")
    known = sum(SETS.values(), ())
    parser.add_argument("--pbrt", metavar="DIR", required=True, help="a checkout of pbrt-v4 with its submodules, see below")
    parser.add_argument("--luxcore", metavar="DIR", help="a checkout of LuxCoreRender, for its scenes")
    parser.number("--crops", CROPS, f"crops of each picture, at most {CROPS}")
    other_renderer.add_options(parser, "pbrt", known, SEEDS)
    parser.add_argument("--picture", metavar="FILE", nargs="?", const=PICTURE,
                        help=f"only make the picture of {PICTURE_SPP} samples per pixel (default {PICTURE})")
    options = parser.parse_args(arguments)
    other_renderer.finish_options(parser, options, "pbrt", arguments)
    options.counts = tuple(n for n in COUNTS if n <= options.spp)
    options.scenes = [name for name in options.scenes if options.luxcore or name in SCENES]
    options.reference_share = 0.125 if options.quick else 0.25
    return options


def run(arguments):
    options = parse_options(arguments)
    program, remarks = (options.program, ()) if options.program else builds.pbrt(options.pbrt, options.jobs)
    work = PbrtRun(program, options.jobs)
    if options.picture:
        return make_picture(work, options.picture)
    if options.luxcore:
        SCENES.update(lux_scenes.scenes(options.luxcore, cache_folder() / "pbrt"))
    views = [view for name in options.scenes for view in crops(name, "fresh")[:options.crops]]
    references = work.references({
        view: max(64, int(SCENES[view.scene].reference_spp * options.reference_share) // 2 * 2) for view in views})
    tasks = [Task(view, label, seed, tuple(n for n in options.counts if (label, n) not in ROUNDED))
             for view in views for label in SAMPLERS for seed in range(1, options.seeds + 1)]
    cells = PbrtCells(work.results(references, tasks))
    report = Report(options, cells, references, remarks)
    if report.write("pbrt", report.summary()):
        compare.write(options.out / "pbrt.csv", report.compared.rows(options.counts, MEASURES))
