# SPDX-License-Identifier: Apache-2.0
"""Updates the README's table, and the answers and table in evidence/README.md, from the benches' CSV files: `scripts/bench summary`"""

import functools

from ..base.command import CommandError, Parser
from ..base.files import read_numbers
from ..base.tables import md_table, series, update_table
from ..measure.statistics import Estimate
from ..realtime.realtime import in_order
from ..renders.renders import HEADLINE, NAMES, TO_WHITE
from ..renders.times import over
from ..samplers.samplers import PEAKS

COMMAND = "scripts/bench summary"
COUNTS = (1, 2, 3, 4, 6, 8, 16, 32, 64)
RESULTS = "renders.csv"
# Rows of the README's table: sampler, name, whether it must know the sample count, whether it shows patterns.
SHORT = (("blue", "**`blue`**", "no", "no"), ("sobol-global", "global Sobol': one sequence over the image", "no", "[yes](docs/blue.md#visible-patterns)"),
         ("zorder", "Z-order, as in pbrt-v4 and Cycles", "yes", "no"), ("sobol", "padded Sobol', in each pixel", "no", "no"))
LONG = ("white", "mask", "blue", "sobol-global", "zorder", "openqmc-sobolbn", "openqmc-pmjbn", "openqmc-latticebn")


def read(path):
    """{(measure, scene, sampler, spp): Estimate}."""
    try:
        rows = read_numbers(path)
    except OSError:
        raise CommandError(f"{path} is missing; run scripts/bench renders") from None
    return {(row["measure"], row["scene"], row["sampler"], row["spp"]): Estimate(*(row[name] for name in ("error", "low", "high", "scenes", "crops", "left_out")))
            for row in rows}


def short_table(found):
    """The sample counts that match the error of 16 samples of white noise."""
    rows = []
    for label, name, tuned, patterns in SHORT:
        if own := found.get((TO_WHITE, "", label, 16)):
            count = f"{16 * own.value:.1f}"
            rows.append([name, f"**{count}**" if label == "blue" else count, tuned, patterns])
    return md_table(["sampler", "samples to match 16 of white noise", "must know the count", "visible patterns"], rows, 2)


def table(found):
    """Errors over padded Sobol'."""
    rows = [[NAMES[label], *(own.text() if (own := found.get((HEADLINE, "", label, spp))) else "" for spp in COUNTS)] for label in LONG]
    return md_table(["error over padded Sobol'", *map(str, COUNTS)], [row for row in rows if any(row[1:])])


# ---- Answers, each from one bench's CSV file if it exists

EFFECTS = {"cornell": "indirect light in a box", "penumbra": "soft shadows", "glossy": "glossy reflections", "lens": "depth of field", "glass": "clear glass",
           "interior": "many bounces", "motion": "motion blur", "fog": "fog"}


def less(*values):
    """"30%, 24% and 20%" for errors over padded Sobol'."""
    return series([f"{100 * (1 - value):.0f}%" for value in values])


def less_at(found, label, measure, counts, scene=""):
    return less(*(own.value for spp in counts if (own := found.get((measure, scene, label, spp)))))


def of_renders(found):
    white = {label: f"{16 * own.value:.1f} ({16 * own.low:.1f} to {16 * own.high:.1f})" for (measure, _, label, _), own in found.items() if measure == TO_WHITE}
    yield "How many samples do I save?", (
        f"to match the visible error of 16 independent random samples, you need {white['blue']} samples with `blue`; {white['sobol-global']} with global Sobol'; "
        f"{white['zorder']} with Z-order tuned for the sample count; and {white['sobol']} with padded Sobol'. The 95% intervals in brackets are wide because results vary from scene to scene"), "renders.md#samples-needed"
    sharp = [own for spp in COUNTS if (own := found.get(("displayed", "", "blue", spp)))]
    ends = " to ".join(f"{end(own.value for own in sharp):.2f}" for end in (min, max)) + " times that of padded Sobol'" + " (none of these differences is significant)" * (not any(own.significant for own in sharp))
    yield "How much does the gain depend on the blur?", (
        f"after a 2.1-pixel blur, `blue` has {less_at(found, 'blue', 'displayed_2.1', (1, 4, 16, 64))} less error than padded Sobol' at 1, 4, 16 and 64 samples, respectively; after a 1.0-pixel "
        f"blur, it has {less_at(found, 'blue', 'displayed_1.0', (1, 4, 16, 64))} less. Without a blur, its error is {ends}"), "renders.md"
    scenes = {scene: own for (measure, scene, label, spp), own in found.items() if (measure, label, spp) == (HEADLINE, "blue", 16) and scene}
    order = sorted(scenes, key=lambda scene: scenes[scene].value)
    most, least = (series([f"{EFFECTS.get(name, f'the `{name}` model')} ({less(scenes[name].value)}{', not significant' * (not scenes[name].significant)})" for name in names])
                   for names in (order[:3], order[:-4:-1]))
    yield ("Which effects gain most, and which least?", f"the gain over padded Sobol' at 16 samples is largest for {most}, and smallest for {least}",
           "renders.md#scene-by-scene")
    yield "Adaptive sampling or time limits?", (
        f"`blue` doesn't need to know the sample count. At 3 and 6 samples, it has {less_at(found, 'blue', HEADLINE, (3, 6))} less error than padded Sobol', respectively. Z-order has only "
        f"{less_at(found, 'zorder', HEADLINE, (3, 6))} less, even when tuned for these sample counts"), "renders.md"
    wins = []
    for measure, after in ((HEADLINE, "after a 2.1-pixel blur"), ("displayed_1.0", "after a 1.0-pixel blur")):
        for label in LONG:
            better = [(own.value / blue.value, spp, own.value, blue.value) for spp in COUNTS
                      if (own := found.get((measure, "", label, spp))) and (blue := found.get((measure, "", "blue", spp))) and own.value < 0.995 * blue.value]
            if better:
                _, spp, own, blue = min(better)
                wins.append(f"{NAMES[label]} {after} at {spp} sample{'s' * (spp > 1)} ({own:.2f}, compared with {blue:.2f} for `blue`)")
    yield "Where do others win?", (
        "averaged over scenes, the samplers that beat `blue` by the widest margins are " + (series(wins) or "none") + ". The errors in brackets are relative to padded Sobol'. Other samplers win by more in [single frames]"
        "(results/realtime.md), with single numbers, and where `u[3]` selects a light or lobe ([list](results/samplers.md#where-others-win)). Z-order also has "
        "lower error for products across two pairs of numbers, especially beyond 64 samples ([counts](results/samplers.md#every-count))"), "renders.md"


def of_denoise(found):
    own = {spp: found["plain:displayed", "", "blue", spp] for spp in (1, 2, 4, 16)}
    gains = [str(spp) for spp, each in own.items() if each.significant]
    significant = f"The gain is significant only at {series(gains)} sample{'s' * (gains != ['1'])}." if gains else "None of these gains is significant."
    yield "What about a denoiser?", (
        f"after Open Image Denoise, `blue` has {less_at(found, 'blue', 'plain:displayed', own)} less error than padded Sobol' at 1, 2, 4 and 16 samples, respectively. {significant} "
        f"The references are accurate enough for only {series([str(each.crops) for each in own.values()])} of the {own[1].crops + own[1].left_out} crops of built-in scenes. After denoising and a 2.1-pixel blur, it has {less_at(found, 'blue', 'plain:displayed_2.1', own)} less"), "denoise.md"


def compared(factors):
    """Ratios, and which of them differ significantly from 1."""
    different = [f"{own.value:.2f}" for own in factors if own.significant]
    return f"{series([f'{own.value:.2f}' for own in factors])}, {'of which ' + series(different) if different else 'none of them'} significantly different from 1"


def of_pbrt(rows):
    found = {(scene, label, spp): own for (measure, scene, label, spp), own in rows.items() if measure == HEADLINE}
    fixed, random = ([found[scene, "zsobol", spp] for spp in (2, 4, 16)] for scene in ("Fixed wavelengths", "Four random wavelengths"))
    yield "In pbrt-v4?", (f"with four random wavelengths per path (pbrt's default), `zsobol` has {series([f'{own.value:.2f} (95% interval {own.low:.2f} to {own.high:.2f})' for own in random])} times the error of `blue` "
                          "at 2, 4 and 16 samples after a 2.1-pixel blur. A few scenes account for nearly all of this gain ([limits](../examples/pbrt/README.md)). With fixed wavelengths, "
                          f"the factors are {compared(fixed)}"), "pbrt.md"


def of_cycles(rows):
    found = {(label, spp): own for (measure, scene, label, spp), own in rows.items() if (measure, scene) == (HEADLINE, "Scenes")}
    tabulated, pure = ([found[label, spp] for spp in (4, 16, 64)] for label in ("tabulated_sobol", "blue_noise_pure"))
    yield "In Cycles?", (f"at 4, 16 and 64 samples, Tabulated Sobol has {series([f'{own.value:.2f}' for own in tabulated])} times the error of `blue` after a 2.1-pixel blur. For Cycles' *pure* blue noise, which is tuned for the sample count, "
                         f"the factors are {compared(pure)}"), "cycles.md"


def of_realtime(rows):
    own = in_order(rows)

    def at(outcome):
        names = {"blue": "`blue`", "mask + golden ratio, R2": "a shifted mask", "STBN": "STBN", "FAST": "FAST",
                 **({"interleaved gradient noise": "interleaved gradient noise"} if outcome == "one frame" else {})}
        return series([f"{own[way]['half-plane', outcome, 'sigma 1.0']:.2f} for {name}" for way, name in names.items() if way in own])

    yield "Real time?", (f"use `blue` if frames are averaged and each effect uses two or four numbers; for single frames, use interleaved gradient noise, FAST or a mask. With two numbers per effect and a still camera, these are the errors after a 1.0-pixel blur, relative to padded Sobol'. Averaged frames with a still camera and a frame weight of 0.1: {at('average, 0.1')}; with a weight of 0.05: {at('average, 0.05')}. Single frames: {at('one frame')}"), "realtime.md"


def of_cost(found, samples, draws):
    times = {(row["sampler"], row["form"]): float(row["nanoseconds"]) for row in draws}
    inline = {"`blue`": times["blue", "inline"], "libbn's padded Sobol'": times["sobol", "inline"],
              **{NAMES.get(name, name): value for (name, form), value in times.items() if form == "peer"}}
    text = (f"drawing four numbers inline takes {series([f'{value:.0f} ns with {name}' for name, value in inline.items()])}. In wavefronts, it takes "
            f"{times['blue', 'many']:.1f} ns with `blue` and {times['sobol', 'many']:.1f} ns with padded Sobol'")
    if samples:
        cost = over(samples, "white")
        share = {label: f"{100 * time * found[TO_WHITE, '', label, 16].value:.0f}" for label, time in cost.items() if (TO_WHITE, "", label, 16) in found}
        others = [f"{share[label]}% for {NAMES[label].partition(', ')[0]}" for label in sorted(share, key=lambda label: float(share[label])) if label not in ("white", "blue", "mask")]
        text += (f". To reach the visible error of 16 independent random samples, `blue` needs {share['blue']}% of their CPU time. This figure is "
                 f"{series(others)} ([measured](results/times.csv) in eight scenes; times vary between scenes)")
    yield "What does it cost?", text, "samplers.md#time-per-draw"


def of_samplers(rows):
    peaks = {}
    for row in rows:
        if row["row"] == PEAKS:
            peaks[row["sampler"]] = max(peaks.get(row["sampler"], 0), row["value"])
    yield "Does it show patterns?", (f"no. Its largest spectral peaks are {peaks['blue']:.1f} times the mean power, compared with {peaks['white']:.1f} for white noise and padded Sobol', {peaks['zorder']:.1f} for "
                                     f"Z-order, {peaks['mask']:.1f} for a mask and {peaks['sobol-global']:.1f} for global Sobol'"), "samplers.md#spectral-peaks"


def of_worst(rows):
    blue, sobol = (sorted(row[name] for row in rows) for name in ("blue", "sobol"))
    worse = sum(row["blue"] > row["sobol"] for row in rows)
    yield "How bad can a seed be?", (f"`blue` has a higher error than padded Sobol' for {worse} of {len(rows)} seeds at 4 samples per pixel in a crop of `penumbra`, the scene that gains most (`scripts/bench picture`). With its worst seed, `blue` has "
                                       f"{blue[-1] / sobol[len(sobol) // 2]:.2f} times the median error of padded Sobol'; with its own worst seed, padded Sobol' has {sobol[-1] / sobol[len(sobol) // 2]:.2f} times this median"), "worst.csv"


def answers(folder):
    """One line for each question whose CSV exists."""
    def rows(name, of=read_numbers):
        return of(folder / name) if (folder / name).is_file() else []

    renders = rows(RESULTS, read)
    own = {of_denoise: rows("denoise.csv", read), of_pbrt: rows("pbrt.csv", read), of_cycles: rows("cycles.csv", read),
           of_realtime: rows("realtime.csv"), functools.partial(of_cost, renders, rows("times.csv")): rows("samplers_draws.csv"),
           of_samplers: rows("samplers.csv"), of_worst: rows("worst.csv")}
    found = [*of_renders(renders), *(answer for of, given in own.items() if given for answer in of(given))]
    return "\n".join(f"- **{question}** {text[0].upper()}{text[1:]} ([details]({folder.name}/{link}))." for question, text, link in found)


def run(arguments):
    parser = Parser("summary", __doc__)
    parser.out()
    parser.hidden("--readme", "README.md")
    parser.add_argument("--print", action="store_true", help="print the tables without changing files")
    options = parser.parse_args(arguments)
    found, page = read(options.out / RESULTS), options.out.parent / "README.md"
    if not options.print:
        update_table(options.readme, COMMAND, short_table(found))
        update_table(page, COMMAND, table(found))
        update_table(page, f"{COMMAND}: answers", answers(options.out))
    print(answers(options.out), short_table(found), table(found), sep="\n\n")
