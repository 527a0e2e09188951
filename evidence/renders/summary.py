# SPDX-License-Identifier: Apache-2.0
"""The table of the README, and answers and table of evidence/README.md, from the CSV files of the benches: `scripts/bench summary`"""


from ..base.command import CommandError, Parser
from ..base.files import read_numbers
from ..base.tables import md_table, update_table
from ..measure.statistics import Estimate
from ..realtime.realtime import in_order
from ..samplers.samplers import PEAKS
from .renders import HEADLINE, NAMES, TO_WHITE

COMMAND = "scripts/bench summary"
COUNTS = (1, 2, 3, 4, 6, 8, 16, 32, 64)
RESULTS = "renders.csv"
# The README's rows: sampler, its name, whether it must know the count, whether it shows patterns.
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
    """How many samples have the error of 16 of white noise's."""
    rows = []
    for label, name, told, seen in SHORT:
        if own := found.get((TO_WHITE, "", label, 16)):
            count = f"{16 * own.value:.1f}"
            rows.append([name, f"**{count}**" if label == "blue" else count, told, seen])
    return md_table(["sampler", "samples to match 16 of white noise", "must know the count", "visible patterns"], rows, 2)


def table(found):
    """Errors over padded Sobol'."""
    rows = [[NAMES[label], *(own.text() if (own := found.get((HEADLINE, "", label, spp))) else "" for spp in COUNTS)] for label in LONG]
    return md_table(["error over padded Sobol'", *map(str, COUNTS)], [row for row in rows if any(row[1:])])


# ---- Answers, each from the CSV of one bench; none where that was not run

def joined(pairs):
    return ", ".join(f"{value:.2f} at {spp}" for spp, value in pairs)


def errors(found, label, measure, counts, scene=""):
    return [(spp, own.value) for spp in counts if (own := found.get((measure, scene, label, spp)))]


def of_renders(found):
    white = {label: 16 * own.value for (measure, _, label, _), own in found.items() if measure == TO_WHITE}
    yield "How many samples do I save?", (
        f"{white['blue']:.1f} samples of `blue` leave the visible error of 16 of white noise; padded Sobol' takes {white['sobol']:.1f}, global Sobol' "
        f"{white['sobol-global']:.1f}, Z-order tuned for the count {white['zorder']:.1f}"), "renders.md#samples-to-an-error"
    after = [(f"after sigma {sigma}" if sigma else "without a blur", errors(found, "blue", f"displayed_{sigma}" if sigma else "displayed", (1, 4, 16, 64)))
             for sigma in (2.1, 1.0, 0)]
    yield "At which blur, and without one?", "error over padded Sobol': " + "; ".join(f"{what} {joined(pairs)} samples" for what, pairs in after), "renders.md"
    scenes = {scene: own.value for (measure, scene, label, spp), own in found.items() if (measure, label, spp) == (HEADLINE, "blue", 16) and scene}
    order = sorted(scenes, key=scenes.get)
    yield "Which effects gain most, which nothing?", (
        f"at 16 samples most {', '.join(f'`{name}` ({scenes[name]:.2f})' for name in order[:3])}, least "
        f"{', '.join(f'`{name}` ({scenes[name]:.2f})' for name in order[:-4:-1])}"), "renders.md#scene-by-scene"
    yield "Adaptive sampling, time limits?", (
        f"no count has to be known: {joined(errors(found, 'blue', HEADLINE, (3, 6)))} samples; Z-order, even tuned for these counts, has "
        f"{joined(errors(found, 'zorder', HEADLINE, (3, 6)))}"), "renders.md"
    better = {}
    for (measure, scene, label, spp), own in found.items():
        if not scene and measure in ("displayed_2.1", "displayed_1.0") and label != "blue" and own.value < found[measure, "", "blue", spp].value - 0.005:
            better.setdefault((label, measure), []).append(f"{own.value:.2f} against {found[measure, '', 'blue', spp].value:.2f} at {spp}")
    said = "; ".join(f"{NAMES[label]} after sigma {measure.partition('_')[2]} ({', '.join(counts)})" for (label, measure), counts in better.items())
    yield "Where do others win?", said or "nowhere on average, after a blur", "renders.md"


def of_denoise(found):
    yield "What about a denoiser?", (
        f"after Open Image Denoise, error over padded Sobol', as displayed: {joined(errors(found, 'blue', 'plain:displayed', (1, 4, 16)))} samples; "
        f"after a blur besides {joined(errors(found, 'blue', 'plain:displayed_2.1', (1, 4, 16)))}"), "denoise.md"


def of_realtime(rows):
    own = in_order(rows)

    def at(outcome):
        names = {"blue": "blue", "mask + golden ratio, R2": "a moved mask", "STBN": "STBN", "FAST": "FAST"}
        return ", ".join(f"{name} {own[way]['half-plane', outcome, 'sigma 1.0']:.2f}" for way, name in names.items() if way in own)

    yield "Real time?", (f"two numbers after sigma 1.0, error over padded Sobol': averages of frames {at('average, 0.1')}; a single frame {at('one frame')}"), "realtime.md"


def of_draws(rows):
    times = {(row["sampler"], row["form"]): float(row["nanoseconds"]) for row in rows}
    peers = ", ".join(f"{NAMES.get(name, name)} {value:.0f}" for (name, form), value in times.items() if form == "peer")
    yield "What does it cost?", (f"four numbers take {times['blue', 'inline']:.0f} ns inline, padded Sobol' {times['sobol', 'inline']:.0f}"
                                 + f" ({peers})" * bool(peers)), "samplers.md#time-per-draw"


def of_samplers(rows):
    peaks = {}
    for row in rows:
        if row["row"] == PEAKS:
            peaks[row["sampler"]] = max(peaks.get(row["sampler"], 0), row["value"])
    yield "Does it show patterns?", (f"no: its largest spectral peaks are {peaks['blue']:.1f} times the mean power, white noise's {peaks['white']:.1f}, Z-order's "
                                     f"{peaks['zorder']:.1f}, global Sobol's {peaks['sobol-global']:.1f}"), "samplers.md#spectral-peaks"


def of_worst(rows):
    blue, sobol = (sorted(row[name] for row in rows) for name in ("blue", "sobol"))
    worse = sum(row["blue"] > row["sobol"] for row in rows)
    yield "How often is it unlucky?", (f"of {len(rows)} seeds of a soft shadow at 4 samples it has more error than padded Sobol' in {worse}; its worst has "
                                       f"{blue[-1] / sobol[len(sobol) // 2]:.2f} times the median error of padded Sobol', whose worst has {sobol[-1] / sobol[len(sobol) // 2]:.2f}"), "worst.csv"


SOURCES = (("renders.csv", of_renders), ("denoise.csv", of_denoise), ("realtime.csv", of_realtime), ("samplers_draws.csv", of_draws), ("samplers.csv", of_samplers),
           ("worst.csv", of_worst))


def answers(folder):
    lines = []
    for name, of in SOURCES:
        if (folder / name).is_file():
            rows = read_numbers(folder / name)
            lines += [f"- **{question}** {answer[0].upper()}{answer[1:]} ([how]({folder.name}/{link}))."
                      for question, answer, link in of(read(folder / name) if "error" in rows[0] and "scene" in rows[0] else rows)]
    return "\n".join(lines)


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
