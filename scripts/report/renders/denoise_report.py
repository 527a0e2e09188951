# SPDX-License-Identifier: Apache-2.0
"""The results of `scripts/bench denoise`: tables, conclusions, a plot and a contact sheet."""

import statistics

import numpy as np

from ..base import peers
from ..base.tables import md_table
from ..measure import equal_quality
from ..measure.gains import BEST_PEER, Gains, gain_of
from .denoiser import FLIP_SEEDS, MEASURES, PRIMARY_RAYS, WAYS, WORST_SHARE
from .views import EXPOSURES, SETS

MEASURE_NAMES = {"relative": "relative RMSE", "trimmed": "trimmed relative RMSE", "displayed": "RMSE as displayed, unblurred",
                 "displayed_2.1": "RMSE as displayed, after sigma 2.1", "flip": "mean FLIP"}
TIME_MEASURE = f"plain:{equal_quality.MEASURE}"
SHEET_SCENES, SHEET_SIDE = ("cornell", "lens", "glossy"), 120  # pixels


class Report:
    """cells: judge.Cells with measures WAY:MEASURE."""

    def __init__(self, options, cells, references, pictures, version, costs=None):
        self.options, self.cells, self.references, self.pictures = options, cells, references, pictures
        self.version, self.costs = version, costs
        self.counts, self.labels = options.counts, options.labels
        self.scenes = tuple(dict.fromkeys(view.scene for view in references))
        self.gains = Gains(cells, references, options.labels)

    # ---- Gains

    def gain(self, way, spp, measure, than="sobol", scene=None, label="blue"):
        """A Gain over all scenes or one; None if nothing was measured."""
        return self.gains.gain(label, spp, f"{way}:{measure}", than, tuple(view for view in self.references if scene in (None, view.scene)))

    def of_way(self, way, spp, measure, label="blue"):
        """How many times smaller the error is than with `plain`, for the same sampler."""
        found = {}
        for view in self.references:
            plain, own = (self.cells.get(view, label, spp, f"{name}:{measure}") for name in ("plain", way))
            if plain and own and min(*plain, *own) > 0:
                found[view] = np.log(plain) - np.log(own)
        return gain_of(found)

    def measures(self, way):
        """The measures that have results."""
        return [name for name in (*MEASURES, "flip") if self.gain(way, self.counts[0], name)]

    def rows(self):
        times = equal_quality.rows(self.gains, self.costs, self.counts, TIME_MEASURE) if self.costs else []
        return [*self.gains.rows(self.counts, [f"{way}:{name}" for way in WAYS for name in (*MEASURES, "flip")]), *times]

    # ---- Tables

    def scene_table(self, way, measure):
        rows = []
        for scene in (*self.scenes, None):
            found = [self.gain(way, spp, measure, "sobol", scene) for spp in self.counts]
            texts = [gain.text() if gain else "" for gain in found]
            rows.append([scene, *texts] if scene else ["**all**", *(f"**{text}**" if text else "" for text in texts)])
        return md_table(["sobol / blue", *map(str, self.counts)], rows)

    def samplers_table(self, way, measure):
        rows = []
        for label in self.labels:
            if label != "white":
                found = [self.gain(way, spp, measure, "white", None, label) for spp in self.counts]
                rows.append([label, *(gain.text() if gain else "" for gain in found)])
        if self.gains.peers:
            found = [self.gain(way, spp, measure, BEST_PEER) for spp in self.counts]
            rows.append([f"{BEST_PEER} / blue", *(gain.text() if gain else "" for gain in found)])
        return md_table(["white / sampler", *map(str, self.counts)], rows)

    def ways_table(self, measure):
        rows = []
        for label in ("sobol", "blue"):
            for way in list(WAYS)[1:]:
                found = [self.of_way(way, spp, measure, label) for spp in self.counts]
                if any(found):
                    rows.append([f"{label}, `plain` / `{way}`", *(gain.text() if gain else "" for gain in found)])
        return md_table([MEASURE_NAMES[measure], *map(str, self.counts)], rows)

    def worst_table(self):
        rows = []
        for scene in self.scenes:
            row = [scene]
            for label in ("sobol", "blue"):
                for spp in self.counts[:2]:
                    shares = [share for view in self.references if view.scene == scene
                              for share in self.cells.get(view, label, spp, "plain:worst") or ()]
                    row.append(f"{100 * statistics.mean(shares):.0f} %" if shares else "")
            rows.append(row)
        return md_table(["scene", *(f"{label}, {spp} spp" for label in ("sobol", "blue") for spp in self.counts[:2])], rows)

    # ---- Conclusions

    def cells_apart_from_one(self, way, measure):
        """(better, worse): [(scene, spp, Gain)] whose interval lies entirely on one side of 1."""
        better, worse = [], []
        for scene in self.scenes:
            for spp in self.counts:
                gain = self.gain(way, spp, measure, "sobol", scene)
                if gain and gain.low > 1:
                    better.append((scene, spp, gain))
                elif gain and gain.high < 1:
                    worse.append((scene, spp, gain))
        return better, worse

    def verdicts(self):
        lines = []
        for way in WAYS:
            for measure in ("relative", "displayed", "flip"):
                if measure not in self.measures(way):
                    continue
                better, worse = self.cells_apart_from_one(way, measure)
                cell_count = sum(1 for scene in self.scenes for spp in self.counts if self.gain(way, spp, measure, "sobol", scene))
                mean = ", ".join(f"{gain.value:.2f}" for spp in self.counts if (gain := self.gain(way, spp, measure)))
                where = ": " + ", ".join(f"{scene} at {spp} ({gain.text()})" for scene, spp, gain in worse) if worse else ""
                lines.append(f"- `{way}`, {MEASURE_NAMES[measure]}: sobol / blue {mean} at {', '.join(map(str, self.counts))} "
                             f"samples. Out of {cell_count} combinations of scene and sample count, blue is better in "
                             f"{len(better)} and worse in {len(worse)}{where}.")
        return "\n".join(lines)

    # ---- Text

    def short(self):
        """What the denoiser leaves of the advantage: a paragraph each for single pixels and after the blur."""
        return "\n\n".join(self.short_of(measure) for measure in ("displayed", "displayed_2.1"))

    def short_of(self, measure):
        counts, parts = ", ".join(map(str, self.counts)), []
        for than in ("white", "sobol", "zorder", BEST_PEER):
            found = [gain for spp in self.counts if (gain := self.gain("plain", spp, measure, than))] if (
                than in self.labels or than == BEST_PEER and self.gains.peers) else []
            if found:
                parts.append(f"{' '.join(f'{gain.value:.2f}' for gain in found)} times less than {than if than == BEST_PEER else f'`{than}`'}")
        better, worse = self.cells_apart_from_one("plain", measure)
        return (f"After Open Image Denoise, {MEASURE_NAMES[measure]}, at {counts} samples: the error of `blue` is {'; '.join(parts)}. Against "
                f"`sobol`, by scene and count, it is smaller beyond doubt in {len(better)} cases and larger in {len(worse)}.")

    def text(self):
        options = self.options
        seeds = f"{options.seeds} seed{'s' if options.seeds > 1 else ''}"
        per_path = {scene: statistics.mean(value for view in self.references if view.scene == scene
                                           for value in self.cells.get(view, "sobol", self.counts[-1], "rays"))
                    for scene in self.scenes}
        cost = ", ".join(f"{scene} {PRIMARY_RAYS / rays:.1f}" for scene, rays in per_path.items())
        parts = [
            "# After denoising", "", f"Printed by `{options.command}` with Open Image Denoise (pyoidn {self.version}).", "",
            self.short(), "", "![sobol / blue after the denoiser](denoise.png)", "",
            f"{len(self.references)} crops of {len(self.scenes)} built-in "
            f"scenes (the set *{options.views}*, {SETS[options.views]}), {seeds} of each, against references with "
            f"{options.reference_spp} samples per pixel. Crops are denoised by themselves. Ratios say how many times smaller the error "
            "is: geometric means over scenes, pictures, crops and seeds, with the 95 % interval of a bootstrap over all four. "
            "Relative RMSE divides the difference by the reference plus a tenth of its mean. FLIP uses "
            f"{min(options.seeds, FLIP_SEEDS)} seeds. A view is excluded from ratios for which its reference is too noisy."
            + (f" OpenQMC's commit is {peers.commit(options.openqmc)}." if self.gains.peers else ""), "",
            "The denoiser is used in three ways:", "", *(f"- `{way}`: {what}." for way, what in WAYS.items()), "",
            "## Where blue noise helps and where it hurts", "", self.verdicts(), "",
            "A few pixels dominate the relative RMSE. This share of its square comes from the worst "
            f"{100 * WORST_SHARE:g} % of the pixels:", "",
            self.worst_table(), "",
            "## Recommendations", "",
            "Keep directly visible light (lamps, the sky) out of the denoiser: denoise the rest and add that light afterwards, from "
            "a few additional primary rays. Take albedo and normal from the same rays and declare them noise-free. If visible "
            "lamps cannot be separated, consult the tables: where blue is worse at 1 and 2 samples per pixel, `sobol` is the "
            "better choice.", "",
            f"The {PRIMARY_RAYS} primary rays end at the first surface and are traced once per picture, not once per sample. They "
            f"cost as many rays as this many samples of full paths: {cost}. So at low sample counts, also compare `apart` with "
            "`plain` at the next larger count.", ""]
        for measure in ("relative", "displayed", "flip"):
            if measure in self.measures("plain"):
                parts += [self.ways_table(measure), ""]
        if self.costs:
            parts += ["## Time to reach an error", "", "As in [renders.md](renders.md), for pictures from the denoiser (`plain`), without "
                      "its own time, which is the same for all.", "",
                      md_table(*equal_quality.table_rows(self.gains, self.costs, self.counts, TIME_MEASURE)), ""]
        parts += ["## Every scene", ""]
        for way in WAYS:
            for measure in ("relative", "displayed", "flip"):
                if measure in self.measures(way):
                    parts += [f"### `{way}`, {MEASURE_NAMES[measure]}", "", self.scene_table(way, measure), ""]
        parts += ["## All samplers", ""]
        for way in WAYS:
            for measure in self.measures(way):
                parts += [f"### `{way}`, {MEASURE_NAMES[measure]}", "", self.samplers_table(way, measure), ""]
        return "\n".join(parts)

    # ---- Pictures

    def draw(self, folder, pages):
        from ..base.plots import finish, plt, save

        figure, axes = plt.subplots(1, len(WAYS), figsize=(4 * len(WAYS), 3.6), sharey=True)
        for axis, way in zip(axes, WAYS):
            for scene in (*self.scenes, None):
                found = {spp: gain for spp in self.counts if (gain := self.gain(way, spp, "relative", "sobol", scene))}
                if found:
                    axis.plot(list(found), [gain.value for gain in found.values()], marker="o", markersize=4, label=scene or "all",
                              **({"color": "black", "linewidth": 2.2} if scene is None else {"linewidth": 1.2}))
            axis.axhline(1, color="0.5", linewidth=.8)
            finish(axis, way, "samples per pixel")
        axes[0].set_ylabel("relative RMSE, sobol / blue")
        axes[-1].legend(fontsize="small", loc="center left", bbox_to_anchor=(1.02, 0.5))
        save(figure, folder / "denoise.png")
        self.draw_sheet(pages / "denoise_pictures.png")

    def draw_sheet(self, path):
        """The first view of some scenes at one sample per pixel: noisy, denoised, and denoised with lamps apart."""
        from ..base.contact_sheet import preview, sheet
        from ..base.files import write_image

        columns = (("blue", "1 noisy"), ("sobol", "1 plain"), ("blue", "1 plain"), ("sobol", "1 apart"), ("blue", "1 apart"), None)
        rows, names = [], []
        for scene in SHEET_SCENES:
            view = next((view for view in self.references if view.scene == scene), None)
            if view is None:
                continue
            row = []
            for column in columns:
                picture = self.references[view].picture if column is None else self.pictures[view, *column]
                row.append([part(preview(picture, EXPOSURES.get(scene, 0.0)))])
            rows.append(row)
            names.append(scene)
        if rows:
            heads = ["blue, 1 spp", "sobol, plain", "blue, plain", "sobol, apart", "blue, apart", "reference"]
            # A palette with dithering: a third of the size of full colour, and no bands in smooth light.
            whole = sheet(rows, names, heads).convert("RGB")
            write_image(path, whole.quantize(palette=whole.quantize(256)))


def part(image, side=SHEET_SIDE):
    """The upper middle of a picture, where the box's lamp is, scaled to one size without resampling."""
    side_x, side_y = min(side, image.width), min(side, image.height)
    left, top = (image.width - side_x) // 2, (image.height - side_y) // 4
    image = image.crop((left, top, left + side_x, top + side_y))
    return image.resize((side, side), 0) if image.size != (side, side) else image
