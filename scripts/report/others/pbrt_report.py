# SPDX-License-Identifier: Apache-2.0
"""The text of pbrt.md: how many times smaller the error of `blue` is than that of pbrt's samplers, and the time it takes."""

import math

import numpy as np

from ..base.tables import md_table
from ..measure.gains import BEST_PEER, Gain, Gains, bootstrap, row_of
from ..measure.image_error import SIGMAS
from ..measure.ratios import seconds_to_error
from . import lux_scenes
from .other_renderer import EXPOSED, HEADLINE, KINDS, MEASURES, OtherReport, name_of
from .pbrt_build import COMMIT
from .pbrt_scenes import CROP, HEIGHT, HELD_OUT, SCENES, TUNING, WIDTH

SPREAD_COUNTS = (1, 4, 16, 64)
WANTED_SAMPLER, WANTED_SPP = "zsobol", 16
SPECTRAL = "hair"
SETS = {"Scenes from LuxCoreRender": tuple(lux_scenes.SCENES), "Scenes of ours": tuple(name for name in HELD_OUT if name != SPECTRAL),
        "Hair": (SPECTRAL,), "Tuning scenes": tuple(TUNING)}

TITLE = "# In pbrt-v4\n"
INTRO = f"""How the sampler of [examples/pbrt](../../examples/pbrt/README.md) compares with pbrt-v4's own, in pbrt-v4. Figures are error
ratios, pbrt's sampler over `blue`, at the same `--spp`: 1.20 means that pbrt's sampler has 1.20 times the
error of `blue`, less than 1 that `blue` has more. They are geometric means over scenes, crops and seeds; in brackets is the 95 %
interval of a bootstrap over all three.

Errors are root mean squares over the pixels and channels of crops of {CROP[0]}x{CROP[1]} pixels from pictures of {WIDTH}x{HEIGHT}, after
a Gaussian blur or without. *As displayed* clips pictures to 0..1 before the blur; *exposed and displayed* first multiplies them so
that the mean luminance of a crop's reference is {EXPOSED}; *raw* does neither. Hashes of the names place the crops. Nothing was chosen or tuned by these crops,
nor by any of LuxCoreRender's scenes. Two other crops of `{SPECTRAL}` prompted how wavelengths are spread, so it is apart.

`zsobol` rounds counts down to powers of two: at 3 and 6 it takes 2 and 4 samples. `sobol` is one sequence over the whole picture. *Best
of pbrt's* is the best of its {{own}} here, chosen at each count afterwards.
"""

METHOD = """pbrt's film has its neutral sensor (`cie1931`) and a box filter one pixel wide, the integrator is `volpath`. `--spp` and
`--seed` set counts and seeds, other options of samplers are pbrt's defaults. `sobol` keeps the positions in the pixel for all seeds.
LuxCoreRender's scenes keep their meshes, cameras, lamps, plain colours and images; its skies and suns became an image of ours, layered
and procedural materials simple ones, and what its checkout lacks is left out.

References are means of two pictures by `paddedsobol`. It hashes pixel, dimension and seed, and the references have seeds of their
own, so their errors are independent of all others'. Half the difference of the two pictures is a reference's own error. A crop
counts where the error of `blue` is at least three times that."""


def answer(title, rows):
    """Where blue is ahead of pbrt's default, of its global Sobol' and of the best, and where not: from rows of Report.headline_rows()."""
    def of(measure, than):
        found = {int(row["spp"]): float(row["gain"]) for row in rows if row["measure"] == measure and row["than"] == than}
        return ", ".join(f"{value:.2f} at {spp}" for spp, value in found.items())

    parts = [f"`{than}` {found}" if than in ("zsobol", "sobol") else f"the best of pbrt's {found}"
             for than in ("zsobol", "sobol", "best of pbrt") if (found := of(HEADLINE[0], than))]
    return f"{title}, {name_of(HEADLINE[0])}, error over `blue`'s: {'; '.join(parts)}."


def than_name(than):
    return "best of pbrt's" if than == BEST_PEER else f"`{than}`"


class Report(OtherReport):
    """options: of pbrt.parse_options(); remarks: of pbrt_build.Built."""

    def __init__(self, options, cells, references, remarks):
        super().__init__(options, cells, references, options.samplers, {}, "independent", CROP[0] * CROP[1])
        self.remarks = remarks
        self.thans = [(than, than_name(than)) for than in (*self.own, BEST_PEER)]
        self.sets = {}
        for title, scenes in SETS.items():
            gains = self.gains_of(scenes)
            if gains.views:
                self.sets[title] = gains

    def gains_of(self, scenes):
        gains = Gains(self.cells, {view: own for view, own in self.references.items() if view.scene in scenes}, self.samplers)
        gains.peers = self.own
        return gains

    # ---- Errors

    def table(self, gains, measure):
        """One row per count, with intervals, and which of pbrt's is best."""
        rows = []
        for spp in self.counts:
            found = [gains.gain("blue", spp, measure, than) for than, _ in self.thans]
            best = gains.best_peer(spp, measure)
            rows.append([str(spp), *(gain.text() if gain else "" for gain in found), f"`{best}`" if best else ""])
        return md_table(["spp", *(name for _, name in self.thans), "which is"], rows)

    def summary(self):
        """The table of examples/pbrt/README.md: over the first scenes, as displayed and in brackets raw."""
        gains = next(iter(self.sets.values()))
        scenes = len({view.scene for view in gains.views})
        return (f"{next(iter(self.sets))}: {scenes}; crops: {len(gains.views)}; seeds: {self.options.seeds}.\n\n"
                + self.ratios(gains, "error over `blue`'s, at spp", self.thans, self.counts, HEADLINE))

    def headline_rows(self, gains=None):
        """What `scripts/bench summary` reads: over the first scenes, in the form of gains.write_rows()."""
        gains = gains or next(iter(self.sets.values()))
        found = [(gains.gain("blue", spp, measure, than), measure.removesuffix("_0.0"), spp, "blue", "best of pbrt" if than == BEST_PEER else than)
                 for measure in MEASURES for spp in self.counts for than in (*self.own, BEST_PEER)]
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
        parts = [TITLE]
        for title, gains in self.sets.items():
            parts += [answer(title, self.headline_rows(gains)), ""]
        parts += [INTRO.replace("{own}", str(len(self.own)))]
        for title, gains in self.sets.items():
            parts += [f"## {title}", ""]
            for measure in (f"{kind}_{sigma}" for kind in KINDS for sigma in reversed(SIGMAS)):
                parts += [f"{name_of(measure).capitalize()}:", "", self.table(gains, measure), ""]
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
        parts += ["## How it was measured", "", f"`{self.options.command}`, pbrt-v4 at commit `{COMMIT[:8]}`, "
                  f"{self.options.seeds} seeds.", *(f" {remark}" for remark in self.remarks), "", METHOD, "",
                  "Crops are named by their left and upper pixels. Own errors are those of references over the smallest error of any "
                  f"sampler at {self.counts[-1]} samples, the greatest of a scene's crops.", "", self.references_table()]
        return "\n".join(parts) + "\n"
