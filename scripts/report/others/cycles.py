# SPDX-License-Identifier: Apache-2.0
"""Compares `blue` with Cycles' own sampling patterns, in Cycles: `scripts/bench cycles --cycles DIR` writes docs/report/cycles.md

DIR is a checkout of Cycles at the tag that cycles_build.py names; it stays as it is. The first run builds Cycles' stand-alone program
for a quarter of an hour. The scenes of cycles_scenes.py are rendered with every pattern at 1 to 64 samples per pixel and several seeds,
and with adaptive sampling, and measured against references. All is cached in ~/.cache/libbn ($XDG_CACHE_HOME): an interrupted run resumes.
"""

import argparse
import dataclasses
import hashlib
import os
import tempfile
from pathlib import Path

import numpy as np

from ..base.command import positive
from ..base.files import read_exr
from ..renders.judge import Cells
from ..renders.renderer import RenderError
from .cycles_build import TAG, build
from .cycles_report import ADAPTIVE, ADAPTIVE_SPP, PREVIEW, PREVIEW_SPP, Report
from .cycles_scenes import SCENES, SIZE, View, text
from .other_renderer import REFERENCE_SEED, OtherRun, add_options, finish_options, processor_seconds, write_picture, write_report

# Values of Cycles' `sampling_pattern`: its default, its two kinds of blue noise, and that of examples/cycles.
SAMPLERS = ("tabulated_sobol", "blue_noise_first", "blue_noise_pure", "blue")
SEEDS = 4
# What the page begins with.
PICTURE = {"tabulated_sobol": "Tabulated Sobol", "blue": "blue"}
PICTURE_SCENE, PICTURE_SPP, PICTURE_PART = "monkey", 4, (24, 0, 144, 144)
REFERENCE_SPP = 2048
REFERENCE_SAMPLER = "sobol_burley"  # which hashes pixel, dimension and seed
PIXELS = SIZE[0] * SIZE[1]


def integrator(sampler, spp, seed, threshold=None):
    """Attributes of Cycles' integrator; a threshold turns adaptive sampling on."""
    return {"sampling_pattern": sampler, "seed": seed, "aa_samples": spp, "use_adaptive_sampling": "true" if threshold else "false",
            "adaptive_threshold": threshold or 0}


def render(program, checkout, scene, settings, out, spp=0, counts=False):
    """Renders `spp` samples (default: as the settings tell the pattern) into `out`, with `counts` their number in each pixel; returns the
    processor seconds."""
    with tempfile.TemporaryDirectory(prefix="libbn-cycles-") as folder:
        path = Path(folder) / "scene.xml"
        path.write_text(text(scene, checkout, settings), encoding="utf-8")
        (Path(folder) / "examples").symlink_to(Path(checkout).resolve() / "examples")
        # Cycles finds included files from the folder of a relative path alone.
        command = ["/usr/bin/env", f"--chdir={folder}", str(Path(program).resolve()), "--quiet", "--threads", "1", "--samples",
                   str(spp or settings["aa_samples"]), "--width", str(SIZE[0]), "--height", str(SIZE[1]), "--output", str(out), path.name]
        environment = {**os.environ, "BN_TOLD": str(settings["aa_samples"]), **({"BN_COUNTS": "1"} if counts else {})}
        seconds = processor_seconds(command, f"Cycles failed on {scene}", environment)
        if not Path(out).is_file():
            raise RenderError(f"Cycles wrote no picture of {scene}")
    return seconds


@dataclasses.dataclass(frozen=True)
class Task:
    """All pictures of one view, pattern and seed; with a threshold one adaptive picture. The pattern is told the count of each picture,
    or `told`."""

    view: View
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
        return PIXELS * (sum(self.counts) + 40 * len(self.counts))  # starting Cycles takes as long as some samples


class CyclesRun(OtherRun):
    """Renders tasks, or finds their results in the cache."""

    def __init__(self, program, checkout, jobs):
        super().__init__(program, "cycles", jobs)
        self.checkout, self.build = checkout, hashlib.sha256(Path(program).read_bytes()).hexdigest()

    def key(self, task, reference):
        return {"scene": text(task.view.scene, self.checkout, integrator(task.sampler, task.told, task.seed, task.threshold)), "size": SIZE,
                "counts": task.counts, "build": self.build}

    def render(self, task, spp, seed, out, counts=False):
        return render(self.program, self.checkout, task.view.scene, integrator(task.sampler, task.told or spp, seed, task.threshold), out, spp,
                      counts)

    def more(self, task, spp, out):
        if not task.threshold:
            return {}
        out.unlink()
        self.render(task, spp, task.seed, out, counts=True)
        # Cycles gives the share of the greatest count.
        return {"samples": float(np.mean(read_exr(out)[0][..., 0])) * spp}

    def reference_key(self, view, spp):
        return {"reference": text(view.scene, self.checkout, integrator(REFERENCE_SAMPLER, spp, 0)), "size": SIZE, "seed": REFERENCE_SEED}

    def reference_task(self, view, spp):
        return Task(view, REFERENCE_SAMPLER, 0, ())

    def picture(self, path, reference):
        """Writes PICTURE_SCENE as the patterns of PICTURE render it."""
        pictures = {}
        with tempfile.TemporaryDirectory(prefix="libbn-") as folder:
            for sampler, name in PICTURE.items():
                out = Path(folder) / "out.exr"
                render(self.program, self.checkout, PICTURE_SCENE, integrator(sampler, PICTURE_SPP, 1), out)
                pictures[name] = read_exr(out)[0]
        write_picture(path, pictures, reference.picture, PICTURE_PART)


# ---- The command

def parse_options(arguments):
    parser = argparse.ArgumentParser(
        prog="scripts/bench cycles", description=__doc__.splitlines()[0], formatter_class=argparse.RawDescriptionHelpFormatter, epilog=f"""
Get the checkout with:
  git clone --branch {TAG} https://github.com/blender/cycles DIR
It stays as it is: a copy of it is patched and built in ~/.cache/libbn/cycles, in a quarter of an hour on two cores, with the packages
that examples/cycles/README.md names. The whole comparison then takes about an hour on one core the first time. Builds, references
and results are cached there, and a run that was interrupted resumes.""")
    parser.add_argument("--cycles", metavar="DIR", required=True, help="a checkout of Cycles, see below")
    add_options(parser, "cycles", SCENES, SEEDS)
    parser.add_argument("--reference-spp", type=positive, default=REFERENCE_SPP, metavar="N",
                        help=f"samples per pixel of references (default {REFERENCE_SPP})")
    parser.add_argument("--no-adaptive", action="store_true", help="leave out adaptive sampling")
    parser.add_argument("--pictures", type=Path, default=Path("docs"), help=argparse.SUPPRESS)
    options = parser.parse_args(arguments)
    finish_options(parser, options, "cycles", arguments, ("reference_spp", "no_adaptive"), {"scenes": SCENES})
    if options.quick:
        options.reference_spp = 256
    return options


def run(arguments):
    options = parse_options(arguments)
    program = options.program or build(options.cycles, options.jobs)
    work = CyclesRun(program, options.cycles, options.jobs)
    views = [View(name) for name in options.scenes]
    references = work.references(views, dict.fromkeys(views, options.reference_spp))
    seeds = range(1, options.seeds + 1)
    tasks = [Task(view, sampler, seed, options.counts) for view in views for sampler in SAMPLERS for seed in seeds]
    tasks += [Task(view, sampler, seed, tuple(n for n in options.counts if n < PREVIEW_SPP), told=PREVIEW_SPP) for view in views
              for sampler in PREVIEW for seed in seeds]
    tasks += [Task(view, sampler, seed, (ADAPTIVE_SPP,), threshold) for view in views for sampler in SAMPLERS for seed in seeds
              for threshold in ADAPTIVE if not options.no_adaptive]
    cells = Cells(work.results(references, tasks))
    if write_report(options, "cycles", Report(options, cells, references, SAMPLERS), views):
        work.picture(options.pictures / "cycles.jpg", references[View(PICTURE_SCENE)])
