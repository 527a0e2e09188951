# SPDX-License-Identifier: Apache-2.0
"""The first table of evidence/results and the README's: `scripts/bench summary` writes both

It reads what `scripts/bench renders` and `scripts/bench pbrt` wrote to evidence/results: errors of other samplers over
that of blue, in crops of large pictures that nothing was tuned on. If the first was run with times, and `scripts/bench denoise`, it also writes
how long each sampler takes to an error.
"""

import sys
from pathlib import Path

from ..base.command import CommandError, Parser
from ..base.tables import md_table, update_table
from ..measure.gains import BEST_PEER, read_rows

COMMAND = "scripts/bench summary"
COUNTS, SHORT_COUNTS = (1, 2, 3, 4, 6, 8, 16, 32, 64), (1, 3, 4, 6, 8, 16, 64)
MEASURES = {"displayed_2.1": "as displayed, sigma 2.1", "displayed_1.0": "as displayed, sigma 1.0", "displayed": "as displayed, single pixels",
            "rmse_2.1": "raw, sigma 2.1", "rmse_1.0": "raw, sigma 1.0", "rmse": "raw, single pixels"}
# Where, the file, the command that writes it, and what blue is compared with there.
PARTS = (
    ("our path tracer", "renders_headline.csv", "scripts/bench renders", {
        "white": "white", "sobol": "padded Sobol'", "sobol-global": "global Sobol'", "zorder": "Z-order",
        "mask": "a mask (`mask`)", BEST_PEER: BEST_PEER}),
    ("pbrt-v4", "pbrt_headline.csv", "scripts/bench pbrt", {
        "independent": "white (`independent`)", "paddedsobol": "padded Sobol' (`paddedsobol`)", "sobol": "global Sobol' (`sobol`)",
        "halton": "`halton`", "zsobol": "Z-order (`zsobol`), its default", "best of pbrt": "best of pbrt's own"}),
)
# What the README shows of it: of errors as displayed in our path tracer, these rows.
SHORT = {"sobol": "padded Sobol'", "mask": "a blue-noise mask", "zorder": "Z-order, told each count", BEST_PEER: "best of OpenQMC's three",
         "sobol-global": "global Sobol'"}


# Equal quality: file, measure, and the count at which white noise has the error to be reached.
TIME_COMMAND = f"{COMMAND}: time"
TIMES = {"white noise's error at 16 samples": ("renders_headline.csv", "seconds:displayed_2.1", 16),
         "at 64": ("renders_headline.csv", "seconds:displayed_2.1", 64),
         "at 16, after Open Image Denoise and the blur": ("denoise.csv", "seconds:plain:displayed_2.1", 16)}
TIMED = {"pcg": "PCG32", "sobol": "padded Sobol'", "sobol-global": "global Sobol'", "zorder": "Z-order", BEST_PEER: "the best of OpenQMC", "blue": "`blue`"}


def over(gains):
    """What the gains cover, such as '6 scenes, 24 crops'; a range if some sample counts exclude some."""
    def spread(numbers, what):
        low, high = min(numbers), max(numbers)
        return f"{high if low == high else f'{low} to {high}'} {what}{'' if high == 1 else 's'}"

    return f"{spread([gain.scenes for gain in gains], 'scene')}, {spread([gain.views for gain in gains], 'crop')}"


def table(parts):
    """One Markdown table from {where: table of gains.read_rows()}."""
    rows = []
    for where, _, _, names in PARTS:
        gains = parts.get(where, {})
        for measure in MEASURES:
            for than, name in names.items():
                found = [gains.get((measure, spp, "blue", than)) for spp in COUNTS]
                if any(found):
                    rows.append([f"{where}, {over([gain for gain in found if gain])}", MEASURES[measure], name,
                                 *(gain.text() if gain else "" for gain in found)])
    return md_table(["where", "measured", "error over that of `blue`", "1 spp", *(str(spp) for spp in COUNTS[1:])], rows)


def short_table(parts):
    """The README's: SHORT alone, without intervals."""
    found = {name: [parts.get("our path tracer", {}).get(("displayed_2.1", spp, "blue", than)) for spp in SHORT_COUNTS] for than, name in SHORT.items()}
    return md_table(["error over that of `blue`", "1 spp", *(str(spp) for spp in SHORT_COUNTS[1:])],
                    [[name, *(f"{gain.value:.2f}" if gain else "" for gain in gains)] for name, gains in found.items() if any(gains)])


def time_table(folder):
    """Processor time to an error over white noise's, from what TIMES names; None without times."""
    columns = []
    for name, measure, spp in TIMES.values():
        rows = read_rows(folder / name) if (folder / name).is_file() else {}
        column = {label: gain for (own, count, label, _), gain in rows.items() if (own, count) == (measure, spp)}
        peers = [gain for label, gain in column.items() if label.startswith("openqmc-")]
        if peers:
            column[BEST_PEER] = max(peers, key=lambda gain: gain.value)
        columns.append(column)
    if not columns[0]:
        return None
    return md_table(["processor time, white noise = 1, to", *TIMES], [
        [name, *(f"{1 / column[label].value:.2f} ({1 / column[label].high:.2f} to {1 / column[label].low:.2f})" if label in column else ""
                 for column in columns)] for label, name in TIMED.items()])


def read_parts(folder):
    parts = {where: read_rows(folder / name) for where, name, _, _ in PARTS if (folder / name).is_file()}
    missing = [f"{folder / name} is missing; run {command}" for where, name, command, _ in PARTS if where not in parts]
    if not parts:
        raise CommandError("; ".join(missing))
    return parts, missing


def run(arguments):
    parser = Parser("summary", __doc__)
    parser.add_argument("--report", type=Path, default=Path("evidence/results"), metavar="FOLDER",
                        help="folder with the results of the commands (default evidence/results)")
    parser.hidden("--readme", "README.md")
    parser.add_argument("--print", action="store_true", help="print the table without changing files")
    options = parser.parse_args(arguments)
    parts, missing = read_parts(options.report)
    text = table(parts)
    if not options.print:
        update_table(options.report / "README.md", COMMAND, text)
        update_table(options.readme, COMMAND, short_table(parts))
        if time_table(options.report):
            update_table(options.report / "README.md", TIME_COMMAND, time_table(options.report))
    for line in missing:
        print(f"bench: {line}", file=sys.stderr)
    print(text)
