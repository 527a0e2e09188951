# SPDX-License-Identifier: Apache-2.0
"""Compares the samplers after denoising, by RMSE and FLIP: `scripts/bench denoise` writes evidence/results/denoise.*

The references are those of `scripts/bench renders`.
"""

import dataclasses
import importlib.metadata
import math
import threading

import numpy as np
import OpenEXR

from ..base.command import package
from ..base.page import write_page
from ..base.plots import plt, save
from ..measure import compare
from ..measure.image_error import displayed, displayed_rmse, own_errors, relative_rmse
from ..measure.statistics import estimate
from . import renders, views
from .judge import Cells, Run, Task, pictures_of, plan, render_references

# The inputs of the denoiser.
WAYS = {
    "none": "not denoised",
    "colour": "colour only",
    "plain": "colour, albedo and normal from the same samples",
    "primary": "albedo and normal from additional primary rays, declared noise-free (`cleanAux`)",
    "apart": "like `primary`, but directly visible light from the same rays is added after denoising",
}
DENOISED = tuple(WAYS)[1:]
MEASURES = {"relative": "relative RMSE", "displayed": "RMSE as displayed, unblurred",
            "displayed_2.1": "RMSE as displayed, after sigma 2.1", "flip_75": "FLIP at 75 cm", "flip_35": "FLIP at 35 cm"}
FLIP_WAYS, FLIP_COUNTS, FLIP_DPI = ("none", "plain"), (1, 4, 16), 96  # computing FLIP takes longer than everything else
PRIMARY_RAYS, PRIMARY_SAMPLER, PRIMARY_SEED = 16, "blue", 500_000

# All calls share one filter and its threads.
_LOCK = threading.Lock()


def load():
    """(denoise(colour, albedo, normal, clean), version)."""
    pyoidn = package("pyoidn", ".venv/bin/python -m pip install pyoidn")

    def denoise(colour, albedo=None, normal=None, clean=False):
        guides = {} if albedo is None else {"albedo": np.ascontiguousarray(np.clip(albedo, 0, 1), np.float32), "clean_aux": clean,
                                            "normal": np.ascontiguousarray(normal, np.float32)}
        with _LOCK:
            return pyoidn.denoise(np.ascontiguousarray(np.maximum(colour, 0), np.float32), hdr=True, **guides)

    return denoise, importlib.metadata.version("pyoidn")


def flip(image, reference, exposure, distance):
    """Mean FLIP of the displayed images on a screen with FLIP_DPI, seen from `distance` centimetres."""
    flip_evaluator = package("flip_evaluator", ".venv/bin/python -m pip install flip-evaluator")
    pixels_per_degree = distance / 2.54 * FLIP_DPI * math.tan(math.radians(1))
    shown = (displayed(each, exposure).astype(np.float32) for each in (reference, image))
    return float(flip_evaluator.evaluate(*shown, "LDR", inputsRGB=False, applyMagma=False, parameters={"ppd": pixels_per_degree})[1])


def read_layers(path):
    """(float32 array (height, width, 9), attributes): colour, albedo and normal of a path-traced image."""
    names = [*"RGB", *(f"albedo.{c}" for c in "RGB"), *(f"normal.{c}" for c in "XYZ")]
    with OpenEXR.File(str(path), separate_channels=True) as file:
        channels = file.channels()
        return np.stack([channels[name].pixels.astype(np.float32) for name in names], -1), dict(file.header())


def layers_of(program, view, sampler, seed, counts):
    """{count: layers}."""
    return {spp: layers for spp, layers, _ in pictures_of(program, Task(view, sampler, seed, counts), read_layers)}


def denoised(denoise, way, layers, lamps, rays):
    """lamps: the directly visible light in the colour; rays: layers from additional primary rays."""
    (colour, *guides), (visible, *clean) = np.split(layers, 3, -1), np.split(rays, 3, -1)
    return {"none": lambda: colour, "colour": lambda: denoise(colour), "plain": lambda: denoise(colour, *guides),
            "primary": lambda: denoise(colour, *clean, True), "apart": lambda: denoise(colour - lamps, *clean, True) + visible}[way]()


# ---- Measures

def errors(image, reference, exposure, with_flip=True):
    """{measure: error} for all MEASURES."""
    reference = np.maximum(reference, 0)
    return {"relative": relative_rmse(image, reference),
            **{f"displayed_{sigma}" if sigma else "displayed": displayed_rmse(image, reference, exposure, sigma) for sigma in (0.0, 2.1)},
            **({f"flip_{distance}": flip(image, reference, exposure, distance) for distance in (75, 35)} if with_flip else {})}


class DenoisedRun(Run):
    """A judge.Run that measures images after denoising them in all WAYS."""

    def __init__(self, program, jobs, denoiser):
        super().__init__(program, "denoised", jobs)
        self.denoise, self.version = denoiser

    def key(self, task, reference):
        return {**super().key(task, reference), "denoiser": self.version, "rays": [PRIMARY_RAYS, PRIMARY_SAMPLER], "ways": list(WAYS)}

    def measure(self, task, reference):
        """(rows with measures named WAY:MEASURE, no images)."""
        primary = dataclasses.replace(task.view, lights=(*task.view.lights, "--max-depth", "0"))  # paths that end at the first surface
        whole, lamps = (layers_of(self.program, view, task.label, task.seed, task.counts) for view in (task.view, primary))
        rays = layers_of(self.program, primary, PRIMARY_SAMPLER, PRIMARY_SEED + task.seed, (PRIMARY_RAYS,))[PRIMARY_RAYS]
        return [{"spp": spp, **{
            f"{way}:{name}": error for way in WAYS
            for name, error in errors(denoised(self.denoise, way, layers, lamps[spp][..., :3], rays), reference.picture, reference.exposure,
                                      way in FLIP_WAYS and spp in FLIP_COUNTS).items()}} for spp, layers in whole.items()], {}


# ---- The report

COUNTS = (1, 2, 4, 8, 16)
LABELS = ("white", "sobol", "sobol-global", "zorder", "blue")


class Report(renders.Report):
    """The tables of the page. cells: judge.Cells with measures WAY:MEASURE."""

    def gain(self, measure, views=None):
        """{count: Estimate of blue's error over padded Sobol's, with the inputs `plain`}."""
        return self.found("blue", f"plain:{measure}", views)

    def scenes(self):
        """The Estimates of each scene at each count. With a single crop and seed, an interval has no width."""
        return [own for views in self.compared.by_scene().values() for own in self.gain("displayed", views).values() if own.crops > 1]

    def way_table(self, measure):
        """The errors of the other WAYS relative to `plain`, for the same sampler."""
        def over_plain(label, way):
            def of(spp):
                pairs = {view: [self.compared.cells.get(view, label, spp, f"{name}:{measure}") for name in (way, "plain")] for view in self.compared.views}
                return estimate({view: np.log(own) - np.log(plain) for view, (own, plain) in pairs.items() if own and plain and min(*own, *plain) > 0})

            return of

        return compare.table("error over that of `plain`", self.counts, {f"{label}, `{way}`": over_plain(label, way) for label in ("sobol", "blue")
                                                                       for way in ("colour", "primary", "apart")})

    def rows(self):
        return self.compared.rows(self.counts, [f"{way}:{name}" for way in WAYS for name in MEASURES], ("plain:displayed", "plain:displayed_2.1"))

    def plot(self, path):
        figure, axes = plt.subplots(1, len(DENOISED), figsize=(3.4 * len(DENOISED), 3.6), sharey=True)
        for axis, way in zip(axes, DENOISED):
            self.draw(axis, f"{way}:displayed", way)
        axes[0].set_ylabel("error over padded Sobol'")
        axes[-1].legend(fontsize="small", loc="center left", bbox_to_anchor=(1.02, 0.5))
        save(figure, path)


def with_own_errors(reference):
    """A judge.Reference whose own errors are named like the measures after denoising."""
    own = own_errors(reference.picture, reference.first_half, reference.exposure, errors)
    return dataclasses.replace(reference, own={f"{way}:{name}": error for way in WAYS for name, error in own.items()})


def run(arguments):
    options = views.parse_options("denoise", __doc__, arguments, COUNTS, choose=False, samplers=LABELS)
    work = DenoisedRun(options.pathtracer, options.jobs, load())
    references = render_references(options.pathtracer, options.chosen, options.reference_spp)
    tasks = plan(options.chosen, options.labels, options.counts, options.seeds)
    cells = Cells(work.results(references, tasks))
    report = Report(options, cells, {view: with_own_errors(own) for view, own in references.items()})
    report.plot(options.out / "denoise.png")
    compare.write(options.out / "denoise.csv", report.rows())
    write_page(options.out / "denoise.md", globals(), report=report, options=options, version=work.version)
