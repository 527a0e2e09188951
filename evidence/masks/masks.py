# SPDX-License-Identifier: Apache-2.0
"""Compares the time and error of the mask generators: `scripts/bench masks` writes evidence/results/masks.*"""

import dataclasses
import functools
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

import bluenoise

from ..base.command import Parser, core_count
from ..base.contact_sheet import enlarged_part, grey, sheet
from ..base.files import kept, write_image
from ..base.page import write_page
from ..base.plots import plt, save
from ..base.tables import md_table

ROOT = Path(__file__).resolve().parents[2]
SIZES = (64, 128, 256, 512, 1024, 2048)
PLAIN = 128  # width and height of other libraries' masks, and of the masks in the plot of error against time
ERRORS = ("e_0.75", "e_1", "e_1.5", "e_2")
FIELDS = ("method", "options", "width", "threads", "repeats", "seconds", "cpu_seconds", *ERRORS)
NETWORKS = {"network": "neural.onnx", "fast network": "neural_fast.onnx", "vector network": "neural_vector.onnx"}
#: The methods to choose from: {method: (options of its rows, windows of an infinite plane, channels, bit-identical on every machine)}.
CHOICES = {
    "void-and-cluster": ("", "no", "1", "yes"),
    "relax": ("", "no", "1", "yes"),
    "network": ("", "yes", "1", "in practice"),
    "fast network": ("", "yes", "1", "in practice"),
    "vector network": ("", "yes", "2", "no"),
    "anneal": ("1000 sweeps", "no", "1 to 4", "yes"),
}
CHOICE_SIZES = (64, 256, 1024, 2048)
UNTIMED = ("void-and-cluster, sigma 1.9", "builtin")


@dataclasses.dataclass(frozen=True)
class Method:
    name: str
    options: str
    make: Callable  # make(shape, seed=, and threads= with many_threads)
    sizes: tuple = SIZES
    many_threads: bool = False
    most_repeats: int = 20


def network(file, channels):
    """make() of a network, with one generator per thread count."""
    generator = functools.cache(lambda threads: bluenoise.NeuralGenerator(ROOT / "libbn/data" / file, threads=threads, channels=channels))
    return lambda shape, seed, threads: generator(threads).mask(shape, seed=seed)


def white(shape, seed):
    """Ranks in random order."""
    return np.random.default_rng(seed).permutation(shape[0] * shape[1]).astype(np.uint32).reshape(shape)


METHODS = (
    Method("white", "", white),
    Method("void-and-cluster", "", bluenoise.void_and_cluster),
    Method("void-and-cluster", "sigma 1.9", functools.partial(bluenoise.void_and_cluster, sigma=1.9), (PLAIN,)),
    Method("relax", "", bluenoise.relax, many_threads=True),
    *(Method("anneal", f"{sweeps} sweeps", functools.partial(bluenoise.anneal, sweeps=sweeps), tuple(n for n in SIZES if n <= most), most_repeats=repeats)
      for sweeps, most, repeats in ((100, 256, 3), (1000, 128, 1), (10000, 128, 1))),
    Method("builtin", "", lambda shape, seed: bluenoise.builtin(shape), (16, 32, 64, 128, 256)),
    *(Method(name, "", network(file, 1 + (name == "vector network")), many_threads=True) for name, file in NETWORKS.items()),
)


# ---- Measuring

def row_of(method, options, width, threads, repeats, seconds, masks):
    """seconds: (wall-clock, CPU). Errors are means over masks and their channels."""
    channels = [channel for ranks in masks for channel in ranks.reshape(-1, *ranks.shape[-2:])]
    errors = (statistics.mean(bluenoise.dithering_error(ranks, float(key[2:])) for ranks in channels) for key in ERRORS)
    return dict(zip(FIELDS, (method, options, width, threads, repeats, *(f"{value:.6f}" for value in seconds), *(f"{error:.5f}" for error in errors))))


def measure(cores):
    """Yields rows as dicts. Runs of different methods are interleaved at each size, so that other jobs on the machine affect all of them alike."""
    for size in (16, 32, *SIZES):
        repeats = {64: 20, 128: 20, 256: 9, 512: 5, 1024: 3}.get(size, 1)
        jobs = [(method, threads, [], []) for method in METHODS if size in method.sizes for threads in sorted({1, cores if method.many_threads else 1})]
        # The first run of the fast methods is a warm-up. It makes no difference at the largest size.
        for seed in range(-1 if size < 2048 else 0, repeats):
            for method, threads, times, masks in jobs:
                if seed < 0 and method.most_repeats < 20 or seed >= method.most_repeats:
                    continue
                wall, cpu = time.perf_counter(), time.process_time()
                ranks = method.make((size, size), seed=max(seed, 0), **({"threads": threads} if method.many_threads else {}))
                if seed >= 0:
                    times.append((time.perf_counter() - wall, time.process_time() - cpu))
                    # Measuring the errors of large masks takes longer than generating them, and they barely differ between seeds.
                    if len(masks) < (1 if size >= 512 else repeats):
                        masks.append(ranks)
        for method, threads, times, masks in jobs:
            row = row_of(method.name, method.options, size, threads, len(times), map(min, zip(*times)), masks)
            print(f"bench: {size}x{size} {label(row)}", file=sys.stderr)
            yield row


def run_peer(name, command):
    """A row for another library's generator (--peer)."""
    seconds = []
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "ranks"
        for _ in range(3):
            result = subprocess.run([*command.split(), str(PLAIN), str(PLAIN), str(path)], stdout=subprocess.PIPE, text=True, check=False)
            if result.returncode != 0:
                sys.exit(f"bench: the peer {name} ({command}) failed with status {result.returncode}")
            seconds.append([float(word) for word in result.stdout.split()[-2:]])
        return row_of(name, "", PLAIN, 1, 3, map(statistics.median, zip(*seconds)), [np.fromfile(path, "<u4").reshape(PLAIN, PLAIN)])


# ---- Tables, the plot and the image

def label(row):
    return ", ".join(filter(None, (row["method"], row["options"], f"{row['threads']} threads" if row["threads"] > 1 else "")))


def time_text(seconds):
    return f"{1e6 * seconds:.0f} us" if seconds < 1e-3 else f"{1e3 * seconds:.3g} ms" if seconds < 1 else f"{seconds:.3g} s"


def table(rows):
    lines = []
    for row in (row for row in rows if row["width"] == PLAIN):
        times = [time_text(row["seconds"]), time_text(row["cpu_seconds"]), f"{1e9 * row['cpu_seconds'] / row['width'] ** 2:.0f} ns"]
        lines.append([label(row), *(times if label(row) not in UNTIMED else ["", "", ""]), *(f"{row[key]:.4f}" for key in ERRORS)])
    return md_table(["method", "time", "CPU time", "per texel", *(key.upper() for key in ERRORS)], lines)


def choice_rows(rows, method):
    return [row for row in rows if (row["method"], row["options"]) == (method, CHOICES[method][0])]


def choice_table(rows, threads):
    """A table of what each method can do."""
    lines = []
    for method, (options, *abilities) in CHOICES.items():
        own = choice_rows(rows, method)
        if own:
            quality = next((row for row in own if row["width"] == PLAIN), own[0])
            cells = [f"{quality[key]:.4f}" for key in ("e_1", "e_1.5")]
            for size in CHOICE_SIZES:
                at = [row for row in own if row["width"] == size]
                best = [row for row in at if row["threads"] == threads] or at
                cells.append(time_text(best[0]["seconds"]) if best else "")
            lines.append([", ".join(filter(None, (method, options))), *cells, *abilities])
    return md_table(["method", "E_1", "E_1.5", *(f"{size}x{size}" for size in CHOICE_SIZES), "windows", "channels", "same bits"], lines, 3)


def plot(rows, path):
    """Plots error against time per texel, and time against size, for the methods in CHOICES."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.6))
    for i, method in enumerate(CHOICES):
        best = {}
        for row in choice_rows(rows, method):
            width, taken = row["width"], 1e3 * row["seconds"]
            best[width] = min(taken, best.get(width, taken))
            if width == PLAIN and row["threads"] == 1:
                left.plot(1e6 * row["cpu_seconds"] / width**2, row["e_1"], "o", color=f"C{i}", label=label(row))
        right.plot(list(best), list(best.values()), ".-", color=f"C{i}")
    left.set(xscale="log", xlabel="microseconds of CPU time per texel", ylabel="E_1 (lower is better)",
             title=f"error against time, {PLAIN}x{PLAIN}, one thread")
    right.set(xscale="log", yscale="log", xlabel="width = height in texels", ylabel="milliseconds", title="time per mask, all cores")
    left.legend(fontsize=9)
    for axis in (left, right):
        axis.grid(True, which="both", alpha=0.25)
    save(figure, path)


def picture(groups, path):
    """One row per generator: the top-left quarter, the mean spectrum (grey from 0 to 2 times white noise), and three grey levels."""
    rows = []
    for masks in groups.values():
        values, side = bluenoise.to_float(masks[0]), masks[0].shape[0]
        power = np.fft.fftshift(np.mean([bluenoise.power_spectrum(ranks) for ranks in masks], axis=0))
        parts = [256 * values, *(np.where(values < level, 0, 255) for level in (1 / 16, 1 / 4, 1 / 2))]
        images = [enlarged_part(grey(np.uint8(part)), (0, 0, side // 2, side // 2), 2) for part in parts]
        rows.append([images[0], grey(np.uint8(np.clip(power * 127.5, 0, 255))), *images[1:]])
    write_image(path, sheet(rows, list(groups), ["ranks", "power spectrum", "1/16", "1/4", "1/2"]).convert("L"))


def answer(rows, method, size):
    own = [row for row in choice_rows(rows, method) if row["width"] == size]
    return f"{time_text(min(row['seconds'] for row in own))} to reach an E_1 of {own[0]['e_1']:.4f}"


def run(arguments):
    parser = Parser("masks", __doc__)
    parser.add_argument("--peer", action="append", default=[], metavar='"NAME=COMMAND"',
                        help="another library's generator: `COMMAND WIDTH HEIGHT FILE` writes ranks to FILE as little-endian "
                             "32-bit integers and prints the wall-clock time and the CPU time in seconds")
    parser.add_argument("--again", action="store_true", help="keep the times in masks.csv and redo everything else")
    parser.out()
    parser.hidden("--picture", "docs/neural.png")
    options = parser.parse_args(arguments)
    peers = [peer.partition("=") for peer in options.peer]
    if not all(command for _, _, command in peers):
        parser.error("--peer must be NAME=COMMAND")
    threads = core_count()

    rows = kept(options.out / "masks.csv", options.again, lambda: [
        *measure(threads), *(run_peer(name, command) for name, _, command in peers)])
    plot(rows, options.out / "masks.png")
    generator, count = bluenoise.NeuralGenerator(), 16
    picture({name: [make((128, 128), seed=seed) for seed in range(count)] for name, make in (
        ("network", generator.mask), ("void-and-cluster", bluenoise.void_and_cluster), ("white", white))}, options.picture)
    known = {method.name for method in METHODS}
    write_page(options.out / "masks.md", globals(), rows=rows, threads=threads, others=dict.fromkeys(row["method"] for row in rows if row["method"] not in known),
               size=max(row["width"] for row in rows if row["width"] <= 1024 and row["method"] == "network"))
