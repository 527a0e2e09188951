# SPDX-License-Identifier: Apache-2.0
"""Measures the screen-space error of the samplers: `scripts/bench samplers` writes docs/report/samplers.*

Runs the programs bench_samplers and bench_draws, writes their results to out/samplers, and the tables in samplers.md
with plots of error against time, and spectra of error images, to docs/report. With --every it measures every count
from 1 to 64 instead: samplers_every.md and samplers_spp.png.
"""

import argparse
import csv
import io
import subprocess
import sys
import textwrap
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
from scipy.ndimage import gaussian_filter1d

from ..base import peers
from ..base.command import add_out, add_pathtracer
from ..base.files import read_rows, write_rows, write_text
from ..base.palette import plain_numbers, style
from ..base.plots import plt, save
from ..base.tables import md_table
from ..measure.image_error import radial_spectrum, windowed_power

SAMPLERS = ("white", "sobol", "sobol4d", "zorder", "mask", "blue")
BASE = "sobol"  # the baseline of all ratios
QUICK = ("white", BASE, "blue")
SIZE, DOMAINS, INTEGRANDS = 128, 16, 48  # as in bench_samplers
FIGURES = {
    "half-planes-01": "Half-planes in dimensions (0,1)",
    "half-planes-23": "Half-planes in dimensions (2,3)",
    "products": "Products over both pairs of a domain",
    "siblings": "Products over two domains of a family",
    "families": "Products over domains of two families",
    "singles": "Steps in a number of its own",
    "steps": "Steps along the axes, at the position in the pixel",
    "discs": "Discs in dimensions (0,1)",
    "smooth": "Smooth bumps in dimensions (0,1)",
    "smooth-products": "Smooth bumps in both pairs of a domain, multiplied",
}
WHAT = {
    "products": "Half-planes in (0,1) and in (2,3) of one domain, multiplied.",
    "siblings": "A half-plane in each of two domains of a family, multiplied, for all six pairs of siblings and all pairs of dimensions.",
    "families": "The same in domains of two families of one parent, which are independent.",
    "singles": "u < c at irrational c, in all four numbers, in domains with keys 4k: libbn's single numbers, pairs 2 and 3 of "
               "`bn_sample_pair()`.",
    "steps": "x < c and y < c at irrational c, in (0,1) of domains with keys 4k, blurred along the edge only: edges parallel to "
             "the sides of the picture.",
}
PLOTTED = ("half-planes-01", "products")
EVERY = ("half-planes-01", "discs", "smooth", "products", "siblings", "smooth-products")  # in the table and the plot of every count
EVERY_DOMAINS, EVERY_COUNTS = 4, (1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 12, 14, 16, 20, 24, 28, 32, 40, 48, 56, 64)
EVERY_SAMPLERS = ("white", BASE, "sobol4d", "zorder", "blue")
BLURS = ("2.1", "1.0", "0.0")
MEAN = "inf"  # the blur that leaves the mean of the picture
SPECTRA_COUNTS = (1, 4, 16)
# Centres and radii of the discs for the spectra (the first is shown), and the positions of the steps.
DISCS = ((0.4, 0.45, 0.35), (0.63, 0.37, 0.27), (0.29, 0.71, 0.23))
STEPS = (0.236, 0.618, 0.854)
RINGS, DIRECTIONS, GREYS = 8, 8, 16


def run_program(program, arguments):
    """Returns its standard output; progress goes to the terminal."""
    try:
        result = subprocess.run([program, *arguments], stdout=subprocess.PIPE, check=False)
    except OSError as error:
        sys.exit(f"bench: cannot run {program} ({error.strerror}); build it with scripts/setup")
    if result.returncode != 0:
        sys.exit(f"bench: {program} failed with status {result.returncode}")
    return result.stdout


def run_bench(program, arguments):
    """The rows of a program as dicts."""
    return list(csv.DictReader(io.StringIO(run_program(program, arguments).decode())))


def run_all(program, samplers, *arguments):
    """The rows of all samplers, two at a time, slowest first."""
    def run(name):
        rows = run_bench(program, ["--samplers", name, *arguments])
        print(f"bench: measured {name}", file=sys.stderr)
        return rows

    slow = sorted(samplers, key=lambda name: (name != "zorder", name not in peers.PEERS))
    with ThreadPoolExecutor(2) as pool:
        found = dict(zip(slow, pool.map(run, slow)))
    return [row for name in samplers for row in found[name]]


def errors(rows, sampler, figure, sigma):
    """{spp: RMSE}"""
    return {int(row["spp"]): float(row["rmse"]) for row in rows
            if (row["sampler"], row["figure"], row["sigma"]) == (sampler, figure, sigma)}


def ratios(rows, sampler, figure, sigma, base=BASE):
    """{spp: RMSE relative to that of `base`}"""
    base = errors(rows, base, figure, sigma)
    return {spp: error / base[spp] for spp, error in errors(rows, sampler, figure, sigma).items()}


def names_in(rows):
    return list(dict.fromkeys(row["sampler"] for row in rows))


def ratio_row(label, found):
    return [label, *(f"{value:.2f}" if value < 10 else f"{value:.1f}" for value in found.values())]


def table(rows, figure, sigma, base=BASE):
    found = {name: ratios(rows, name, figure, sigma, base) for name in names_in(rows) if name != base}
    return md_table(["sampler", *map(str, errors(rows, BASE, figure, sigma))],
                    [ratio_row(name, of_counts) for name, of_counts in found.items()])


def summary_table(rows):
    """blue, and the best of OpenQMC's samplers at each count."""
    lines, others = [], [name for name in names_in(rows) if name in peers.PEERS]
    for figure, name in FIGURES.items():
        lines.append(ratio_row(f"{name}: blue", ratios(rows, "blue", figure, "2.1")))
        found = [ratios(rows, other, figure, "2.1") for other in others]
        if found:
            lines.append(ratio_row("best of OpenQMC", {spp: min(one[spp] for one in found) for spp in found[0]}))
    return md_table(["", *map(str, errors(rows, BASE, next(iter(FIGURES)), "2.1"))], lines)


def line(name, names):
    return {**style(name, names), "markersize": 3}


def plot_spp(rows, path):
    """Error after a blur of 2.1 pixels against every count."""
    figure, axes = plt.subplots(2, 3, figsize=(13, 8.8), layout="constrained")
    names = names_in(rows)
    for axis, what in zip(axes.flat, EVERY):
        for name in names:
            found = errors(rows, name, what, "2.1")
            # Where the padded and the four-dimensional Sobol' agree, both are seen.
            axis.loglog(list(found), list(found.values()),
                        **{**line(name, names), "markersize": 2, "linewidth": 1.2, "linestyle": ":" if name == "sobol4d" else "-"})
        axis.set(title=textwrap.fill(FIGURES[what], 36), xlabel="samples per pixel", ylabel="RMSE, sigma 2.1")
        axis.set_xscale("log", base=2)
        axis.grid(True, which="major", alpha=0.25)
        plain_numbers(axis.xaxis, axis.yaxis)
    figure.legend(*axes.flat[0].get_legend_handles_labels(), loc="outside lower center", ncols=len(names))
    save(figure, path, laid_out=True)


def worst_step(found):
    """The largest ratio of the errors at a count and at the one before, and that count."""
    counts = list(found)
    return max((found[spp] / found[before], spp) for before, spp in zip(counts, counts[1:]))


def every_text(rows, command, commit):
    names = names_in(rows)
    rise, spp = worst_step(errors(rows, "blue", "half-planes-01", "2.1"))
    other, other_spp = worst_step(errors(rows, BASE, "half-planes-01", "2.1"))
    parts = ["# Error at every count", "", f"Printed by `{command}`.", "",
             f"From one count to the next the error of `blue` on half-planes grows by at most {100 * (rise - 1):.0f} %, at {spp} samples; that of",
             f"padded Sobol' by {100 * (other - 1):.0f} %, at {other_spp}.", "",
             "![Error against every count](samplers_spp.png)", "",
             f"RMSE after a blur of 2.1 pixels, `{BASE}` at one sample = 1 (that of white noise), as on [the samplers' page](samplers.md), over",
             f"{EVERY_DOMAINS} domains. `sobol` is padded: its two pairs of dimensions are independent (0,2)-sequences; `sobol4d` is one",
             "four-dimensional Owen-scrambled Sobol' sequence in each pixel. `zorder` is declared at each count. Discs and bumps lie",
             "in (0,1). Products over two domains of a family take all pairs in turn.", ""]
    if commit:
        parts += [f"OpenQMC is at commit {commit}.", ""]
    for what in EVERY:
        base = errors(rows, BASE, what, "2.1")[1]
        found = {name: errors(rows, name, what, "2.1") for name in names}
        parts += [f"## {FIGURES[what]}", "", md_table(
            ["sampler", *map(str, EVERY_COUNTS)],
            [[name + (" (padded)" if name == BASE else ""), *(f"{own[spp] / base:.3f}" if spp in own else "" for spp in EVERY_COUNTS)]
             for name, own in found.items()]), ""]
    return "\n".join(parts)


def report_every(options, path):
    """Every count: its own rows, page and plot."""
    if options.again:
        rows = read_or_say(path)
    else:
        arguments = ["--every", "--domains", str(EVERY_DOMAINS), "--figures", ",".join(EVERY)]
        rows = run_all(options.program, (*EVERY_SAMPLERS, *peers.chosen(options.openqmc, options.pathtracer)), *arguments)
        write_rows(path, list(rows[0]), rows)
    plot_spp(rows, options.out / "samplers_spp.png")
    command = "scripts/bench samplers --every" + (" --openqmc DIR" if set(peers.PEERS) & set(names_in(rows)) else "")
    text = every_text(rows, command, peers.commit(options.openqmc))
    write_text(options.out / "samplers_every.md", text)
    print(text)


def draw_times(draws):
    """{sampler: nanoseconds of its fastest single 4-D draw}: bn_sample_4d(), inline or called, or a peer's draw."""
    times = {}
    for row in draws:
        if row["form"] in ("inline", "single", "peer"):
            times[row["sampler"]] = min(times.get(row["sampler"], np.inf), float(row["nanoseconds"]))
    return times


def draws_table(draws):
    forms = ("inline", "single", "block", "peer")
    found, rows = {(row["sampler"], row["form"]): float(row["nanoseconds"]) for row in draws}, []
    for name in dict.fromkeys(row["sampler"] for row in draws if row["form"] != "domain"):
        cells = [f"{found[name, form]:.1f}" if (name, form) in found else "" for form in forms]
        ratio = f"{found[name, 'peer'] / found['blue', 'inline']:.2f}" if (name, "peer") in found else ""
        rows.append([name, *cells, ratio])
    return md_table(["sampler", "inline", "call", "block", "peer", "peer / inline blue"], rows)


def plot_time(rows, draws, path):
    """RMSE after a blur of 2.1 pixels against the time to draw one domain per pixel."""
    figure, axes = plt.subplots(1, len(PLOTTED), figsize=(12, 4.6))
    names, times = names_in(rows), draw_times(draws)
    for axis, what in zip(axes, PLOTTED):
        for name in names:
            found = {spp: error for spp, error in errors(rows, name, what, "2.1").items() if spp & (spp - 1) == 0}
            if name in times and found:
                axis.plot([spp * times[name] for spp in found], list(found.values()), **line(name, names))
        axis.set(xscale="log", yscale="log", title=f"{FIGURES[what]}, sigma 2.1",
                 xlabel="nanoseconds per pixel to draw one domain")
        axis.grid(True, which="both", alpha=0.25)
        plain_numbers(axis.xaxis, axis.yaxis)
    axes[0].set_ylabel("RMSE")
    axes[0].legend(fontsize="small")
    save(figure, path)


# ---- Spectra of error images

def draw_samples(program, name, spp):
    """A sampler's draws in the second member of a family, one seed each: float32 [DOMAINS][SIZE][SIZE][spp][4]."""
    raw = run_program(program, ["--samples", name, str(spp)])
    return np.frombuffer(raw, np.float32).reshape(DOMAINS, SIZE, SIZE, spp, 4)


def disc_errors(samples):
    """Error images [DOMAINS * discs][SIZE][SIZE], in dimensions (0,1)."""
    return np.concatenate([(((samples[..., 0] - x) ** 2 + (samples[..., 1] - y) ** 2 < r * r).mean(axis=-1) - np.pi * r * r)
                           for x, y, r in DISCS])


def anisotropy(power):
    """(frequency, dB): on rings of a power spectrum [SIZE][SIZE], variance over squared mean across directions."""
    y, x = np.meshgrid(np.fft.fftfreq(SIZE), np.fft.fftfreq(SIZE), indexing="ij")
    frequency = np.hypot(x, y)
    ring = np.where(frequency > 0, np.floor(frequency * 2 * RINGS), RINGS).astype(int)
    # Axes and diagonals lie in the middle of their sectors.
    direction = np.round(np.arctan2(y, x) / np.pi * DIRECTIONS).astype(int) % DIRECTIONS
    found = []
    for k in range(RINGS):
        means = [power[(ring == k) & (direction == d)].mean() for d in range(DIRECTIONS)]
        found.append(10 * np.log10(np.var(means) / np.mean(means) ** 2))
    return (np.arange(RINGS) + 0.5) / (2 * RINGS), found


def greys(values, low, high):
    """Values from 0 to 1 in few steps, to keep the PNG small."""
    return np.round(np.clip((values - low) / (high - low), 0, 1) * (GREYS - 1)) / (GREYS - 1)


def axes_ratio(samples):
    """The ratio of the low-frequency power of the error of steps along the two axes; 1 if there is no difference."""
    logs = []
    for d in range(4):
        for place in STEPS:
            error = (samples[..., d] < place).mean(axis=-1) - place
            along = [np.mean(gaussian_filter1d(error, 2.1, axis=axis, mode="wrap") ** 2, axis=(1, 2)) for axis in (1, 2)]
            # The first dimension of each pair belongs to x, the second to y.
            logs.append((-1) ** d * np.log(along[0] / along[1]))
    return float(np.exp(abs(np.mean(logs))))


def plot_spectra(program, names, path):
    """Error images of a disc, their spectra in two dimensions and radially averaged, and their anisotropy. Returns
    {name: {spp: axes_ratio()}}."""
    figure, axes = plt.subplots(2 * len(SPECTRA_COUNTS), len(names) + 1, width_ratios=[*([1] * len(names)), 1.6],
                                figsize=(1.5 * len(names) + 3.4, 3.4 * len(SPECTRA_COUNTS)), layout="constrained")
    unlike = {}
    for column, name in enumerate(names):
        for k, spp in enumerate(SPECTRA_COUNTS):
            samples = draw_samples(program, name, spp)
            images = disc_errors(samples)
            shares = np.repeat([np.pi * r * r for *_, r in DISCS], DOMAINS)
            images /= np.sqrt(shares * (1 - shares) / spp)[:, None, None]  # white noise has the power 1
            unlike.setdefault(name, {})[spp] = axes_ratio(samples)
            power = np.mean([windowed_power(image) for image in images], axis=0)
            shown = np.log10(np.maximum(np.fft.fftshift(power), 1e-4)).reshape(SIZE // 2, 2, SIZE // 2, 2).mean(axis=(1, 3))
            top, below = axes[2 * k], axes[2 * k + 1]
            top[column].imshow(greys(images[0][:64, :64], -1.5, 1.5), cmap="gray", vmin=0, vmax=1, interpolation="nearest")
            below[column].imshow(greys(shown, -2, 0.5), cmap="gray", vmin=0, vmax=1, interpolation="nearest")
            own = {**style(name, names), "marker": ""}
            spectra = [radial_spectrum(image) for image in images]
            top[-1].semilogy(spectra[0][0], np.mean([values for _, values in spectra], axis=0), **own)
            below[-1].plot(*anisotropy(power), **own)
            for axis in (top[column], below[column]):
                axis.set(xticks=[], yticks=[])
            if column == 0:
                top[0].set_ylabel(f"{spp} spp")
                below[0].set_ylabel("power")
        axes[0, column].set_title(name, fontsize=9)
    for k in range(len(SPECTRA_COUNTS)):
        axes[2 * k, -1].set(ylim=(3e-3, 5), ylabel="power, white = 1")
        axes[2 * k + 1, -1].set_ylabel("anisotropy, dB")
    for axis in axes[:, -1]:
        axis.grid(True, which="both", alpha=0.25)
        axis.yaxis.set_label_position("right")
        axis.yaxis.tick_right()
    axes[-1, -1].set_xlabel("cycles per pixel")
    figure.legend(*axes[0, -1].get_legend_handles_labels(), loc="outside lower center", ncols=len(names), fontsize=8)
    save(figure, path, colours=256, laid_out=True)  # with fewer colours, greys would replace those of the lines
    return unlike


def answer(rows):
    """What the tables after the blur say of blue, and of the best of OpenQMC, in two sentences."""
    def ends(found):
        return f"{min(found.values()):.2f} to {max(found.values()):.2f}"

    others, parts = [name for name in names_in(rows) if name in peers.PEERS], []
    shown = {"half-planes-01": "a step in one pair of dimensions", "products": "a product over both pairs of a domain",
             "siblings": "one over two domains of a family"}
    for figure, what in shown.items():
        best = ""
        if others:
            found = [ratios(rows, other, figure, "2.1") for other in others]
            best = f" (best of OpenQMC: {ends({spp: min(one[spp] for one in found) for spp in found[0]})})"
        parts.append(f"{what} {ends(ratios(rows, 'blue', figure, '2.1'))}{best}")
    unblurred = ratios(rows, "blue", "half-planes-01", "0.0")
    return (f"After a blur of 2.1 pixels `blue` has this share of padded Sobol's error, the least and the most over the counts: "
            f"{', '.join(parts)}. Without a blur it has {ends(unblurred)} of it in a step: what it changes is where the error lies.")


def report_text(rows, draws, unlike, command):
    names = names_in(rows)
    parts = ["# Screen-space error of the samplers", "", f"Printed by `{command}`.", "", answer(rows), "",
             "![Error against every count](samplers_spp.png)", "",
             f"Every figure is an error relative to that of `{BASE}` (Owen-scrambled Sobol', independent in each pixel and padded: its two",
             "pairs of dimensions are sequences of their own) in the same run; below 1 is better. `sobol4d` is Sobol' in four dimensions",
             "at once, in each pixel on its own, as in the path tracer. Every pixel integrates the same function. The image of",
             f"per-pixel errors is blurred with a Gaussian of sigma pixels; its RMSE is taken over {SIZE}x{SIZE} pixels without a margin of 8 and",
             f"averaged over {INTEGRANDS} integrands of a kind in each of {DOMAINS} domains. Each domain has its own seed, and domains cycle through",
             "the members of their families. Sigma 0.0 is the error without blur. Samplers run progressively and are measured at",
             "every sample count; `zorder` is run for each count separately, because it must know the count.", ""]
    if set(peers.PEERS) & set(names):
        parts += ["OpenQMC's samplers are used in the same way: the domains of a family are `newDomain()` with the keys 4k to",
                  "4k + 3 of one parent; steps use the first pair of dimensions.", ""]
    parts += ["## blue, sigma 2.1", "", summary_table(rows), "",
              "The plot above is of [every count from 1 to 64](samplers_every.md), with discs and smooth integrands.", "",
              "## Spectra of error images", "",
              f"The integrands are discs in dimensions (0,1) of a domain other than the position in the pixel, over {DOMAINS} domains.",
              "Upper rows: an error image and the radially averaged power. Lower rows: the power in two dimensions (frequency 0 in the",
              "middle, black is a hundredth of white noise) and its anisotropy on rings, the variance over eight directions divided by",
              "the squared mean. The anisotropy of `white` is due to chance alone.", "",
              "![Error images, their spectra and anisotropy](samplers_spectra.png)", "",
              "Ratio of the low-frequency power of the error of steps along the two axes in such domains, sigma 2.1; 1 is balanced:", "",
              md_table(["sampler", *map(str, SPECTRA_COUNTS)], [ratio_row(name, unlike[name]) for name in names]), ""]
    if draws:
        parts += ["## Time per draw", "",
                  "Nanoseconds per 4-D draw on one core (`bench_draws`), in the order of a path tracer: six domains for each of",
                  "16 indices, pixel after pixel. Columns: the inline form in `bn_draw.h`, a call of `bn_sample_4d()`, and",
                  "`bn_sample_block()`, which draws one domain of many pixels at once. Each time is the minimum of many short,",
                  "interleaved measurements; only ratios are comparable between machines.", ""]
        if any(row["form"] == "peer" for row in draws):
            parts += ["The same program measures OpenQMC, also inlined: a sampler for each pixel and index, `newDomain()` for each",
                      "domain, and `drawSample<4>()`.", ""]
        parts += [draws_table(draws), "", "![Error against time](samplers_time.png)", ""]
    for figure, name in FIGURES.items():
        parts += [f"## {name}", ""]
        if figure in WHAT:
            parts += [WHAT[figure], ""]
        for sigma in BLURS:
            parts += [f"Sigma {sigma}:", "", table(rows, figure, sigma), ""]
        parts += ["The mean of the picture, over white noise's:", "", table(rows, figure, MEAN, "white"), ""]
    return "\n".join(parts)


def read_or_say(path):
    try:
        return read_rows(path)
    except OSError as error:
        sys.exit(f"bench: {error.filename}: {error.strerror}; measure first, without --again")


def run(arguments):
    parser = argparse.ArgumentParser(prog="scripts/bench samplers", description=__doc__.splitlines()[0])
    parser.add_argument("--program", default="build/tests/bench/bench_samplers", help=argparse.SUPPRESS)
    parser.add_argument("--draws", default="build/tests/bench/bench_draws", help=argparse.SUPPRESS)
    add_pathtracer(parser)
    peers.add_option(parser)
    parser.add_argument("--quick", action="store_true", help=f"measure {', '.join(QUICK)} only")
    parser.add_argument("--every", action="store_true", help="measure every count from 1 to 64 instead, after a blur of 2.1 pixels")
    parser.add_argument("--again", action="store_true", help="use the results of the previous run instead of measuring")
    add_out(parser)
    parser.add_argument("--pages", type=Path, default=Path("out/samplers"), metavar="FOLDER",
                        help="folder for the CSV files (default out/samplers)")
    options = parser.parse_args(arguments)

    files = options.pages / "samplers.csv", options.pages / "samplers_draws.csv"
    if options.every:
        report_every(options, options.pages / "samplers_every.csv")
        return
    if options.again:
        rows, draws = map(read_or_say, files)
    else:
        others = peers.chosen(options.openqmc, options.pathtracer)
        draws = [row for row in run_bench(options.draws, []) if not row["form"].startswith("peer") or row["sampler"] in others]
        rows = run_all(options.program, (*(QUICK if options.quick else SAMPLERS), *others))
        for path, found in zip(files, (rows, draws)):
            write_rows(path, list(found[0]), found)
    names = names_in(rows)
    plot_time(rows, draws, options.out / "samplers_time.png")
    unlike = plot_spectra(options.program, names, options.out / "samplers_spectra.png")
    command = "scripts/bench samplers" + (" --quick" if options.quick else "")
    command += " --openqmc DIR" if set(peers.PEERS) & set(names) else ""
    text = report_text(rows, draws, unlike, command)
    write_text(options.out / "samplers.md", text)
    print(text)
    print(f"Written: {options.out}/samplers.md and its plots; {options.pages}/samplers.csv and samplers_draws.csv.")
