# SPDX-License-Identifier: Apache-2.0
"""The text of pbrt.md: how many times smaller the error of `blue` is than that of pbrt's samplers, and the time it takes."""

import math

import numpy as np

from ..base.tables import md_table
from ..measure.gains import BEST_PEER, Gain, Gains, bootstrap, row_of
from ..measure.image_error import SIGMAS
from ..measure.ratios import seconds_to_error
from .other_renderer import HEADLINE, KINDS, OtherReport, name_of
from .pbrt_build import COMMIT
from .pbrt_scenes import CROP, HEIGHT, HELD_OUT, SCENES, TUNING, WIDTH

HEADLINE_THANS = ("independent", "sobol", "halton", "zsobol", BEST_PEER)
HEADLINE_COUNTS = (1, 2, 3, 4, 6, 16, 64)
SPREAD_COUNTS = (1, 4, 16, 64)
WANTED_SAMPLER, WANTED_SPP = "zsobol", 16

TITLE = "# In pbrt-v4\n"
INTRO = f"""How the sampler of [examples/pbrt](../../examples/pbrt/README.md) compares with pbrt-v4's own, in pbrt-v4. Figures are error
ratios, pbrt's sampler over `blue`, at the same `--spp`: 1.20 means that pbrt's sampler has 1.20 times the
error of `blue`, less than 1 that `blue` has more. They are geometric means over scenes, crops and seeds; in brackets is the 95 %
interval of a bootstrap over all three.

Errors are root mean squares over the pixels and channels of crops of {CROP[0]}x{CROP[1]} pixels from pictures of {WIDTH}x{HEIGHT},
after a Gaussian blur of 2.1 pixels unless a table says otherwise. *As displayed* clips pictures to 0..1 before the blur, *raw*
does not. Hashes of the names place the crops. The sampler and the layout of its decisions were chosen by other crops, of the tuning
scenes {', '.join(TUNING)}.

`zsobol` rounds counts down to powers of two: at 3 and 6 it takes 2 and 4 samples.
"""

METHOD = """pbrt's film has its neutral sensor (`cie1931`) and a box filter one pixel wide, the integrator is `volpath`. `--spp` and
`--seed` set counts and seeds, other options of samplers are pbrt's defaults. `halton` and `sobol` keep the positions in the pixel for
all seeds.

References are means of two pictures by `paddedsobol`. It hashes pixel, dimension and seed, and the references have seeds of their
own, so their errors are independent of all others'. Half the difference of the two pictures is a reference's own error. A crop
counts where the error of `blue` is at least three times that."""


def answer(rows, rest):
    """Where blue is ahead of pbrt's default and of the best of all, and where not: sentences from rows of Report.headline_rows(), over
    the first scenes and, if there are any, over those without SPECTRAL."""
    def of(rows, than):
        found = {int(row["spp"]): float(row["gain"]) for row in rows if row["measure"] == HEADLINE[0] and row["than"] == than}
        return {spp: value for spp, value in found.items() if spp in HEADLINE_COUNTS}

    def spread(values):
        return f"{min(values):.2f} to {max(values):.2f}"

    def against_default(found):
        powers = spread([value for spp, value in found.items() if not spp & (spp - 1)])
        others = [f"{value:.2f} at {spp}" for spp, value in found.items() if spp & (spp - 1)]
        return f"{powers} times the error of `blue` at powers of two" + (f" (and {', '.join(others)})" if others else "")

    parts = []
    if default := of(rows, "zsobol"):
        parts.append(f"As displayed, after a blur, pbrt's default `zsobol` has {against_default(default)}. At other counts it takes fewer samples.")
    if best := of(rows, "best of pbrt"):
        behind = [f"{spp} ({value:.2f})" for spp, value in best.items() if value < 1]
        parts.append(f"The best of all of pbrt's samplers, chosen at each count afterwards, has {spread(best.values())} times"
                     + (f" and is ahead at {', '.join(behind)}." if behind else "."))
    if default and best and rest:
        parts.append(f"One scene, `{SPECTRAL}`, decides much of that and makes intervals wide: without it `zsobol` has "
                     f"{against_default(of(rest, 'zsobol'))}, and the best {spread(of(rest, 'best of pbrt').values())} times.")
    return " ".join(parts)


def than_name(than):
    return "best of pbrt's" if than == BEST_PEER else f"`{than}`"


WAVELENGTHS = """Two crops of `hair` show an evenly lit background alone, where nothing but wavelengths is noisy. A path has four of them.
`pmj02bn` spaces its single numbers evenly: with 3 and 6 samples there are 12 and 24 evenly spaced wavelengths, but with 4 the
samples' sets of four nearly coincide. With 2 to 7 samples `blue` always spaces wavelengths evenly, and with one it takes them from a mask.
These two crops prompted that; how to do it was chosen by the tuning crops."""
SPECTRAL = "hair"


class Report(OtherReport):
    """options: of pbrt.parse_options(); remarks: of pbrt_build.Built."""

    def __init__(self, options, cells, references, remarks):
        super().__init__(options, cells, references, options.samplers, {}, "independent", CROP[0] * CROP[1])
        self.remarks = remarks
        self.thans = [(than, than_name(than)) for than in (*self.own, BEST_PEER)]
        self.sets = {}
        for title, scenes in (("Held-out scenes", HELD_OUT), ("Tuning scenes", TUNING)):
            gains = self.gains_of(scenes)
            if gains.views:
                self.sets[title] = gains

    def gains_of(self, scenes):
        gains = Gains(self.cells, {view: own for view, own in self.references.items() if view.scene in scenes}, self.samplers)
        gains.peers = self.own
        return gains

    def without_spectral(self):
        """Gains over the held-out scenes but SPECTRAL; None without it, or of it alone."""
        rest = self.gains_of([scene for scene in HELD_OUT if scene != SPECTRAL])
        return rest if 0 < len(rest.views) < len(next(iter(self.sets.values())).views) else None

    # ---- Errors

    def headline(self, gains, measure):
        thans = [than for than in HEADLINE_THANS if than in (*self.own, BEST_PEER)]
        rows = []
        for spp in self.counts:
            if spp in HEADLINE_COUNTS:
                found = [gains.gain("blue", spp, measure, than) for than in thans]
                best = gains.best_peer(spp, measure)
                rows.append([str(spp), *(gain.text() if gain else "" for gain in found), f"`{best}`" if best else ""])
        return md_table(["spp", *map(than_name, thans), "which is"], rows)

    def summary(self):
        """The table of examples/pbrt/README.md: over held-out scenes, as displayed and in brackets raw."""
        gains, counts = next(iter(self.sets.values())), [n for n in HEADLINE_COUNTS if n in self.counts]
        scenes = len({view.scene for view in gains.views})
        return (f"{next(iter(self.sets))}: {scenes}; crops: {len(gains.views)}; seeds: {self.options.seeds}.\n\n"
                + self.ratios(gains, "error over `blue`'s, at spp", self.thans, counts, HEADLINE))

    def headline_rows(self, gains=None):
        """What `scripts/bench summary` reads: over held-out scenes, in the form of gains.write_rows()."""
        gains = gains or next(iter(self.sets.values()))
        found = [(gains.gain("blue", spp, measure, than), measure, spp, "blue", "best of pbrt" if than == BEST_PEER else than)
                 for measure in HEADLINE for spp in self.counts for than in (*self.own, BEST_PEER)]
        return [row_of(*row) for row in found if row[0]]

    def scenes_table(self, gains, measure, than):
        """One row per scene: the ratio at SPREAD_COUNTS, and its smallest and greatest over crops."""
        rows = []
        for scene in dict.fromkeys(view.scene for view in gains.views):
            views = tuple(view for view in gains.views if view.scene == scene)
            row = [f"{scene}: {SCENES[scene].what}"]
            for spp in (n for n in SPREAD_COUNTS if n in self.counts):
                whole = gains.gain("blue", spp, measure, than, views)
                each = [gain.value for gain in (gains.gain("blue", spp, measure, than, (view,)) for view in views) if gain]
                row.append(f"{whole.value:.2f} ({min(each):.2f} to {max(each):.2f})" if whole else "")
            rows.append(row)
        return md_table([f"{than_name(than)} over `blue`", *(str(n) for n in SPREAD_COUNTS if n in self.counts)], rows)

    # ---- Time

    def seconds(self, view, label, measure, wanted):
        rate = self.rate(view, label)
        errors = [self.rms(view, label, spp, measure) for spp in self.counts]
        return seconds_to_error([rate * spp for spp in self.counts], errors, wanted)

    def equal_error(self, gains, measure, label):
        """A Gain: how many times longer `label` takes than blue for the error of WANTED_SAMPLER at WANTED_SPP."""
        scenes, left_out = {}, 0
        for view in gains.views:
            wanted = self.rms(view, WANTED_SAMPLER, WANTED_SPP, measure)
            own, other = (self.seconds(view, name, measure, wanted) for name in ("blue", label))
            if math.isfinite(own) and math.isfinite(other) and gains.is_judged(view, WANTED_SAMPLER, WANTED_SPP, measure):
                scenes.setdefault(view.scene, []).append(np.log([other / own]))
            else:
                left_out += 1
        if not scenes:
            return None
        mean, low, high = (math.exp(value) for value in bootstrap(list(scenes.values())))
        return Gain(mean, low, high, len(scenes), sum(map(len, scenes.values())), left_out)

    def equal_error_table(self, gains):
        rows = []
        for label in self.own:
            found = [self.equal_error(gains, measure, label) for measure in HEADLINE]
            rows.append([f"`{label}`", *(f"{gain.text()}, {gain.left_out} left out" if gain else "" for gain in found)])
        return md_table(["processor time over `blue`'s", *map(name_of, HEADLINE)], rows)

    # ---- References

    def references_table(self):
        rows = []
        for scene in dict.fromkeys(view.scene for view in self.references):
            views = [view for view in self.references if view.scene == scene]
            shares = [max(self.own_share(view, measure) for view in views) for measure in HEADLINE]
            places = ", ".join(f"{view.x0}+{view.y0}" for view in views)
            rows.append([scene, SCENES[scene].what, places, str(self.references[views[0]].spp),
                         *(f"{share:.2f}" for share in shares)])
        return md_table(["scene", "", "crops at", "samples", *(f"own error, {name_of(measure)}" for measure in HEADLINE)], rows)

    # ---- All

    def text(self):
        rest = self.without_spectral()
        parts = [TITLE, answer(self.headline_rows(), self.headline_rows(rest) if rest else []), "", INTRO]
        for title, gains in self.sets.items():
            parts += [f"## {title}", ""]
            for measure in HEADLINE:
                parts += [f"{name_of(measure).capitalize()}:", "", self.headline(gains, measure), ""]
        if rest:
            if self.options.views == "final":
                parts += [WAVELENGTHS, ""]
            parts += [f"Held-out scenes without `{SPECTRAL}`, {name_of(HEADLINE[0])}:", "", self.headline(rest, HEADLINE[0]), ""]
        parts += ["## Scene by scene", "", "In brackets: the smallest and the greatest of a scene's crops.", ""]
        for gains in self.sets.values():
            for measure in HEADLINE:
                for than in ("zsobol", BEST_PEER):
                    if than in (*self.own, BEST_PEER):
                        parts += [f"{name_of(measure).capitalize()}:", "", self.scenes_table(gains, measure, than), ""]
        if "independent" in self.samplers:
            parts += ["## Time", "", "Processor seconds of `--nthreads 1`, without what starting pbrt takes.", "", self.times_table("sampler"), ""]
        if WANTED_SAMPLER in self.samplers and WANTED_SPP in self.counts:
            gains = next(iter(self.sets.values()))
            parts += [f"Time to the error that `{WANTED_SAMPLER}` has at {WANTED_SPP} samples, {next(iter(self.sets)).lower()}; crops "
                      f"where a sampler does not reach it with {self.counts[-1]} samples are left out:", "",
                      self.equal_error_table(gains), ""]
        for title, gains in self.sets.items():
            parts += [f"## All measures, {title.lower()}", ""]
            for kind in KINDS:
                for sigma in reversed(SIGMAS):
                    measure = f"{kind}_{sigma}"
                    parts += [f"{name_of(measure).capitalize()}:", "", self.ratios(
                        gains, "over `blue`", self.thans, self.counts, measure, lambda gain: f"{gain.value:.2f}"), ""]
        parts += ["## How it was measured", "", f"`{self.options.command}`, pbrt-v4 at commit `{COMMIT[:8]}`, "
                  f"{self.options.seeds} seeds.", *(f" {remark}" for remark in self.remarks), "", METHOD, "",
                  "Crops are named by their left and upper pixels. Own errors are those of references over the smallest error of any "
                  f"sampler at {self.counts[-1]} samples, the greatest of a scene's crops.", "", self.references_table()]
        return "\n".join(parts) + "\n"
