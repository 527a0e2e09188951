# SPDX-License-Identifier: Apache-2.0
"""Measures point sets, their spectra and their Monte Carlo error: `scripts/bench points` writes docs/report/points.*

The spectrum of a set is its periodogram, averaged over rings of frequencies and over sets. The error is the variance of
the mean of a function over the points, as in Singh et al., "Analysis of sample correlations for Monte Carlo rendering",
2019. Every set is moved by random offsets on the torus, so all estimates are unbiased and their error is their variance.
"""

import argparse
import math
import textwrap

import numpy as np
from scipy.special import erf

import bluenoise

from ..base.bench_options import arguments_that_count
from ..base.command import add_out, positive
from ..base.files import write_text
from ..base.palette import plain_numbers
from ..base.plots import plt, save
from ..base.tables import md_table

COUNTS = (16, 32, 64, 128, 256, 512, 1024)
RATE_FROM = 64  # points from which the rate of convergence is fitted
SPECTRUM_COUNT = 512
BINS_PER_PRINCIPAL = 16  # rings of the spectrum up to the principal frequency


def of_sampler(kind):
    return lambda n, seed: bluenoise.Sampler(kind, seed=seed).block(0, 0, 1, 1, 0, n, 0)[0, 0, :, :2].astype(np.float64)


def of_method(method):
    return lambda n, seed: bluenoise.points(n, method=method, seed=seed)


# Okabe and Ito's palette
SETS = {
    "white": (of_sampler("white"), "#767676", "o"),
    "best-candidate": (of_method("best-candidate"), "#009e73", "^"),
    "poisson-disk": (of_method("poisson-disk"), "#cc79a7", "v"),
    "mask": (of_method("mask"), "#56b4e9", "D"),
    "sobol, one pixel": (of_sampler("sobol"), "#d55e00", "s"),
    "blue, one pixel": (of_sampler("blue"), "#0050b0", "o"),
}

# ---- Functions on the square, with their integrals; each is 0 at the border, so that the torus has no seam

RADIUS, SIGMA = 0.3, 0.1


def from_centre(points):
    return np.hypot(points[..., 0] - 0.5, points[..., 1] - 0.5)


FUNCTIONS = {
    "disc (a step)": (lambda p: (from_centre(p) < RADIUS).astype(float), math.pi * RADIUS**2),
    "cone (a crease)": (lambda p: np.maximum(0.0, 1 - from_centre(p) / RADIUS), math.pi * RADIUS**2 / 3),
    "Gaussian (smooth)": (lambda p: np.exp(-0.5 * (from_centre(p) / SIGMA) ** 2),
                          2 * math.pi * SIGMA**2 * float(erf(0.5 / (SIGMA * math.sqrt(2)))) ** 2),
}


def variance(points, function, integral, offsets):
    """The mean squared error over sets (sets, n, 2) and offsets (sets, m, 2)."""
    moved = (points[:, None] + offsets[:, :, None]) % 1.0
    return float(np.mean((function(moved).mean(2) - integral) ** 2))


def rate(counts, variances):
    """The exponent a of the power law n**-a that fits the variances."""
    chosen = [i for i, n in enumerate(counts) if n >= min(RATE_FROM, counts[-2])]
    return -float(np.polyfit(np.log([counts[i] for i in chosen]), np.log([variances[i] for i in chosen]), 1)[0])


def periodogram(points, most):
    """Power at the whole frequencies (v, u) up to `most` with u >= 0; white noise has 1 on average, the mean is left out."""
    # The power of e**(2 pi i f x) in x and y separately, multiplied and summed over the points
    u, v = np.arange(most + 1), np.arange(-most, most + 1)
    power = np.abs(np.exp(2j * np.pi * v[:, None] * points[:, 1]) @ np.exp(2j * np.pi * points[:, :1] * u)) ** 2 / len(points)
    power[most, 0] = np.nan
    return power


def radial(power, width):
    """(frequency, mean power) in rings of a width; the frequencies beyond the largest ring in all directions are left out."""
    most = power.shape[1] - 1
    frequency = np.hypot(*np.meshgrid(np.arange(-most, most + 1), np.arange(most + 1), indexing="ij"))
    inside = (frequency <= most) & ~np.isnan(power)
    ring = (frequency[inside] / width).astype(int)
    counts = np.bincount(ring)
    filled = counts > 0
    return ((np.arange(len(counts)) + 0.5) * width)[filled], np.bincount(ring, power[inside])[filled] / counts[filled]


def measure(sets, offset_count, counts):
    """{name: {function: [variance for each count]}}"""
    rng = np.random.default_rng(1)
    results = {name: {function: [] for function in FUNCTIONS} for name in SETS}
    for n in counts:
        offsets = rng.random((sets, offset_count, 2))
        for name, (make, _, _) in SETS.items():
            points = np.stack([make(n, seed) for seed in range(1, sets + 1)])
            for function, (value, integral) in FUNCTIONS.items():
                results[name][function].append(variance(points, value, integral, offsets))
    return results


def plot(results, spectra, counts, path):
    figure = plt.figure(figsize=(12, 8.4))
    top = figure.add_gridspec(1, len(SETS), top=0.95, bottom=0.76, left=0.02, right=0.985, wspace=0.08)
    for i, (name, (make, colour, _)) in enumerate(SETS.items()):
        axis = figure.add_subplot(top[i])
        axis.plot(*make(256, 1).T, ".", color=colour, markersize=3)
        axis.set(xlim=(0, 1), ylim=(0, 1), xticks=[], yticks=[], aspect="equal")
        axis.set_title(name, fontsize=10)
    middle = figure.add_gridspec(1, 1, top=0.70, bottom=0.43, left=0.06, right=0.985)
    axis = figure.add_subplot(middle[0])
    for name, (frequency, power) in spectra.items():
        axis.plot(frequency, power, color=SETS[name][1], label=name, linewidth=1.4)
    axis.set(yscale="log", ylim=(0.01, 8), xlim=(0, 3), xlabel="frequency, in units of the square root of the number of points",
             ylabel="power, white = 1")
    axis.grid(True, alpha=0.25)
    axis.legend(fontsize=8, ncols=3)
    bottom = figure.add_gridspec(1, len(FUNCTIONS), top=0.33, bottom=0.06, left=0.06, right=0.985, wspace=0.2)
    for i, function in enumerate(FUNCTIONS):
        axis = figure.add_subplot(bottom[i])
        for name, (_, colour, marker) in SETS.items():
            axis.plot(counts, results[name][function], color=colour, marker=marker, markersize=4, linewidth=1.3)
        axis.set(xscale="log", yscale="log", title=function)
        axis.set_xscale("log", base=2)
        axis.set_xlabel("points", labelpad=0)
        plain_numbers(axis.xaxis)
        axis.set_xticks(counts[::2])
        axis.grid(True, alpha=0.25)
        if i == 0:
            axis.set_ylabel("variance")
    save(figure, path, 32, laid_out=True)


def low_power(spectrum):
    frequency, power = spectrum
    return float(power[frequency < 0.5].mean())


def paragraph(text):
    return textwrap.wrap(text, 130, break_long_words=False, break_on_hyphens=False)


def answer(results):
    """Two sentences: variances of the most points over white noise's, the mean over the functions."""
    over = {name: np.exp(np.mean([np.log(values[-1] / results["white"][function][-1]) for function, values in by_function.items()]))
            for name, by_function in results.items() if name != "white"}
    return ("The variance of a mean over the most points is this share of white noise's, on average over three functions: "
            + ", ".join(f"{name} {share:.2g}" for name, share in over.items())
            + ". To integrate in a pixel use a sampler, and `blue` for errors that are blue *between* pixels; point sets are for placing "
            "things, [also on a surface](../points.md).")


def report_text(results, spectra, sets, offset_count, counts, command):
    errors = [[name, *(cell for function, values in by_function.items() for cell in (
        f"{values[-1] / results['white'][function][-1]:.2g}", f"{rate(counts, values):.1f}"))] for name, by_function in results.items()]
    lines = [
        "# Point sets", "",
        *paragraph(f"Printed by `{command}`. The sets are those of `bluenoise.points`, with white noise and one pixel's samples of "
                   "`sobol` and `blue` for comparison."), "",
        *paragraph(answer(results)), "",
        "![256 points of each set, their spectra, and the variance of three integrals](points.png)", "",
        *paragraph(
            "The variance follows from the power of the set at the frequencies of the function. Best candidates and Poisson disks keep "
            "some power at the lowest frequencies, so without a step in the function their error falls about as fast as that of white "
            "noise, from a lower start. Points of a mask have less there, and the nets `sobol` and `blue` have least."), "",
        "## Spectrum", "",
        *paragraph(f"The curves are periodograms of {SPECTRUM_COUNT} points, averaged over rings of frequencies and {sets} sets. Here, "
                   "the mean power below half the principal frequency, where white noise has 1; less is better:"), "",
        md_table(["set", "power"], [[name, f"{low_power(spectrum):.3f}"] for name, spectrum in spectra.items()]),
        "", "## Monte Carlo error", "",
        *paragraph(f"Variance of the mean of a function over {counts[-1]} points, relative to white noise, and the exponent *a* of the "
                   f"power law *n^-a* that fits the variances from {RATE_FROM} points on. A disc of radius {RADIUS}, a cone over it, and "
                   f"a Gaussian of sigma {SIGMA}; {sets} sets, each moved by {offset_count} random offsets on the torus, which makes "
                   'every estimate unbiased (Singh et al., "Analysis of sample correlations for Monte Carlo rendering", 2019).'), "",
        md_table(["set", *(head for function in FUNCTIONS for head in (function, "rate"))], errors)]
    return "\n".join(lines)


def run(arguments):
    parser = argparse.ArgumentParser(prog="scripts/bench points", description=__doc__.splitlines()[0])
    parser.add_argument("--sets", type=positive, default=10, metavar="N", help="sets of each kind (default 10)")
    parser.add_argument("--offsets", type=positive, default=200, metavar="N", help="random offsets of each set (default 200)")
    parser.add_argument("--most", type=int, choices=COUNTS[2:], default=COUNTS[-1], help="largest number of points (default 1024)")
    add_out(parser)
    options = parser.parse_args(arguments)
    counts = [n for n in COUNTS if n <= options.most]
    principal = math.sqrt(SPECTRUM_COUNT)
    spectra = {}
    for name, (make, _, _) in SETS.items():
        power = np.mean([periodogram(make(SPECTRUM_COUNT, seed), int(3 * principal)) for seed in range(1, options.sets + 1)], 0)
        frequency, ring = radial(power, principal / BINS_PER_PRINCIPAL)
        spectra[name] = frequency / principal, ring
    results = measure(options.sets, options.offsets, counts)
    plot(results, spectra, counts, options.out / "points.png")
    text = report_text(results, spectra, options.sets, options.offsets, counts, " ".join(["scripts/bench points", *arguments_that_count(arguments)]))
    write_text(options.out / "points.md", text)
    print(text)
