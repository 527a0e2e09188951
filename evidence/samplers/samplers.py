# SPDX-License-Identifier: Apache-2.0
"""Measures the screen-space error of the samplers: `scripts/bench samplers` writes evidence/results/samplers.*

Measures errors (screen_space.py) and times (the program bench_draws), writes them to out/samplers, and the tables in samplers.md
with plots of errors and of spectra of error images, to evidence/results.
"""

import csv
import math
import subprocess
import sys
import textwrap
from pathlib import Path

import numpy as np

from ..base import peers
from ..base.command import Parser
from ..base.files import kept, write_text
from ..base.plots import finish, plt, save, style
from ..base.progress import in_parallel
from ..base.tables import md_table
from ..measure.image_error import radial_spectrum, windowed_power
from .screen_space import COUNTS, DOMAINS, INTEGRANDS, SIZE, draws, measure

SAMPLERS = ("white", "sobol", "sobol4d", "zorder", "mask", "blue")
BASE = "sobol"  # the baseline of all ratios
QUICK = ("white", BASE, "blue")
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
    "singles": "u < c at irrational c, in all four numbers, in domains with keys 4k: libbn's single numbers.",
    "steps": "x < c and y < c at irrational c, in (0,1) of domains with keys 4k, blurred along the edge only: edges parallel to "
             "the sides of the picture.",
}
PLOTTED = ("half-planes-01", "discs", "smooth", "products", "siblings", "smooth-products")
BLURS = (2.1, 1.0, 0.0)
MEAN = math.inf  # the blur that leaves the mean of the picture
SPECTRA_COUNTS = (1, 4, 16)
# Centres and radii of the discs for the spectra; the first is shown.
DISCS = ((0.4, 0.45, 0.35), (0.63, 0.37, 0.27), (0.29, 0.71, 0.23))
GREYS = 16


def time_draws(program):
    """The rows of bench_draws as dicts; progress goes to the terminal."""
    try:
        text = subprocess.run([program], stdout=subprocess.PIPE, text=True, check=True).stdout
    except (OSError, subprocess.CalledProcessError) as error:
        sys.exit(f"bench: {program} failed: {error}; build it with scripts/setup")
    return list(csv.DictReader(text.splitlines()))


def measure_all(program, samplers, counts=COUNTS, domains=DOMAINS):
    """Rows of errors of all samplers, two at a time, slowest first."""
    def run(name):
        rows = [{"sampler": name, "figure": figure, "spp": spp, "sigma": sigma, "rmse": float(f"{error:.6g}")}
                for (figure, spp, sigma), error in measure(program, name, counts, domains).items()]
        print(f"bench: measured {name}", file=sys.stderr)
        return rows

    found = dict(in_parallel(2, run, sorted(samplers, key=lambda name: (name != "zorder", name not in peers.PEERS))))
    return [row for name in samplers for row in found[name]]


def ratios(rows, sampler, figure, sigma, base=BASE):
    """{spp: RMSE relative to that of `base`}"""
    own, base = ({row["spp"]: row["rmse"] for row in rows if (row["sampler"], row["figure"], row["sigma"]) == (name, figure, sigma)}
                 for name in (sampler, base))
    return {spp: error / base[spp] for spp, error in own.items()}


def names_in(rows):
    return list(dict.fromkeys(row["sampler"] for row in rows))


def ratio_row(label, found):
    return [label, *(f"{value:.2f}" if value < 10 else f"{value:.1f}" for value in found.values())]


def table(rows, figure, sigma, base=BASE):
    return md_table(["sampler", *map(str, ratios(rows, BASE, figure, sigma))],
                    [ratio_row(name, ratios(rows, name, figure, sigma, base)) for name in names_in(rows) if name != base])


def best_peer(rows, figure):
    """{spp: the least ratio of OpenQMC's samplers}, empty without them."""
    found = [ratios(rows, name, figure, 2.1) for name in names_in(rows) if name in peers.PEERS]
    return {spp: min(one[spp] for one in found) for spp in found[0]} if found else {}


def summary_table(rows):
    """blue, and the best of OpenQMC's samplers at each count."""
    lines = []
    for figure, name in FIGURES.items():
        lines.append(ratio_row(f"{name}: blue", ratios(rows, "blue", figure, 2.1)))
        if best := best_peer(rows, figure):
            lines.append(ratio_row("best of OpenQMC", best))
    return md_table(["", *map(str, ratios(rows, BASE, next(iter(FIGURES)), 2.1))], lines)


def plot_spp(rows, path):
    """Error after a blur of 2.1 pixels, relative to that of BASE, against samples."""
    figure, axes = plt.subplots(2, 3, figsize=(13, 8.8), layout="constrained")
    names = names_in(rows)
    for axis, what in zip(axes.flat, PLOTTED):
        for name in names:
            found = ratios(rows, name, what, 2.1)
            axis.loglog(list(found), list(found.values()), **style(name, names))
        finish(axis, textwrap.fill(FIGURES[what], 36), "samples per pixel")
    figure.legend(*axes.flat[0].get_legend_handles_labels(), loc="outside lower center", ncols=len(names))
    save(figure, path, laid_out=True)


def times_table(times):
    forms = ("inline", "single", "block", "peer")
    found, rows = {(row["sampler"], row["form"]): row["nanoseconds"] for row in times}, []
    for name in dict.fromkeys(row["sampler"] for row in times):
        cells = [f"{found[name, form]:.1f}" if (name, form) in found else "" for form in forms]
        ratio = f"{found[name, 'peer'] / found['blue', 'inline']:.2f}" if (name, "peer") in found else ""
        rows.append([name, *cells, ratio])
    return md_table(["sampler", "inline", "call", "block", "peer", "peer / inline blue"], rows)


# ---- Spectra of error images

def disc_errors(program, name, spp):
    """Error images [DOMAINS * discs][SIZE][SIZE], in dimensions (0,1) of the second members of families."""
    pairs = [samples[2].copy() for samples in draws(program, name, spp)]
    return [((x - a) ** 2 + (y - b) ** 2 < r * r).mean(axis=-1) - np.pi * r * r for a, b, r in DISCS for x, y in pairs]


def greys(values, low, high):
    """Values from 0 to 1 in few steps, to keep the PNG small."""
    return np.round(np.clip((values - low) / (high - low), 0, 1) * (GREYS - 1)) / (GREYS - 1)


def plot_spectra(program, names, path):
    """Error images of a disc and their spectra, in two dimensions and radially averaged."""
    figure, axes = plt.subplots(2 * len(SPECTRA_COUNTS), len(names) + 1, width_ratios=[*([1] * len(names)), 1.6],
                                figsize=(1.5 * len(names) + 3.4, 3.4 * len(SPECTRA_COUNTS)), layout="constrained")
    shares = np.repeat([np.pi * r * r for *_, r in DISCS], DOMAINS)
    for column, name in enumerate(names):
        axes[0, column].set_title(name, fontsize=9)
        for k, spp in enumerate(SPECTRA_COUNTS):
            images = np.array(disc_errors(program, name, spp)) / np.sqrt(shares * (1 - shares) / spp)[:, None, None]  # white noise has the power 1
            power = np.mean([windowed_power(image) for image in images], axis=0)
            shown = np.log10(np.maximum(np.fft.fftshift(power), 1e-4)).reshape(SIZE // 2, 2, SIZE // 2, 2).mean(axis=(1, 3))
            for axis, picture in zip(axes[2 * k:, column], (greys(images[0][:64, :64], -1.5, 1.5), greys(shown, -2, 0.5))):
                axis.imshow(picture, cmap="gray", vmin=0, vmax=1, interpolation="nearest")
                axis.set(xticks=[], yticks=[])
            axes[2 * k, 0].set_ylabel(f"{spp} spp")
            spectra = [radial_spectrum(image) for image in images]
            axes[2 * k, -1].semilogy(spectra[0][0], np.mean([values for _, values in spectra], axis=0), **{**style(name, names), "marker": ""})
    for k in range(len(SPECTRA_COUNTS)):
        axes[2 * k, -1].set(ylim=(3e-3, 5), ylabel="power, white = 1", xlabel="cycles per pixel")
        axes[2 * k, -1].grid(True, which="both", alpha=0.25)
        axes[2 * k + 1, -1].axis("off")
    figure.legend(*axes[0, -1].get_legend_handles_labels(), loc="outside lower center", ncols=len(names), fontsize=8)
    save(figure, path, colours=256, laid_out=True)  # with fewer colours, greys would replace those of the lines


def answer(rows):
    """What the tables after the blur say of blue, of the best of OpenQMC and of Z-order, in two sentences."""
    def ends(found):
        return f"{min(found.values()):.2f} to {max(found.values()):.2f}"

    parts = []
    for figure, what in {"half-planes-01": "half-planes in one pair of dimensions", "smooth": "smooth bumps there",
                         "products": "products over both pairs of a domain", "siblings": "over two domains of a family",
                         "families": "over domains of two families"}.items():
        others = {"best of OpenQMC": best_peer(rows, figure)}
        if "zorder" in names_in(rows):
            others["Z-order at powers of two"] = {n: value for n, value in ratios(rows, "zorder", figure, 2.1).items() if n & (n - 1) == 0}
        said = ", ".join(f"{name} {ends(found)}" for name, found in others.items() if found)
        parts.append(f"{what} {ends(ratios(rows, 'blue', figure, 2.1))}" + f" ({said})" * bool(said))
    return (f"After a blur of 2.1 pixels `blue` has this share of padded Sobol's error, the least and the most over the counts: "
            f"{'; '.join(parts)}. Without a blur it has {ends(ratios(rows, 'blue', 'half-planes-01', 0.0))} of it in half-planes: what it changes is "
            "where the error lies.")


def report_text(rows, times, command):
    parts = ["# Screen-space error of the samplers", "", f"Printed by `{command}`.", "", answer(rows), "",
             "![Error over padded Sobol's after a blur, against samples per pixel](samplers_spp.png)", "",
             f"Every figure is an error relative to that of `{BASE}` (Owen-scrambled Sobol', independent in each pixel and padded: its two",
             "pairs of dimensions are sequences of their own) in the same run; below 1 is better. `sobol4d` is Sobol' in four dimensions",
             "at once, in each pixel on its own, as in the path tracer. Every pixel integrates the same function. The image of",
             f"per-pixel errors is blurred with a Gaussian of sigma pixels; its RMSE is taken over {SIZE}x{SIZE} pixels without a margin of 8 and",
             f"averaged over {INTEGRANDS} integrands of a kind in each of {DOMAINS} domains. Each domain has its own seed, and domains cycle through",
             "the members of their families. Sigma 0.0 is the error without blur. Samplers run progressively and are measured at",
             "every sample count; `zorder` is run for each count separately, because it must know the count.", ""]
    if set(peers.PEERS) & set(names_in(rows)):
        parts += ["OpenQMC's samplers are used in the same way: the domains of a family are `newDomain()` with the keys 4k to",
                  "4k + 3 of one parent; steps use the first pair of dimensions.", ""]
    parts += ["## blue, sigma 2.1", "", summary_table(rows), "",
              "## Spectra of error images", "",
              f"The integrands are discs in dimensions (0,1) of a domain other than the position in the pixel, over {DOMAINS} domains.",
              "Upper rows: an error image and the radially averaged power. Lower rows: the power in two dimensions (frequency 0 in the",
              "middle, black is a hundredth of white noise). The power of `blue` falls towards frequency 0 without a bump; at 16 samples it has a",
              "low ridge at a quarter of a cycle per pixel, where blocks of 4 x 4 pixels repeat.", "",
              "![Error images and their spectra](samplers_spectra.png)", ""]
    if times:
        parts += ["## Time per draw", "",
                  "Nanoseconds per 4-D draw on one core (`bench_draws`), in the order of a path tracer: six domains for each of",
                  "16 indices, pixel after pixel. Columns: the inline form in `bn_draw.h`, a call of `bn_sample_4d()`, and",
                  "`bn_sample_block()`, which draws one domain of many pixels at once. Each time is the minimum of many short,",
                  "interleaved measurements; only ratios are comparable between machines.", ""]
        if any(row["form"] == "peer" for row in times):
            parts += ["The same program measures OpenQMC, also inlined: a sampler for each pixel and index, `newDomain()` for each",
                      "domain, and `drawSample<4>()`.", ""]
        parts += [times_table(times), ""]
    for figure, name in FIGURES.items():
        parts += [f"## {name}", ""]
        if figure in WHAT:
            parts += [WHAT[figure], ""]
        for sigma in BLURS:
            parts += [f"Sigma {sigma}:", "", table(rows, figure, sigma), ""]
        parts += ["The mean of the picture, over white noise's:", "", table(rows, figure, MEAN, "white"), ""]
    return "\n".join(parts)


def run(arguments):
    parser = Parser("samplers", __doc__)
    parser.hidden("--program", "build/evidence/programs/bench_samplers")
    parser.hidden("--draws", "build/evidence/programs/bench_draws")
    parser.pathtracer()
    parser.add_argument("--quick", action="store_true", help=f"measure {', '.join(QUICK)} only")
    parser.add_argument("--again", action="store_true", help="use the results of the previous run instead of measuring")
    parser.out()
    parser.add_argument("--pages", type=Path, default=Path("out/samplers"), metavar="FOLDER",
                        help="folder for the CSV files (default out/samplers)")
    options = parser.parse_args(arguments)

    others = () if options.again else peers.chosen(options.openqmc, options.pathtracer)
    times = kept(options.pages / "samplers_draws.csv", options.again, lambda: [
        row for row in time_draws(options.draws) if row["form"] != "peer" or row["sampler"] in others])
    rows = kept(options.pages / "samplers.csv", options.again, lambda: measure_all(
        options.program, (*(QUICK if options.quick else SAMPLERS), *others)))
    names = names_in(rows)
    plot_spp(rows, options.out / "samplers_spp.png")
    plot_spectra(options.program, names, options.out / "samplers_spectra.png")
    command = "scripts/bench samplers" + (" --quick" if options.quick else "")
    command += " --openqmc DIR" if set(peers.PEERS) & set(names) else ""
    text = report_text(rows, times, command)
    write_text(options.out / "samplers.md", text)
    print(text)
    print(f"Written: {options.out}/samplers.md and its plots; {options.pages}/samplers.csv and samplers_draws.csv.")
