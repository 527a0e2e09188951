# SPDX-License-Identifier: Apache-2.0
"""Masks by a network, time against error: `scripts/bench neural` writes docs/report/neural.* and docs/neural.png

Times the network that ships beside this library's other mask makers at sizes up to 2048, on one thread and on all,
adds the rows of other networks from a file, and makes of them the tables of neural.md, the plots, and the README's
picture of masks, spectra and thresholded patterns.
"""

import argparse
import csv
import io
import os
import statistics
import time
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from PIL import Image, ImageDraw

import bluenoise
from report.files import write_image, write_text, written_beside
from report.masks import LEVELS, low_frequency, time_text
from report.onnx_cost import cost, metadata

ROOT = Path(__file__).resolve().parents[2]
FAST = ROOT / "libbn/data/neural_fast.onnx"
SIZES = (64, 128, 256, 512, 1024, 2048)
QUICK_SIZES = (64, 128)
QUALITY_SHAPES = ((64, 64), (128, 128), (256, 256), (97, 61), (65, 300), (16, 16))
FIELDS = ("method", "options", "width", "threads", "repeats", "seconds", "cpu_seconds", "e_1", "e_1.5", "flop_per_texel")
COLOURS = {"network": "tab:red", "fast network": "tab:pink", "void-and-cluster": "tab:blue", "relax": "tab:green",
           "anneal": "tab:orange", "white": "0.6"}
PAPER_COLOURS = ("tab:purple", "tab:brown", "tab:olive", "tab:cyan", "black")

# Additions and multiplications of the inner loops, per texel. Void-and-cluster adds a circle of 5 texels' radius for
# each texel it sets; a step of relaxation multiplies and adds 60 pairs; a trial of annealing sums two windows of 15 x 15
# before and after, about 2 operations each.
VOID_AND_CLUSTER_FLOP = 81
RELAX_FLOP = 2 * 60
ANNEAL_FLOP = 2 * 2 * 225


class Method:
    def __init__(self, name, options, make, flop, sizes=SIZES, many_threads=True):
        self.name, self.options, self.make, self.flop = name, options, make, flop
        self.sizes, self.many_threads = sizes, many_threads


def methods(models, most):
    """`models` maps the names of networks to None for the one that ships, or to a path."""
    made = []
    for name, path in models.items():
        generators = {}

        def make(size, seed, threads, path=path, generators=generators):
            if threads not in generators:
                generators[threads] = bluenoise.NeuralGenerator(path, threads=threads)
            return generators[threads].mask((size, size), seed=seed)

        operations, _ = cost((path or ROOT / "libbn/data/neural.onnx").read_bytes())
        made.append(Method(name, "", make, operations))
    for steps in (16, 64, 128):
        made.append(Method("relax", f"{steps} steps",
                           lambda size, seed, threads, steps=steps: bluenoise.mask(
                               (size, size), method="relax", steps=steps, seed=seed, threads=threads),
                           RELAX_FLOP * steps))
    made.append(Method("void-and-cluster", "", lambda size, seed, threads: bluenoise.mask((size, size), seed=seed),
                       VOID_AND_CLUSTER_FLOP, many_threads=False))
    for sweeps, largest in ((100, 256), (1000, 128)):
        made.append(Method("anneal", f"{sweeps} sweeps",
                           lambda size, seed, threads, sweeps=sweeps: bluenoise.mask(
                               (size, size), method="anneal", sweeps=sweeps, seed=seed),
                           ANNEAL_FLOP * sweeps, sizes=tuple(s for s in SIZES if s <= min(largest, most)),
                           many_threads=False))
    made.append(Method("white", "", lambda size, seed, threads: bluenoise.mask((size, size), method="white", seed=seed),
                       0, many_threads=False))
    return made


def repeats_of(size, quick):
    return 2 if quick else {64: 20, 128: 20, 256: 9, 512: 5, 1024: 3}.get(size, 1)


def errors_of(masks):
    figures = [(bluenoise._core.mask_error(ranks, 1.0), bluenoise._core.mask_error(ranks, 1.5)) for ranks in masks]
    return tuple(statistics.mean(column) for column in zip(*figures))


def measure(chosen, sizes, threads, quick):
    """Rows as dicts. The methods of one size take turns, so that a busy machine slows all of them alike."""
    rows = []
    for size in sizes:
        jobs = [(method, count) for method in chosen if size in method.sizes
                for count in ((1, threads) if method.many_threads and threads > 1 else (1,))]
        repeats = repeats_of(size, quick)
        times = [[] for _ in jobs]
        masks = [[] for _ in jobs]
        # The first is not counted, it meets cold memory; at the largest sizes that makes no difference.
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
                # Errors of large masks take longer than the masks, and hardly differ between seeds.
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
    """Rows of another program's file: columns name, size, seconds, threads, e_1, e_1.5, flop_per_texel."""
    with open(path, newline="", encoding="utf-8") as file:
        return [{"method": row["name"], "options": "", "width": int(row["size"]), "threads": int(row["threads"]),
                 "repeats": "", "seconds": row["seconds"], "cpu_seconds": row["seconds"], "e_1": row["e_1"],
                 "e_1.5": row["e_1.5"], "flop_per_texel": row["flop_per_texel"]}
                for row in csv.DictReader(file) if int(row["size"]) in sizes]


def label(row):
    name = row["method"] + (f", {row['options']}" if row["options"] else "")
    return name + (f", {row['threads']} threads" if int(row["threads"]) > 1 else "")


def microseconds(row):
    """Of the processor, per texel."""
    return 1e6 * float(row["cpu_seconds"]) / int(row["width"]) ** 2


def flop_text(text):
    value = float(text or "nan")
    if not value > 0:
        return ""
    return f"{value:.0f}" if value < 1e4 else f"{value / 1e3:.0f} k" if value < 1e6 else f"{value / 1e6:.1f} M"


def table(rows):
    lines = ["| method | time | processor time | per texel | FLOP per texel | E_1 | E_1.5 |", "| --- |" + " ---: |" * 6]
    for row in sorted(rows, key=lambda row: float(row["cpu_seconds"])):
        times = time_text(float(row["seconds"])), time_text(float(row["cpu_seconds"]))
        lines.append(f"| {label(row)} | {times[0]} | {times[1]} | {1e3 * microseconds(row):.0f} ns | "
                     f"{flop_text(row['flop_per_texel'])} | {float(row['e_1']):.4f} | {float(row['e_1.5']):.4f} |")
    return "\n".join(lines)


def colour_of(row, others):
    return COLOURS.get(row["method"]) or PAPER_COLOURS[others.index(row["method"]) % len(PAPER_COLOURS)]


def plot(rows, sizes, path):
    """Error against time per texel, at the size where other networks were measured and at a large one; time against
    size. One legend for all three."""
    others = [name for name in dict.fromkeys(row["method"] for row in rows) if name not in COLOURS]
    rows = [row for row in rows if row["method"] != "white"]
    marks = {}
    for row in rows:
        marks.setdefault(row["method"], []).append(row["options"])
    figure, axes = plt.subplots(1, 3, figsize=(15, 6.4))
    shown = (128 if 128 in sizes else sizes[0], 1024 if 1024 in sizes else sizes[-1])
    for axis, size in zip(axes, shown):
        for row in rows:
            if int(row["width"]) != size or int(row["threads"]) != 1:
                continue
            for error, style in (("e_1", "full"), ("e_1.5", "none")):
                axis.plot(microseconds(row), float(row[error]), fillstyle=style, linestyle="none",
                          **style_of(row, others, marks))
        axis.set(xscale="log", xlabel="microseconds of the processor per texel", ylabel="E_1 (filled), E_1.5 (open)",
                 ylim=(0, None), title=f"{size}x{size}: error against time, one thread")
        axis.grid(True, which="both", alpha=0.25)
    for name in dict.fromkeys(label(row) for row in rows):
        chosen = [row for row in rows if label(row) == name]
        axes[2].plot([int(row["width"]) for row in chosen], [1e3 * float(row["seconds"]) for row in chosen], label=name,
                     markersize=4, linestyle=":" if int(chosen[0]["threads"]) > 1 else "-",
                     **style_of(chosen[0], others, marks))
    axes[2].set(xscale="log", yscale="log", xlabel="width = height in texels", ylabel="milliseconds by the wall clock",
                title="time against size")
    axes[2].grid(True, which="both", alpha=0.25)
    figure.legend(*axes[2].get_legend_handles_labels(), loc="lower center", ncol=5, fontsize=8)
    figure.tight_layout(rect=(0, 0.16, 1, 1))
    with written_beside(path) as beside:
        figure.savefig(beside, dpi=80)
    plt.close(figure)


def style_of(row, others, marks):
    options = list(dict.fromkeys(marks[row["method"]]))
    return {"color": colour_of(row, others), "marker": "o^sD"[options.index(row["options"]) % 4]}


# ---- Quality of the network that ships ----------------------------------------------------------------------------


def quality_table(generator, seeds):
    """Errors over seeds at shapes of every kind."""
    lines = [f"| shape | E_1, mean of {seeds} | largest | E_1.5, mean | largest |", "| --- |" + " ---: |" * 4]
    for height, width in QUALITY_SHAPES:
        figures = np.array([errors_of([generator.mask((height, width), seed=seed)]) for seed in range(seeds)])
        mean, most = figures.mean(axis=0), figures.max(axis=0)
        lines.append(f"| {height}x{width} | {mean[0]:.4f} | {most[0]:.4f} | {mean[1]:.4f} | {most[1]:.4f} |")
    return "\n".join(lines)


def fixed_pattern(generator, count, size=32):
    """The deviation, over texels, of the mean of the masks of `count` seeds, over what independent masks have."""
    total = np.zeros((size, size))
    for seed in range(count):
        total += bluenoise.to_float(generator.mask((size, size), seed=seed))
    return (total / count).std() / np.sqrt(1 / 12 / count)


def spectrum_picture(masks, size):
    """The mean power spectrum, zero in the middle, grey level 0 to 2 times white noise's."""
    power = np.mean([bluenoise.power_spectrum(ranks) for ranks in masks], axis=0)
    return Image.fromarray(np.uint8(np.clip(np.fft.fftshift(power) * 127.5, 0, 255))).resize((size, size), Image.NEAREST)


def picture(groups, path):
    """A row for each kind of mask: the mask, its spectrum, and its patterns at three grey levels."""
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


def level_table(groups):
    lines = ["| mask | " + " | ".join(f"{a}/{b}" for a, b in LEVELS) + " |", "| --- |" + " ---: |" * len(LEVELS)]
    for name, masks in groups.items():
        lines.append(f"| {name} | " + " | ".join(f"{power:.3f}" for power in low_frequency(masks)) + " |")
    return "\n".join(lines)


def report_text(rows, sizes, models, quality, flatness, anisotropy, masks, levels, command, threads):
    parts = ["# Masks by a network: time against error", "",
             f"Printed by `{command}`. Times are the least of the repeats, by the wall clock and of the",
             "processor (of all threads together; on a busy machine it is the one to compare), on 1 thread unless said",
             f"otherwise ({threads} is every core of that machine); the methods of one size took turns. Time per texel is",
             "the processor's. Errors are means over the seeds of `bn_mask_error`, lower is better. FLOP per texel are",
             "multiplications and additions of the inner loop (of the network, two for each weight of a convolution and",
             "one for every other value made), margins and sorting left out; void-and-cluster's, relaxation's and",
             "annealing's are integer operations.", ""]
    for name, path in models.items():
        content = (path or ROOT / "libbn/data/neural.onnx").read_bytes()
        operations, weights = cost(content)
        radius = metadata(content)["bn.receptive_radius"]
        parts.append(f"* {name}: {weights} weights, {len(content)} bytes, {operations} FLOP per texel, sees {radius} texels "
                     "around.")
    parts += ["", "![Error against time, time against size](neural.png)", ""]
    for size in sizes:
        parts += [f"## {size}x{size}", "", table([row for row in rows if int(row["width"]) == size]), ""]
    decibels = ", ".join(f"{name} {value:.1f}" for name, value in anisotropy.items())
    parts += ["## Every size and seed", "", "The network that ships; 16x16 is the smallest size that is promised anything.",
              "", quality, "",
              f"The mean of the 32x32 masks of {flatness[1]} seeds deviates from flat by {flatness[0]:.3f} times what",
              "independent white noise would (1: no fixed pattern). Anisotropy of the mean spectrum of",
              f"{masks} masks of 128x128, in dB ({-10 * np.log10(masks):.0f} is what perfectly isotropic ones have):",
              f"{decibels}.", "",
              "## Every grey level", "",
              "Power of thresholded masks below half the principal frequency, white noise 1:", "", levels, ""]
    return "\n".join(parts)


def main():
    parser = argparse.ArgumentParser(prog="scripts/bench neural", description=__doc__.splitlines()[0])
    parser.add_argument("--paper", type=Path, metavar="FILE",
                        help="rows of other networks, as `python -m bn_trainer table` writes them (default "
                             "docs/report/paper.csv, where there is one)")
    parser.add_argument("--model", action="append", default=[], metavar="NAME=FILE", help="another network, an ONNX file")
    parser.add_argument("--quick", action="store_true", help="two sizes and few seeds: a try, not a measurement")
    parser.add_argument("--again", action="store_true", help="keep the times of neural.csv, make all else anew")
    parser.add_argument("--out", type=Path, default=Path("docs/report"), help="folder (default docs/report)")
    parser.add_argument("--picture", type=Path, default=None, help="the README's picture (default docs/neural.png)")
    options = parser.parse_args()
    paper = options.paper or (ROOT / "docs/report/paper.csv")
    models = {"network": None, "fast network": FAST}
    for argument in options.model:
        name, _, path = argument.partition("=")
        if not path:
            parser.error(f"--model must be NAME=FILE, not {argument}")
        models[name] = Path(path)
    threads = os.cpu_count() or 1
    sizes = QUICK_SIZES if options.quick else SIZES
    if options.again:
        with open(options.out / "neural.csv", newline="", encoding="utf-8") as file:
            rows = [row for row in csv.DictReader(file) if row["repeats"]]
    else:
        rows = measure(methods(models, 64 if options.quick else max(sizes)), sizes, threads, options.quick)
    if options.paper or paper.is_file():
        rows += paper_rows(paper, sizes)

    out = io.StringIO()
    writer = csv.DictWriter(out, FIELDS, lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    write_text(options.out / "neural.csv", out.getvalue())
    plot(rows, sizes, options.out / "neural.png")
    generator = bluenoise.NeuralGenerator()
    count = 2 if options.quick else 16
    groups = {"network": [generator.mask((128, 128), seed=seed) for seed in range(count)],
              "void-and-cluster": [bluenoise.mask((128, 128), seed=seed) for seed in range(count)],
              "white noise": [bluenoise.mask((128, 128), method="white", seed=seed) for seed in range(count)]}
    picture(groups, options.picture or options.out.parent / "neural.png")
    quality = quality_table(generator, 2 if options.quick else 20)
    seeds = 50 if options.quick else 1000
    flatness = fixed_pattern(generator, seeds), seeds
    anisotropy = {name: bluenoise.anisotropy(masks) for name, masks in groups.items()}
    command = "scripts/bench neural" + "".join(f' --model "{name}=FILE"' for name in models if models[name] not in (None, FAST))
    text = report_text(rows, sizes, models, quality, flatness, anisotropy, count, level_table(groups), command,
                       threads)
    write_text(options.out / "neural.md", text)
    print(text)


if __name__ == "__main__":
    main()
