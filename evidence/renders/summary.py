# SPDX-License-Identifier: Apache-2.0
"""The tables of the README and of evidence/README.md, from what `scripts/bench renders` wrote: `scripts/bench summary`"""


from ..base.command import CommandError, Parser
from ..base.files import read_numbers
from ..base.tables import md_table, update_table
from ..measure.statistics import Estimate
from .renders import HEADLINE, NAMES, TO_WHITE

COMMAND = "scripts/bench summary"
COUNTS = (1, 2, 3, 4, 6, 8, 16, 32, 64)
RESULTS = "renders.csv"
# The README's rows: sampler, its name, whether it must know the count, whether it shows patterns.
SHORT = (("blue", "**`blue`**", "no", "no"), ("sobol-global", "global Sobol': one sequence over the image", "no", "[yes](docs/blue.md#no-patterns)"),
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


def run(arguments):
    parser = Parser("summary", __doc__)
    parser.out()
    parser.hidden("--readme", "README.md")
    parser.add_argument("--print", action="store_true", help="print the tables without changing files")
    options = parser.parse_args(arguments)
    found = read(options.out / RESULTS)
    if not options.print:
        update_table(options.readme, COMMAND, short_table(found))
        update_table(options.out.parent / "README.md", COMMAND, table(found))
    print(short_table(found), table(found), sep="\n\n")
