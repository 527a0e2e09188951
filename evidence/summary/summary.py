# SPDX-License-Identifier: Apache-2.0
"""Updates the README's table, and the answers and table in evidence/README.md, from the benches' CSV files: `scripts/bench summary`"""

from ..base.command import CommandError, Parser
from ..base.files import read_numbers
from ..base.page import render
from ..base.tables import md_table, series, update_table
from ..measure.statistics import Estimate
from ..realtime.realtime import in_order
from ..renders.renders import HEADLINE, TO_WHITE
from ..renders.times import over
from ..samplers.samplers import PEAKS
from ..samplers.variants import NAMES

COMMAND = "scripts/bench summary"
COUNTS = (1, 2, 3, 4, 6, 8, 16, 32, 64)
RESULTS = "renders.csv"
# Rows of the README's table: sampler, name, whether it must know the sample count, whether it shows patterns.
SHORT = (("blue", "**`blue`**", "no", "no"), ("sobol-global", "global Sobol': one sequence over the image", "no", "[yes](docs/blue.md#visible-patterns)"),
         ("zorder", "Z-order, as in pbrt-v4 and Cycles", "yes", "no"), ("sobol", "padded Sobol', in each pixel", "no", "no"))
LONG = ("white", "mask", "blue", "sobol-global", "zorder", "heitz", "openqmc-sobolbn", "openqmc-pmjbn", "openqmc-latticebn")


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
    return md_table(["sampler", "samples to match white noise at 16", "must know the sample count", "visible patterns"], rows, 2)


def table(found):
    """Errors over padded Sobol'."""
    rows = [[NAMES[label], *(own.text() if (own := found.get((HEADLINE, "", label, spp))) else "" for spp in COUNTS)] for label in LONG]
    return md_table(["error over padded Sobol'", *map(str, COUNTS)], [row for row in rows if any(row[1:])])


# ---- Figures of answers.md.in. found: what read() returns

EFFECTS = {"cornell": "indirect light in a box", "penumbra": "soft shadows", "glossy": "glossy reflections", "lens": "depth of field", "glass": "clear glass",
           "interior": "many bounces", "motion": "motion blur", "fog": "fog"}


def at_counts(found, label, measure, counts, scene=""):
    return [own for spp in counts if (own := found.get((measure, scene, label, spp)))]


def less_at(found, label, measure, counts):
    """"30%, 24% and 20%" for errors over padded Sobol'."""
    return series([f"{100 * (1 - own.value):.0f}%" for own in at_counts(found, label, measure, counts)])


def to_white(found, label):
    own = found[TO_WHITE, "", label, 16]
    return f"{16 * own.value:.1f} ({16 * own.low:.1f} to {16 * own.high:.1f})"


def effects(found, step):
    """The three scenes with the largest gain (step 1) or the smallest (step -1)."""
    scenes = {scene: own for (measure, scene, label, spp), own in found.items() if (measure, label, spp) == (HEADLINE, "blue", 16) and scene}
    return series([f"{EFFECTS.get(scene, f'the `{scene}` model')} ({100 * (1 - own.value):.0f}%{', not significant' * (not own.significant)})"
                   for scene, own in sorted(scenes.items(), key=lambda item: item[1].value)[::step][:3]])


def wins(found):
    """Where each other sampler leads most over `blue`, after each blur."""
    leads = []
    for measure, after in ((HEADLINE, "after a 2.1-pixel blur"), ("displayed_1.0", "after a 1.0-pixel blur")):
        for label in LONG:
            better = [(own.value / blue.value, spp, own.value, blue.value) for spp in COUNTS
                      if (own := found.get((measure, "", label, spp))) and (blue := found.get((measure, "", "blue", spp))) and own.value < 0.995 * blue.value]
            if better:
                _, spp, own, blue = min(better)
                leads.append(f"{NAMES[label]} {after} at {spp} sample{'s' * (spp > 1)} ({own:.2f}, compared with {blue:.2f} for `blue`)")
    return series(leads) or "none"


def significant(found):
    """The sample counts at which the gain before denoising is significant."""
    return [str(spp) for spp in (1, 2, 4, 16) if found["plain:displayed", "", "blue", spp].significant]


def intervals(factors):
    return series([f"{own.value:.2f} (95% interval {own.low:.2f} to {own.high:.2f})" for own in factors])


def compared(factors):
    """Ratios, and which of them differ significantly from 1."""
    different = [f"{own.value:.2f}" for own in factors if own.significant]
    return f"{series([f'{own.value:.2f}' for own in factors])}, {'of which ' + series(different) if different else 'none of them'} significantly different from 1"


def frames(rows, outcome):
    own, names = in_order(rows), {"blue": "`blue`", "mask + golden ratio, R2": "a shifted mask", "STBN": "STBN", "FAST": "FAST"}
    if outcome == "one frame":
        names["interleaved gradient noise"] = "interleaved gradient noise"
    return series([f"{own[way]['half-plane', outcome, 'sigma 1.0']:.2f} for {name}" for way, name in names.items() if way in own])


def draw_time(rows, sampler, form):
    return next(row["nanoseconds"] for row in rows if (row["sampler"], row["form"]) == (sampler, form))


def inline_times(rows):
    return [f"{row['nanoseconds']:.0f} ns with {name}" for row in rows
            if (name := {"blue": "`blue`", "sobol": "libbn's padded Sobol'"}.get(row["sampler"]) if row["form"] == "inline" else
                NAMES.get(row["sampler"], row["sampler"]) if row["form"] == "peer" else None)]


def cpu_shares(found, rows):
    """{sampler: CPU time to the error of 16 samples of white noise, in per cent of theirs}, the lowest first."""
    shares = {label: f"{100 * time * found[TO_WHITE, '', label, 16].value:.0f}" for label, time in over(rows, "white").items()
              if (TO_WHITE, "", label, 16) in found and label not in ("white", "mask")}
    return dict(sorted(shares.items(), key=lambda item: float(item[1])))


def peak(rows, sampler):
    return f"{max(row['value'] for row in rows if (row['row'], row['sampler']) == (PEAKS, sampler)):.1f}"


def worst_of(rows):
    return sum(row["blue"] > row["sobol"] for row in rows)


CSV = ("renders", "denoise", "pbrt", "cycles", "realtime", "samplers_draws", "times", "samplers", "worst")


def answers(folder, **found):
    """One line for each question whose CSV exists."""
    for name in CSV:
        path = folder / f"{name}.csv"
        found.setdefault(name, (read if name in CSV[:4] else read_numbers)(path) if path.is_file() else [])
    return render(globals(), "answers.md.in", folder=folder.name, draws=found["samplers_draws"], **found).rstrip("\n")


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
