# SPDX-License-Identifier: Apache-2.0
"""Measures screen-space error and spectral peaks of the samplers: `scripts/bench samplers` writes evidence/results/samplers.*"""

import csv
import shutil
import sys
from pathlib import Path

from ..base.command import Parser, command_shown, names_of, output_of
from ..base.files import kept, read_numbers, write_image, write_rows, write_text, written_beside
from ..base.page import render
from ..base.plots import finish, plt, save, style
from ..base.progress import in_parallel
from ..base.tables import md_table
from . import heitz, integrands, plugins, variants
from .integrands import COUNTS, EVERY_COUNT, SIDE
from .variants import NAMES

EVERY, RUNS_OF_EVERY = ("white", "sobol", "zorder", "sobol-global", "blue"), 4  # the samplers measured at every count
OWN = ("white", "sobol", "zorder", "mask", "blue")
ALL = (*OWN, "sobol-global", "heitz", *variants.PEERS)
TUNED = {"zorder", "heitz"}  # for each count, so each is a run of its own
ONLY = {}  # {sampler: the counts that it has} if these are not all
PAIRED = ("white", "zorder", "mask", "sobol-global", "heitz", *variants.PEERS)  # the samplers in the table of pairs, before others and blue
PAIR_COUNTS = (1, 4, 16, 64)
# Heitz et al. optimise the eight dimensions of one pair of domains, so there is no second family.
LEFT_OUT = ("heitz", "products of two members")
WIN = 0.05  # smaller differences are not listed
BASE, PEAKS = "sobol", "spectral peaks, the largest of any pair"
#: Sections of the page: {row of integrands.py: heading}.
ROWS = {
    "half-planes": "Half-planes over a pair, after sigma 2.1",
    "half-planes, sigma 1.0": "Half-planes over a pair, after sigma 1.0",
    "half-planes, single pixels": "Half-planes over a pair, without a blur",
    "half-planes, period 64": "Half-planes that drift with a period of 64 pixels, after sigma 2.1",
    "products of both pairs": "Products of half-planes across the two pairs, after sigma 2.1",
    "products of two members": "Products of half-planes over two domains of a family, after sigma 2.1",
    "single numbers": "Steps in a single number, after sigma 2.1",
    "edges along the pixel's sides": "Edges parallel to the sides of the pixel, blurred along the edge",
}
SHOWN_COUNTS = (1, 2, 3, 5, 7, 11, 16, 24, 32, 64, 256, 1024, 4096)
PLOTTED = ("half-planes", "products of both pairs", "products of two members")


def measure_all(ways, runs, counts=COUNTS, images_of=integrands.images_of_run):
    """Rows by integrand and sample count with each sampler's error relative to BASE, or its peaks."""
    def run(name):
        own = [n for n in counts if n in ONLY.get(name, counts)]
        found = integrands.summarised(integrands.measure(ways[name], runs, own, name in TUNED, images_of))
        print(f"bench: measured {name}", file=sys.stderr)
        return {row: dict(zip(own, values)) for row, values in found.items()}

    found = dict(in_parallel(2, run, sorted(ways, key=lambda name: name not in TUNED)))
    return [{"row": row, "sampler": name, "spp": spp, "value": f"{value if row.startswith('spectral') else value / found[BASE][row][spp]:.4f}"}
            for row in found[BASE] for name in ways if (name, row.partition(",")[0]) != LEFT_OUT for spp, value in found[name].get(row, {}).items()]


def updated(path, again, ways, *how):
    """The rows of measure_all(ways, *how), saved to a CSV file that keeps those of samplers not measured now. again: measures only the
    samplers that the file lacks."""
    earlier = read_numbers(path) if path.is_file() else []
    known = {row["sampler"] for row in earlier} if again else set()
    if not (left := {name: draw for name, draw in ways.items() if name not in known}):
        return earlier
    rows = measure_all({BASE: ways[BASE], **left}, *how)
    rows += [row for row in earlier if row["sampler"] not in {BASE, *left}]
    order = list(dict.fromkeys(row["row"] for row in rows))
    rows.sort(key=lambda row: (order.index(row["row"]), (*ALL, row["sampler"]).index(row["sampler"])))
    write_rows(path, list(rows[0]), rows)
    return read_numbers(path)


def pairs(row):
    """A row's name on the page."""
    return row.replace("of both pairs", "across the two pairs")


def row_table(rows, row, counts=COUNTS):
    found = {}
    for each in rows:
        if each["row"] == row and (each["sampler"] != BASE or row == PEAKS):
            found.setdefault(each["sampler"], {})[each["spp"]] = f"{each['value']:.{1 if row == PEAKS else 2}f}"
    return md_table(["spectral peaks" if row == PEAKS else "error over padded Sobol'", *map(str, counts)],
                    [[NAMES.get(name, name), *(values.get(spp, "") for spp in counts)] for name, values in found.items()])


def wins_table(rows):
    """One row per integrand and sampler with at least 5% lower error than `blue` at some sample count."""
    errors = {(row["row"], row["sampler"], row["spp"]): row["value"] for row in rows if not row["row"].startswith("spectral")}
    found = {}
    for (row, name, spp), value in errors.items():
        if value < (1 - WIN) * errors[row, "blue", spp]:
            found.setdefault((row if "sigma" in row or "pixels" in row or row.startswith("edges along") else f"{row}, sigma 2.1", name), []).append(
                f"{100 * (1 - value / errors[row, 'blue', spp]):.0f}% at {spp}")
    return md_table(["integrand", "sampler", "lower error than `blue`"], [[pairs(row), NAMES.get(name, name), ", ".join(less)] for (row, name), less in sorted(found.items())], 2)


def times_table(times):
    forms = ("inline", "single", "block", "peer")
    found = {(row["sampler"], row["form"]): float(row["nanoseconds"]) for row in times}
    return md_table(["sampler", "inline", "a call", "a block", "OpenQMC, inline"], [
        [name, *(f"{found[name, form]:.1f}" if (name, form) in found else "" for form in forms)] for name in dict.fromkeys(name for name, _ in found)])


def plot(rows, path):
    figure, axes = plt.subplots(1, len(PLOTTED) + 1, figsize=(15, 4.2), layout="constrained")
    names = list(dict.fromkeys(row["sampler"] for row in rows))
    for axis, row in zip(axes, (*PLOTTED, PEAKS)):
        for name in names:
            found = {each["spp"]: each["value"] for each in rows if (each["row"], each["sampler"]) == (row, name)}  # empty if LEFT_OUT
            axis.plot(list(found), list(found.values()), **style(name, names))
        finish(axis, "spectral peaks (white noise 5.6)" if row == PEAKS else row, "samples per pixel")
    axes[0].set_ylabel("error over padded Sobol'")
    axes[-1].set_yticks([6, 8, 12, 20, 40, 60])
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=len(names))
    save(figure, path)


def answer(rows):
    def ends(row, name):
        values = [each["value"] for each in rows if (each["row"], each["sampler"]) == (row, name)]
        return f"{min(values):.2f} to {max(values):.2f}" if row != PEAKS else f"{max(values):.1f}"

    return (f"After a 2.1-pixel blur, `blue` has {ends('half-planes', 'blue')} times the error of padded Sobol' for half-planes over a pair of numbers, "
            f"and {ends('products of both pairs', 'blue')} times that error for products across the two pairs. Without a blur, the factor for half-planes is "
            f"{ends('half-planes, single pixels', 'blue')}. `blue` shows no patterns: its largest spectral peaks are {ends(PEAKS, 'blue')} times the mean power, compared with "
            f"{ends(PEAKS, 'white')} for white noise, {ends(PEAKS, 'zorder')} for Z-order and {ends(PEAKS, 'sobol-global')} for global Sobol'.")


def pairs_table(found):
    """One row for each sampler and count, with the errors of all pairs of a domain's numbers."""
    names = [name for name in dict.fromkeys(row["row"] for row in found) if "domain" not in name]
    errors = {(row["sampler"], row["spp"], row["row"]): row["value"] for row in found}
    return md_table(["sampler, samples", *(f"`{name}`" for name in names)], [
        [f"{NAMES.get(label, label)}, {spp}", *(f"{errors[label, spp, name]:.2f}" for name in names)]
        for label in (*PAIRED, *(name for name in dict.fromkeys(row["sampler"] for row in found) if name not in ALL), "blue") for spp in PAIR_COUNTS if (label, spp, names[0]) in errors])


def domains_table(found, count=16):
    """The errors of `blue` for the pairs of each domain of a family."""
    errors = {row["row"]: row["value"] for row in found if (row["sampler"], row["spp"]) == ("blue", count)}
    names = [name for name in errors if "domain" not in name]
    return md_table([f"`blue`, {count} samples", *(f"`{name}`" for name in names)], [
        [f"domain {member}", *(f"{errors[f'{name}, domain {member}']:.2f}" for name in names)] for member in range(4)])


def report_text(rows, times, every, paired, options):
    return render(globals(), "samplers.md.in", rows=rows, times=times, every=every, paired=paired, options=options, variants=variants)


def run(arguments):
    parser = Parser("samplers", __doc__)
    parser.hidden("--draws", "build/evidence/programs/bench_draws")
    parser.pathtracer()
    parser.number("--runs", 8, "number of seeds")
    parser.add_argument("--again", action="store_true", help="measure only results missing from the previous run's files")
    parser.add_argument("--samplers", type=names_of("sampler", ALL), metavar="A,B,...", help=f"measure only these of {', '.join(ALL)}")
    parser.add_argument("--out", type=Path, help="folder for the report (default evidence/results; out/samplers with --sampler)")
    parser.add_argument("--picture", type=Path, metavar="FILE", help="only draw constant and drifting half-planes with each sampler")
    options = parser.parse_args(arguments)
    if options.picture:
        return write_image(options.picture, integrands.patterns())
    others = {name: plugins.load(f"{file}-4d" if name in variants.PEERS else file) for name, file in variants.files_of(options).items()}
    TUNED.update(name for name, plugin in others.items() if plugin.tuned)
    ONLY.update({name: plugin.counts for name, plugin in others.items() if plugin.counts})
    added = dict(options.sampler)
    if added:  # beside the published results
        options.out = options.out or Path("out/samplers")
        for path in Path("evidence/results").glob("samplers*.csv"):
            with written_beside(options.out / path.name) as beside:
                shutil.copy(path, beside)
    options.out = options.out or Path("evidence/results")
    # As a whole: partial runs only update a page.
    options.command = command_shown("samplers", [word for word in arguments if word not in ("--samplers", ",".join(options.samplers or ()))])
    ways = {**{name: integrands.of_library(name) for name in OWN}, "sobol-global": integrands.global_sobol, **{name: plugin.way(SIDE) for name, plugin in others.items()}}
    if options.heitz:
        ways["heitz"] = integrands.of_heitz(heitz.Tables(options.heitz))
    if options.samplers or added:
        ways = {name: draw for name, draw in ways.items() if name in (*(options.samplers or ()), *added, BASE)}
    timed = [f"{name}={plugin.file}" for name, plugin in others.items() if name in added and not plugin.function]
    times = kept(options.out / "samplers_draws.csv", (options.again or options.samplers) and not added, lambda: [
        row for row in csv.DictReader(output_of([options.draws, *timed], "build it with scripts/setup", text=True).splitlines())
        if row["form"] != "peer" or row["sampler"] in others])
    rows = updated(options.out / "samplers.csv", options.again, ways, options.runs)
    some = {name: draw for name, draw in ways.items() if name in EVERY or (name in added and name not in TUNED)}
    every = updated(options.out / "samplers_counts.csv", options.again, some, RUNS_OF_EVERY, EVERY_COUNT, integrands.images_at_every_count)
    paired = updated(options.out / "samplers_pairs.csv", options.again, ways, options.runs, COUNTS, integrands.images_of_pairs)
    plot(rows, options.out / "samplers.png")
    text = report_text(rows, times, every, paired, options)
    write_text(options.out / "samplers.md", text)
    print(text)
