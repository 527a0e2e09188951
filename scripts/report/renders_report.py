# SPDX-License-Identifier: Apache-2.0
"""What `scripts/bench renders` measured, as tables: ratios of errors, aims, tests, times."""

import csv
import io
import math
import statistics

import numpy as np
from scipy import stats

from .files import write_text
from .image_error import LUMINANCE, SIGMAS
from .ratios import geometric_mean, ratio, seconds_to_error, worse_cells

MEASURES = (2.1, 1.0, 0.0, "flip")
MEASURE_NAMES = {0.0: "RMSE, unblurred", 1.0: "RMSE after sigma 1.0", 2.1: "RMSE after sigma 2.1", "flip": "mean FLIP"}
# What the samplers of this library are to reach after sigma 2.1, in the geometric mean over the scenes lit directly.
AIMS = {"white": {1: 1.7, 4: 2.2, 16: 2.6, 64: 3.0}, "sobol": {n: 1.3 for n in (1, 2, 4, 8, 16)}}
SECONDS_AIM = 1 / 8
Z_SPP, Z_SEEDS, FALSE_ALARMS = 16, 16, 0.01
FURNACE_AIM = 1e-3
SHARE_AIM, THREADS_AIM, RAYS_AIM = 0.20, 1.9, 0.80

TIMED_NOTE = "as the path tracer reports it (attribute `samplingShare`), one thread, 64 samples per pixel, median of three"


def md_table(header, rows):
    lines = ["| " + " | ".join(header) + " |", "| --- |" + " ---: |" * (len(header) - 1)]
    return "\n".join([*lines, *("| " + " | ".join(row) + " |" for row in rows)])


def ratio_text(r):
    """1.83 ± 0.05: half the 95 % interval, which is nearly symmetric where it is narrow; a wide one by its ends."""
    if math.isnan(r.standard_error):
        return f"{r.value:.2f}"
    if r.high > 1.3 * r.low:
        return f"{r.value:.2f}, {r.low:.2f} to {r.high:.2f}"
    return f"{r.value:.2f} ± {(r.high - r.low) / 2:.2f}"


def verdict(r, aim):
    return "met" if r.value >= aim else "missed" if r.high < aim else "missed, within the noise"


class Report:
    def __init__(self, options, cells, references, furnaces, times):
        from .renders import DIRECT

        self.options, self.cells, self.references = options, cells, references
        self.furnaces, self.times = furnaces, times
        self.scenes, self.labels, self.counts = options.scenes, options.samplers, tuple(options.seeds)
        self.direct = tuple(scene for scene in DIRECT if scene in self.scenes)

    # ---- Ratios

    def ratio(self, scene, label, spp, measure, than):
        """How many times less error than `than`; None when one of them was not measured."""
        own = self.cells.values.get((scene, label, spp), {}).get(measure)
        other = self.cells.values.get((scene, than, spp), {}).get(measure)
        if not own or not other:
            return None
        count = min(len(own), len(other))
        return ratio(other[:count], own[:count])

    def mean_ratio(self, label, spp, measure, than):
        found = [self.ratio(scene, label, spp, measure, than) for scene in self.direct]
        return geometric_mean(found) if found and all(found) else None

    def ratio_table(self, label, than, measure):
        header = [f"{than} / {label}", *map(str, self.counts)]
        rows = []
        for scene in self.scenes:
            found = [self.ratio(scene, label, spp, measure, than) for spp in self.counts]
            rows.append([scene, *(ratio_text(r) if r else "" for r in found)])
        if len(self.direct) > 1:
            names = [(label, "geometric mean of " + ", ".join(self.direct))]
            if label == "blue" and "blue, declared" in self.labels:
                names.append(("blue, declared", "the same, count declared"))
            for name, text in names:
                found = [self.mean_ratio(name, spp, measure, than) for spp in self.counts]
                rows.append([f"**{text}**", *(f"**{ratio_text(r)}**" if r else "" for r in found)])
        if measure == 2.1 and label == "blue":
            rows.append(["aim", *(f"{AIMS[than][spp]:.1f}" if spp in AIMS[than] else "" for spp in self.counts)])
        return md_table(header, rows)

    def samplers_table(self, measure):
        """Every sampler against white noise, in the mean over the scenes lit directly."""
        rows = []
        for label in self.labels:
            if label != "white":
                found = [self.mean_ratio(label, spp, measure, "white") for spp in self.counts]
                rows.append([label, *(ratio_text(r) if r else "" for r in found)])
        return md_table(["white / sampler", *map(str, self.counts)], rows)

    # ---- Aims

    def aims(self):
        """[(what, aim, measured, verdict)] of all that has one."""
        rows = []
        if self.direct and "blue" in self.labels:
            for than, aims in AIMS.items():
                for spp, aim in aims.items():
                    for label in ("blue", "blue, declared"):
                        r = self.mean_ratio(label, spp, 2.1, than) if label in self.labels else None
                        if r:
                            rows.append((f"{than} / {label}, {spp} spp, sigma 2.1", f"at least {aim}", ratio_text(r),
                                         verdict(r, aim)))
            for scene in ("glass", "interior"):
                found = [self.ratio(scene, "blue", spp, 2.1, "white") for spp in self.counts]
                found = [r for r in found if r]
                if found:
                    least = min(found, key=lambda r: r.value)
                    rows.append((f"white / blue on {scene}, the least over counts", "at least 1.0", ratio_text(least),
                                 verdict(least, 1.0)))
            for than in ("white", "sobol"):
                found = [self.mean_ratio("blue", spp, "flip", than) for spp in self.counts]
                found = [r for r in found if r]
                if found:
                    least = min(found, key=lambda r: r.value)
                    rows.append((f"FLIP, {than} / blue, the least over counts", "at least 1.0", ratio_text(least),
                                 verdict(least, 1.0)))
            certain, _ = worse_cells(self.against_sobol(), FALSE_ALARMS)
            if max(self.options.seeds.values()) > 1:
                rows.append(("cells in which blue is worse than sobol", "none", str(len(certain)),
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
        for label in ("blue", "blue, declared"):
            shares = self.seconds_shares(label)
            if shares:
                mean = math.exp(statistics.mean(math.log(share) for share in shares))
                rows.append((f"seconds of {label} to white's error at {self.times['spp']} spp", f"at most {SECONDS_AIM:.3f}",
                             f"{mean:.3f}", "met" if mean <= SECONDS_AIM else "missed"))
        share = self.times["shares"].get("blue")
        if share is not None:
            rows.append(("share of cornell spent in sampling, blue", f"at most {100 * SHARE_AIM:.0f} %",
                         f"{100 * share:.1f} %", "met" if share <= SHARE_AIM else "missed"))
        speedup = statistics.median(one / two for one, two in self.times["threads"])
        rows.append(("two threads against one", f"{THREADS_AIM} times", f"{speedup:.2f}",
                     "met" if speedup >= THREADS_AIM else "missed"))
        embree = self.times["embree"]
        if embree and "pairs" in embree:
            relative = statistics.median(ours / theirs for ours, theirs in embree["pairs"])
            rows.append(("rays per second, Embree's path tracer = 1", f"at least {RAYS_AIM}", f"{relative:.2f}",
                         "met" if relative >= RAYS_AIM else "missed"))
        return rows

    def against_sobol(self):
        """{(scene, label, spp, measure): Ratio} of every cell in which blue noise could be worse than sobol."""
        cells = {}
        for scene in self.scenes:
            for label in ("blue", "blue, declared"):
                for spp in self.counts:
                    for measure in (0.0, 1.0, 2.1):
                        r = self.ratio(scene, label, spp, measure, "sobol") if label in self.labels else None
                        if r:
                            cells[scene, label, spp, measure] = r
        return cells

    def worse_text(self):
        if max(self.options.seeds.values()) == 1:
            return "One seed says nothing about noise."
        cells = self.against_sobol()
        certain, suspected = worse_cells(cells, FALSE_ALARMS)
        lines = [f"Every scene, count and blur is a cell: {len(cells)} of `blue`, declared or not, against `sobol`. A cell "
                 "is *worse* when its mean over seeds is below 1 by a one-sided t-test after Holm's correction for their "
                 f"number, so that one would be named without cause with a chance of {100 * FALSE_ALARMS:g} %. It is "
                 f"*suspected* when only its own 95 % interval lies below 1: of {len(cells)} cells "
                 f"{len(cells) * 0.025:.0f} would by chance.", ""]
        if not certain:
            lines += ["No cell is worse.", ""]
        listed = [(name, "worse") for name in certain] + [(name, "suspected") for name in suspected]
        if listed:
            lines.append(md_table(["scene", "sampler", "spp", "measure", "sobol / blue", "95 % interval", ""], [
                [scene, label, str(spp), MEASURE_NAMES[measure], f"{cells[scene, label, spp, measure].value:.3f}",
                 f"{cells[scene, label, spp, measure].low:.3f} to {cells[scene, label, spp, measure].high:.3f}", what]
                for (scene, label, spp, measure), what in listed]))
        else:
            lines.append("None is suspected either.")
        return "\n".join(lines)

    # ---- Unbiasedness

    def z_rows(self):
        """([(scene, label, z)], limit of |z|) at the count nearest to Z_SPP that has the most seeds up to Z_SEEDS."""
        spp = max((n for n in self.counts if n <= Z_SPP), key=lambda n: (min(self.options.seeds[n], Z_SEEDS), n))
        rows, fewest = [], 10**9
        for scene in self.scenes:
            _, reference, attributes = self.references[scene]
            wanted = float(np.mean(reference.astype(np.float64) @ LUMINANCE))
            own = float(attributes.get("meanError", 0))
            for label in self.labels:
                means = self.cells.values.get((scene, label, spp), {}).get("mean", [])[:Z_SEEDS]
                if len(means) > 1:
                    fewest = min(fewest, len(means))
                    error = math.hypot(np.std(means, ddof=1) / math.sqrt(len(means)), own)
                    rows.append((scene, label, (np.mean(means) - wanted) / error if error else 0.0))
        self.z_spp, self.z_seeds = spp, fewest
        limit = float(stats.t.ppf(1 - FALSE_ALARMS / (2 * len(rows)), fewest - 1)) if rows else math.inf
        return rows, limit

    def z_text(self):
        rows, limit = self.z_rows()
        if not rows:
            return "One seed says nothing about the mean."
        found = {(scene, label): z for scene, label, z in rows}
        table = md_table(["z", *self.labels], [[scene, *(f"{found[scene, label]:+.2f}" if (scene, label) in found else ""
                                                         for label in self.labels)] for scene in self.scenes])
        return (f"The mean luminance of the picture over {self.z_seeds} seeds of {self.z_spp} samples per pixel, less that of "
                "the reference, over its standard error and the reference's own. In all of these together one beyond "
                f"{limit:.2f} would be there without cause with a chance of {100 * FALSE_ALARMS:g} %.\n\n{table}")

    def furnace_text(self):
        from .renders import FURNACE_SPP

        rows = [[row["sampler"], f"{100 * row['mean']:+.4f} %", f"{100 * row['worst']:.2f} %"] for row in self.furnaces]
        return (f"The closed glowing cube, {FURNACE_SPP} samples per pixel: how far the mean and the worst pixel are from what "
                "they are known to be.\n\n" + md_table(["sampler", "mean", "worst pixel"], rows))

    # ---- Times

    def seconds_to_white(self, label):
        """{scene: (seconds of label, seconds of white)} to white's blurred error at its last count."""
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
            return "Nothing was timed in this run (`--no-times`)."
        times, parts = self.times, []
        parts += [f"On {times['machine']}.", "", "### Seconds to an error", "",
                  f"Seconds of one thread until the error after sigma 2.1 is that of white noise at {times['spp']} samples per "
                  f"pixel: progressive runs of {times['rounds']} seeds in turn (`pathtracer --convergence`), medians of seconds and "
                  "of errors at each count, straight lines of logarithms between counts. For `blue, declared` "
                  "each count is a run of its own.", ""]
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
            rows.append(["**geometric mean of the shares**", "", *means])
            parts += [md_table(["scene", "error", *labels], rows), "", "![Error against seconds](renders_time.png)", ""]
        parts += ["### Share of sampling", "",
                  f"The share of the frame's time that drawing samples takes on `cornell`, {TIMED_NOTE}.", "",
                  md_table(["sampler", "share"], [[label, f"{100 * share:.1f} %"] for label, share in times["shares"].items()])
                  if times["shares"] else "This path tracer does not report it.", "",
                  "### Threads and rays", ""]
        pairs = times["threads"]
        big = f"{times['big'][0]}x{times['big'][1]}"
        parts += [f"Seconds of one thread over seconds of two, `cornell`, {big} pixels, 16 samples per pixel, "
                  f"{len(pairs)} pairs in turn: median **{statistics.median(one / two for one, two in pairs):.2f}** ("
                  + ", ".join(f"{one / two:.2f}" for one, two in pairs) + ").", ""]
        embree = times["embree"]
        if embree is None:
            parts.append("Embree's own path tracer was not found (Debian: `apt-get install embree-tools`), so nothing is "
                         "said of rays per second beside it.")
        elif "failed" in embree:
            parts.append(f"Embree's own path tracer did not render the box: {embree['failed']}")
        else:
            ours, theirs = zip(*embree["pairs"])
            relative = [a / b for a, b in embree["pairs"]]
            parts.append(f"Rays per second of one thread on the Cornell box, {big} pixels, 8 samples per pixel, beside the path "
                         f"tracer of Embree's tools (`{embree['program']}`; its box is lit from one point under the lamp), "
                         f"{len(ours)} pairs in turn: median {statistics.median(ours):.2f} million, theirs "
                         f"{statistics.median(theirs):.2f} million, ratio **{statistics.median(relative):.2f}** ("
                         + ", ".join(f"{r:.2f}" for r in relative) + ").")
        return "\n".join(parts)

    # ---- Text

    def references_table(self):
        rows = []
        for scene in self.scenes:
            attributes = self.references[scene][2]
            own = [attributes.get(f"error{i}") for i in range(len(SIGMAS))]
            last = max(self.counts)
            least = []
            for sigma, error in zip(SIGMAS, own):
                cell = self.cells.values.get((scene, "blue", last), {}).get(sigma)
                least.append(f"{100 * error / statistics.mean(cell):.0f} %" if cell and error is not None else "")
            rows.append([scene, *(f"{error:.5f}" if error is not None else "" for error in own), *least])
        return md_table(["scene", *(f"sigma {sigma}" for sigma in SIGMAS),
                         *(f"of blue's at {max(self.counts)} spp, sigma {sigma}" for sigma in SIGMAS)], rows)

    def text(self):
        from .renders import FLIP_SEEDS

        options = self.options
        seeds = ", ".join(f"{count} at {spp}" for spp, count in options.seeds.items())
        size = "x".join(map(str, options.size))
        parts = ["# Rendered scenes", "", f"Printed by `{options.command}`.", "",
                 f"{len(self.scenes)} built-in scenes of the example path tracer, {size} pixels, against references of "
                 f"{options.reference_spp} samples per pixel (`sobol`, another seed). Errors are of linear radiance, root "
                 "mean squares over pixels and channels, as they are and after Gaussians of 1.0 and 2.1 pixels: a near and a "
                 "far view. FLIP is the mean of HDR-FLIP (`flip-evaluator`, its defaults), on the same linear radiance.", "",
                 "Ratios say how many times less error the second has than the first: geometric means over seeds "
                 f"({seeds} samples per pixel; FLIP of at most {FLIP_SEEDS}), ± half their 95 % interval, or its ends where it is wide. "
                 "`blue`, `sobol`, `white` and `mask` are progressive runs, stopped at each count; `zorder` is told each "
                 "count, which it needs, and so is `blue, declared` at the counts that libbn has a set for.", "",
                 "[renders.html](renders.html) compares any two pictures under a slider; download it and open it from disk.", "",
                 "![Pictures and blurred errors](renders_pictures.png)", "",
                 "## Aims", "", md_table(["what", "aim", "measured", ""], [list(row) for row in self.aims()]), ""]
        if len(self.direct) > 1:
            parts += ["## All samplers", "",
                      f"White noise's error over each sampler's, geometric mean over {', '.join(self.direct)}.", ""]
            for measure in MEASURES:
                parts += [f"### {MEASURE_NAMES[measure]}", "", self.samplers_table(measure), ""]
            parts += ["![The same as plots](renders_mean.png)", ""]
        parts += ["## Every scene", "", "![Error after a blur, relative to white noise](renders_blurred.png)", "",
                  "![Error unblurred, relative to white noise](renders_unblurred.png)", "",
                  "Spectra of the error:", "", "![Spectra](renders_spectra.png)", ""]
        for than in ("white", "sobol"):
            for measure in MEASURES:
                parts += [f"### {than} / blue, {MEASURE_NAMES[measure]}", "", self.ratio_table("blue", than, measure), ""]
        parts += ["## Never worse than sobol", "", self.worse_text(), "",
                  "## Unbiased", "", self.z_text(), "", self.furnace_text(), "",
                  "## Times", "", self.times_text(), "",
                  "## The references' own error", "",
                  "Half of what their two halves differ by, and that as a share of the smallest error they judge. It is part of "
                  "every figure, and makes ratios at high counts look smaller than they are.", "", self.references_table(), ""]
        return "\n".join(parts)

    # ---- Files

    def write(self, folder):
        from . import renders_plots

        write_text(folder / "renders.csv", self.csv_text())
        renders_plots.draw_all(self, folder)
        write_text(folder / "renders.html", renders_plots.html_page(self))
        write_text(folder / "renders.md", self.text())

    def csv_text(self):
        out = io.StringIO()
        writer = csv.writer(out, lineterminator="\n")
        writer.writerow(["scene", "sampler", "spp", "seeds", "rmse", "rmse_1.0", "rmse_2.1", "flip",
                         *(f"{than}_over_{name}" for than in ("white", "sobol")
                           for name in ("rmse", "rmse_1.0", "rmse_2.1", "flip"))])
        for scene in self.scenes:
            for label in self.labels:
                for spp in self.counts:
                    cell = self.cells.values.get((scene, label, spp))
                    if cell:
                        errors = [f"{math.sqrt(statistics.mean(e * e for e in cell[sigma])):.6g}" for sigma in SIGMAS]
                        flip = f"{statistics.mean(cell['flip']):.6g}" if cell["flip"] else ""
                        found = [self.ratio(scene, label, spp, measure, than) for than in ("white", "sobol")
                                 for measure in (0.0, 1.0, 2.1, "flip")]
                        writer.writerow([scene, label, spp, len(cell[0.0]), *errors, flip,
                                         *(f"{r.value:.4f}" if r else "" for r in found)])
        return out.getvalue()
