# SPDX-License-Identifier: Apache-2.0
"""The text of cycles.md: how many times the error of `blue` Cycles' own patterns have, what adaptive sampling takes, and the time."""

import math

import numpy as np

from ..base.tables import md_table
from ..measure.gains import Gains, bootstrap
from .cycles_scenes import SCENES, SIZE, ZOOM
from .other_renderer import HEADLINE, OtherReport, name_of

NAMES = {"tabulated_sobol": "Tabulated Sobol", "blue_noise_first": "blue noise (first)", "blue_noise_pure": "blue noise (pure)"}
ADAPTIVE, ADAPTIVE_SPP = (0.05,), 128
# Patterns that have to be told the number of samples, told so many, and stopped before.
PREVIEW, PREVIEW_SPP = ("blue_noise_first", "blue_noise_pure"), 64
ANSWER_COUNTS = (1, 4, 16, 64)
SPREAD_COUNTS = (1, 4, 16, 64)

INTRO = f"""Figures are error ratios, Cycles' pattern over `blue` of [examples/cycles](../../examples/cycles/README.md), at the same number of
samples per pixel: 1.20 means that Cycles' pattern has 1.20 times the error of `blue`, less than 1 that `blue` has more. They are geometric
means over scenes and seeds; in brackets is the 95 % interval of a bootstrap over both. Errors are root mean squares over the pixels and
channels of pictures of {SIZE[0]}x{SIZE[1]} pixels, the middle of ones {ZOOM} times as wide, after a Gaussian blur of 2.1 pixels unless a
table says otherwise. *As displayed* clips pictures to 0..1 before the blur, *raw* does not.
"""

METHOD = """The patterns are the values `tabulated_sobol`, `blue_noise_first` and `blue_noise_pure` of Cycles' `sampling_pattern`, which are told
the number of samples (`aa_samples`) of each picture unless a table says otherwise, and `blue`, which is not. Clamping of indirect light is
Cycles' own, and the pixel filter is the stand-alone program's, a box. Cycles puts sample 0 into the middle of the pixel, whatever the
pattern. `penumbra` and `lens` guided the choice of what is drawn where.

References are means of two pictures by `sobol_burley` with seeds of their own, so their errors are independent of all others'. Half the
difference of the two is a reference's own error. A scene counts where the error of `blue` is at least three times that;
where a cell is empty, the reference is too noisy."""


class Report(OtherReport):
    """options: of cycles.parse_options()."""

    def __init__(self, options, cells, references, samplers):
        super().__init__(options, cells, references, samplers, NAMES, "tabulated_sobol", SIZE[0] * SIZE[1])
        self.gains = Gains(cells, references, samplers)

    # ---- Errors

    def table(self, measure, **form):
        return self.ratios(self.gains, "error over `blue`'s, at spp", [(than, NAMES[than]) for than in self.own], self.counts, measure, **form)

    def preview_table(self, measure):
        return self.ratios(self.gains, "error over `blue`'s, at spp", [(f"{than} {PREVIEW_SPP}", NAMES[than]) for than in PREVIEW],
                           [spp for spp in self.counts if spp < PREVIEW_SPP], measure)

    def summary(self):
        """The table of examples/cycles/README.md: as displayed and in brackets raw."""
        told = [(f"{than} {PREVIEW_SPP}", f"{NAMES[than]}, told {PREVIEW_SPP}") for than in PREVIEW]
        return (f"Scenes: {len(self.gains.views)}; seeds: {self.options.seeds}.\n\n" + self.ratios(
            self.gains, "error over `blue`'s, at spp", [*((than, NAMES[than]) for than in self.own), *told], self.counts, HEADLINE))

    def scenes_table(self, measure, than):
        counts, rows = [n for n in SPREAD_COUNTS if n in self.counts], []
        for view in self.gains.views:
            found = [self.gains.gain("blue", spp, measure, than, (view,)) for spp in counts]
            rows.append([f"`{view.scene}`: {SCENES[view.scene].what}", *(f"{gain.value:.2f}" if gain else "" for gain in found)])
        return md_table([f"{NAMES[than]} over `blue`", *map(str, counts)], rows)

    # ---- Adaptive sampling

    def mean_ratio(self, name, than, threshold):
        """(mean, low, high) of a figure of adaptive pictures, the other's over that of `blue`."""
        scenes = []
        for view in self.gains.views:
            own, other = (self.cells.get(view, f"{label} {threshold}", ADAPTIVE_SPP, name) for label in ("blue", than))
            if own and other and min(*own, *other) > 0:
                scenes.append(np.log(other) - np.log(own))
        return [math.exp(value) for value in bootstrap(scenes)] if scenes else None

    def adaptive_table(self):
        rows = []
        for threshold in ADAPTIVE:
            for label in self.samplers:
                samples = [np.mean(found) for found in (self.cells.get(view, f"{label} {threshold}", ADAPTIVE_SPP, "samples")
                                                        for view in self.gains.views) if found]
                row = [str(threshold), self.name(label), f"{np.mean(samples):.1f}" if samples else ""]
                for name in ("samples", *HEADLINE):
                    found = self.mean_ratio(name, label, threshold) if label != "blue" else None
                    row.append("{:.2f} ({:.2f} to {:.2f})".format(*found) if found else "")
                rows.append(row)
        return md_table(["threshold", "pattern", "mean samples", "samples over `blue`'s",
                         *(f"error over `blue`'s, {name_of(measure)}" for measure in HEADLINE)], rows)

    # ---- References

    def references_table(self):
        rows = []
        for view, reference in self.references.items():
            shares = [f"{self.own_share(view, measure):.2f}" for measure in HEADLINE]
            rows.append([f"`{view.scene}`", str(reference.spp), *shares])
        return md_table(["scene", "samples", *(f"own error, {name_of(measure)}" for measure in HEADLINE)], rows)

    # ---- All

    def answer(self):
        """Three sentences."""
        counts = [n for n in ANSWER_COUNTS if n in self.counts]
        said, raw = ([", ".join(f"{gain.value:.2f}" if gain else "?" for gain in (
            self.gains.gain("blue", spp, measure, than) for spp in counts)) for than in self.own] for measure in HEADLINE)
        at = f"At {', '.join(map(str, counts[:-1]))} and {counts[-1]} samples" if len(counts) > 1 else f"At {counts[0]} sample"
        threshold = ADAPTIVE[-1]
        samples, error = (self.mean_ratio(name, "tabulated_sobol", threshold) for name in ("samples", HEADLINE[0]))
        last = ("With adaptive sampling and a threshold of {}, Tabulated Sobol takes {:.2f} ({:.2f} to {:.2f}) times the samples of `blue` and ends "
                "with {:.2f} ({:.2f} to {:.2f}) times its error. ".format(threshold, *samples, *error) if samples and error else "")
        early = [n for n in counts if n < PREVIEW_SPP]
        preview = [", ".join(f"{gain.value:.2f}" if gain else "?" for gain in (
            self.gains.gain("blue", spp, HEADLINE[0], f"{than} {PREVIEW_SPP}") for spp in early)) for than in PREVIEW]
        return (f"{at}, Tabulated Sobol, the default of Cycles' stand-alone program, has {said[0]} times the error of `blue` as "
                f"displayed (raw {raw[0]}). Told the number of samples, Cycles' blue noise has {said[2]} times with *pure* (raw {raw[2]}) and {said[1]} times "
                f"with *first* (raw {raw[1]}). Told {PREVIEW_SPP} and stopped at {', '.join(map(str, early))}, as in a preview, *pure* has {preview[1]} times "
                f"and *first* {preview[0]} times. "
                f"{last}A sample with `blue` takes {self.time('blue'):.2f} times as long as with Tabulated Sobol.")

    def text(self):
        parts = ["# In Cycles", "", self.answer(), "", INTRO]
        for measure in HEADLINE:
            parts += [f"{name_of(measure).capitalize()}:", "", self.table(measure), ""]
        parts += ["## Scene by scene", ""]
        for measure in HEADLINE:
            for than in ("tabulated_sobol", "blue_noise_pure"):
                parts += [f"{name_of(measure).capitalize()}:", "", self.scenes_table(measure, than), ""]
        parts += ["## Stopped early", "", f"As a preview shows them: told {PREVIEW_SPP} samples, of which so many have been taken. `blue` is "
                  "not told.", ""]
        for measure in HEADLINE:
            parts += [f"{name_of(measure).capitalize()}:", "", self.preview_table(measure), ""]
        if any(self.cells.get(view, f"blue {ADAPTIVE[0]}", ADAPTIVE_SPP, "samples") for view in self.gains.views):
            parts += ["## Adaptive sampling", "", f"At most {ADAPTIVE_SPP} samples, which is also what the patterns are told, with Cycles' default "
                      "minimum. Cycles splits a pixel's samples into two halves by bits of the index and stops where they agree: if the halves of "
                      "a pattern are better spread, they agree sooner, though its error may not be less.", "", self.adaptive_table(), ""]
        parts += ["## Time", "", "Processor seconds of `--threads 1`, without what starting Cycles takes. On a machine with other work a few "
                  "per cent mean nothing.", "", self.times_table("pattern"), ""]
        parts += ["## Other blurs", ""]
        for kind in ("displayed", "rmse"):
            for sigma in ("1.0", "0.0"):
                parts += [f"{name_of(f'{kind}_{sigma}').capitalize()}:", "", self.table(
                    f"{kind}_{sigma}", cell=lambda gain: f"{gain.value:.2f}"), ""]
        parts += ["## How it was measured", "", f"`{self.options.command}`, Cycles v4.2.0, {self.options.seeds} seeds.", "", METHOD, "",
                  f"Own errors are those of references over the smallest error of any pattern at {self.counts[-1]} samples.", "",
                  self.references_table()]
        return "\n".join(parts) + "\n"
