# SPDX-License-Identifier: Apache-2.0
"""The text of renders.md: gains, spread over views, targets, statistical tests and times."""

import math
import statistics

import numpy as np
from scipy import stats

from .gains import BEST_PEER, BEST_PEER_EACH, HEADLINE_MEASURES, REFERENCE_MARGIN, Gains
from .image_error import LUMINANCE, MEASURES, WHAT_FOR, measure_name
from .judge import FLIP_COUNTS, FLIP_SEEDS
from .ratios import ratio, seconds_to_error, worse_cells
from .variants import SIDE_SEEDS
from .views import DIRECT, SETS

# Targets for blue after sigma 2.1, as displayed and raw: geometric means over the directly lit scenes.
AIMS = {"sobol": {n: 1.25 for n in (1, 2, 4, 8, 16, 32, 64)}}
SECONDS_AIM = 1 / 8
Z_SPP, Z_SEEDS, FALSE_ALARMS = 16, 16, 0.01
FURNACE_AIM = 1e-3
SHARE_AIM, THREADS_AIM, RAYS_AIM = 0.20, 1.9, 0.80
ALL_MEASURES = (*MEASURES, "flip")
TABLE_MEASURES = ("displayed_2.1", "displayed_1.0", "displayed", "rmse_2.1", "rmse_1.0", "rmse", "trimmed_2.1", "flip")
SPREAD_COUNTS = (1, 4, 16, 64)
MOST_LISTED = 20

TIMED_NOTE = "as the path tracer reports it (attribute `samplingShare`), one thread, 64 samples per pixel, median of three"


def md_table(header, rows):
    lines = ["| " + " | ".join(header) + " |", "| --- |" + " ---: |" * (len(header) - 1)]
    return "\n".join([*lines, *("| " + " | ".join(row) + " |" for row in rows)])


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


def verdict(gain, aim):
    return "met" if gain.value >= aim else "missed" if gain.high < aim else "missed, within the interval"


class Report:
    """options: of renders.parse_options(); cells: judge.Cells; references: {view: judge.Reference}."""

    def __init__(self, options, cells, references, furnaces, times):
        self.options, self.cells, self.references = options, cells, references
        self.furnaces, self.times = furnaces, times
        self.views, self.labels, self.counts = tuple(references), options.labels, tuple(options.seeds)
        self.scenes = tuple(dict.fromkeys(view.scene for view in self.views))
        self.gains = Gains(cells, references, self.labels)

    def views_of(self, scenes):
        return tuple(view for view in self.views if view.scene in scenes)

    @property
    def direct(self):
        return self.views_of(DIRECT)

    def first_view(self, scene):
        return self.views_of((scene,))[0]

    def headline_rows(self):
        return self.gains.rows(self.counts, ALL_MEASURES)

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

    # ---- Targets

    def aims(self):
        """[(what, target, measured, verdict)]."""
        rows = []
        if self.direct and "blue" in self.labels:
            for measure in HEADLINE_MEASURES:
                for than, aims in AIMS.items():
                    for spp, aim in aims.items():
                        gain = self.gains.gain("blue", spp, measure, than, self.direct)
                        if gain:
                            rows.append((f"{than} / blue, {spp} spp, {measure_name(measure)}, directly lit scenes",
                                         f"at least {aim}", gain.text(), verdict(gain, aim)))
            for measure in (*HEADLINE_MEASURES, "flip"):
                for than in ("white", "sobol"):
                    found = [(self.gains.gain("blue", spp, measure, than), spp) for spp in self.counts]
                    found = [(gain, spp) for gain, spp in found if gain]
                    if found:
                        gain, spp = min(found, key=lambda item: item[0].value)
                        rows.append((f"{than} / blue, {measure_name(measure)}, all scenes, smallest over sample counts",
                                     "at least 1.0", f"{gain.text()} at {spp} spp", verdict(gain, 1.0)))
            certain, _ = worse_cells(self.against_sobol(), FALSE_ALARMS)
            if max(self.options.seeds.values()) > 1:
                rows.append(("cells where blue is worse than sobol", "none", str(len(certain)),
                             "missed" if certain else "met"))
        furnace = max((abs(row["mean"]) for row in self.furnaces), default=0)
        rows.append(("furnace, mean of the picture", f"within {100 * FURNACE_AIM:g} %", f"{100 * furnace:.4f} %",
                     "met" if furnace <= FURNACE_AIM else "missed"))
        z_rows, limit = self.z_rows()
        if z_rows:
            worst = max(abs(z) for _, _, z in z_rows)
            rows.append(("greatest |z| of a mean", f"at most {limit:.2f}", f"{worst:.2f}",
                         "met" if worst <= limit else "missed"))
        if self.times:
            rows += self.time_aims()
        return rows

    def time_aims(self):
        rows = []
        shares = self.seconds_shares("blue")
        if shares:
            mean = math.exp(statistics.mean(math.log(share) for share in shares))
            rows.append((f"blue's time to white's error at {self.times['spp']} spp", f"at most {SECONDS_AIM:.3f}",
                         f"{mean:.3f}", "met" if mean <= SECONDS_AIM else "missed"))
        share = self.times["shares"].get("blue")
        if share is not None:
            rows.append(("share of cornell's render time spent sampling, blue", f"at most {100 * SHARE_AIM:.0f} %",
                         f"{100 * share:.1f} %", "met" if share <= SHARE_AIM else "missed"))
        speedup = statistics.median(one / two for one, two in self.times["threads"])
        rows.append(("speedup of two threads", f"{THREADS_AIM} times", f"{speedup:.2f}",
                     "met" if speedup >= THREADS_AIM else "missed"))
        embree = self.times["embree"]
        if embree and "pairs" in embree:
            relative = statistics.median(ours / theirs for ours, theirs in embree["pairs"])
            rows.append(("rays per second, Embree's path tracer = 1", f"at least {RAYS_AIM}", f"{relative:.2f}",
                         "met" if relative >= RAYS_AIM else "missed"))
        return rows

    # ---- Never worse than sobol

    def against_sobol(self):
        """{(view, spp, measure): Ratio} of sobol to blue for every RMSE cell."""
        cells = {}
        for view in self.views:
            for spp in self.counts:
                for measure in (name for name in MEASURES if name.startswith("rmse")):
                    own, other = (self.cells.get(view, name, spp, measure) for name in ("blue", "sobol"))
                    if own and other and min(*own, *other) > 0:
                        count = min(len(own), len(other))
                        cells[view, spp, measure] = ratio(other[:count], own[:count])
        return cells

    def worse_text(self):
        if max(self.options.seeds.values()) == 1:
            return "This test needs more than one seed."
        cells = self.against_sobol()
        certain, suspected = worse_cells(cells, FALSE_ALARMS)
        lines = [f"Each combination of view, sample count and blur is a cell: {len(cells)} cells of `blue` against `sobol`, RMSE. A "
                 "cell counts as *worse* if a one-sided t-test over seeds with Holm's correction finds its ratio below 1; the "
                 f"probability of any false alarm is {100 * FALSE_ALARMS:g} %. It is *suspected* if only its own 95 % interval "
                 f"lies below 1; about {len(cells) * 0.025:.0f} of {len(cells)} cells would be by chance.", ""]
        lines.append(f"{len(certain) or 'No'} cell{'s are' if len(certain) > 1 else ' is'} worse, {len(suspected)} suspected"
                     + (f"; the first {MOST_LISTED} are listed." if len(certain) + len(suspected) > MOST_LISTED else "."))
        listed = ([(name, "worse") for name in certain] + [(name, "suspected") for name in suspected])[:MOST_LISTED]
        if listed:
            lines += ["", md_table(["view", "spp", "measure", "sobol / blue", "95 % interval", ""], [
                [view.label, str(spp), measure_name(measure), f"{cells[view, spp, measure].value:.3f}",
                 f"{cells[view, spp, measure].low:.3f} to {cells[view, spp, measure].high:.3f}", what]
                for (view, spp, measure), what in listed])]
        return "\n".join(lines)

    # ---- Unbiasedness

    def z_rows(self):
        """([(view, label, z)], limit of |z|), at the largest sample count up to Z_SPP with the most seeds, at most Z_SEEDS."""
        spp = max((n for n in self.counts if n <= Z_SPP), key=lambda n: (min(self.options.seeds[n], Z_SEEDS), n))
        rows, chances = [], []
        for view in self.views:
            reference = self.references[view]
            wanted = float(np.mean(reference.picture.astype(np.float64) @ LUMINANCE))
            for label in self.labels:
                means = (self.cells.get(view, label, spp, "mean") or [])[:Z_SEEDS]
                if len(means) > 1:
                    error = math.hypot(np.std(means, ddof=1) / math.sqrt(len(means)), reference.mean_error)
                    rows.append((view, label, (np.mean(means) - wanted) / error if error else 0.0))
                    chances.append(len(means) - 1)
        self.z_spp = spp
        limit = float(stats.t.ppf(1 - FALSE_ALARMS / (2 * len(rows)), min(chances))) if rows else math.inf
        return rows, limit

    def z_text(self):
        rows, limit = self.z_rows()
        if not rows:
            return "This test needs more than one seed."
        worst = {}
        for view, label, z in rows:
            at = view.scene, label
            worst[at] = max(worst.get(at, 0.0), z, key=abs)
        table = md_table(["z", *self.labels], [[scene, *(f"{worst[scene, label]:+.2f}" if (scene, label) in worst else ""
                                                         for label in self.labels)] for scene in self.scenes])
        return (f"z is the difference between the mean luminance of pictures with {self.z_spp} samples per pixel and that of the "
                "reference, divided by their combined standard error; the table shows the view with the largest |z| of each "
                f"scene. If all were unbiased, the probability that any of the {len(rows)} values exceeds {limit:.2f} would be at "
                f"most {100 * FALSE_ALARMS:g} %.\n\n{table}")

    def furnace_text(self):
        rows = [[row["sampler"], f"{100 * row['mean']:+.4f} %", f"{100 * row['worst']:.2f} %"] for row in self.furnaces]
        return ("A closed glowing cube, whose pixels are all known, at 64 samples per pixel: relative error of the mean and of the "
                "worst pixel.\n\n" + md_table(["sampler", "mean", "worst pixel"], rows))

    # ---- Times

    def seconds_to_white(self, label):
        """{scene: (seconds of label, seconds of white)} to reach white's blurred error at its last sample count."""
        result = {}
        for scene, runs in self.times["runs"].items():
            last = runs["white"][-1]
            rows = runs[label]
            result[scene] = (seconds_to_error([row["seconds"] for row in rows], [row["rmse_2.1"] for row in rows],
                                              last["rmse_2.1"]), last["seconds"])
        return result

    def seconds_shares(self, label):
        found = [own / white for own, white in self.seconds_to_white(label).values()]
        return found if found and not any(math.isnan(share) for share in found) else []

    def times_text(self):
        if self.times is None:
            return "This run did not measure times (`--no-times`)."
        times, parts = self.times, []
        parts += [f"On {times['machine']}.", "", "### Time to reach an error", "",
                  f"Seconds, on one thread, until the error after sigma 2.1 equals that of white noise at {times['spp']} samples per "
                  f"pixel: interleaved progressive runs of {times['rounds']} seeds (`pathtracer --convergence`), medians of seconds and "
                  "errors at each sample count, log-log interpolation between them.", ""]
        if times["runs"]:
            labels = list(next(iter(times["runs"].values())))
            rows = []
            for scene, runs in times["runs"].items():
                cells = []
                for label in labels:
                    own, white = self.seconds_to_white(label)[scene]
                    cells.append("not reached" if math.isnan(own) else f"{own:.3f} s, {own / white:.3f}")
                rows.append([scene, f"{runs['white'][-1]['rmse_2.1']:.5f}", *cells])
            means = []
            for label in labels:
                shares = self.seconds_shares(label)
                means.append(f"**{math.exp(statistics.mean(map(math.log, shares))):.3f}**" if shares else "")
            rows.append(["**geometric mean of the ratios to white**", "", *means])
            parts += [md_table(["scene", "error", *labels], rows), "", *self.plot("Error against seconds", "renders_time.png")]
        parts += ["### Time spent sampling", "",
                  f"The share of `cornell`'s render time that is spent drawing samples, {TIMED_NOTE}.", "",
                  md_table(["sampler", "share"], [[label, f"{100 * share:.1f} %"] for label, share in times["shares"].items()])
                  if times["shares"] else "This path tracer does not report it.", "",
                  "### Threads and rays", ""]
        pairs = times["threads"]
        big = f"{times['big'][0]}x{times['big'][1]}"
        parts += [f"Speedup of two threads over one, `cornell`, {big} pixels, 16 samples per pixel, "
                  f"{len(pairs)} interleaved pairs: median **{statistics.median(one / two for one, two in pairs):.2f}** ("
                  + ", ".join(f"{one / two:.2f}" for one, two in pairs) + ").", ""]
        embree = times["embree"]
        if embree is None:
            parts.append("Rays per second are not compared, because Embree's own path tracer was not found (Debian: "
                         "`apt-get install embree-tools`).")
        elif "failed" in embree:
            parts.append(f"Embree's own path tracer failed to render the box: {embree['failed']}")
        else:
            ours, theirs = zip(*embree["pairs"])
            relative = [a / b for a, b in embree["pairs"]]
            parts.append(f"Rays per second of one thread on the Cornell box, {big} pixels, 8 samples per pixel, compared with the "
                         f"path tracer of embree-tools (`{embree['program']}`; its box is lit by a point light under the lamp), "
                         f"{len(ours)} interleaved pairs: median {statistics.median(ours):.2f} million, Embree's "
                         f"{statistics.median(theirs):.2f} million, ratio **{statistics.median(relative):.2f}** ("
                         + ", ".join(f"{r:.2f}" for r in relative) + ").")
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
            rows.append([view.label, f"{view.width}x{view.height}", *(f"{own[measure]:.5f}" for measure in HEADLINE_MEASURES),
                         *shares])
        names = [measure_name(measure) for measure in HEADLINE_MEASURES]
        return md_table(["view", "pixels", *names, *(f"share of blue's at {last} spp, {name}" for name in names)], rows)

    def left_out_text(self):
        found = [(measure, spp, views) for measure in HEADLINE_MEASURES for spp in self.counts
                 if (views := self.gains.left_out(spp, measure))]
        if not found:
            return "No view is excluded."
        return "Excluded from the gains of blue: " + "; ".join(
            f"{measure_name(measure)} at {spp} spp: {', '.join(view.label for view in views)}"
            for measure, spp, views in found) + "."

    def peers_text(self):
        if not self.gains.peers:
            return ("This run does not include OpenQMC's samplers; `--openqmc DIR` adds them from a checkout.")
        best = {measure: ", ".join(f"{self.gains.best_peer(spp, measure)} at {spp}" for spp in self.counts)
                for measure in HEADLINE_MEASURES}
        return (f"*{BEST_PEER}* is the one of its three samplers with the smallest geometric-mean error over all views at that sample "
                f"count: as displayed, {best['displayed_2.1']} samples per pixel; by RMSE, {best['rmse_2.1']}. *{BEST_PEER_EACH}* picks "
                "the best of the three for each view with hindsight, which favours OpenQMC.")

    def plot(self, title, name):
        """Lines that show a plot, where the plots lie beside the text."""
        return [f"![{title}]({name})", ""] if self.options.plots == self.options.out else []

    def text(self):
        options = self.options
        seeds = ", ".join(f"{count} at {spp}" for spp, count in options.seeds.items())
        sizes = sorted({view.size for view in self.views}, key=lambda size: size[0] * size[1])
        small, large = ("x".join(map(str, size)) for size in (sizes[0], sizes[-1]))
        title = "# Rendered scenes" + ("" if options.views == "core" else f": {options.views} views")
        parts = [title, "", f"Printed by `{options.command}`.", "",
                 f"{len(self.scenes)} built-in scenes of the example path tracer from {len(self.views)} views ({options.views}: "
                 f"{SETS[options.views]}), {small} to {large} pixels, against references with {options.reference_spp} samples per "
                 "pixel (`sobol`, a different seed). Picture sizes have no common factor, and every view rotates, moves and zooms "
                 "the camera slightly: the gain of blue noise along an edge depends on how the edge is aligned with the pixel "
                 "grid.", "",
                 f"Number of seeds: {seeds} samples per pixel (at most {SIDE_SEEDS} for `zorder` and `mask`; FLIP uses {FLIP_SEEDS}, at "
                 f"{', '.join(map(str, FLIP_COUNTS))} samples). `blue`, `sobol`, `white`, `mask` and OpenQMC's samplers render one "
                 "progressive run, measured at each sample count; `zorder` renders each count separately, because it must know the "
                 "count.", "",
                 "## Error reduction", "",
                 "Each number says how many times smaller blue's error is: geometric means over scenes, views and seeds, with 95 % "
                 "intervals of a bootstrap that resamples all three. A view is excluded where blue's error is less than "
                 f"{REFERENCE_MARGIN:g} times the error of the reference itself.", ""]
        for measure in HEADLINE_MEASURES:
            if "blue" in self.labels:
                parts += [f"### blue, {measure_name(measure)}", "",
                          gain_table(self.gains, self.counts, self.gains.thans(), measure), ""]
        parts += [self.peers_text(), "", *self.plot("Error reduction over white noise", "renders_gain.png"),
                  "## The error measures", "", *(f"- {text}" for text in WHAT_FOR.values()), "",
                  "## Spread over views", "",
                  "The geometric mean over a scene's views, followed by the smallest and the largest.", ""]
        for measure in HEADLINE_MEASURES:
            for than in self.gains.thans()[:3]:
                parts += [f"### {than} / blue, {measure_name(measure)}", "", self.spread_table(than, measure), ""]
        parts += [*self.plot("Every view", "renders_views.png"),
                  "## Targets", "", md_table(["what", "target", "measured", ""], [list(row) for row in self.aims()]), "",
                  "## All samplers", "", "White noise's error divided by each sampler's, over all scenes and views.", ""]
        parts += samplers_tables(self.gains, self.counts, TABLE_MEASURES)
        spectra = self.plot("Spectra", "renders_spectra.png")
        parts += [*(["## Spectra of the error", "", *spectra] if spectra else []),
                  "## Never worse than sobol", "", self.worse_text(), "",
                  "## Unbiased", "", self.z_text(), "", self.furnace_text(), "",
                  "## Times", "", self.times_text(), "",
                  "## The error of the references", "",
                  "Half the difference between the two halves of each reference, also as a share of blue's error at the largest "
                  "sample count. It contributes to every figure, and makes gains at high sample counts look smaller than they are.", "", self.references_table(), "",
                  self.left_out_text(), ""]
        return "\n".join(parts)
