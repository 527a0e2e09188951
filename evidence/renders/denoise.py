# SPDX-License-Identifier: Apache-2.0
"""Compares the samplers after denoising: `scripts/bench denoise` writes evidence/results/denoise.*

Renders the views with white, sobol, blue and the peers in the build at 1 to 16 samples per pixel, denoises each picture in
three ways with Open Image Denoise (the optional package pyoidn), and measures the remaining error against the references
of `scripts/bench renders`. Results are cached in ~/.cache/libbn, so an interrupted run resumes.
"""

import dataclasses
import importlib.metadata
import threading

import numpy as np
import OpenEXR

from ..base import peers
from ..base.command import Parser, package
from ..base.files import write_text
from ..base.plots import finish, plt, save
from ..base.tables import md_table
from ..measure import equal_quality, gains
from ..measure.gains import BEST_PEER, Gains, gain_of
from ..measure.image_error import displayed_rmse, own_errors, relative_rmse, trimmed_relative_rmse
from . import variants, views
from .judge import Cells, Run, Task, pictures_of, plan, render_references
from .renders import REFERENCE_SPP

# What the denoiser is given.
WAYS = {
    "plain": "colour, albedo and normal of the same samples",
    "primary": "albedo and normal of additional primary rays, declared noise-free (`cleanAux`)",
    "apart": "as `primary`, with directly visible light added after denoising, from the same rays",
}
MEASURES = {"relative": "relative RMSE", "trimmed": "trimmed relative RMSE", "displayed": "RMSE as displayed, unblurred",
            "displayed_2.1": "RMSE as displayed, after sigma 2.1"}
PRIMARY_RAYS, PRIMARY_SAMPLER, PRIMARY_SEED = 16, "blue", 500_000

# All calls share one filter and its threads.
_LOCK = threading.Lock()


def load():
    """(denoise(colour, albedo, normal, clean), version)."""
    pyoidn = package("pyoidn", ".venv/bin/python -m pip install pyoidn")

    def denoise(colour, albedo, normal, clean):
        arrays = [np.ascontiguousarray(array, np.float32) for array in (np.maximum(colour, 0), np.clip(albedo, 0, 1), normal)]
        with _LOCK:
            return pyoidn.denoise(arrays[0], albedo=arrays[1], normal=arrays[2], hdr=True, clean_aux=clean)

    return denoise, importlib.metadata.version("pyoidn")


# ---- Pictures with their layers

def read_layers(path):
    """(float32 array (height, width, 9), attributes): colour, albedo and normal of a path-traced picture."""
    names = [*"RGB", *(f"albedo.{c}" for c in "RGB"), *(f"normal.{c}" for c in "XYZ")]
    with OpenEXR.File(str(path), separate_channels=True) as file:
        channels = file.channels()
        return np.stack([channels[name].pixels.astype(np.float32) for name in names], -1), dict(file.header())


@dataclasses.dataclass(frozen=True)
class Layers:
    """The input of the denoiser; lamps is the directly visible light in its colour."""

    colour: np.ndarray
    albedo: np.ndarray
    normal: np.ndarray
    lamps: np.ndarray


def layers_of(program, view, sampler, seed, counts):
    """{count: Layers}."""
    seen, whole = ({spp: picture for spp, picture, _ in pictures_of(program, Task(own, sampler, seed, counts), read_layers)}
                   for own in (primary(view), view))
    return {spp: Layers(whole[spp][..., :3], whole[spp][..., 3:6], whole[spp][..., 6:], seen[spp][..., :3]) for spp in counts}


def primary(view):
    """The view without what lies behind the first surface."""
    return dataclasses.replace(view, lights=(*view.lights, "--max-depth", "0"))


def primary_rays(program, view, seed):
    """Layers from additional primary rays: directly visible light, albedo and normal."""
    task = Task(primary(view), PRIMARY_SAMPLER, PRIMARY_SEED + seed, (PRIMARY_RAYS,))
    (_, picture, _), = pictures_of(program, task, read_layers)
    return Layers(picture[..., :3], picture[..., 3:6], picture[..., 6:], picture[..., :3])


def denoised(denoise, way, picture, rays):
    if way == "plain":
        return denoise(picture.colour, picture.albedo, picture.normal, False)
    if way == "primary":
        return denoise(picture.colour, rays.albedo, rays.normal, True)
    return denoise(picture.colour - picture.lamps, rays.albedo, rays.normal, True) + rays.lamps


# ---- Measures

def errors(image, reference, exposure):
    """{measure: error} for all MEASURES."""
    reference = np.maximum(reference, 0)
    return {"relative": relative_rmse(image, reference), "trimmed": trimmed_relative_rmse(image, reference),
            **{f"displayed_{sigma}" if sigma else "displayed": displayed_rmse(image, reference, exposure, sigma)
               for sigma in (0.0, 2.1)}}


class DenoisedRun(Run):
    """A judge.Run that measures pictures after denoising, in all WAYS."""

    def __init__(self, program, most_spp, jobs, denoiser):
        super().__init__(program, "denoised", most_spp, jobs)
        self.denoise, self.version = denoiser

    def key(self, task, reference):
        return {**super().key(task, reference), "denoiser": self.version, "rays": [PRIMARY_RAYS, PRIMARY_SAMPLER],
                "primary": self.builds.key(task.view, PRIMARY_SAMPLER), **({"told": True} if task.label in variants.DECLARED else {})}

    def measure(self, task, reference):
        """(rows with measures named WAY:MEASURE, no pictures)."""
        pictures = layers_of(self.program, task.view, task.label, task.seed, task.counts)
        rays = primary_rays(self.program, task.view, task.seed)
        return [{"spp": spp, **{
            f"{way}:{name}": error for way in WAYS
            for name, error in errors(denoised(self.denoise, way, picture, rays), reference.picture, reference.exposure).items()}}
            for spp, picture in pictures.items()], {}


# ---- The report

COUNTS, SEEDS = (1, 2, 4, 8, 16), 4
LABELS = ("white", "sobol", "sobol-global", "zorder", "blue")
SHOWN = ("relative", "displayed")
TIME_MEASURE = f"plain:{equal_quality.MEASURE}"


class Report:
    """cells: judge.Cells with measures WAY:MEASURE; costs: of equal_quality.costs(), or None."""

    def __init__(self, options, cells, references, version, costs=None):
        self.options, self.cells, self.references = options, cells, references
        self.version, self.costs, self.counts, self.labels = version, costs, options.counts, options.labels
        self.scenes = tuple(dict.fromkeys(view.scene for view in references))
        self.gains = Gains(cells, references, options.labels)

    def gain(self, way, measure, than="sobol", scene=None, label="blue"):
        """function(count) -> Gain over all scenes or one; None if nothing was measured."""
        views = tuple(view for view in self.references if scene in (None, view.scene))
        return lambda spp: self.gains.gain(label, spp, f"{way}:{measure}", than, views)

    def of_way(self, way, measure, label):
        """function(count) -> Gain: how many times smaller the error is than with `plain`, for the same sampler."""
        def gain(spp):
            pairs = {view: [self.cells.get(view, label, spp, f"{name}:{measure}") for name in ("plain", way)] for view in self.references}
            return gain_of({view: np.log(plain) - np.log(own) for view, (plain, own) in pairs.items() if plain and own and min(*plain, *own) > 0})

        return gain

    def rows(self):
        times = equal_quality.rows(self.gains, self.costs, self.counts, TIME_MEASURE) if self.costs else []
        return [*self.gains.rows(self.counts, [f"{way}:{name}" for way in WAYS for name in MEASURES]), *times]

    def short(self, measure):
        """What the denoiser leaves of the advantage, in a paragraph."""
        parts = []
        for than in ("white", "sobol", "sobol-global", "zorder", *([BEST_PEER] if self.gains.peers else [])):
            found = [gain for spp in self.counts if (gain := self.gain("plain", measure, than)(spp))]
            parts.append(f"{' '.join(f'{gain.value:.2f}' for gain in found)} with {than if than == BEST_PEER else f'`{than}`'}")
        counted = ", ".join(str(gain.views) if (gain := self.gain("plain", measure)(spp)) else "0" for spp in self.counts)
        cells = [gain for way in WAYS for scene in self.scenes for spp in self.counts if (gain := self.gain(way, measure, "sobol", scene)(spp))]
        return (f"After Open Image Denoise (`plain`), {MEASURES[measure]}, at {', '.join(map(str, self.counts))} samples, in {counted} of "
                f"{len(self.references)} crops, errors over that of `blue` are {'; '.join(parts)}. By scene, count and way `sobol` errs more beyond "
                f"doubt in {sum(gain.low > 1 for gain in cells)} cases and less in {sum(gain.high < 1 for gain in cells)}.")

    def text(self):
        options, counts = self.options, self.counts
        parts = [
            "# After denoising", "", f"Printed by `{options.command}` with Open Image Denoise (pyoidn {self.version}).", "",
            self.short("displayed"), "", self.short("displayed_2.1"), "", "![sobol / blue after the denoiser](denoise.png)", "",
            f"{len(self.references)} crops of {len(self.scenes)} built-in scenes (the set *{options.views}*, {views.SETS[options.views]}), "
            f"{options.seeds} seed{'s' * (options.seeds > 1)} of each, against references with {options.reference_spp} samples per pixel. Crops are "
            "denoised by themselves. Ratios are geometric means over scenes, pictures, crops and seeds, with "
            "the 95 % interval of a bootstrap over all four. Relative RMSE divides the difference by the reference plus a tenth of its mean. A "
            "view is excluded from ratios for which its reference is too noisy. `zorder` is told each count."
            + (f" OpenQMC's commit is {peers.commit(options.openqmc)}." if self.gains.peers else ""), "",
            "The denoiser is used in three ways:", "", *(f"- `{way}`: {what}." for way, what in WAYS.items()), "",
            f"Keep directly visible light (lamps, the sky) out of the denoiser: denoise the rest and add that light afterwards, from {PRIMARY_RAYS} "
            "primary rays, which end at the first surface. Take albedo and normal from the same rays and declare them noise-free. What that gains:", ""]
        for measure in SHOWN:
            parts += [gains.table(MEASURES[measure], counts, {f"{label}, `plain` / `{way}`": self.of_way(way, measure, label)
                                                              for label in ("sobol", "blue") for way in list(WAYS)[1:]}), ""]
        if self.costs:
            parts += ["## Time to reach an error", "", "As in [renders.md](renders.md), for pictures from the denoiser (`plain`), without "
                      "its own time, which is the same for all.", "",
                      md_table(*equal_quality.table_rows(self.gains, self.costs, counts, TIME_MEASURE)), ""]
        parts += ["## Every scene", ""]
        for way in WAYS:
            for measure in SHOWN:
                rows = {scene: self.gain(way, measure, "sobol", scene) for scene in self.scenes}
                parts += [f"### `{way}`, {MEASURES[measure]}", "", gains.table("sobol / blue", counts, {**rows, "**all**": self.gain(way, measure)}), ""]
        parts += ["## All samplers", ""]
        for way in WAYS:
            for measure, name in MEASURES.items():
                rows = {label: self.gain(way, measure, "white", None, label) for label in self.labels if label != "white"}
                if self.gains.peers:
                    rows[f"{BEST_PEER} / blue"] = self.gain(way, measure, BEST_PEER)
                parts += [f"### `{way}`, {name}", "", gains.table("white / sampler", counts, rows), ""]
        return "\n".join(parts)

    def draw(self, path):
        figure, axes = plt.subplots(1, len(WAYS), figsize=(4 * len(WAYS), 3.6), sharey=True)
        for axis, way in zip(axes, WAYS):
            for scene in (*self.scenes, None):
                found = {spp: gain for spp in self.counts if (gain := self.gain(way, "relative", "sobol", scene)(spp))}
                axis.plot(list(found), [gain.value for gain in found.values()], marker="o", markersize=4, label=scene or "all",
                          **({"color": "black", "linewidth": 2.2} if scene is None else {"linewidth": 1.2}))
            axis.axhline(1, color="0.5", linewidth=.8)
            finish(axis, way, "samples per pixel")
        axes[0].set_ylabel("relative RMSE, sobol / blue")
        axes[-1].legend(fontsize="small", loc="center left", bbox_to_anchor=(1.02, 0.5))
        save(figure, path)


def parse_options(arguments):
    parser = Parser("denoise", __doc__)
    views.add_options(parser, REFERENCE_SPP, "out/denoise")
    parser.number("--spp", max(COUNTS), "largest sample count, at most 16")
    options = parser.parse_args(arguments)
    options.samplers, options.chosen = LABELS, views.of(parser, options)
    views.finish_options(parser, options, "denoise", arguments)
    options.seeds = options.seeds or SEEDS
    options.counts = tuple(spp for spp in COUNTS if spp <= options.spp)
    return options


def with_own_errors(reference):
    """A judge.Reference whose own errors carry the names of the denoised measures."""
    own = own_errors(reference.picture, reference.first_half, reference.exposure, errors)
    return dataclasses.replace(reference, own={f"{way}:{name}": error for way in WAYS for name, error in own.items()})


def run(arguments):
    options = parse_options(arguments)
    work = DenoisedRun(options.pathtracer, max(options.counts), options.jobs, load())
    references = render_references(options.pathtracer, options.chosen, options.reference_spp)
    tasks = plan(options.chosen, options.labels, {spp: options.seeds for spp in options.counts})
    cells = Cells(work.results(references, tasks))
    cost = None if options.no_times else equal_quality.costs(
        options.pathtracer, work.store, views.first_of_each(options.chosen), options.labels, equal_quality.machine(), work.builds, options.retime)
    report = Report(options, cells, {view: with_own_errors(own) for view, own in references.items()}, work.version, cost)
    report.draw(options.out / "denoise.png")
    gains.write_rows(options.out / "denoise.csv", report.rows())
    text = report.text()
    write_text(options.out / "denoise.md", text)
    print(text)
