# SPDX-License-Identifier: Apache-2.0
"""Screen-space error of the samplers: `scripts/bench samplers` writes docs/report/samplers.*

Runs the programs bench_samplers and bench_draws, keeps their rows as CSV, and makes of them the tables of samplers.md
and the pictures: error against samples per pixel, against the width of the blur and against the time spent drawing,
spectra of error images.
"""

import argparse
import csv
import io
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from report import peers
from report.files import write_text, written_beside
from report.image_error import radial_spectrum
from report.palette import style

TABLE_SPP = (1, 2, 3, 4, 6, 8, 16, 32, 64, 128, 256, 1000, 1024)
SAMPLERS = ("blue", "sobol", "zorder", "mask")  # and white, which all are related to
SIZE = 256  # pixels a side, of bench_samplers


def run_program(program, arguments):
    """What it wrote; progress goes to the terminal."""
    try:
        result = subprocess.run([program, *arguments], stdout=subprocess.PIPE, check=False)
    except OSError as error:
        sys.exit(f"bench: {program} does not run ({error.strerror}); build it with scripts/setup")
    if result.returncode != 0:
        sys.exit(f"bench: {program} failed with status {result.returncode}")
    return result.stdout


def run_bench(program, arguments):
    """The rows of a program as dicts."""
    return list(csv.DictReader(io.StringIO(run_program(program, arguments).decode())))


def ratios(rows, **wanted):
    """{spp: ratio to white} of the rows that have these values; declared="own" is each count declared."""
    own = wanted.pop("declared", "0") == "own"
    return {
        int(row["spp"]): float(row["ratio"])
        for row in rows
        if all(row[key] == value for key, value in wanted.items())
        and row["declared"] == (row["spp"] if own else "0")
    }


def run_all(program, samplers, quick=False):
    """Every part of the report, two programs at a time: all have `white` to relate to."""
    families = ["--families", "half-planes,wide"]
    parts = [["--declared", *families, *([] if quick else ["--sets", "2"]), "--pairs", pair] for pair in ("01", "23")]
    if not quick:
        parts += [["--families", "4-D", "--pairs", ""],
                  ["--families", "half-planes", "--pairs", "02,03,12,13"],
                  ["--families", "half-planes", "--pairs", "01", "--sets", "2", "--max-spp", "1024"]]
    with ThreadPoolExecutor(2) as pool:
        results = list(pool.map(lambda part: run_bench(program, ["--samplers", ",".join(samplers), *part]), parts))
    rows = [row for result in results[:4] for row in result]
    return rows + [row for result in results[4:] for row in result if int(row["spp"]) > 256]


def names_in(rows):
    return list(dict.fromkeys(row["sampler"] for row in rows))


def table(rows, family, pair, sigma):
    measured = {int(row["spp"]) for row in rows if row["family"] == family and row["pair"] == pair}
    columns = [spp for spp in TABLE_SPP if spp in measured]
    lines = ["| sampler | " + " | ".join(str(spp) for spp in columns) + " |", "| --- |" + " ---: |" * len(columns)]
    for name in names_in(rows):
        for declared in ("0", "own"):
            found = ratios(rows, sampler=name, family=family, pair=pair, sigma=sigma, declared=declared)
            if name == "white" or not found:
                continue
            label = name if declared == "0" else f"{name}, count declared"
            cells = (f"{found[spp]:.3f}" if spp in found else "" for spp in columns)
            lines.append(f"| {label} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def line(name, names):
    return {**style(name, names), "markersize": 3}


def plot_spp(rows, path):
    figure, axes = plt.subplots(2, 3, figsize=(13, 8), sharex=True)
    names = names_in(rows)
    for row, (family, pair) in enumerate((("half-planes", "01"), ("wide", "23"))):
        for axis, sigma in zip(axes[row], ("0.0", "1.0", "2.1")):
            for name in names:
                found = ratios(rows, sampler=name, family=family, pair=pair, sigma=sigma)
                spp = sorted(found)
                axis.plot(spp, [found[n] for n in spp], **line(name, names))
            axis.set(xscale="log", yscale="log", title=f"{family}, dimensions {pair}, sigma {sigma}")
            axis.set_xscale("log", base=2)
            axis.grid(True, which="both", alpha=0.25)
    for axis in axes[1]:
        axis.set_xlabel("samples per pixel")
    for axis in axes[:, 0]:
        axis.set_ylabel("RMSE relative to white noise")
    axes[0, 0].legend()
    save(figure, path)


def plot_sigma(rows, path):
    figure, axes = plt.subplots(1, 4, figsize=(15, 4), sharey=True)
    names = names_in(rows)
    sigmas = sorted({row["sigma"] for row in rows}, key=float)
    for axis, spp in zip(axes, (1, 4, 16, 64)):
        for name in names:
            values = [ratios(rows, sampler=name, family="half-planes", pair="01", sigma=s).get(spp) for s in sigmas]
            axis.plot([float(s) for s in sigmas], values, **line(name, names))
        axis.set(title=f"{spp} samples per pixel", xlabel="sigma of the blur in pixels", yscale="log")
        axis.grid(True, which="both", alpha=0.25)
    axes[0].set_ylabel("RMSE relative to white noise")
    axes[0].legend()
    save(figure, path)


def draw_times(draws):
    """{sampler: nanoseconds of its fastest single 4-D draw}, for one bn_draw_4d(), bn_sample_4d() or peer's draw."""
    times = {}
    for row in draws:
        if row["form"] in ("inline", "single", "peer"):
            times[row["sampler"]] = min(times.get(row["sampler"], np.inf), float(row["nanoseconds"]))
    return times


def draws_table(draws):
    forms = ("inline", "single", "block", "peer")
    lines = ["| sampler | inline | call | block | peer | peer / inline blue |", "| --- |" + " ---: |" * 5]
    found = {(row["sampler"], row["form"]): float(row["nanoseconds"]) for row in draws}
    for name in dict.fromkeys(row["sampler"] for row in draws if row["form"] != "domain"):
        cells = [f"{found[name, form]:.1f}" if (name, form) in found else "" for form in forms]
        ratio = f"{found[name, 'peer'] / found['blue', 'inline']:.2f}" if (name, "peer") in found else ""
        lines.append(f"| {name} | " + " | ".join([*cells, ratio]) + " |")
    return "\n".join(lines)


def plot_time(rows, draws, path):
    """RMSE after a blur of 2.1 pixels against the time a pixel's draws of one domain take."""
    figure, axes = plt.subplots(1, 2, figsize=(12, 4.5), sharey=True)
    names, times = names_in(rows), draw_times(draws)
    for axis, pair in zip(axes, ("01", "23")):
        for name in names:
            found = {int(row["spp"]): float(row["rmse"]) for row in rows
                     if (row["sampler"], row["declared"], row["family"], row["pair"], row["sigma"])
                     == (name, "0", "half-planes", pair, "2.1") and int(row["spp"]) <= 256}
            spp = [n for n in sorted(found) if n & (n - 1) == 0]
            if name in times and spp:
                axis.plot([n * times[name] for n in spp], [found[n] for n in spp], **line(name, names))
        axis.set(xscale="log", yscale="log", title=f"half-planes, dimensions {pair}, sigma 2.1",
                 xlabel="nanoseconds per pixel spent drawing")
        axis.grid(True, which="both", alpha=0.25)
    axes[0].set_ylabel("RMSE")
    axes[0].legend()
    save(figure, path)


def draw_samples(program, name, spp):
    """What a sampler draws in one domain: float32 [SIZE][SIZE][spp][4]."""
    raw = run_program(program, ["--samples", name, str(spp)])
    return np.frombuffer(raw, np.float32).reshape(SIZE, SIZE, spp, 4)


def plot_spectra(program, names, path):
    """Error images of one disc at 1, 4 and 16 samples and their radial spectra, per sampler."""
    counts = (1, 4, 16)
    figure, axes = plt.subplots(len(counts), len(names) + 1, figsize=(2.35 * (len(names) + 1), 8))
    for column, name in enumerate(names):
        samples = draw_samples(program, name, counts[-1])
        inside = (samples[..., 0] - 0.4) ** 2 + (samples[..., 1] - 0.45) ** 2 < 0.35**2
        for row, spp in enumerate(counts):
            error = inside[..., :spp].mean(axis=-1) - np.pi * 0.35**2
            axes[row, column].imshow(error[:128, :128], cmap="gray", vmin=-0.6 / spp**0.6, vmax=0.6 / spp**0.6,
                                     interpolation="nearest")
            axes[row, column].set(xticks=[], yticks=[], title=name if row == 0 else None,
                                  ylabel=f"{spp} spp" if column == 0 else None)
            frequency, power = radial_spectrum(error)
            white = np.pi * 0.35**2 * (1 - np.pi * 0.35**2) / spp
            axes[row, -1].plot(frequency, power / white, **{**style(name, names), "marker": ""})
    for axis in axes[:, -1]:
        axis.set(yscale="log", ylim=(1e-3, 8))
        axis.grid(True, which="both", alpha=0.25)
    axes[0, -1].set_title("power, white = 1")
    axes[0, -1].legend(fontsize=7)
    axes[-1, -1].set_xlabel("cycles per pixel")
    save(figure, path)


def save(figure, path):
    figure.tight_layout()
    with written_beside(path) as beside:
        figure.savefig(beside, dpi=80)
    plt.close(figure)


def report_text(rows, draws, command):
    pairs = sorted({row["pair"] for row in rows if row["pair"] != "all"}, key="01 23 02 03 12 13".split().index)
    parts = ["# Screen-space error of the samplers", "",
             f"Printed by `{command}`.", "",
             "Every figure is the mean RMSE over a family of integrands, as a ratio to",
             "white noise in the same run, 256x256 pixels; lower is better. Unless a count is declared, one run of",
             "each sampler is stopped at every count. Sigma is the blur in pixels; 0.0 is the error of each pixel",
             "by itself, which blue noise leaves as it is.", "",
             "![Error against samples per pixel](samplers_spp.png)", "",
             "![Error against the width of the blur](samplers_sigma.png)", "",
             "Error images of a disc, one sampler per column, and their radially averaged power spectra:", "",
             "![Error images and their spectra](samplers_spectra.png)", ""]
    if draws:
        parts += ["## Time of a draw", "",
                  "Nanoseconds per 4-D draw on one core (`bench_draws`), drawn as a path does: six domains for each of",
                  "16 indices, pixel after pixel. The inline form of `bn_draw.h`, a call of `bn_sample_4d()`, and beside",
                  "them `bn_sample_block()`, which draws one domain of many pixels at once. The time is the least of",
                  "many short ones in turn; only ratios travel from machine to machine.", ""]
        if any(row["form"] == "peer" for row in draws):
            parts += ["OpenQMC is measured by the same program, inlined too: a sampler for each pixel and index,",
                      "`newDomain()` for each domain, `drawSample<4>()`.", ""]
        parts += [draws_table(draws), "", "![Error against time](samplers_time.png)", ""]
    families = list(dict.fromkeys((row["family"], row["pair"]) for row in rows))
    for family, pair in sorted(families, key=lambda item: (item[0] != "half-planes", item[0] == "4-D",
                                                           pairs.index(item[1]) if item[1] in pairs else 9)):
        for sigma in ("1.0", "2.1", "0.0"):
            where = "all four dimensions" if pair == "all" else f"dimensions {pair[0]} and {pair[1]}"
            parts += [f"## {family}, {where}, sigma {sigma}", "", table(rows, family, pair, sigma), ""]
    return "\n".join(parts)


def write_rows(path, rows):
    out = io.StringIO()
    writer = csv.DictWriter(out, rows[0].keys(), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    write_text(path, out.getvalue())


def main():
    parser = argparse.ArgumentParser(prog="scripts/bench samplers", description=__doc__.splitlines()[0])
    parser.add_argument("--program", default="build/tests/bench/bench_samplers", help=argparse.SUPPRESS)
    parser.add_argument("--draws", default="build/tests/bench/bench_draws", help=argparse.SUPPRESS)
    parser.add_argument("--pathtracer", default="build/examples/pathtracer/pathtracer", help=argparse.SUPPRESS)
    peers.add_option(parser)
    parser.add_argument("--quick", action="store_true", help="blue and sobol only, one set of two families")
    parser.add_argument("--rows", type=Path, metavar="CSV", help="take rows measured before instead of measuring")
    parser.add_argument("--out", type=Path, default=Path("docs/report"), help="folder (default docs/report)")
    options = parser.parse_args()

    draws_file = options.out / "samplers_draws.csv"
    if options.rows:
        rows = list(csv.DictReader(io.StringIO(options.rows.read_text(encoding="utf-8"))))
        draws = list(csv.DictReader(io.StringIO(draws_file.read_text(encoding="utf-8"))))
    else:
        others = peers.chosen(options.openqmc, options.pathtracer)
        draws = [row for row in run_bench(options.draws, []) if row["form"] != "peer" or row["sampler"] in others]
        rows = run_all(options.program, (*(SAMPLERS[:2] if options.quick else SAMPLERS), *others), options.quick)
    write_rows(options.out / "samplers.csv", rows)
    write_rows(draws_file, draws)
    plot_time(rows, draws, options.out / "samplers_time.png")
    plot_spp(rows, options.out / "samplers_spp.png")
    plot_sigma(rows, options.out / "samplers_sigma.png")
    plot_spectra(options.program, names_in(rows), options.out / "samplers_spectra.png")
    command = "scripts/bench samplers" + (" --quick" if options.quick else "")
    command += " --openqmc DIR" if set(peers.PEERS) & set(names_in(rows)) else ""
    text = report_text(rows, draws, command)
    write_text(options.out / "samplers.md", text)
    print(text)


if __name__ == "__main__":
    main()
