# SPDX-License-Identifier: Apache-2.0
"""Compares `blue` with Cycles' own sampling patterns: `scripts/bench cycles --cycles DIR --program FILE` writes evidence/results/cycles.md

FILE is Cycles' stand-alone program with the patch from examples/cycles, and DIR is its source folder, which also contains the scenes' objects.
"""

import argparse
import dataclasses
import math
import os
import re
import subprocess
import tempfile
from pathlib import Path

from ..base.command import Parser
from ..renders.judge import Cells
from ..renders.renderer import REFERENCE_SEED, RenderError, processor_seconds
from ..renders.views import View
from . import other_renderer
from .other_renderer import Task

# ---- Scenes, in the XML of Cycles' stand-alone program. Images show the middle of frames ZOOM times as wide, because whole scenes at
# this size would show mostly edges.

SIZE = (192, 144)
ZOOM = 3
FOV = math.pi / 4  # field of view of Cycles' cameras

SPHERE = '<include src="examples/objects/sphere.xml"/>'
CUBE = '<include src="examples/objects/cube.xml"/>'


def surface(name, closure, **parameters):
    values = "".join(f' {key}="{value}"' for key, value in parameters.items())
    return (f'<shader name="{name}"><{closure} name="{name}_closure"{values}/>'
            f'<connect from="{name}_closure {"emission" if closure == "emission" else "bsdf"}" to="output surface"/></shader>')


def put(shader, shape, translate="0 0 0", scale="1 1 1"):
    return (f'<transform translate="{translate}"><transform scale="{scale}"><state interpolation="smooth" shader="{shader}">{shape}</state>'
            '</transform></transform>')


def square(y, half):
    return f'<mesh P="{-half} {y} {half}  {half} {y} {half}  {half} {y} {-half}  {-half} {y} {-half}" nverts="4" verts="0 1 2 3"/>'


def lamp(x, y, z, width, depth, strength):
    """A rectangle that shines down."""
    return (f'<state shader="lamp"><light light_type="area" size="1" strength="{strength} {strength} {strength}" sizeu="{width}" '
            f'sizev="{depth}" tfm="1 0 0 {x}  0 0 1 {y}  0 1 0 {z}"/></state>')


def camera(**parameters):
    values = "".join(f' {key}="{value}"' for key, value in parameters.items())
    return f'<transform translate="0 2 -6" rotate="20 1 0 0"><camera type="perspective"{values}/></transform>'


PENUMBRA = "\n".join((
    camera(), surface("lamp", "emission", color="1 1 1", strength="1"), surface("floor", "diffuse_bsdf", color="0.7 0.7 0.65"),
    surface("wood", "diffuse_bsdf", color="0.6 0.4 0.25"), put("floor", square(-1, 12)),
    put("wood", SPHERE, "-0.55 -0.65 0.3", "0.35 0.35 0.35"), put("wood", CUBE, "0.5 -0.7 0.9", "0.15 0.3 0.15"),
    put("wood", CUBE, "0.1 0.6 0.2", "0.8 0.03 0.06"), put("wood", CUBE, "-0.2 0.9 1", "0.05 0.03 1.2"),
    lamp(-1.5, 4, 1, 1.2, 0.6, 120), lamp(1.2, 3.5, -0.5, 0.5, 0.5, 60), lamp(0.5, 4, 3, 0.3, 1.5, 90)))
LENS = "\n".join((
    '<integrator caustics_reflective="false"/>',
    camera(aperturesize="0.15", focaldistance="6.3"), surface("lamp", "emission", color="1 1 1", strength="1"),
    '<shader name="floor"><checker_texture name="checker" scale="1.5" color1="0.8 0.8 0.8" color2="0.15 0.2 0.4"/>'
    '<diffuse_bsdf name="floor_closure"/><connect from="checker color" to="floor_closure color"/>'
    '<connect from="floor_closure bsdf" to="output surface"/></shader>',
    surface("steel", "glossy_bsdf", color="0.8 0.8 0.8", roughness="0.15"),
    surface("copper", "glossy_bsdf", color="0.9 0.55 0.35", roughness="0.35"), put("floor", square(-1, 12)),
    *(put("steel" if i % 2 else "copper", SPHERE, f"{-1.2 + 0.6 * i} -0.7 {-2.4 + 1.5 * i}", "0.3 0.3 0.3") for i in range(5)),
    lamp(-2, 4, 0, 1, 1, 150), lamp(2, 3, 3, 0.5, 2, 150),
    '<background><background name="bg" color="0.5 0.6 0.8" strength="0.4"/><connect from="bg background" to="output surface"/>'
    '</background>'))


@dataclasses.dataclass(frozen=True)
class Scene:
    what: str
    body: str = ""  # our own scene; if empty, examples/scene_NAME.xml is used


SCENES = {
    "penumbra": Scene("ours: soft shadows of three lamps", PENUMBRA),
    "lens": Scene("ours: depth of field, glossy spheres", LENS),
    "caustics": Scene("Cycles': glass, a point light"),
    "cube_surface": Scene("Cycles': a diffuse cube under a uniform sky"),
    "cube_volume": Scene("Cycles': a cube of varying density"),
    "monkey": Scene("Cycles': rough glass and metal under a sky"),
    "sphere_bump": Scene("Cycles': a bumpy diffuse sphere"),
}


def view_of(scene):
    return View(scene, "middle", *SIZE)


LIGHT = re.compile(r'<light\b([^>]*?)\btfm="([^"]*)"([^>]*)/>')


def placed(light):
    """Moves a light into a transform: since v4.5, Cycles ignores the `tfm` attribute. It lists three rows, whereas a transform lists columns."""
    rows = [*map(float, light[2].split()), 0, 0, 0, 1]
    return f'<transform matrix="{" ".join(f"{rows[i]:g}" for j in range(4) for i in range(j, 16, 4))}"><light{light[1]}{light[3]}/></transform>'


def text(scene, checkout, integrator):
    """The XML of a scene with a zoomed camera and the given integrator attributes. It includes files from an adjacent folder `examples`."""
    body = SCENES[scene].body
    if not body:
        try:
            body = (Path(checkout) / "examples" / f"scene_{scene}.xml").read_text(encoding="utf-8")
        except OSError as error:
            raise RenderError(f"cannot read {error.filename} ({error.strerror})") from None
        body = re.sub(r"<\?xml[^>]*>|</?cycles>", "", body)
        body = re.sub(r'src="(?:\./)?objects/', 'src="examples/objects/', body)
    body = LIGHT.sub(placed, body)
    fov = 2 * math.atan(math.tan(FOV / 2) / ZOOM)
    body = re.sub(r'\s*\bfov="[^"]*"', "", body)
    body = body.replace('type="perspective"', f'type="perspective" fov="{fov:.6f}"')
    settings = "".join(f' {name}="{value}"' for name, value in integrator.items())
    return f"<cycles>\n{body}\n<integrator{settings}/>\n</cycles>\n"


# ---- The comparison

# Values of Cycles' `sampling_pattern`: its default, the sequence that the default tabulates, two blue-noise types, and the pattern from examples/cycles.
NAMES = {"tabulated_sobol": "Tabulated Sobol", "sobol_burley": "Sobol-Burley", "blue_noise_first": "blue noise (first)", "blue_noise_pure": "blue noise (pure)"}
SAMPLERS = (*NAMES, "blue")
SPREAD = ("tabulated_sobol", "blue_noise_pure")  # the patterns that the scene-by-scene tables compare with `blue`
COUNTS = (1, 2, 3, 4, 6, 8, 16, 32, 64)
# The image at the top of the page.
PICTURE = {"tabulated_sobol": "Tabulated Sobol", "blue": "blue"}
PICTURE_SCENE, PICTURE_SPP, PICTURE_PART = "monkey", 4, (24, 0, 144, 144)
REFERENCE_SPP = 1024
REFERENCE_SAMPLER = "sobol_burley"  # hashes pixel, dimension and seed
# Patterns that must know the sample count; they are tuned for PREVIEW_SPP and stopped earlier.
PREVIEW, PREVIEW_SPP = ("blue_noise_first", "blue_noise_pure"), 64
EARLY = tuple(n for n in COUNTS if n < PREVIEW_SPP)
TUNED = {f"{than} {PREVIEW_SPP}": f"{NAMES[than]}, tuned for {PREVIEW_SPP}" for than in PREVIEW}


# ---- Running Cycles

def integrator(sampler, spp, seed):
    """Attributes of Cycles' integrator."""
    return {"sampling_pattern": sampler, "seed": seed, "aa_samples": spp, "use_adaptive_sampling": "false", "adaptive_threshold": 0}


class CyclesRun(other_renderer.OtherRun):
    """Renders tasks, or finds their results in the cache."""

    reference = REFERENCE_SAMPLER

    def __init__(self, program, checkout, jobs):
        super().__init__(program, "cycles/results", jobs)
        self.checkout = checkout

    def key(self, task, reference):
        return {"scene": text(task.view.scene, self.checkout, integrator(task.sampler, task.tuned_for, task.seed)), "size": SIZE,
                "counts": task.counts, "build": self.sha256}

    def render(self, task, spp, seed, out):
        scene, tuned_for = task.view.scene, task.tuned_for or spp
        with tempfile.TemporaryDirectory(prefix="libbn-cycles-") as folder:
            path = Path(folder) / "scene.xml"
            path.write_text(text(scene, self.checkout, integrator(task.sampler, tuned_for, seed)), encoding="utf-8")
            (Path(folder) / "examples").symlink_to(Path(self.checkout).resolve() / "examples")
            # Cycles finds included files only if the scene is given by a relative path.
            command = ["/usr/bin/env", f"--chdir={folder}", str(Path(self.program).resolve()), "--quiet", "--threads", "1", "--samples",
                       str(spp), "--width", str(SIZE[0]), "--height", str(SIZE[1]), "--output", str(out), path.name]
            seconds = processor_seconds(command, f"Cycles failed on {scene}", {**os.environ, "BN_TOLD": str(tuned_for)})
        if not out.is_file():
            raise RenderError(f"Cycles wrote no image of {scene}")
        return seconds

    def reference_key(self, view, spp):
        return {"reference": text(view.scene, self.checkout, integrator(REFERENCE_SAMPLER, spp, 0)), "size": SIZE, "seed": REFERENCE_SEED,
                "build": self.sha256}

    def picture(self, path, reference):
        """Writes PICTURE_SCENE as rendered by the patterns in PICTURE."""
        pictures = {name: self.rendered(Task(view_of(PICTURE_SCENE), sampler), PICTURE_SPP, 1)[1] for sampler, name in PICTURE.items()}
        other_renderer.write_picture(path, pictures, reference.picture, PICTURE_PART)


# ---- The command

def run(arguments):
    parser = Parser("cycles", __doc__, formatter_class=argparse.RawDescriptionHelpFormatter, epilog="""
examples/cycles/README.md explains how to add the pattern. Measuring previews requires another change: in src/session/session.cpp,
set_aa_samples() gets getenv("BN_TOLD") ? atoi(getenv("BN_TOLD")) : params.samples. The whole comparison takes an hour and a half on one core.""")
    parser.add_argument("--cycles", metavar="DIR", required=True, help="folder that contains Cycles' sources")
    parser.hidden("--pictures", "docs")
    options = other_renderer.options_of(parser, "cycles", arguments, SCENES, COUNTS)
    version = subprocess.run(["git", "-C", options.cycles, "describe", "--tags", "--always"], capture_output=True, text=True, check=False).stdout
    work, views, seeds = CyclesRun(options.program, options.cycles, options.jobs), [view_of(name) for name in options.scenes], range(1, options.seeds + 1)
    references = work.references(dict.fromkeys(views, REFERENCE_SPP))
    tasks = [Task(view, sampler, seed, COUNTS) for view in views for sampler in SAMPLERS for seed in seeds]
    tasks += [Task(view, sampler, seed, EARLY, PREVIEW_SPP) for view in views for sampler in PREVIEW for seed in seeds]
    report, thans = other_renderer.OtherReport(options, Cells(work.results(references, tasks)), references, NAMES, {"Scenes": SCENES}, SCENES), {**NAMES, **TUNED}
    if report.write(globals(), report.summary(thans), version=version.strip() or "(unknown version)", thans=thans):
        work.picture(options.pictures / "cycles.jpg", references[view_of(PICTURE_SCENE)])
