# SPDX-License-Identifier: Apache-2.0
"""Measures point sets, their spectra and their Monte Carlo error: `scripts/bench points` writes evidence/results/points.*

The spectrum of a set is its periodogram, averaged over rings of frequencies and over sets. The error is the variance of
the mean of a function over the points, as in Singh et al., "Analysis of sample correlations for Monte Carlo rendering",
2019. Every set is moved by random offsets on the torus, so all estimates are unbiased and their error is their variance.
"""

import math

import numpy as np
from scipy.special import erf

import bluenoise

from ..base.command import Parser, command_shown
from ..base.files import write_text
from ..base.plots import plain_numbers, plt, save
from ..base.tables import md_table

COUNTS = (16, 32, 64, 128, 256, 512, 1024)
RATE_FROM = 64  # points from which the rate of convergence is fitted
SPECTRUM_COUNT = 512
PRINCIPAL = math.sqrt(SPECTRUM_COUNT)
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

# Functions of the distance from the centre of the square, with their integrals; each is 0 at the border, so that the torus has no seam.
RADIUS, SIGMA = 0.3, 0.1
FUNCTIONS = {
    "disc (a step)": (lambda r: (r < RADIUS).astype(float), math.pi * RADIUS**2),
    "cone (a crease)": (lambda r: np.maximum(0.0, 1 - r / RADIUS), math.pi * RADIUS**2 / 3),
    "Gaussian (smooth)": (lambda r: np.exp(-0.5 * (r / SIGMA) ** 2), 2 * math.pi * SIGMA**2 * float(erf(0.5 / (SIGMA * math.sqrt(2)))) ** 2),
}


def measure(sets, offset_count):
    """{name: {function: [variance for each count]}}: mean squared errors over sets and offsets."""
    rng = np.random.default_rng(1)
    results = {name: {function: [] for function in FUNCTIONS} for name in SETS}
    for n in COUNTS:
        offsets = rng.random((sets, offset_count, 2))
        for name, (make, _, _) in SETS.items():
            points = np.stack([make(n, seed) for seed in range(1, sets + 1)])
            moved = (points[:, None] + offsets[:, :, None]) % 1.0 - 0.5
            for function, (value, integral) in FUNCTIONS.items():
                results[name][function].append(float(np.mean((value(np.hypot(*np.moveaxis(moved, -1, 0))).mean(2) - integral) ** 2)))
    return results


def rate(variances):
    """The exponent a of the power law n**-a that fits the variances."""
    first = COUNTS.index(RATE_FROM)
    return -float(np.polyfit(np.log(COUNTS[first:]), np.log(variances[first:]), 1)[0])


def spectrum(make, sets):
    """(frequency over the principal one, mean power): periodograms, averaged over rings and sets; white noise has 1, the mean is left out."""
    most = int(3 * PRINCIPAL)
    u, v = np.arange(most + 1), np.arange(-most, most + 1)
    # The power of e**(2 pi i f x) in x and y separately, multiplied and summed over the points
    power = np.mean([np.abs(np.exp(2j * np.pi * v[:, None] * points[:, 1]) @ np.exp(2j * np.pi * points[:, :1] * u)) ** 2 / len(points)
                     for points in (make(SPECTRUM_COUNT, seed) for seed in range(1, sets + 1))], 0)
    frequency = np.hypot(v[:, None], u)
    inside = (frequency <= most) & (frequency > 0)
    ring = (frequency[inside] / PRINCIPAL * BINS_PER_PRINCIPAL).astype(int)
    counts = np.bincount(ring)
    filled = counts > 0
    return ((np.arange(len(counts)) + 0.5) / BINS_PER_PRINCIPAL)[filled], np.bincount(ring, power[inside])[filled] / counts[filled]


def plot(results, spectra, path):
    figure = plt.figure(figsize=(12, 8.4), layout="constrained")
    top, middle, bottom = figure.subfigures(3, 1, height_ratios=(1, 1.3, 1.3))
    for axis, (name, (make, colour, _)) in zip(top.subplots(1, len(SETS)), SETS.items()):
        axis.plot(*make(256, 1).T, ".", color=colour, markersize=3)
        axis.set(xlim=(0, 1), ylim=(0, 1), xticks=[], yticks=[], aspect="equal", title=name)
    axis = middle.subplots()
    for name, (frequency, power) in spectra.items():
        axis.plot(frequency, power, color=SETS[name][1], label=name, linewidth=1.4)
    axis.set(yscale="log", ylim=(0.01, 8), xlim=(0, 3), xlabel="frequency, in units of the square root of the number of points",
             ylabel="power, white = 1")
    axis.grid(True, alpha=0.25)
    axis.legend(fontsize=8, ncols=3)
    for axis, function in zip(bottom.subplots(1, len(FUNCTIONS)), FUNCTIONS):
        for name, (_, colour, marker) in SETS.items():
            axis.loglog(COUNTS, results[name][function], color=colour, marker=marker, markersize=4, linewidth=1.3)
        axis.set(title=function, xlabel="points", ylabel="variance")
        axis.set_xscale("log", base=2)
        plain_numbers(axis.xaxis)
        axis.grid(True, alpha=0.25)
    save(figure, path, 32, laid_out=True)


def report_text(results, spectra, options, command):
    shares = {name: {function: values[-1] / results["white"][function][-1] for function, values in own.items()} for name, own in results.items()}
    over = ", ".join(f"{name} {np.exp(np.mean(np.log(list(own.values())))):.2g}" for name, own in shares.items() if name != "white")
    return "\n".join([
        "# Point sets", "",
        f"Printed by `{command}`. The sets are those of `bluenoise.points`, with white noise and one pixel's samples of `sobol` and `blue` for "
        "comparison.", "",
        f"The variance of a mean over the most points is this share of white noise's, as a geometric mean over three functions: {over}. To integrate in a "
        "pixel use a sampler, and `blue` for errors that are blue *between* pixels; point sets are for placing things, "
        "[also on a surface](../points.md).", "",
        "![256 points of each set, their spectra, and the variance of three integrals](points.png)", "",
        "The variance follows from the power of the set at the frequencies of the function. Best candidates and Poisson disks keep some power at the "
        "lowest frequencies, so without a step in the function their error falls about as fast as that of white noise, from a lower start. Points "
        "of a mask have less there, and the nets `sobol` and `blue` have least.", "",
        f"Power is the mean of periodograms of {SPECTRUM_COUNT} points below half the principal frequency, where white noise has 1, over "
        f"{options.sets} sets; less is better. Then the variance of the mean of a function over {COUNTS[-1]} points, relative to white noise, and the "
        f"exponent *a* of the power law *n^-a* that fits the variances from {RATE_FROM} points on. A disc of radius {RADIUS}, a cone over it, and a "
        f"Gaussian of sigma {SIGMA}; each set is moved by {options.offsets} random offsets on the torus, which makes every estimate unbiased (Singh "
        'et al., "Analysis of sample correlations for Monte Carlo rendering", 2019).', "",
        md_table(["set", "power", *(head for function in FUNCTIONS for head in (function, "rate"))], [
            [name, f"{spectra[name][1][spectra[name][0] < 0.5].mean():.3f}",
             *(cell for function, values in own.items() for cell in (f"{shares[name][function]:.2g}", f"{rate(values):.1f}"))]
            for name, own in results.items()])])


def run(arguments):
    parser = Parser("points", __doc__)
    parser.number("--sets", 10, "sets of each kind")
    parser.number("--offsets", 200, "random offsets of each set")
    parser.out()
    options = parser.parse_args(arguments)
    spectra = {name: spectrum(make, options.sets) for name, (make, _, _) in SETS.items()}
    results = measure(options.sets, options.offsets)
    plot(results, spectra, options.out / "points.png")
    text = report_text(results, spectra, options, command_shown("points", arguments))
    write_text(options.out / "points.md", text)
    print(text)
