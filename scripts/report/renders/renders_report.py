# SPDX-License-Identifier: Apache-2.0
"""The text of renders.md: the answer, gains, spread over views, statistical tests and times."""

import functools
import math
import statistics

import numpy as np

from ..base import peers
from ..base.tables import md_table
from ..measure import equal_quality, gains, picture_tests
from ..measure.gains import BEST_PEER, HEADLINE_MEASURES, REFERENCE_MARGIN, VISIBLE, Gains
from ..measure.image_error import MEASURES, WHAT_FOR, measure_name
from ..measure.ratios import worse_cells
from .judge import FLIP_COUNTS, FLIP_SEEDS, SHOWN_COUNTS
from .variants import SIDE_SEEDS
from .views import SETS, SHOWN

LOSS_MEASURES = tuple(name for name in MEASURES if name.startswith("rmse"))
ALL_MEASURES = (*MEASURES, "flip")
TABLE_MEASURES = ("displayed_2.1", "displayed_1.0", "displayed", "rmse_2.1", "rmse_1.0", "rmse", "trimmed_2.1", "flip")
SPREAD_COUNTS = (1, 4, 16, 64)
# Rings of judge's spectra, 1/64 cycles per pixel wide.
BANDS = {"below 1/32": slice(0, 2), "1/32 to 1/16": slice(2, 4), "1/16 to 1/8": slice(4, 8), "1/8 to 1/2": slice(8, 32)}
MOST_LISTED = 20

TIMED_NOTE = "as the path tracer reports it (attribute `samplingShare`), one thread, 64 samples per pixel, median of three"


def gain_table(gains, counts, thans, measure):
    """One row per sample count: how many times smaller blue's error is than that of each of `thans`, with intervals."""
    rows = []
    for spp in counts:
        found = [gains.gain("blue", spp, measure, than) for than in thans]
        if any(found):
            rows.append([str(spp), *(gain.text() if gain else "" for gain in found)])
    return md_table(["spp", *thans], rows)


def samplers_table(gains, counts, measure):
    """Every sampler compared with white noise."""
    rows = []
    for label in gains.labels:
        if label != "white":
            found = [gains.gain(label, spp, measure, "white") for spp in counts]
            if any(found):
                rows.append([label, *(f"{gain.value:.2f}" if gain else "" for gain in found)])
    return md_table(["white / sampler", *map(str, counts)], rows)


def samplers_tables(gains, counts, measures):
    """A heading and a table for each measure that was taken; FLIP is optional."""
    parts = []
    for measure in measures:
        if any(gains.gain("sobol", spp, measure, "white") for spp in counts):
            parts += [f"### {measure_name(measure)}", "", samplers_table(gains, counts, measure), ""]
    return parts


class Report:
    """options: of renders.parse_options(); cells: judge.Cells; references: {view: judge.Reference}; times: of
    speed.measure_all(), with costs of equal_quality.costs(), or None for both."""

    def __init__(self, options, cells, references, furnaces, times, costs=None):
        self.options, self.cells, self.references = options, cells, references
        self.furnaces, self.times, self.costs = furnaces, times, costs
        self.views, self.labels, self.counts = tuple(references), options.labels, tuple(options.seeds)
        self.scenes = tuple(dict.fromkeys(view.scene for view in self.views))
        self.gains = Gains(cells, references, self.labels)

    def views_of(self, scenes):
        return tuple(view for view in self.views if view.scene in scenes)

    def first_view(self, scene):
        return self.views_of((scene,))[0]

    def headline_rows(self):
        times = equal_quality.rows(self.gains, self.costs, self.counts) if self.costs else []
        return [*self.gains.rows(self.counts, ALL_MEASURES), *times]

    # ---- Spread over views

    def spread(self, scene, label, spp, measure, than):
        """{view: gain}: geometric means over seeds."""
        found = {}
        for view in self.views_of((scene,)):
            logs = self.gains.logs(view, label, spp, measure, than)
            if logs is not None and self.gains.is_judged(view, label, spp, measure):
                found[view] = math.exp(np.mean(logs))
        return found

    def spread_table(self, than, measure):
        counts = [spp for spp in SPREAD_COUNTS if spp in self.counts]
        rows = []
        for scene in self.scenes:
            cells = []
            for spp in counts:
                found = list(self.spread(scene, "blue", spp, measure, than).values())
                cells.append(f"{math.exp(statistics.mean(map(math.log, found))):.2f} ({min(found):.2f} to {max(found):.2f})"
                             if found else "")
            rows.append([scene, *cells])
        return md_table([f"{than} / blue", *map(str, counts)], rows)

    # ---- The answer

    def against(self, than):
        """{spp: how many times less error blue has than `than`, as displayed}."""
        found = {spp: self.gains.gain("blue", spp, HEADLINE_MEASURES[0], than) for spp in self.counts}
        return {spp: gain.value for spp, gain in found.items() if gain}

    def short(self):
        """Three sentences: how much less noise, where most and least, and what the tests of the pictures found."""
        than_all = [(than, found.values()) for than in self.gains.thans() if (found := self.against(than))]
        if "blue" not in self.labels or not than_all:
            return "This run does not say how `blue` compares with the others."
        ends = [f"{min(values):.2f} to {max(values):.2f} than {than if than == BEST_PEER else f'`{than}`'}" for than, values in than_all]
        parts = [f"As displayed, after a blur of 2.1 pixels, `blue` has this many times less error, the smallest and the largest over the "
                 f"sample counts from {min(self.counts)} to {max(self.counts)}: {', '.join(ends)}."]
        least = {scene: math.exp(statistics.mean(map(math.log, found.values()))) for scene in self.scenes
                 if (found := self.spread(scene, "blue", max(self.counts), HEADLINE_MEASURES[0], "sobol"))}
        if len(least) > 1:
            order = sorted(least, key=least.get)
            parts.append(f"Over `sobol` at {max(self.counts)} samples it gains most in `{order[-1]}` ({least[order[-1]]:.2f}) and least in "
                         f"`{order[0]}` ({least[order[0]]:.2f}).")
        if max(self.options.seeds.values()) > 1:
            certain, _ = worse_cells(self.losses, picture_tests.FALSE_ALARMS)
            biased = picture_tests.biased(self.biases)
            unblurred = sum(measure == "rmse" for *_, measure in certain)
            where = f", {unblurred} of them in single pixels, without a blur" if certain else ""
            parts.append(f"Of {len(self.losses)} tests for a loss to `sobol` {len(certain) or 'none'} found one{where}; of {len(self.biases)} "
                         f"for a bias {len(biased) or 'none'} did.")
        return " ".join(parts)

    # ---- Tests

    @functools.cached_property
    def losses(self):
        """{(scene, spp, measure): Ratio} of sobol's error to blue's."""
        return picture_tests.against_sobol(self.cells, self.views, self.counts, LOSS_MEASURES)

    @functools.cached_property
    def biases(self):
        """{(scene, label): Ratio} of means to those of the references, at the largest count, where they vary least."""
        return picture_tests.biases(self.cells, self.references, self.labels, max(self.counts))

    def worse_text(self):
        if max(self.options.seeds.values()) == 1:
            return "This test needs more than one seed."
        cells, false_alarms = self.losses, picture_tests.FALSE_ALARMS
        certain, suspected = worse_cells(cells, false_alarms)
        smallest = {at: picture_tests.smallest_loss(cell, len(cells)) for at, cell in cells.items()}
        parts = [f"A cell is the RMSE of `blue` against `sobol` in all crops and seeds of one scene, or of all scenes, at one sample count and blur: "
                 f"{len(cells)} cells. A cell is *worse* if a one-sided t-test with Holm's correction finds its ratio below 1; the "
                 f"probability of any false alarm is {100 * false_alarms:g} %. It is *suspected* if only its own 95 % interval lies "
                 f"below 1; about {len(cells) * 0.025:.0f} would be by chance.", "",
                 f"{len(certain) or 'No'} cell{'s are' if len(certain) > 1 else ' is'} worse, {len(suspected)} suspected"
                 + (f"; the first {MOST_LISTED} are listed." if len(certain) + len(suspected) > MOST_LISTED else "."), ""]
        listed = ([(at, "worse") for at in certain] + [(at, "suspected") for at in suspected])[:MOST_LISTED]
        if listed:
            parts += [md_table(["scene", "spp", "measure", "sobol / blue", "95 % interval", ""], [
                [scene, str(spp), measure_name(measure), f"{cells[scene, spp, measure].value:.3f}",
                 f"{cells[scene, spp, measure].low:.3f} to {cells[scene, spp, measure].high:.3f}", what]
                for (scene, spp, measure), what in listed]), ""]
        rows = []
        for scene in dict.fromkeys(scene for scene, *_ in cells):
            rows.append([scene, *(" to ".join(f"{100 * end(smallest[at] for at in smallest if at[:2] == (scene, spp)):.1f}"
                                              for end in (min, max)) if (scene, spp, "rmse") in cells else "" for spp in self.counts)])
        return "\n".join([*parts, "The smallest loss, in percent of the error, that the test finds with a probability of "
                          f"{100 * picture_tests.POWER:g} % (smallest and largest over the blurs):", "",
                          md_table(["loss, %", *map(str, self.counts)], rows)])

    def bias_text(self):
        cells = self.biases
        if not cells:
            return "This test needs more than one seed."

        def text(at):
            return f"{100 * (cells[at].value - 1):+.2f} ({100 * picture_tests.smallest_bias(cells[at], len(cells)):.2f})" if at in cells else ""

        rows = [[scene, *(text((scene, label)) for label in self.labels)] for scene in dict.fromkeys(scene for scene, _ in cells)]
        found = picture_tests.biased(cells)
        return (f"How far the mean luminance of the pictures with {max(self.counts)} samples per pixel is from that of the references, in percent, over "
                "all crops and seeds of a scene; in parentheses the smallest difference that a two-sided t-test finds with a "
                f"probability of {100 * picture_tests.POWER:g} %. If all samplers are unbiased, the probability that any of the "
                f"{len(cells)} cells is called biased is at most {100 * picture_tests.FALSE_ALARMS:g} %. "
                + ("Biased: " + ", ".join(f"{label} in {scene}" for scene, label in found) if found else "No cell is biased")
                + ".\n\n" + md_table(["difference, %", *self.labels], rows))

    def furnace_text(self):
        rows = [[row["sampler"], f"{100 * row['mean']:+.4f} %", f"{100 * row['worst']:.2f} %"] for row in self.furnaces]
        return ("A closed glowing cube, whose pixels are all known, at 64 samples per pixel: relative error of the mean and of the "
                "worst pixel.\n\n" + md_table(["sampler", "mean", "worst pixel"], rows))

    def frequencies_text(self):
        """Errors by frequency, down to the mean, over white noise's."""
        def share(label, spp, amplitude):
            found = [amplitude(view, label, spp) / amplitude(view, "white", spp) for view in self.gains.views]
            return f"{math.exp(np.mean(np.log(found))):.2f}"

        def deviation(view, label, spp):
            return np.std(self.cells.get(view, label, spp, "mean"), ddof=1)

        def band(places):
            return lambda view, label, spp: math.sqrt(np.mean([spectrum[places] for spectrum in
                                                               self.cells.get(view, label, spp, "spectrum")]))

        counts = [spp for spp in SHOWN_COUNTS if spp in self.counts]
        rows = []
        for name, amplitude in {"mean of the crop": deviation, **{name: band(places) for name, places in BANDS.items()}}.items():
            rows += [[name, label, *(share(label, spp, amplitude) for spp in counts)] for label in self.labels
                     if label != "white"]
        return ("The amplitude of the error over that of white noise, geometric means over crops, by frequency in cycles per pixel. The first "
                "rows are the standard deviation of a crop's mean over seeds: how much it flickers where every frame has a key of its own.\n\n"
                + md_table(["frequency", "sampler", *map(str, counts)], rows))

    # ---- Times

    def denoised_times(self):
        """{label: Gain in time after the denoiser}, from the last run of `scripts/bench denoise` with this set of views."""
        path = self.options.out / "denoise.csv"
        rows = gains.read_rows(path) if path.is_file() else {}
        return {label: rows[key] for label in self.labels
                if (key := (f"seconds:plain:{equal_quality.MEASURE}", equal_quality.TARGETS[0], label, "white")) in rows}

    def quality_text(self):
        denoised = self.denoised_times()

        def more(label):
            if label is None:
                return [f"after denoising, at {equal_quality.TARGETS[0]}"] if denoised else []
            return [denoised[label].text() if label in denoised else ""] if denoised else []

        table = md_table(*equal_quality.table_rows(self.gains, self.costs, self.counts, more=more))
        return (f"Processor seconds for a million pixels until the error, {measure_name(equal_quality.MEASURE)}, is that of white noise at "
                f"{' and at '.join(map(str, equal_quality.TARGETS))} samples per pixel: geometric means over crops, with the 95 % interval of "
                "the bootstrap. The cost of a sample is measured in a crop of every scene, as a median of interleaved runs of one "
                "thread. " + ("The last column is the same for pictures from Open Image Denoise (denoise.md), without its own time. "
                              if denoised else "") + f"\n\n{table}")

    def times_text(self):
        if self.times is None:
            return "This run did not measure times (`--no-times`)."
        times, parts = self.times, []
        parts += [f"On {times['machine']}.", "", "### Time to reach an error", "", self.quality_text(), ""]
        parts += ["### Time spent sampling", "",
                  f"The share of `cornell`'s render time that is spent drawing samples, {TIMED_NOTE}.", "",
                  md_table(["sampler", "share"], [[label, f"{100 * share:.1f} %"] for label, share in times["shares"].items()])]
        return "\n".join(parts)

    # ---- Text

    def references_table(self):
        last, rows = max(self.counts), []
        for view in self.views:
            own = self.references[view].own
            shares = []
            for measure in HEADLINE_MEASURES:
                errors = self.cells.get(view, "blue", last, measure)
                shares.append(f"{100 * own[measure] / statistics.mean(errors):.0f} %" if errors and min(errors) > 0 else "")
            rows.append([view.label, "+".join(map(str, view.crop[:2])), *(f"{own[measure]:.5f}" for measure in HEADLINE_MEASURES),
                         *shares])
        names = [measure_name(measure) for measure in HEADLINE_MEASURES]
        return md_table(["view", "crop", *names, *(f"share of blue's at {last} spp, {name}" for name in names)], rows)

    def left_out_text(self):
        empty = [view.label for view in self.views if view not in self.gains.views]
        found = [(measure, spp, views) for measure in HEADLINE_MEASURES for spp in self.counts
                 if (views := self.gains.left_out(spp, measure))]
        noisy = "; ".join(f"{measure_name(measure)} at {spp} spp: {', '.join(view.label for view in views)}"
                          for measure, spp, views in found)
        return (f"Excluded from all figures, because there is no noise to see: {', '.join(empty) or 'none'}. Excluded from the gains of "
                f"blue, because the reference is too noisy: {noisy or 'none'}.")

    def peers_text(self):
        if not self.gains.peers:
            return ("This run does not include OpenQMC's samplers; `--openqmc DIR` adds them from a checkout.")
        best = {measure: ", ".join(f"{self.gains.best_peer(spp, measure)} at {spp}" for spp in self.counts)
                for measure in HEADLINE_MEASURES}
        return (f"*{BEST_PEER}* is the one of its three samplers with the smallest geometric-mean error over all views at that sample "
                f"count: as displayed, {best['displayed_2.1']} samples per pixel; by RMSE, {best['rmse_2.1']}. OpenQMC's commit is "
                f"{peers.commit(self.options.openqmc)}.")

    def text(self):
        options = self.options
        sizes = " and ".join(f"{width}x{height}" for width, height in sorted({(view.width, view.height) for view in self.views}))
        title = "# Rendered scenes" + ("" if options.views == SHOWN else f": {options.views} views")
        what = (f"in {len(self.views)} crops of {'x'.join(map(str, self.views[0].size))} pixels, out of pictures of {sizes} pixels: one in "
                "each quarter, placed by a hash before anything was rendered")
        seeds = max(options.seeds.values())
        parts = [title, "", f"Printed by `{options.command}`.", "",
                 self.short(), "", "![Error reduction over white noise](renders_gain.png)", "",
                 f"{len(self.scenes)} built-in scenes of the example path tracer, {what}. The set of views is *{options.views}*, "
                 f"{SETS[options.views]}; no two sets share a camera or a crop. References have {options.reference_spp} samples per pixel "
                 "(`sobol`, a different seed).", "",
                 f"Each figure comes from {seeds} seed{'s' if seeds > 1 else ''} (`mask`: at most {SIDE_SEEDS}; FLIP: {FLIP_SEEDS}, at "
                 f"{', '.join(map(str, FLIP_COUNTS))} samples). `blue`, `sobol`, `white`, `mask` and OpenQMC's samplers render one "
                 "progressive run, measured at each sample count; `zorder` renders each count separately, because it must know the "
                 "count. `sobol` is padded: its two pairs of dimensions are sequences of their own.", "",
                 "## Error reduction", "",
                 "Each number says how many times smaller blue's error is: geometric means over scenes, pictures, crops and seeds, "
                 "with 95 % intervals of a bootstrap that resamples all four. A crop is excluded where blue's error is less than "
                 f"{REFERENCE_MARGIN:g} times the error of the reference itself, or "
                 f"where the error of white noise as displayed is below {VISIBLE:g} at one sample.", ""]
        for measure in HEADLINE_MEASURES:
            if "blue" in self.labels:
                parts += [f"### blue, {measure_name(measure)}", "",
                          gain_table(self.gains, self.counts, self.gains.thans(), measure), ""]
        parts += [self.peers_text(), "",
                  "## The error measures", "", *(f"- {text}" for text in WHAT_FOR.values()), "",
                  "## Spread over views", "",
                  "The geometric mean over a scene's crops, followed by the smallest and the largest.", ""]
        for measure in HEADLINE_MEASURES:
            for than in self.gains.thans():
                parts += [f"### {than} / blue, {measure_name(measure)}", "", self.spread_table(than, measure), ""]
        parts += ["![Every view](renders_views.png)", "",
                  "## All samplers", "", "White noise's error divided by each sampler's, over all scenes and crops.", ""]
        parts += samplers_tables(self.gains, self.counts, TABLE_MEASURES)
        if self.gains.views and seeds > 1 and self.cells.get(self.gains.views[0], "white", 1, "spectrum"):
            parts += ["## Frequencies of the error", "", self.frequencies_text(), ""]
        parts += ["## Losses to sobol", "", self.worse_text(), "",
                  "## Unbiased", "", self.bias_text(), "", self.furnace_text(), "",
                  "## Times", "", self.times_text(), "",
                  "## The error of the references", "",
                  "Half the difference between the two halves of each reference, also as a share of blue's error at the largest "
                  "sample count. It contributes to every figure, and makes gains at high sample counts look smaller than they are.", "", self.references_table(), "",
                  self.left_out_text(), ""]
        return "\n".join(parts)
