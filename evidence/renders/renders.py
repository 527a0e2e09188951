# SPDX-License-Identifier: Apache-2.0
"""Compares the samplers on rendered scenes: `scripts/bench renders` writes evidence/results/renders.*

Renders crops of large pictures of every built-in scene with every sampler at 1 to 64 samples per pixel and 12 seeds,
measures each against a reference, and measures the cost of a sample. Writes renders.md with its plot and
renders_headline.csv to evidence/results, and renders.csv to out/renders. With `--views` other than held-out everything goes to a folder of
out/renders named after the set, with `--quick` (small crops, 4 seeds) to quick, with `--lights coin` to coin. References and results are
cached in ~/.cache/libbn ($XDG_CACHE_HOME): an interrupted run resumes, and a change to one sampler renders only that one again.
"""

import dataclasses
import functools
import math
import statistics

import numpy as np

from ..base import peers
from ..base.command import Parser
from ..base.files import write_text
from ..base.plots import finish, plt, save, style
from ..base.progress import Progress
from ..base.tables import md_table
from ..measure import equal_quality, gains, ratios
from ..measure.gains import BEST_PEER, HEADLINE_MEASURES, REFERENCE_MARGIN, VISIBLE, Gains, value_text
from ..measure.image_error import MEASURES, WHAT_FOR, measure_name
from ..measure.ratios import worse_cells
from . import variants, views
from .judge import SEEDS, SPECTRUM_COUNTS, Cells, Run, plan, render_references, seeds_up_to
from .variants import SIDE_SEEDS
from .views import SETS, SHOWN

LOSS_MEASURES = tuple(name for name in MEASURES if name.startswith("rmse"))
TABLE_MEASURES = ("displayed_2.1", "displayed_1.0", "displayed", "rmse_2.1", "rmse_1.0", "rmse", "trimmed_2.1")
SPREAD_COUNTS = (1, 4, 16, 64)
# Rings of judge's spectra, 1/64 cycles per pixel wide.
BANDS = {"below 1/32": slice(0, 2), "1/32 to 1/16": slice(2, 4), "1/16 to 1/8": slice(4, 8), "1/8 to 1/2": slice(8, 32)}
MOST_LISTED = 20


class Report:
    """options: of renders.parse_options(); cells: judge.Cells; references: {view: judge.Reference}; costs, shares: of
    equal_quality.costs() and sampling_shares(), measured on a machine, or None."""

    def __init__(self, options, cells, references, costs=None, shares=None, machine=""):
        self.options, self.cells, self.references = options, cells, references
        self.costs, self.shares, self.machine = costs, shares, machine
        self.views, self.labels, self.counts = tuple(references), options.labels, tuple(options.seeds)
        self.scenes = tuple(dict.fromkeys(view.scene for view in self.views))
        self.gains = Gains(cells, references, self.labels)

    def headline_rows(self):
        times = equal_quality.rows(self.gains, self.costs, self.counts) if self.costs else []
        return [*self.gains.rows(self.counts, MEASURES), *times]

    # ---- Gains

    def gain_table(self, measure):
        """One row per sample count: the error of each other sampler over that of blue, with intervals."""
        thans, rows = self.gains.thans(), []
        for spp in self.counts:
            found = [self.gains.gain("blue", spp, measure, than) for than in thans]
            if any(found):
                rows.append([str(spp), *(gain.text() if gain else "" for gain in found)])
        return md_table(["spp", *thans], rows)

    def samplers_table(self, measure):
        return gains.table("white / sampler", self.counts, {
            label: lambda spp, label=label: self.gains.gain(label, spp, measure, "white") for label in self.labels if label != "white"}, value_text)

    def spread(self, scene, spp, measure, than):
        """[gain of blue in each crop of a scene]: geometric means over seeds."""
        views = [view for view in self.views if view.scene == scene and self.cells.get(view, "blue", spp, measure)]
        logs = [self.gains.logs(view, "blue", spp, measure, than) for view in views if self.gains.is_judged(view, "blue", spp, measure)]
        return [math.exp(np.mean(own)) for own in logs if own is not None]

    def spread_table(self, than, measure):
        counts = [spp for spp in SPREAD_COUNTS if spp in self.counts]
        return md_table([f"{than} / blue", *map(str, counts)], [
            [scene, *(f"{statistics.geometric_mean(found):.2f} ({min(found):.2f} to {max(found):.2f})" if found else ""
                      for found in (self.spread(scene, spp, measure, than) for spp in counts))] for scene in self.scenes])

    # ---- The answer

    def short(self):
        """Three sentences: how much less noise, where most and least, and what the tests of the pictures found."""
        found = {than: [gain.value for spp in self.counts if (gain := self.gains.gain("blue", spp, HEADLINE_MEASURES[0], than))]
                 for than in self.gains.thans()}
        ends = [f"{min(values):.2f} to {max(values):.2f} with {than if than == BEST_PEER else f'`{than}`'}" for than, values in found.items() if values]
        parts = [f"As displayed, after a blur of 2.1 pixels, errors over that of `blue`, the smallest and the largest over the "
                 f"sample counts from {min(self.counts)} to {max(self.counts)}, are {', '.join(ends)}."]
        least = {scene: statistics.geometric_mean(own) for scene in self.scenes
                 if (own := self.spread(scene, max(self.counts), HEADLINE_MEASURES[0], "sobol"))}
        if len(least) > 1:
            order = sorted(least, key=least.get)
            parts.append(f"Over `sobol` at {max(self.counts)} samples it gains most in `{order[-1]}` ({least[order[-1]]:.2f}) and least in "
                         f"`{order[0]}` ({least[order[0]]:.2f}).")
        if self.losses and self.biases:
            certain, _ = worse_cells(self.losses)
            biased = ratios.biased(self.biases)
            unblurred = sum(measure == "rmse" for *_, measure in certain)
            where = f", {unblurred} of them in single pixels, without a blur" if certain else ""
            parts.append(f"Of {len(self.losses)} tests for a loss to `sobol` {len(certain) or 'none'} found one{where}; of {len(self.biases)} "
                         f"for a bias {len(biased) or 'none'} did.")
        return " ".join(parts)

    # ---- Tests, which need more than one seed

    @functools.cached_property
    def losses(self):
        """{(scene, spp, measure): Ratio} of sobol's error to blue's."""
        return ratios.against_sobol(self.cells, self.views, self.counts, LOSS_MEASURES) if max(self.options.seeds.values()) > 1 else {}

    @functools.cached_property
    def biases(self):
        """{(scene, label): Ratio} of means to those of the references, at the largest count, where they vary least."""
        return ratios.biases(self.cells, self.references, self.labels, max(self.counts))

    def worse_text(self):
        cells = self.losses
        certain, suspected = worse_cells(cells)
        smallest = {at: ratios.smallest_loss(cell, len(cells)) for at, cell in cells.items()}
        parts = [f"A cell is the RMSE of `blue` against `sobol` in all crops and seeds of one scene, or of all scenes, at one sample count and blur: "
                 f"{len(cells)} cells. A cell is *worse* if a one-sided t-test with Holm's correction finds its ratio below 1; the "
                 f"probability of any false alarm is {100 * ratios.FALSE_ALARMS:g} %. It is *suspected* if only its own 95 % interval lies "
                 f"below 1; about {len(cells) * 0.025:.0f} would be by chance.", "",
                 f"{len(certain) or 'No'} cell{'s are' if len(certain) > 1 else ' is'} worse, {len(suspected)} suspected"
                 + (f"; the first {MOST_LISTED} are listed." if len(certain) + len(suspected) > MOST_LISTED else "."), ""]
        listed = ([(at, "worse") for at in certain] + [(at, "suspected") for at in suspected])[:MOST_LISTED]
        if listed:
            parts += [md_table(["scene", "spp", "measure", "sobol / blue", "95 % interval", ""], [
                [scene, str(spp), measure_name(measure), f"{cells[scene, spp, measure].value:.3f}",
                 f"{cells[scene, spp, measure].low:.3f} to {cells[scene, spp, measure].high:.3f}", what]
                for (scene, spp, measure), what in listed]), ""]
        rows = [[scene, *(" to ".join(f"{100 * end(smallest[at] for at in smallest if at[:2] == (scene, spp)):.1f}"
                                      for end in (min, max)) if (scene, spp, "rmse") in cells else "" for spp in self.counts)]
                for scene in dict.fromkeys(scene for scene, *_ in cells)]
        return "\n".join([*parts, "The smallest loss, in percent of the error, that the test finds with a probability of "
                          f"{100 * ratios.POWER:g} % (smallest and largest over the blurs):", "",
                          md_table(["loss, %", *map(str, self.counts)], rows)])

    def bias_text(self):
        cells, found = self.biases, ratios.biased(self.biases)

        def text(at):
            return f"{100 * (cells[at].value - 1):+.2f} ({100 * ratios.smallest_bias(cells[at], len(cells)):.2f})" if at in cells else ""

        rows = [[scene, *(text((scene, label)) for label in self.labels)] for scene in dict.fromkeys(scene for scene, _ in cells)]
        return (f"How far the mean luminance of the pictures with {max(self.counts)} samples per pixel is from that of the references, in percent, over "
                "all crops and seeds of a scene; in parentheses the smallest difference that a two-sided t-test finds with a "
                f"probability of {100 * ratios.POWER:g} %. If all samplers are unbiased, the probability that any of the "
                f"{len(cells)} cells is called biased is at most {100 * ratios.FALSE_ALARMS:g} %. "
                + ("Biased: " + ", ".join(f"{label} in {scene}" for scene, label in found) if found else "No cell is biased")
                + ".\n\n" + md_table(["difference, %", *self.labels], rows))

    def frequencies_text(self):
        """Errors by frequency, down to the mean, over white noise's."""
        def deviation(view, label, spp):
            return np.std(self.cells.get(view, label, spp, "mean"), ddof=1)

        def band(places):
            return lambda view, label, spp: math.sqrt(np.mean([own[places] for own in self.cells.get(view, label, spp, "spectrum")]))

        counts, rows = [spp for spp in SPECTRUM_COUNTS if spp in self.counts], []
        for name, amplitude in {"mean of the crop": deviation, **{name: band(places) for name, places in BANDS.items()}}.items():
            rows += [[name, label, *(f"{statistics.geometric_mean(amplitude(view, label, spp) / amplitude(view, 'white', spp) for view in self.gains.views):.2f}"
                                     for spp in counts)] for label in self.labels if label != "white"]
        return ("The amplitude of the error over that of white noise, geometric means over crops, by frequency in cycles per pixel. The first "
                "rows are the standard deviation of a crop's mean over seeds: how much it flickers where every frame has a key of its own.\n\n"
                + md_table(["frequency", "sampler", *map(str, counts)], rows))

    # ---- Times and references

    def times_text(self):
        if not self.costs:
            return "This run did not measure times (`--no-times`)."
        return (f"On {self.machine}: processor seconds for a million pixels until the error, {measure_name(equal_quality.MEASURE)}, is that of white "
                f"noise at {' and at '.join(map(str, equal_quality.TARGETS))} samples per pixel: geometric means over crops, with the 95 % interval "
                "of the bootstrap. The cost of a sample is measured in a crop of every scene, as a median of interleaved runs of one thread. "
                + "\n\n" + md_table(*equal_quality.table_rows(self.gains, self.costs, self.counts))
                + "\n\nThe share of `cornell`'s render time that is spent drawing samples, as the path tracer reports it (attribute `samplingShare`), one "
                f"thread, {equal_quality.SHARE_SPP} samples per pixel, median of {equal_quality.SHARE_ROUNDS}:\n\n"
                + md_table(["sampler", "share"], [[label, f"{100 * share:.1f} %"] for label, share in self.shares.items()]))

    def references_text(self):
        last, most = max(self.counts), []
        for measure in HEADLINE_MEASURES:
            shares = {view: own.own[measure] / statistics.mean(errors) for view, own in self.references.items()
                      if (errors := self.cells.get(view, "blue", last, measure)) and min(errors) > 0}
            view = max(shares, key=shares.get)
            most.append(f"{100 * shares[view]:.0f} % in `{view.label}` ({measure_name(measure)})")
        empty = [view.label for view in self.views if view not in self.gains.views]
        noisy = "; ".join(f"{measure_name(measure)} at {spp} spp: {', '.join(view.label for view in views)}"
                          for measure in HEADLINE_MEASURES for spp in self.counts if (views := self.gains.left_out(spp, measure)))
        return ("Half the difference between the two halves of each reference contributes to every figure, and makes gains at high sample counts "
                f"look smaller than they are. Of blue's error at {last} samples it is at most {' and '.join(most)}. Excluded from all figures, "
                f"because there is no noise to see: {', '.join(empty) or 'none'}. Excluded from the gains of blue, because the reference is too "
                f"noisy: {noisy or 'none'}.")

    def peers_text(self):
        if not self.gains.peers:
            return "This run does not include OpenQMC's samplers; `--openqmc DIR` adds them from a checkout."
        best = {measure: ", ".join(f"{self.gains.best_peer(spp, measure)} at {spp}" for spp in self.counts)
                for measure in HEADLINE_MEASURES}
        return (f"*{BEST_PEER}* is the one of its three samplers with the smallest geometric-mean error over the views that count at that sample "
                f"count: as displayed, {best['displayed_2.1']} samples per pixel; by RMSE, {best['rmse_2.1']}. OpenQMC's commit is "
                f"{peers.commit(self.options.openqmc)}.")

    def plot(self, path):
        """Error reduction of every sampler over white noise, as displayed and raw, with the interval of blue."""
        figure, axes = plt.subplots(1, len(HEADLINE_MEASURES), figsize=(12, 4.4), sharey=True)
        for axis, measure in zip(axes, HEADLINE_MEASURES):
            for label in self.labels:
                found = {spp: gain for spp in self.counts if (gain := self.gains.gain(label, spp, measure, "white"))}
                own = style(label, self.labels)
                axis.plot(list(found), [gain.value for gain in found.values()], **own)
                if label == "blue":
                    axis.fill_between(list(found), [gain.low for gain in found.values()],
                                      [gain.high for gain in found.values()], color=own["color"], alpha=.15, linewidth=0)
            finish(axis, measure_name(measure), "samples per pixel")
        axes[0].set_ylabel("error reduction over white (times)")
        axes[0].legend(fontsize="small")
        save(figure, path)

    # ---- Text

    def text(self):
        options = self.options
        sizes = " and ".join(f"{width}x{height}" for width, height in sorted({(view.width, view.height) for view in self.views}))
        seeds = max(options.seeds.values())
        parts = ["# Rendered scenes" + ("" if options.views == SHOWN else f": {options.views} views"), "", f"Printed by `{options.command}`.", "",
                 self.short(), "", "![Error reduction over white noise](renders_gain.png)", "",
                 f"{len(self.scenes)} built-in scenes of the example path tracer, in {len(self.views)} crops of "
                 f"{'x'.join(map(str, self.views[0].size))} pixels, out of pictures of {sizes} pixels: one in each quarter, placed by a hash before "
                 f"anything was rendered. The set of views is *{options.views}*, {SETS[options.views]}; no two sets share a camera or a crop. "
                 f"References have {options.reference_spp} samples per pixel (`sobol`, a different seed).", "",
                 f"Each figure comes from {seeds} seed{'s' if seeds > 1 else ''} (`mask`: at most {SIDE_SEEDS}). `blue`, `sobol`, `white`, `mask` "
                 "and OpenQMC's samplers render one progressive run, measured at each sample count; `zorder` renders each count separately, because "
                 "it must know the count. `sobol` is padded: its two pairs of dimensions are sequences of their own.", "",
                 "## Error reduction", "",
                 "Each number is the error of another sampler over that of `blue`: geometric means over scenes, pictures, crops and seeds, "
                 "with 95 % intervals of a bootstrap that resamples all four. A crop is excluded where blue's error is less than "
                 f"{REFERENCE_MARGIN:g} times the error of the reference itself, or "
                 f"where the error of white noise as displayed is below {VISIBLE:g} at one sample.", ""]
        for measure in HEADLINE_MEASURES:
            parts += [f"### blue, {measure_name(measure)}", "", self.gain_table(measure), ""]
        parts += [self.peers_text(), "",
                  "## The error measures", "", *(f"- {text}" for text in WHAT_FOR.values()), "",
                  "## Spread over views", "",
                  f"{measure_name(HEADLINE_MEASURES[0])}: the geometric mean over a scene's crops, followed by the smallest and the largest.", ""]
        for than in self.gains.thans():
            parts += [self.spread_table(than, HEADLINE_MEASURES[0]), ""]
        parts += ["## All samplers", "", "White noise's error divided by each sampler's, over all scenes and crops.", ""]
        for measure in TABLE_MEASURES:
            parts += [f"### {measure_name(measure)}", "", self.samplers_table(measure), ""]
        if self.gains.views and seeds > 1 and self.cells.get(self.gains.views[0], "white", 1, "spectrum"):
            parts += ["## Frequencies of the error", "", self.frequencies_text(), ""]
        none = "This test needs more than one seed."
        return "\n".join([*parts, "## Losses to sobol", "", self.worse_text() if self.losses else none, "",
                          "## Unbiased", "", self.bias_text() if self.biases else none, "",
                          "## Times", "", self.times_text(), "", "## The error of the references", "", self.references_text(), ""])


# ---- The command

REFERENCE_SPP, QUICK_SEEDS = 2048, 4


def parse_options(arguments):
    parser = Parser("renders", __doc__)
    views.add_options(parser, REFERENCE_SPP, "out/renders")
    variants.add_option(parser)
    parser.number("--spp", 64, "largest sample count, at most 64")
    parser.add_argument("--lights", choices=["coin"], help="one direction off each surface, by a coin, as many small renderers do")
    options = parser.parse_args(arguments)
    views.finish_options(parser, options, "renders", arguments)
    lights = ("--lights", options.lights) if options.lights else ()
    options.chosen = tuple(dataclasses.replace(view, lights=lights) for view in views.of(parser, options))
    options.seeds = seeds_up_to(options.spp, options.seeds or (QUICK_SEEDS if options.quick else SEEDS))
    return options


def run(arguments):
    options = parse_options(arguments)
    chosen = options.chosen
    work = Run(options.pathtracer, "renders", max(options.seeds), options.jobs)
    tasks = plan(chosen, options.labels, options.seeds)
    references = render_references(options.pathtracer, chosen, options.reference_spp)
    cells = Cells(work.results(references, tasks))
    machine = equal_quality.machine()
    cost = shares = None
    if not options.no_times:
        cost = equal_quality.costs(options.pathtracer, work.store, views.first_of_each(chosen), options.labels, machine, work.builds, options.retime)
        shares = equal_quality.sampling_shares(options.pathtracer, options.labels)
    report = Report(options, cells, references, cost, shares, machine)
    # Write the text last, after the files it refers to.
    report.plot(options.out / "renders_gain.png")
    cells.write_csv(options.pages / "renders.csv")
    gains.write_rows(options.out / "renders_headline.csv", report.headline_rows())
    write_text(options.out / "renders.md", report.text())
    print(report.text())
    seconds = sum(reference.seconds for reference in references.values())
    print(f"Written: {options.out}/renders.md and renders_headline.csv, renders_gain.png; {options.pages}/renders.csv. "
          f"References took {Progress.format_interval(seconds)} once.")
