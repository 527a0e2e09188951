# SPDX-License-Identifier: Apache-2.0
"""Compares `blue` with Cycles' own sampling patterns: `scripts/bench cycles --cycles DIR --program FILE` writes evidence/results/cycles.md

FILE is Cycles' stand-alone program with the patch from examples/cycles, and DIR is its source folder, which also contains the scenes' objects.
Renders the scenes with every pattern at 1 to 64 samples per pixel and several seeds, and measures the images against references. Everything
is cached in ~/.cache/libbn ($XDG_CACHE_HOME), so an interrupted run resumes.
"""

import argparse
import dataclasses
import math
import os
import re
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from ..base.command import Parser
from ..base.tables import md_table
from ..measure.statistics import bootstrap
from ..renders.judge import Cells
from ..renders.renderer import REFERENCE_SEED, RenderError, processor_seconds
from . import other_renderer
from .other_renderer import EXPOSED, HEADLINE, Task, name_of

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


@dataclasses.dataclass(frozen=True)
class View:
    scene: str
    name: str = "middle"
    size: tuple = SIZE

    @property
    def label(self):
        return self.scene


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
SEEDS = 2
# The image at the top of the page.
PICTURE = {"tabulated_sobol": "Tabulated Sobol", "blue": "blue"}
PICTURE_SCENE, PICTURE_SPP, PICTURE_PART = "monkey", 4, (24, 0, 144, 144)
REFERENCE_SPP = 1024
REFERENCE_SAMPLER = "sobol_burley"  # hashes pixel, dimension and seed
ADAPTIVE, ADAPTIVE_SPP = 0.05, 128  # threshold, maximum sample count
# Patterns that must know the sample count; they are tuned for PREVIEW_SPP and stopped earlier.
PREVIEW, PREVIEW_SPP = ("blue_noise_first", "blue_noise_pure"), 64
TOLD = {f"{than} {PREVIEW_SPP}": f"{NAMES[than]}, tuned for {PREVIEW_SPP}" for than in PREVIEW}


# ---- Running Cycles

def integrator(sampler, spp, seed, threshold=None):
    """Attributes of Cycles' integrator; a threshold turns adaptive sampling on."""
    return {"sampling_pattern": sampler, "seed": seed, "aa_samples": spp, "use_adaptive_sampling": "true" if threshold else "false",
            "adaptive_threshold": threshold or 0}


class CyclesRun(other_renderer.OtherRun):
    """Renders tasks, or finds their results in the cache."""

    reference = REFERENCE_SAMPLER

    def __init__(self, program, checkout, jobs):
        super().__init__(program, "cycles/results", jobs)
        self.checkout = checkout

    def key(self, task, reference):
        return {"scene": text(task.view.scene, self.checkout, integrator(task.sampler, task.told, task.seed, task.threshold)), "size": SIZE,
                "counts": task.counts, "build": self.sha256}

    def render(self, task, spp, seed, out, counts=False):
        """Renders the image, or with `counts` each pixel's sample count."""
        scene, told = task.view.scene, task.told or spp
        with tempfile.TemporaryDirectory(prefix="libbn-cycles-") as folder:
            path = Path(folder) / "scene.xml"
            path.write_text(text(scene, self.checkout, integrator(task.sampler, told, seed, task.threshold)), encoding="utf-8")
            (Path(folder) / "examples").symlink_to(Path(self.checkout).resolve() / "examples")
            # Cycles finds included files only if the scene is given by a relative path.
            command = ["/usr/bin/env", f"--chdir={folder}", str(Path(self.program).resolve()), "--quiet", "--threads", "1", "--samples",
                       str(spp), "--width", str(SIZE[0]), "--height", str(SIZE[1]), "--output", str(out), path.name]
            environment = {**os.environ, "BN_TOLD": str(told), **({"BN_COUNTS": "1"} if counts else {})}
            seconds = processor_seconds(command, f"Cycles failed on {scene}", environment)
        if not out.is_file():
            raise RenderError(f"Cycles wrote no image of {scene}")
        return seconds

    def more(self, task, spp):
        if not task.threshold:
            return {}
        # Cycles writes counts as fractions of the maximum count.
        return {"samples": float(np.mean(self.rendered(task, spp, task.seed, counts=True)[1][..., 0])) * spp}

    def reference_key(self, view, spp):
        return {"reference": text(view.scene, self.checkout, integrator(REFERENCE_SAMPLER, spp, 0)), "size": SIZE, "seed": REFERENCE_SEED,
                "build": self.sha256}

    def picture(self, path, reference):
        """Writes PICTURE_SCENE as rendered by the patterns in PICTURE."""
        pictures = {name: self.rendered(Task(View(PICTURE_SCENE), sampler, 1, ()), PICTURE_SPP, 1)[1] for sampler, name in PICTURE.items()}
        other_renderer.write_picture(path, pictures, reference.picture, PICTURE_PART)


# ---- The report

class Report(other_renderer.OtherReport):
    TITLE, SCENES, SPREAD = "# In Cycles", SCENES, ("tabulated_sobol", "blue_noise_pure")
    INTRO = f"""Errors on this page are relative to `blue`, the pattern from [examples/cycles](../../examples/cycles/README.md), at the same number
of samples per pixel: 1.20 means that Cycles' pattern has 1.20 times the error of `blue`. The errors are geometric means over scenes and seeds.

Each error is a root mean square over pixels and channels, with or without a Gaussian blur. Images are {SIZE[0]}x{SIZE[1]} pixels and show
the middle of a frame {ZOOM} times as wide. *As displayed* clips the image to 0..1 before the blur. *Exposed and displayed* first scales it
so that the reference's mean luminance is {EXPOSED}. *Raw* does neither.
"""
    METHOD = """We used Cycles {version}. Its own patterns are called `tabulated_sobol`, `sobol_burley`, `blue_noise_first` and `blue_noise_pure` in
`sampling_pattern`. They are tuned for each image's sample count (`aa_samples`) unless a table says otherwise; `blue` does not need to know
the sample count. Indirect light is clamped to Cycles' default, and the pixel filter is the stand-alone program's box filter. Cycles always
places sample 0 at the centre of the pixel. We used `penumbra` and `lens` to decide which effect draws which numbers.

Each reference is the mean of two images rendered with `sobol_burley` and separate seeds, so its error is independent of all other errors.
Half the difference between the two images estimates the reference's own error. A scene counts only if the error of `blue` is at least three
times this error. Cells are empty where the reference is too noisy."""

    def adaptive_ratio(self, name, than):
        """The mean and interval of a figure of adaptive images relative to `blue`, as text."""
        scenes = []
        for view in self.compared.views:
            own, other = (self.cells.get(view, f"{label} {ADAPTIVE}", ADAPTIVE_SPP, name) for label in ("blue", than))
            if own and other and min(*own, *other) > 0:
                scenes.append(np.log(other) - np.log(own))
        return "{:.2f} ({:.2f} to {:.2f})".format(*map(math.exp, bootstrap(scenes))) if scenes else ""

    def sections(self):
        early = [spp for spp in self.counts if spp < PREVIEW_SPP]
        found = {"Stopped early": [
            f"The tables below simulate a preview: the patterns are tuned for {PREVIEW_SPP} samples, "
            "but rendering stops early, at the sample count that heads the column. `blue` does not need to know the sample count.", "",
            *(line for measure in HEADLINE for line in (f"{name_of(measure).capitalize()}:", "", self.ratios(self.compared, measure, early, TOLD), ""))]}
        samples = {label: [np.mean(own) for view in self.compared.views if (own := self.cells.get(view, f"{label} {ADAPTIVE}", ADAPTIVE_SPP, "samples"))]
                   for label in self.samplers}
        if any(samples.values()):
            found["Adaptive sampling"] = [
                f"The threshold is {ADAPTIVE}. Each pixel takes at least Cycles' default minimum and at most {ADAPTIVE_SPP} samples; the patterns are tuned for {ADAPTIVE_SPP}. Cycles splits "
                "a pixel's samples into two halves by bits of the sample index and stops when the two halves agree. The halves of a better pattern agree sooner, "
                "even if its error is not smaller.", "",
                md_table(["pattern", "mean samples", "samples over `blue`'s", *(f"error over `blue`'s, {name_of(measure)}" for measure in HEADLINE)], [
                    [self.name(label), f"{np.mean(samples[label]):.1f}", *(self.adaptive_ratio(name, label) if label != "blue" else ""
                                                                         for name in ("samples", *HEADLINE))] for label in self.samplers])]
        return found

    def answer(self):
        """The main table and the cost."""
        counts = [n for n in (1, 4, 16, 64) if n in self.counts]
        samples, error = (self.adaptive_ratio(name, "tabulated_sobol") for name in ("samples", HEADLINE[0]))
        last = (f"With adaptive sampling and a threshold of {ADAPTIVE}, Tabulated Sobol takes {samples} times as many samples as `blue` and ends up "
                f"with {error} times its error. " if samples and error else "")
        rows = [[name, *(self.both(self.compared, than, spp) for spp in counts)] for than, name in {**NAMES, **TOLD}.items()]
        return (f"Errors relative to `blue` after a 2.1-pixel blur, as displayed (raw errors in brackets):\n\n{md_table(['pattern, at spp', *map(str, counts)], rows)}\n\n"
                f"{last}Tabulated Sobol is the default of Cycles' stand-alone program. All CPU times are [below](#time).")


# ---- The command

def parse_options(arguments):
    parser = Parser("cycles", __doc__, formatter_class=argparse.RawDescriptionHelpFormatter, epilog="""
examples/cycles/README.md explains how to add the pattern. Measuring previews and adaptive sampling requires two more changes: in
src/app/cycles_standalone.cpp, the pass gets the type getenv("BN_COUNTS") ? PASS_SAMPLE_COUNT : PASS_COMBINED, and in src/session/session.cpp,
set_aa_samples() gets getenv("BN_TOLD") ? atoi(getenv("BN_TOLD")) : params.samples. The whole comparison takes an hour and a half on one core.""")
    parser.add_argument("--cycles", metavar="DIR", required=True, help="folder that contains Cycles' sources")
    other_renderer.add_options(parser, "cycles", SCENES, SEEDS)
    parser.number("--reference-spp", REFERENCE_SPP, "samples per pixel of references")
    parser.add_argument("--adaptive", action="store_true", help="also measure adaptive sampling, which takes another half hour")
    parser.hidden("--pictures", "docs")
    options = parser.parse_args(arguments)
    other_renderer.finish_options(parser, options, "cycles", arguments, ("reference_spp",))
    if options.quick:
        options.reference_spp = 256
    return options


def run(arguments):
    options = parse_options(arguments)
    version = subprocess.run(["git", "-C", options.cycles, "describe", "--tags", "--always"], capture_output=True, text=True, check=False).stdout
    Report.METHOD = Report.METHOD.format(version=version.strip() or "(unknown version)")
    work, views, seeds = CyclesRun(options.program, options.cycles, options.jobs), [View(name) for name in options.scenes], range(1, options.seeds + 1)
    references = work.references(dict.fromkeys(views, options.reference_spp))
    early = tuple(n for n in options.counts if n < PREVIEW_SPP)
    tasks = [Task(view, sampler, seed, options.counts) for view in views for sampler in SAMPLERS for seed in seeds]
    tasks += [Task(view, sampler, seed, early, told=PREVIEW_SPP) for view in views for sampler in PREVIEW for seed in seeds]
    if options.adaptive:
        tasks += [Task(view, sampler, seed, (ADAPTIVE_SPP,), ADAPTIVE) for view in views for sampler in SAMPLERS for seed in seeds]
    report = Report(options, Cells(work.results(references, tasks)), references, SAMPLERS, NAMES, {"Scenes": SCENES})
    if report.write("cycles", report.summary({**NAMES, **TOLD})):
        work.picture(options.pictures / "cycles.jpg", references[View(PICTURE_SCENE)])
