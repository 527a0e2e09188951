# SPDX-License-Identifier: Apache-2.0
"""The README's table of error reductions: `scripts/bench summary` writes it into README.md

It reads what `scripts/bench renders` and `scripts/bench models` wrote to docs/report: how many times smaller blue's error
is than that of white noise, Sobol' and the best of OpenQMC, over scenes and views and over third-party models.
"""

import argparse
import sys
from pathlib import Path

from .files import write_text
from .gains import BEST_PEER, read_rows
from .renders_report import md_table

COUNTS = (1, 4, 16, 64)
MEASURES = {"displayed_2.1": "as displayed", "rmse_2.1": "raw"}
THANS = {"white": "white", "sobol": "Sobol'", BEST_PEER: "best of OpenQMC"}
BEGIN, END = "<!-- table: scripts/bench summary -->\n", "<!-- end of the summary -->\n"


class SummaryError(Exception):
    """The message tells the user what to do."""


def over(gains):
    """What the gains cover: '6 scenes, 12 views' or '27 models'; a range if some sample counts exclude some."""
    def spread(numbers, what):
        low, high = min(numbers), max(numbers)
        return f"{high if low == high else f'{low} to {high}'} {what}{'' if high == 1 else 's'}"

    if all(gain.views == gain.scenes for gain in gains):
        return spread([gain.views for gain in gains], "model")
    return f"{spread([gain.scenes for gain in gains], 'scene')}, {spread([gain.views for gain in gains], 'view')}"


def table(parts):
    """One Markdown table from a list of tables of gains.read_rows()."""
    thans = [than for than in THANS if any(key[3] == than for gains in parts for key in gains)]
    rows = []
    for gains in parts:
        own = [gain for (measure, spp, label, _), gain in gains.items()
               if label == "blue" and spp in COUNTS and measure in MEASURES]
        for measure, name in MEASURES.items():
            for than in thans:
                found = [gains.get((measure, spp, "blue", than)) for spp in COUNTS]
                if any(found):
                    rows.append([over(own), name, THANS[than], *(gain.text() if gain else "" for gain in found)])
    return md_table(["over", "error", "times less than", "1 spp", *(str(spp) for spp in COUNTS[1:])], rows)


def read_parts(folder):
    parts = [(folder / f"{name}_headline.csv", f"scripts/bench {name}") for name in ("renders", "models")]
    found = [read_rows(path) for path, _ in parts if path.is_file()]
    missing = [f"{path} is missing; run {command}" for path, command in parts if not path.is_file()]
    if not found:
        raise SummaryError("; ".join(missing))
    return found, missing


def update_readme(readme, text):
    old = readme.read_text(encoding="utf-8")
    if old.count(BEGIN) != 1 or old.count(END) != 1 or old.index(BEGIN) > old.index(END):
        raise SummaryError(f"{readme} must contain the table markers {BEGIN.strip()} and {END.strip()}, once each")
    before, after = old.split(BEGIN)[0], old.split(END)[1]
    write_text(readme, f"{before}{BEGIN}\n{text}\n\n{END}{after}")


def main(arguments=None):
    parser = argparse.ArgumentParser(prog="scripts/bench summary", description=__doc__.splitlines()[0])
    parser.add_argument("--report", type=Path, default=Path("docs/report"), metavar="FOLDER",
                        help="folder with the results of both commands (default docs/report)")
    parser.add_argument("--readme", type=Path, default=Path("README.md"), help=argparse.SUPPRESS)
    parser.add_argument("--print", action="store_true", help="print the table without changing README.md")
    options = parser.parse_args(arguments)
    try:
        parts, missing = read_parts(options.report)
        text = table(parts)
        if not options.print:
            update_readme(options.readme, text)
    except (SummaryError, OSError) as error:
        sys.exit(f"bench: {error}")
    for line in missing:
        print(f"bench: {line}", file=sys.stderr)
    print(text)


if __name__ == "__main__":
    main()
