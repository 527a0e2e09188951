# SPDX-License-Identifier: Apache-2.0
"""Compares neural masks with others, time against error: `scripts/bench neural` writes docs/report/neural.*

Times the built-in network and the library's other mask generators at sizes up to 2048, on one thread and on all, adds
results of other networks from a file and windows of an endless plane, and writes the tables and plots of neural.md,
docs/neural.png with masks, spectra and thresholded patterns, and the table of methods in docs/masks.md.
"""

import argparse
import dataclasses
import functools
import os
import re
import statistics
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

import bluenoise

from ..base.command import add_out
from ..base.files import read_rows, write_image, write_rows, write_text
from ..base.plots import plt, save
from ..base.tables import md_table, update_table
from . import neural_plane, neural_vectors
from .masks import level_table, time_text

ROOT = Path(__file__).resolve().parents[3]
DATA = ROOT / "libbn/data"
SIZES = (64, 128, 256, 512, 1024, 2048)
QUICK_SIZES = (64, 128)
QUALITY_SHAPES = ((64, 64), (128, 128), (256, 256), (97, 61), (65, 300), (16, 16))
FIELDS = ("method", "options", "width", "threads", "repeats", "seconds", "cpu_seconds", "e_1", "e_1.5", "flop_per_texel")
COLOURS = {"network": "tab:red", "fast network": "tab:pink", "vector network": "tab:purple", "void-and-cluster": "tab:blue", "relax": "tab:green",
           "anneal": "tab:orange", "white": "0.6"}

NETWORKS = {"network": "neural.onnx", "fast network": "neural_fast.onnx", "vector network": "neural_vector.onnx"}


def cost(file):
    """(FLOP per texel without margins, receptive radius in texels) of a network, from the table that comes with it."""
    text = (DATA / "README.md").read_text(encoding="utf-8")
    kflop, radius = re.search(rf"^\| `{re.escape(file)}` \| [0-9,]+ \| ([0-9.]+) \| ([0-9]+) \|", text, re.MULTILINE).groups()
    return 1000 * float(kflop), int(radius)


# Additions and multiplications of the inner loops, per texel. Void-and-cluster adds a disc of radius 5 for each texel it
# sets; relaxation multiplies and adds pairs; a trial of annealing sums two windows of 15 x 15 before and after, with about
# 2 operations each.
VOID_AND_CLUSTER_FLOP = 81
RELAX_PAIRS = 924  # of all steps: BN_RELAX_LEARNED_PAIRS
ANNEAL_FLOP = 2 * 2 * 225


@dataclasses.dataclass(frozen=True)
class Method:
    name: str
    options: str
    make: Callable  # make(size, seed, threads)
    flop: float
    sizes: tuple = SIZES
    many_threads: bool = True


def network(model=None, channels=1):
    """make() of a Method: masks of a network, with a generator for each number of threads."""
    generator = functools.cache(lambda threads: bluenoise.NeuralGenerator(model, threads=threads, channels=channels))
    return lambda size, seed, threads: generator(threads).mask((size, size), seed=seed)


def mask(**options):
    """make() of a Method on one thread."""
    return lambda size, seed, threads: bluenoise.mask((size, size), seed=seed, **options)


def relax(**options):
    return lambda size, seed, threads: bluenoise.mask((size, size), method="relax", seed=seed, threads=threads, **options)


def methods(most):
    """All methods; those that take long have no sizes above `most`."""
    made = [Method(name, "", network(DATA / file, 2 if name == "vector network" else 1), cost(file)[0]) for name, file in NETWORKS.items()]
    made.append(Method("relax", "", relax(), 2 * RELAX_PAIRS))
    made.append(Method("void-and-cluster", "", mask(), VOID_AND_CLUSTER_FLOP, many_threads=False))
    for sweeps, largest in ((100, 256), (1000, 128)):
        made.append(Method("anneal", f"{sweeps} sweeps", mask(method="anneal", sweeps=sweeps), ANNEAL_FLOP * sweeps,
                           tuple(size for size in SIZES if size <= min(largest, most)), many_threads=False))
    return [*made, Method("white", "", mask(method="white"), 0, many_threads=False)]


def repeats_of(size, quick):
    return 2 if quick else {64: 20, 128: 20, 256: 9, 512: 5, 1024: 3}.get(size, 1)


def errors_of(masks):
    channels = [channel for ranks in masks for channel in ranks.reshape(-1, *ranks.shape[-2:])]
    figures = [(bluenoise._core.mask_error(ranks, 1.0), bluenoise._core.mask_error(ranks, 1.5)) for ranks in channels]
    return tuple(statistics.mean(column) for column in zip(*figures))


def measure(chosen, sizes, threads, quick):
    """Rows as dicts. The methods for one size are interleaved, so that other load affects all alike."""
    rows = []
    for size in sizes:
        jobs = [(method, count) for method in chosen if size in method.sizes
                for count in ((1, threads) if method.many_threads and threads > 1 else (1,))]
        repeats = repeats_of(size, quick)
        times = [[] for _ in jobs]
        masks = [[] for _ in jobs]
        # The first run is a warm-up, which makes no difference at the largest sizes.
        for seed in range(-1 if size < 2048 else 0, repeats):
            for job, (method, count) in enumerate(jobs):
                if method.name == "anneal" and len(times[job]) >= (1 if method.options == "1000 sweeps" else 3):
                    continue
                wall, cpu = time.perf_counter(), time.process_time()
                ranks = method.make(size, max(seed, 0), count)
                wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
                if seed < 0 and method.name != "anneal":
                    continue
                times[job].append((wall, cpu))
                # Measuring large masks takes longer than generating them, and errors hardly differ between seeds.
                if count == 1 and len(masks[job]) < (1 if size >= 512 else repeats):
                    masks[job].append(ranks)
        errors = {}
        for (method, count), made, taken in zip(jobs, masks, times):
            if count == 1:
                errors[method] = errors_of(made)
            rows.append({
                "method": method.name, "options": method.options, "width": size, "threads": count,
                "repeats": len(taken), "seconds": f"{min(wall for wall, _ in taken):.6f}",
                "cpu_seconds": f"{min(cpu for _, cpu in taken):.6f}",
                "e_1": f"{errors[method][0]:.5f}", "e_1.5": f"{errors[method][1]:.5f}",
                "flop_per_texel": f"{method.flop:.0f}"})
            print(f"bench: {size}x{size} {label(rows[-1])}: {time_text(float(rows[-1]['seconds']))}", flush=True)
    return rows


def paper_rows(path, sizes):
    """Rows from a CSV with the columns name, size, seconds, threads, e_1, e_1.5, flop_per_texel."""
    return [{"method": row["name"], "options": "", "width": int(row["size"]), "threads": int(row["threads"]),
             "repeats": "", "seconds": row["seconds"], "cpu_seconds": row["seconds"], "e_1": row["e_1"],
             "e_1.5": row["e_1.5"], "flop_per_texel": row["flop_per_texel"]}
            for row in read_rows(path) if int(row["size"]) in sizes]


def label(row):
    name = row["method"] + (f", {row['options']}" if row["options"] else "")
    return name + (f", {row['threads']} threads" if int(row["threads"]) > 1 else "")


def microseconds(row):
    """CPU time per texel."""
    return 1e6 * float(row["cpu_seconds"]) / int(row["width"]) ** 2


def flop_text(text):
    value = float(text or "nan")
    if not value > 0:
        return ""
    return f"{value:.0f}" if value < 1e4 else f"{value / 1e3:.0f} k" if value < 1e6 else f"{value / 1e6:.1f} M"


def table(rows):
    lines = []
    for row in sorted(rows, key=lambda row: float(row["cpu_seconds"])):
        times = time_text(float(row["seconds"])), time_text(float(row["cpu_seconds"]))
        lines.append([label(row), *times, f"{1e3 * microseconds(row):.0f} ns", flop_text(row["flop_per_texel"]),
                      f"{float(row['e_1']):.4f}", f"{float(row['e_1.5']):.4f}"])
    return md_table(["method", "time", "CPU time", "per texel", "FLOP per texel", "E_1", "E_1.5"], lines)


def plot(rows, sizes, path):
    """Error against time per texel, and time against size, of the methods of CHOICES."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.6))
    size = 128 if 128 in sizes else sizes[0]
    for method, (options, *_) in CHOICES.items():
        own = [row for row in rows if (row["method"], row["options"]) == (method, options)]
        best = {}
        for row in own:
            width, taken = int(row["width"]), 1e3 * float(row["seconds"])
            best[width] = min(taken, best.get(width, taken))
            if width == size and int(row["threads"]) == 1:
                left.plot(microseconds(row), float(row["e_1"]), "o", color=COLOURS[method], label=label(row))
        right.plot(list(best), list(best.values()), ".-", color=COLOURS[method])
    left.set(xscale="log", xlabel="microseconds of CPU time per texel", ylabel="E_1 (lower is better)",
             title=f"error against time, {size}x{size}, one thread")
    right.set(xscale="log", yscale="log", xlabel="width = height in texels", ylabel="milliseconds", title="time of a mask, all cores")
    left.legend(fontsize=9)
    for axis in (left, right):
        axis.grid(True, which="both", alpha=0.25)
    save(figure, path)


# ---- The choice of a method

#: Of each method: its rows in the tables, then windows of an endless plane, channels, and equal bits on every machine.
CHOICES = {
    "void-and-cluster": ("", "no", "1", "yes"),
    "relax": ("", "no", "1", "yes"),
    "network": ("", "yes", "1", "in practice"),
    "fast network": ("", "yes", "1", "in practice"),
    "vector network": ("", "yes", "2", "no"),
    "anneal": ("1000 sweeps", "no", "1 to 4", "yes"),
}
CHOICE_SIZES = (64, 256, 1024, 2048)


def choice_table(rows, threads):
    """What each method can do. A test compares docs/masks.md with it."""
    lines = []
    for method, (options, *abilities) in CHOICES.items():
        own = [row for row in rows if row["method"] == method and row["options"] == options]
        if not own:
            continue
        quality = next((row for row in own if int(row["width"]) == 128), own[0])
        cells = [f"{float(quality[key]):.4f}" for key in ("e_1", "e_1.5")]
        for size in CHOICE_SIZES:
            at = [row for row in own if int(row["width"]) == size]
            best = [row for row in at if int(row["threads"]) == threads] or at
            cells.append(time_text(float(best[0]["seconds"])) if best else "")
        lines.append([", ".join(filter(None, (method, options))), *cells, *abilities])
    return md_table(["method", "E_1", "E_1.5", *(f"{size}x{size}" for size in CHOICE_SIZES), "windows", "channels", "same bits"], lines, 3)


def answer(rows, sizes, threads):
    """What the report found, in a paragraph."""
    size = 1024 if 1024 in sizes else max(sizes)

    def of(method):
        own = [row for row in rows if row["method"] == method and row["options"] == CHOICES[method][0] and int(row["width"]) == size]
        return f"{time_text(min(float(row['seconds']) for row in own))} for an E_1 of {float(own[0]['e_1']):.4f}"

    return [f"For a single mask the network is not the best tool: at {size}x{size}, on {threads} threads, `void-and-cluster` takes",
            f"{of('void-and-cluster')}, `relax` {of('relax')}, the network {of('network')}.",
            "Both of the former have the same bits everywhere and need no ONNX Runtime. A network is for what they cannot do: windows of",
            "a plane without end or period, and two channels that are blue together, for which annealing takes far longer (see Vectors).", ""]


# ---- Quality of the built-in network


def quality_table(generator, seeds):
    """Errors over seeds for different shapes."""
    lines = []
    for height, width in QUALITY_SHAPES:
        figures = np.array([errors_of([generator.mask((height, width), seed=seed)]) for seed in range(seeds)])
        mean, most = figures.mean(axis=0), figures.max(axis=0)
        lines.append([f"{height}x{width}", *(f"{value:.4f}" for value in (mean[0], most[0], mean[1], most[1]))])
    return md_table(["shape", f"E_1, mean of {seeds}", "largest", "E_1.5, mean", "largest"], lines)


def fixed_pattern(generator, count, size=32):
    """The standard deviation over texels of the mean of `count` masks, relative to that of independent masks."""
    total = np.zeros((size, size))
    for seed in range(count):
        total += bluenoise.to_float(generator.mask((size, size), seed=seed))
    return (total / count).std() / np.sqrt(1 / 12 / count)


def spectrum_picture(masks, size):
    """The mean power spectrum, zero frequency in the middle, grey from 0 to 2 times white noise."""
    power = np.mean([bluenoise.power_spectrum(ranks) for ranks in masks], axis=0)
    return Image.fromarray(np.uint8(np.clip(np.fft.fftshift(power) * 127.5, 0, 255))).resize((size, size), Image.NEAREST)


def picture(groups, path):
    """One row per kind of mask: the mask, its spectrum, and its patterns at three grey levels."""
    side, gap, head = 192, 8, 20
    columns = ["ranks", "power spectrum", "1/16", "1/4", "1/2"]
    sheet = Image.new("L", (len(columns) * (side + gap) + gap, len(groups) * (side + gap + head) + gap), 255)
    draw = ImageDraw.Draw(sheet)
    for row, (name, masks) in enumerate(groups.items()):
        values = bluenoise.to_float(masks[0])
        crop = values[: side // 2, : side // 2]
        tiles = [Image.fromarray(np.uint8(crop * 256)), spectrum_picture(masks, side)]
        tiles += [Image.fromarray(np.where(crop < level, 0, 255).astype(np.uint8)) for level in (1 / 16, 1 / 4, 1 / 2)]
        top = gap + row * (side + gap + head)
        for column, (title, tile) in enumerate(zip(columns, tiles)):
            left = gap + column * (side + gap)
            draw.text((left, top + 4), f"{name}: {title}" if column == 0 else title, fill=0)
            sheet.paste(tile.resize((side, side), Image.NEAREST), (left, top + head))
    write_image(path, sheet)


def report_text(rows, sizes, quality, flatness, anisotropy, masks, levels, vectors, threads):
    parts = ["# Neural masks: time against error", "", "Printed by `scripts/bench neural`.", "", *answer(rows, sizes, threads),
             "![Error against time, time against size](neural.png)", "", "## Which method", "",
             "Wall-clock time on all cores, for those methods that can use several. *Windows*: of an endless plane. *Channels*:",
             "vectors that are blue each and together. *Same bits*: on every machine; for networks, see bn/neural.h.",
             "All methods make any size.", "",
             choice_table(rows, threads), "",
             "`bluenoise mask --method auto` chooses by shape and channels: for one channel, relaxation for two-dimensional masks of more",
             "than 512x512 texels and void-and-cluster otherwise; for two, the vector network; for more, annealing with 100 sweeps.", "",
             "## How it was measured", "",
             "Times are minima over repeats of wall-clock time and of CPU time (summed over",
             "threads, and more reliable on a busy machine), on 1 thread unless stated otherwise",
             f"({threads} threads are all cores of the machine); the methods for one size were interleaved. Time per texel is",
             "CPU time. Errors are means of `bn_mask_error` over seeds; lower is better. FLOP per texel counts the",
             "multiplications and additions of the inner loop (for a network, one per computed value),",
             "without margins and sorting; those of void-and-cluster, relaxation and annealing are integer",
             "operations.", ""]
    for name, file in NETWORKS.items():
        flop, radius = cost(file)
        parts.append(f"* {name}: {(DATA / file).stat().st_size} bytes, {flop:.0f} FLOP per texel, receptive radius {radius} texels.")
    parts.append("")
    for size in sizes:
        parts += [f"## {size}x{size}", "", table([row for row in rows if int(row["width"]) == size]), ""]
    decibels = ", ".join(f"{name} {value:.1f}" for name, value in anisotropy.items())
    parts += ["## Every size and seed", "", "The built-in network; quality is only promised from 16x16 on.",
              "", quality, "",
              f"The mean of {flatness[1]} masks of 32x32 deviates from flat {flatness[0]:.3f} times as much as the mean of",
              "independent white noise (1: no fixed pattern). Anisotropy of the mean spectrum of",
              f"{masks} masks of 128x128, in dB (perfectly isotropic masks have {-10 * np.log10(masks):.0f}):",
              f"{decibels}.", "",
              "## Every grey level", "",
              "Power of thresholded masks below half the principal frequency, relative to white noise:", "", levels, "",
              "In masks of one channel, libbn itself orders the points of the lightest and darkest patterns, which `relax` and the",
              "networks space poorly. In windows, patterns below about 1/32 and above 31/32 are far less blue.", "",
              "## Vectors", "", *vectors, ""]
    return "\n".join(parts)


def run(arguments):
    parser = argparse.ArgumentParser(prog="scripts/bench neural", description=__doc__.splitlines()[0])
    parser.add_argument("--paper", type=Path, metavar="FILE",
                        help="results of other networks, as written by `python -m bn_trainer table` (default "
                             "docs/report/paper.csv, if it exists)")
    parser.add_argument("--quick", action="store_true", help="two sizes and few seeds: a test, not a measurement")
    parser.add_argument("--again", action="store_true", help="keep the times in neural.csv and redo everything else")
    neural_plane.add_option(parser)
    add_out(parser)
    parser.add_argument("--guide", type=Path, default=None, help=argparse.SUPPRESS)
    options = parser.parse_args(arguments)
    paper = options.paper or (ROOT / "docs/report/paper.csv")
    threads = os.cpu_count() or 1
    sizes = QUICK_SIZES if options.quick else SIZES
    if options.again:
        flop = {(method.name, method.options): method.flop for method in methods(max(sizes))}
        rows = [{**row, "flop_per_texel": flop[row["method"], row["options"]]} for row in read_rows(options.out / "neural.csv") if row["repeats"]]
    else:
        rows = measure(methods(64 if options.quick else max(sizes)), sizes, threads, options.quick)
    if options.paper or paper.is_file():
        rows += paper_rows(paper, sizes)

    write_rows(options.out / "neural.csv", FIELDS, rows)
    plot(rows, sizes, options.out / "neural.png")
    generator = bluenoise.NeuralGenerator()
    count = 2 if options.quick else 16
    groups = {"network": [generator.mask((128, 128), seed=seed) for seed in range(count)],
              "void-and-cluster": [bluenoise.mask((128, 128), seed=seed) for seed in range(count)],
              "white noise": [bluenoise.mask((128, 128), method="white", seed=seed) for seed in range(count)]}
    picture(groups, options.out.parent / "neural.png")
    quality = quality_table(generator, 2 if options.quick else 20)
    seeds = 50 if options.quick else 1000
    flatness = fixed_pattern(generator, seeds), seeds
    anisotropy = {name: bluenoise.anisotropy(masks) for name, masks in groups.items()}
    text = report_text(rows, sizes, quality, flatness, anisotropy, count, level_table(groups), neural_vectors.section(options), threads)
    text += "\n".join(["", *neural_plane.section({name: DATA / NETWORKS[name] for name in ("network", "fast network")}, options), ""])
    write_text(options.out / "neural.md", text)
    if options.guide or not options.quick:
        update_table(options.guide or ROOT / "docs" / "masks.md", "scripts/bench neural", choice_table(rows, threads))
    print(text)
