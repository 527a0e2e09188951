# SPDX-License-Identifier: Apache-2.0
"""Vector masks: their energy, the time they take, and what they give a sampler at one sample per pixel."""

import math
import time

import numpy as np

import bluenoise

from ..base.tables import md_table

REACH = 6
HALF_PLANES, SEED = 64, 3
BLURS = (1.0, 2.1)


def energy(ranks):
    """What bn_anneal minimises for two channels: the mean over pairs of texels, weighted by exp(-distance^2 / 4), of
    exp(-|difference of values|), for ranks (2, h, w)."""
    values = (ranks + 0.5) / ranks[0].size
    total = weights = 0.0
    for y in range(REACH + 1):
        for x in range(-REACH, REACH + 1):
            if (y > 0 or x > 0) and y * y + x * x <= REACH * REACH:
                weight = math.exp(-(y * y + x * x) / 4)
                difference = values - np.roll(values, (-y, -x), (1, 2))
                total += weight * np.exp(-np.sqrt((difference**2).sum(0))).mean()
                weights += weight
    return total / weights


def half_plane_errors(values):
    """The error of half-planes, integrated with the one sample values[:, y, x] in each pixel: the root mean square over
    pixels and half-planes, after each blur."""
    generator = np.random.default_rng(SEED)
    size = values.shape[1]
    f = np.fft.fftfreq(size)
    squares = f[:, None] ** 2 + f[None, :] ** 2
    grid = (np.arange(512) + 0.5) / 512
    sums = np.zeros(len(BLURS))
    for i in range(HALF_PLANES):
        angle = 2 * np.pi * (i + generator.random()) / HALF_PLANES
        normal, point = (np.cos(angle), np.sin(angle)), generator.random(2)
        integral = ((grid[:, None] - point[0]) * normal[0] + (grid[None, :] - point[1]) * normal[1] > 0).mean()
        inside = (values[0] - point[0]) * normal[0] + (values[1] - point[1]) * normal[1] > 0
        spectrum = np.fft.fft2(inside - integral)
        for k, sigma in enumerate(BLURS):
            sums[k] += (np.fft.ifft2(spectrum * np.exp(-2 * np.pi**2 * sigma**2 * squares)).real ** 2).mean()
    return np.sqrt(sums / HALF_PLANES)


def white(shape, seed):
    """Ranks in random order."""
    return np.random.default_rng(seed).permutation(shape[0] * shape[1]).astype(np.uint32).reshape(shape)


def makers(size, quick):
    """Name, function of the seed, and the number of seeds that there is time for."""
    shape = (size, size)

    def scalars(make):
        return lambda seed: np.stack([make(shape, seed=2 * seed + c) for c in range(2)])

    network = bluenoise.NeuralGenerator(channels=2, threads=1)
    yield "white noise", scalars(white), 4
    yield "two masks of void-and-cluster", scalars(bluenoise.void_and_cluster), 4
    yield "vector network", lambda seed: network.mask(shape, seed=seed), 4
    for sweeps, seeds in ((10, 2), (100, 2)) if quick else ((10, 4), (100, 2), (1000, 1)):
        yield f"anneal, {sweeps} sweeps", lambda seed, n=sweeps: bluenoise.anneal(shape, channels=2, sweeps=n, seed=seed), seeds


def measure(size, quick):
    for name, make, seeds in makers(size, quick):
        if "anneal" not in name:
            make(0)  # a warm-up
        times, masks = [], []
        for seed in range(seeds):
            begun = time.process_time()
            masks.append(make(seed))
            times.append(time.process_time() - begun)
        near, far = np.mean([half_plane_errors((ranks + 0.5) / ranks[0].size) for ranks in masks], axis=0)
        error = np.mean([bluenoise.dithering_error(channel) for ranks in masks for channel in ranks])
        yield {"method": name, "size": size, "seconds": f"{min(times):.6f}", "energy": f"{np.mean([energy(ranks) for ranks in masks]):.6f}",
               "e_1": f"{error:.5f}", "near": f"{near:.6f}", "far": f"{far:.6f}"}


def lines_of(rows):
    """Lines of Markdown from rows of measure()."""
    number = {row["method"]: row for row in rows}
    (white, *_, last), size = number, rows[0]["size"]
    best, network, lines = number[last], number["vector network"], []
    for name, row in number.items():
        gain = (number[white]["energy"] - row["energy"]) / (number[white]["energy"] - best["energy"])
        lines.append([name, f"{1e6 * row['seconds'] / size**2:.3g} us", f"{row['energy']:.5f}", f"{gain:.1%}", f"{row['e_1']:.4f}",
                      f"{row['near'] / number[white]['near']:.3f}", f"{row['far'] / number[white]['far']:.3f}"])
    return [f"Two channels of {size}x{size} texels on one thread. *Energy* is what `bn_anneal` minimises for two channels: the mean over pairs of "
            "texels, weighted by exp(-distance^2 / 4), of exp(-|difference of values|). *Gain* is how much of the way from white noise to "
            f"{last} a method goes. The last two columns are for a sampler that takes the vector of each pixel as its one sample: the error of "
            f"{HALF_PLANES} random half-planes after a blur of {BLURS[0]:g} and {BLURS[1]:g} pixels, relative to white noise.", "",
            md_table(["method", "CPU time per texel", "energy", "gain", "E_1 of a channel", f"half-planes, blur {BLURS[0]:g}", f"blur {BLURS[1]:g}"],
                     lines), "",
            f"The vector network takes 1/{best['seconds'] / network['seconds']:.0f} of the time of {last}, and its energy is "
            f"{network['energy'] / best['energy'] - 1:.2%} higher (that of white noise: {number[white]['energy'] / best['energy'] - 1:.2%}), its error of "
            f"half-planes {network['near'] / best['near'] - 1:.0%} and {network['far'] / best['far'] - 1:.0%}."]
