# SPDX-License-Identifier: Apache-2.0
"""Compares the mask generators, time against error: `scripts/bench masks` writes docs/report/masks.*

Times every generator, and those of other libraries if given, and writes their results as CSV, the tables in
masks.md and plots of time against error, time against size, and spectra.
"""

import argparse
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import bluenoise

from ..base.command import add_out
from ..base.files import read_rows, write_rows, write_text
from ..base.plots import plt, save
from ..base.tables import md_table

ERRORS = ("e_0.75", "e_1", "e_1.5", "e_2")
FIELDS = ("method", "options", "width", "height", "depth", "threads", "repeats", "seconds", "cpu_seconds", *ERRORS)
LEVELS = ((1, 128), (1, 64), (1, 32), (1, 16), (1, 8), (1, 4), (1, 2), (3, 4), (7, 8), (15, 16), (31, 32), (63, 64),
          (127, 128))
COLOURS = {"white": "0.6", "void-and-cluster, sigma 1.5": "tab:blue", "void-and-cluster, sigma 1.9": "tab:cyan",
           "relax": "tab:green", "anneal": "tab:orange",
           "builtin": "tab:red", "textbook, sigma 1.5": "black"}
PEER_SIZE = 128  # width and height of peers' masks, and of those in the plot of error against time
PEER_COLOURS = ("tab:purple", "tab:brown", "tab:pink", "tab:olive")


def row_of(method, options, shape, threads, times, masks=()):
    """times: (wall-clock, CPU) seconds of each run. Errors are means over the masks."""
    depth, height, width = (1, *shape)[-3:]
    errors = [f"{statistics.mean(bluenoise._core.mask_error(ranks, float(key[2:])) for ranks in masks):.5f}" if masks else "" for key in ERRORS]
    medians = (f"{statistics.median(column):.6f}" for column in zip(*times))
    return dict(zip(FIELDS, (method, options, width, height, depth, threads, len(times), *medians, *errors)))


def measure(quick):
    """The rows of all methods. The first run of each is not counted: it meets cold memory."""
    rows = []

    def job(method, options, shape, repeats, threads=1, **given):
        times, masks = [], []
        if method == "relax":
            given["threads"] = threads
        for seed in (0, *range(repeats)):
            wall, cpu = time.perf_counter(), time.process_time()
            masks.append(bluenoise.mask(shape, method=method, **({} if method == "builtin" else {"seed": seed, **given})))
            times.append((time.perf_counter() - wall, time.process_time() - cpu))
        # Errors of large masks take longer than the masks, and hardly differ between seeds.
        kept = masks[1:2] if shape[-1] >= 512 else masks[1:]
        rows.append(row_of(method, options, shape, threads, times[1:], kept if len(shape) == 2 else ()))
        print(f"bench: {label(rows[-1])}, {'x'.join(map(str, shape))}", file=sys.stderr)

    for size in (64, 128, 256) if quick else (64, 128, 256, 512, 1024):
        shape, repeats = (size, size), {64: 20, 128: 20, 256: 9, 512: 5}.get(size, 3)
        job("white", "", shape, repeats)
        for sigma in (1.5, 1.9):
            job("void-and-cluster", f"sigma {sigma}", shape, repeats, sigma=sigma)
        for threads in (1, 2):
            job("relax", "", shape, repeats, threads)
        for sweeps in () if size > 128 else (100,) if quick else (100, 1000, 10000):
            job("anneal", f"{sweeps} sweeps", shape, 1 if sweeps > 100 else 3, sweeps=sweeps)
    for size in (16, 32, 64, 128, 256):
        job("builtin", "", (size, size), 1)
    if not quick:
        job("void-and-cluster", "sigma 1.5", (64, 64, 64), 3, sigma=1.5)
    return rows


def run_peer(name, command, size, repeats):
    """A row for another library's generator. `command WIDTH HEIGHT FILE` writes ranks to FILE as little-endian 32-bit
    integers and prints the wall-clock time and the CPU time it took, in seconds."""
    seconds = []
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "ranks"
        for _ in range(repeats):
            result = subprocess.run([*command.split(), str(size), str(size), str(path)], stdout=subprocess.PIPE,
                                    text=True, check=False)
            if result.returncode != 0:
                sys.exit(f"bench: the peer {name} ({command}) failed with status {result.returncode}")
            seconds.append([float(word) for word in result.stdout.split()[-2:]])
        return row_of(name, "", (size, size), 1, seconds, [np.fromfile(path, "<u4").reshape(size, size)])


def textbook(size, sigma, seed):
    """Void-and-cluster as Ulichney published it, in double precision, for comparison: three phases, a random initial
    pattern of a tenth of the texels, an untruncated Gaussian on the torus, no optimisations."""
    offsets = np.minimum(np.arange(size), size - np.arange(size))
    gaussian = np.exp(-(offsets[:, None] ** 2 + offsets[None, :] ** 2) / (2 * sigma**2))
    rng = np.random.default_rng(seed)
    ones, ranks, n = np.zeros((size, size), bool), np.zeros((size, size), np.uint32), size * size

    def around(index):
        return np.roll(gaussian, np.unravel_index(index, gaussian.shape), (0, 1))

    def tightest(pattern, energy):
        return np.argmax(np.where(pattern, energy, -np.inf))

    initial = rng.choice(n, n // 10, replace=False)
    ones.flat[initial] = True
    energy = sum(around(index) for index in initial)
    while True:
        cluster = tightest(ones, energy)
        ones.flat[cluster] = False
        energy = energy - around(cluster)
        void = tightest(~ones, -energy)
        ones.flat[void] = True
        energy = energy + around(void)
        if void == cluster:
            break
    pattern, remaining = ones.copy(), energy.copy()
    for rank in range(len(initial) - 1, -1, -1):
        cluster = tightest(pattern, remaining)
        pattern.flat[cluster] = False
        remaining -= around(cluster)
        ranks.flat[cluster] = rank
    for rank in range(len(initial), n // 2):
        void = tightest(~ones, -energy)
        ones.flat[void] = True
        energy += around(void)
        ranks.flat[void] = rank
    zeros = ~ones
    energy = gaussian.sum() - energy
    for rank in range(n // 2, n):
        cluster = tightest(zeros, energy)
        zeros.flat[cluster] = False
        energy -= around(cluster)
        ranks.flat[cluster] = rank
    return ranks


def low_frequency(masks):
    """For each grey level, the mean power of the thresholded masks below half the principal frequency; white noise has
    power 1."""
    height, width = masks[0].shape
    frequency = np.hypot(np.fft.fftfreq(height)[:, None], np.fft.fftfreq(width)[None, :])
    powers = []
    for numerator, denominator in LEVELS:
        level = numerator / denominator
        low = (frequency > 0) & (frequency < np.sqrt(min(level, 1 - level)) / 2)
        mean = []
        for ranks in masks:
            pattern = (ranks < level * ranks.size).astype(float)
            pattern -= pattern.mean()
            mean.append((np.abs(np.fft.fft2(pattern)) ** 2)[low].mean() / (pattern**2).sum())
        powers.append(statistics.mean(mean))
    return powers


def label(row):
    name = row["method"]
    if row["options"]:
        name += f", {row['options']}"
    if row["method"] == "relax":
        name += f", {row['threads']} thread" + ("s" if int(row["threads"]) > 1 else "")
    return name


def time_text(seconds):
    return f"{1e6 * seconds:.0f} us" if seconds < 1e-3 else f"{1e3 * seconds:.3g} ms" if seconds < 1 else f"{seconds:.3g} s"


def table(rows):
    lines = []
    for row in rows:
        texels = int(row["width"]) * int(row["height"]) * int(row["depth"])
        seconds, cpu = float(row["seconds"]), float(row["cpu_seconds"])
        times = [time_text(seconds), time_text(cpu), f"{1e9 * cpu / texels:.0f} ns"]
        if row["method"] == "builtin":
            times = ["baked", "", ""]
        errors = [f"{float(row[key]):.4f}" if row[key] else "" for key in ERRORS]
        lines.append([label(row), *times, *errors])
    return md_table(["method", "time", "CPU time", "per texel", "E_0.75", "E_1", "E_1.5", "E_2"], lines)


def colour_of(row, peers):
    for name, colour in COLOURS.items():
        if label(row).startswith(name):
            return colour
    return PEER_COLOURS[peers.index(row["method"]) % len(PEER_COLOURS)]


def plot_times(rows, peers, size, path):
    figure, axes = plt.subplots(1, 3, figsize=(15, 4.6))
    at_size = [row for row in rows if int(row["width"]) == size and row["depth"] in ("1", 1) and row["method"] != "white"]
    for axis, key in zip(axes, ("e_1", "e_1.5")):
        for row in at_size:
            if row["method"] == "builtin":
                axis.axhline(float(row[key]), color=COLOURS["builtin"], linestyle="--", label="builtin (baked)")
                continue
            name = label(row)
            axis.plot(1e3 * float(row["cpu_seconds"]), float(row[key]), "o", color=colour_of(row, peers),
                      label=name)
        axis.set(xscale="log", xlabel="CPU time in ms", ylabel=f"E_{key[2:]}", title=f"{size}x{size}: error {key[2:]} against time")
        axis.grid(True, which="both", alpha=0.25)
    axes[0].legend(fontsize=7)
    flat = [row for row in rows if row["depth"] in ("1", 1) and row["method"] not in ("white", "builtin")]
    for name in dict.fromkeys(label(row) for row in flat if row["method"] != "anneal"):
        chosen = [row for row in flat if label(row) == name]
        axes[2].plot([int(row["width"]) for row in chosen], [1e3 * float(row["cpu_seconds"]) for row in chosen],
                     marker="o", markersize=3, color=colour_of(chosen[0], peers), label=name,
                     linestyle=":" if chosen[0]["threads"] in ("2", 2) else "-")
    axes[2].set(xscale="log", yscale="log", xlabel="width = height in texels", ylabel="CPU time in ms", title="time against size")
    axes[2].grid(True, which="both", alpha=0.25)
    axes[2].legend(fontsize=7)
    save(figure, path)


def plot_spectra(groups, path):
    """Radially averaged power spectra of the masks and of their thresholded patterns at two grey levels."""
    figure, axes = plt.subplots(1, 3, figsize=(15, 4.2))
    for name, masks in groups.items():
        size = masks[0].shape[0]
        frequency = np.hypot(np.fft.fftfreq(size)[:, None], np.fft.fftfreq(size)[None, :])
        ring = np.floor(frequency * size + 0.5).astype(int).ravel()
        for axis, level in zip(axes, (None, 1 / 16, 1 / 2)):
            power = 0
            for ranks in masks:
                values = ranks.astype(float) if level is None else (ranks < level * ranks.size).astype(float)
                values -= values.mean()
                power = power + np.abs(np.fft.fft2(values)).ravel() ** 2 / (values**2).sum() / len(masks)
            radial = np.bincount(ring, power) / np.bincount(ring)
            steps = np.arange(1, len(radial))
            axis.plot(steps / size, radial[1:], label=name, color=COLOURS.get(name))
            axis.set(xlabel="cycles per texel", title="ranks" if level is None else f"thresholded at {level:g}")
            axis.set(yscale="log", ylim=(1e-3, 8))
            axis.grid(True, which="both", alpha=0.25)
    axes[0].set_ylabel("power, white = 1")
    axes[0].legend(fontsize=7)
    save(figure, path)


def level_table(groups):
    return md_table(["mask", *(f"{a}/{b}" for a, b in LEVELS)],
                    [[name, *(f"{power:.3f}" for power in low_frequency(masks))] for name, masks in groups.items()])


def generated_masks(size, quick):
    count = 2 if quick else 8
    groups = {
        "void-and-cluster, sigma 1.5": [bluenoise.mask((size, size), seed=seed) for seed in range(count)],
        "textbook, sigma 1.5": [textbook(size, 1.5, seed) for seed in range(count)],
    }
    groups["relax"] = [bluenoise.mask((size, size), method="relax", seed=seed) for seed in range(count)]
    groups["builtin"] = [bluenoise.mask((size, size), method="builtin")]
    return groups


def answer(rows):
    """What the tables say about one size, in a sentence for each method."""
    sizes = [int(row["width"]) for row in rows if row["method"] == "relax"]
    size = 256 if 256 in sizes else max(sizes)

    def of(method, options):
        own = [row for row in rows if (row["method"], row["options"]) == (method, options) and int(row["width"]) == size
               and int(row["depth"]) == 1]
        fastest = min(own, key=lambda row: float(row["seconds"]))
        return f"{time_text(float(fastest['seconds']))} for an E_1 of {float(fastest['e_1']):.4f}"

    return (f"A mask of {size}x{size} texels takes void-and-cluster {of('void-and-cluster', 'sigma 1.5')} and relaxation {of('relax', '')}; "
            f"white noise has {next(float(row['e_1']) for row in rows if row['method'] == 'white'):.4f}. "
            "[masks.md](../masks.md) says which method to take.")


def report_text(rows, groups, anisotropies, command):
    parts = ["# Masks: time against error", "", f"Printed by `{command}`.", "", answer(rows), "",
             "![Time against error and size](masks_times.png)", "",
             "Times are medians of wall-clock time and of CPU time (summed over threads, and more",
             "reliable on a busy machine); time per texel is CPU time. Errors are means of `bn_mask_error` over seeds; lower",
             "is better. One thread unless stated otherwise; `white` is white noise.", ""]
    for size in sorted({int(row["width"]) for row in rows if row["depth"] in ("1", 1)}):
        chosen = [row for row in rows if int(row["width"]) == size and row["depth"] in ("1", 1)]
        parts += [f"## {size}x{size}", "", table(chosen), ""]
    deep = [row for row in rows if row["depth"] not in ("1", 1)]
    if deep:
        parts += ["## 64x64x64", "", table(deep), ""]
    parts += ["## Every grey level", "",
              "Power of thresholded masks below half the principal frequency, relative to white noise, compared with",
              "void-and-cluster as published, in double precision without optimisations (`textbook`), 64x64:", "",
              level_table(groups), "",
              "![Radially averaged power spectra](masks_spectra.png)", "",
              "## Anisotropy", "",
              "Anisotropy of the mean spectrum of 16 masks of 128x128, in dB; 16 perfectly isotropic masks have -12:", ""]
    parts += [f"* {name}: {value:.1f}" for name, value in anisotropies.items()]
    return "\n".join(parts) + "\n"


def run(arguments):
    parser = argparse.ArgumentParser(prog="scripts/bench masks", description=__doc__.splitlines()[0])
    parser.add_argument("--peer", action="append", default=[], metavar='"NAME=COMMAND"',
                        help="another library's generator: `COMMAND WIDTH HEIGHT FILE` writes ranks to FILE as little-endian "
                             "32-bit integers and prints the wall-clock time and the CPU time in seconds")
    parser.add_argument("--quick", action="store_true", help="sizes up to 256 only")
    parser.add_argument("--again", action="store_true", help="keep the times in masks.csv and redo everything else")
    add_out(parser)
    options = parser.parse_args(arguments)

    rows = read_rows(options.out / "masks.csv") if options.again else measure(options.quick)
    methods = ("white", "builtin", "void-and-cluster", "relax", "anneal")
    peers = list(dict.fromkeys(row["method"] for row in rows if row["method"] not in methods))
    for peer in options.peer:
        name, _, command = peer.partition("=")
        if not command:
            parser.error(f"--peer must be NAME=COMMAND, not {peer}")
        peers.append(name)
        rows.append(run_peer(name, command, PEER_SIZE, 1 if options.quick else 3))
    write_rows(options.out / "masks.csv", FIELDS, rows)
    plot_times(rows, peers, PEER_SIZE, options.out / "masks_times.png")
    groups = generated_masks(64, options.quick)
    plot_spectra(groups, options.out / "masks_spectra.png")
    anisotropies = {
        method: bluenoise.anisotropy([bluenoise.mask((128, 128), method=method, seed=seed) for seed in range(16)])
        for method in ("void-and-cluster", "relax", "white")
    }
    command = "scripts/bench masks" + "".join(f' --peer "{name}=COMMAND"' for name in peers)
    text = report_text(rows, groups, anisotropies, command)
    write_text(options.out / "masks.md", text)
    print(text)
