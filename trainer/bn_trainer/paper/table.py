# SPDX-License-Identifier: Apache-2.0
"""Reproduces the paper's Table I: `python -m bn_trainer table` updates the tables of evidence/results/paper.md, and paper.png.

Images of 256x256 pixels are dithered to 1 bit with tiled masks from each method. The error is the root mean square of the
difference between the dithered and the original image after a Gaussian blur with mirrored edges. Tables show its mean and
standard deviation over masks. A pixel becomes white if image + threshold >= 1. The threshold is (rank + 1/2) / n, or
(output + 1) / 2 for the raw output of a network or of Wronski's method. The command also
measures why the paper's masks are worse: their histograms, thresholded patterns and similarity.
"""

from __future__ import annotations

import dataclasses
import re
import sys
import time
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import torch
from PIL import Image, ImageDraw, ImageFont

import bluenoise

from .. import losses
from ..config import TrainerError
from ..files import write_atomically
from ..train import default_folder
from . import perceptron, wronski
from .pictures import blurred_errors, dithering_errors, floyd_steinberg, read_picture, synthetic_pictures

SIGMAS = (0.75, 1.0, 1.5)  # of the blurs, in texels; the error columns use TABLE_SIGMA
TABLE_SIGMA = 1.0
CALIBRATING = 8  # masks per method used to find the blur at which void-and-cluster has the paper's ratio
LEVELS = (1 / 16, 1 / 4, 1 / 2)
MEASURED = 16  # masks per method for E and spectra
# RMSE in Table I of the paper (which specifies neither image nor blur), and seconds at 64x64 and 128x128
PUBLISHED_RMSE = {"white": 0.069, "perceptron": 0.046, "wronski": 0.046, "void-and-cluster": 0.029}
PUBLISHED_SECONDS = {"perceptron": {64: 0.0167, 128: 0.0189}, "wronski": {64: 280, 128: 1590},
                     "void-and-cluster": {64: 0.64, 128: 2.97}}


@dataclasses.dataclass
class Method:
    name: str
    size: int
    kind: str  # key into the published figures
    values: np.ndarray  # thresholds in [0, 1], float32 (masks, size, size)
    seconds: float  # per mask, one thread
    flop_per_texel: float = float("nan")
    raw: bool = False  # thresholds are raw outputs, not ranks
    note: str = ""


def ranks_of(values: np.ndarray) -> np.ndarray:
    """Ranks within each mask of (masks, height, width), with ties ordered by position, as thresholds (rank + 1/2) / n."""
    return losses.ranks(torch.from_numpy(values.astype(np.float32))[None])[0].numpy()


def timed(make: Callable[[int], np.ndarray], seeds: Iterable[int]) -> tuple[np.ndarray, float]:
    """One mask per seed, and the median time per mask in seconds."""
    masks, seconds = [], []
    for seed in seeds:
        start = time.perf_counter()
        masks.append(make(seed))
        seconds.append(time.perf_counter() - start)
    return np.stack(masks), float(np.median(seconds))


def library_methods(size: int, count: int) -> list[Method]:
    """White noise, void-and-cluster, and this library's network."""
    try:
        generator = bluenoise.NeuralGenerator(threads=1)
    except (AttributeError, ValueError, OSError, RuntimeError) as error:
        raise TrainerError(f"this library's network: {error}") from None
    shape, methods = (size, size), []
    for name, kind, make, note in (
            ("white noise", "white", lambda seed: np.random.default_rng(seed).permutation(shape[0] * shape[1]).reshape(shape), ""),
            ("void-and-cluster", "void-and-cluster", lambda seed: bluenoise.mask(shape, seed=seed), ""),
            ("this library's network", "ours", lambda seed: generator.mask(shape, seed), "the built-in network")):
        masks, seconds = timed(make, range(count))
        methods.append(Method(name, size, kind, ranks_of(masks), seconds, note=note))
    return methods


def perceptron_methods(folder: Path, size: int, count: int) -> list[Method]:
    """Raw outputs and exact ranks of a trained perceptron; empty if the folder contains no checkpoint."""
    checkpoint = folder / "checkpoint.pt"
    if not checkpoint.exists():
        say(f"skipping {folder.name}: {checkpoint} does not exist (run train-paper)")
        return []
    run = perceptron.PaperTraining.load(checkpoint)
    if run.config.size != size:
        raise TrainerError(f"{checkpoint} has size {run.config.size}, not {size}")
    masks, seconds = timed(lambda seed: perceptron.generate(run.model, [seed], size)[0], range(count))
    name = "perceptron" + (", summed histogram" if run.config.histogram == "sum" else "")
    flop = sum(2 * layer.weight.numel() for layer in run.model.layers) / size**2
    note = f"{run.iteration} of {run.config.iterations} iterations in {run.seconds / 60:.0f} min"
    raw = (masks + 1) / 2
    return [Method(name, size, "perceptron", raw, seconds, flop, True, note),
            Method(name + ", ranks made exact", size, "perceptron exact", ranks_of(raw), seconds, flop, False, note)]


def wronski_method(size: int, count: int, iterations: int) -> Method:
    start = time.perf_counter()
    masks = wronski.optimise(size, range(count), iterations)
    seconds = (time.perf_counter() - start) / count
    return Method("Wronski", size, "wronski", (masks + 1) / 2, seconds, wronski.flop_per_texel(size, iterations), True,
                  f"{iterations} iterations")


def calibrated_sigma(white: Method, void_and_cluster: Method, pictures: list[np.ndarray]) -> float:
    """The blur at which void-and-cluster's error relative to white noise equals the paper's ratio."""
    target = PUBLISHED_RMSE["void-and-cluster"] / PUBLISHED_RMSE["white"]

    def ratio(sigma: float) -> float:
        sums = [sum(dithering_errors(method.values[:CALIBRATING], picture, [sigma]).mean() for picture in pictures)
                for method in (white, void_and_cluster)]
        return sums[1] / sums[0]

    low, high = 0.3, 3.0  # the ratio decreases from 1 with sigma
    for _ in range(10):
        middle = (low + high) / 2
        low, high = (middle, high) if ratio(middle) > target else (low, middle)
    return round((low + high) / 2, 2)


def threshold_error(values: np.ndarray, sigma: float) -> float:
    """E_sigma of raw thresholds, values (height, width) in [0, 1]; bn_mask_error takes ranks."""
    height, width = values.shape
    square = torch.fft.fftfreq(height)[:, None].square() + torch.fft.rfftfreq(width).square()
    transfer = torch.exp(-2 * np.pi**2 * sigma**2 * square)
    levels = ((torch.arange(64) + 0.5) / 64)[:, None, None]
    difference = (torch.from_numpy(values) < levels).float() - levels
    return torch.fft.irfft2(torch.fft.rfft2(difference) * transfer, s=(height, width)).square().mean().sqrt().item()


def mask_figures(method: Method) -> dict[Any, float]:
    """E_1, E_1.5, the standard deviation of values, and the power below half the principal frequency for each level, averaged
    over up to MEASURED of a method's masks; and the similarity of all its masks."""
    values = method.values[:MEASURED]
    measured = [bluenoise.measure(mask) for mask in values]
    if method.raw:
        e_1, e_15 = (np.mean([threshold_error(mask, sigma) for mask in values]) for sigma in (1, 1.5))
    else:
        e_1, e_15 = (np.mean([figures.dithering_error[sigma] for figures in measured]) for sigma in (1, 1.5))
    quarter = np.hypot(*np.meshgrid(np.fft.fftfreq(method.size), np.fft.fftfreq(method.size))) < 0.25
    quarter[0, 0] = False
    return {"e_1": e_1, "e_1.5": e_15, "deviation": values.std(axis=(1, 2)).mean(),
            "grey": np.mean([bluenoise.power_spectrum(mask)[quarter].mean() for mask in values]),
            **{level: np.mean([figures.low_frequency[level] for figures in measured]) for level in LEVELS},
            "alike": likeness(method.values)}


def likeness(values: np.ndarray) -> float:
    """The mean absolute correlation between two masks of a method: 1 for identical or inverted masks, about 0.8 / sqrt(n) for
    independent masks of n texels, and NaN for a single mask."""
    flat = values.reshape(len(values), -1).astype(np.float64)
    flat -= flat.mean(axis=1, keepdims=True)
    flat /= np.linalg.norm(flat, axis=1, keepdims=True)
    pairs = np.triu_indices(len(flat), 1)
    return float(np.abs((flat @ flat.T)[pairs]).mean()) if len(flat) > 1 else float("nan")


def say(line: str) -> None:
    print(f"table: {line}", file=sys.stderr, flush=True)


def number(value: float, digits: int = 4) -> str:
    return "" if np.isnan(value) else f"{value:.{digits}f}"


def time_text(seconds: float) -> str:
    return f"{1e3 * seconds:.3g} ms" if seconds < 1 else f"{seconds:.3g} s" if seconds < 100 else f"{seconds:.0f} s"


def markdown(header: list[str], rows: list[list[str]]) -> str:
    lines = ["| " + " | ".join(header) + " |", "| --- |" + " ---: |" * (len(header) - 1)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows])


def error_table(methods: list[Method], pictures: list[str], errors: list[dict[str, np.ndarray]],
                diffused: dict[str, np.ndarray], sigmas: list[float]) -> str:
    """errors: method index -> picture -> (sigmas, masks); diffused: picture -> (sigmas, 1). The last sigma is the calibrated
    one."""
    at = sigmas.index(TABLE_SIGMA)
    white = {m.size: np.mean([errors[i][p].mean(1) for p in pictures], axis=0)
             for i, m in enumerate(methods) if m.kind == "white"}
    header = ["mask", "masks", *pictures, "mean", *(f"ratio, sigma {sigma:g}" for sigma in sigmas), "published ratio"]
    named = [(f"{m.size}x{m.size} {m.name}", m.kind, m.size, errors[i]) for i, m in enumerate(methods)]
    rows = []
    for name, kind, size, by_picture in [*named, ("error diffusion", "", methods[0].size, diffused)]:
        count = next(iter(by_picture.values())).shape[1]
        means = np.mean([by_picture[p].mean(1) for p in pictures], axis=0)
        published = PUBLISHED_RMSE.get(kind)
        rows.append([name, str(count),
                     *(number(by_picture[p][at].mean()) + (f" ± {by_picture[p][at].std():.4f}" if count > 1 else "")
                       for p in pictures),
                     number(means[at]), *(number(ratio, 2) for ratio in means / white[size]),
                     number(published / PUBLISHED_RMSE["white"], 2) if published else ""])
    return markdown(header, rows)


def figure_table(methods: list[Method], figures: list[dict[Any, float]]) -> str:
    header = ["mask", "time per mask", "published", "FLOP per texel", "E_1", "E_1.5", "deviation",
              "grey < 1/4", *(f"at 1/{round(1 / level)}" for level in LEVELS), "similarity"]
    rows = []
    for method, values in zip(methods, figures):
        published = PUBLISHED_SECONDS.get(method.kind, {}).get(method.size)
        rows.append([f"{method.size}x{method.size} {method.name}", time_text(method.seconds),
                     time_text(published) if published else "", number(method.flop_per_texel, 0), number(values["e_1"]),
                     number(values["e_1.5"]), number(values["deviation"], 3), number(values["grey"], 3),
                     *(number(values[level], 2) for level in LEVELS), number(values["alike"], 3)])
    return markdown(header, rows)


def descent_table(size: int, iterations: Sequence[int], count: int = 2) -> str:
    """A table of the loss and E_1 during Wronski's descent."""
    rows = []
    for steps in iterations:
        history: list[float] = []
        masks = wronski.optimise(size, range(count), steps, progress=history.append)
        rows.append([f"{steps:,}", f"{history[-1]:.3g}", number(np.mean([bluenoise.dithering_error(mask) for mask in masks]))])
    return markdown([f"iterations at {size}x{size}", "loss", "E_1"], rows)


def with_tables(page: str, tables: dict[str, str]) -> str:
    """The page with the tables inserted between its markers."""
    for name, table in tables.items():
        page = re.sub(rf"(<!-- table: {name} -->\n\n).*?(\n\n<!-- end of the table -->)", lambda marks: marks[1] + table + marks[2],
                      page, flags=re.DOTALL)
    return page


def contact_sheet(methods: list[Method], size: int) -> Image.Image:
    """Rows: the methods of a size. Columns: mask, mean spectrum, patterns at LEVELS, part of the dithered scene.

    At most 64x64 texels of masks and patterns are shown, enlarged by a factor of two."""
    chosen = [method for method in methods if method.size == size and method.kind != "perceptron exact"]
    part, scale, gap, left, top = min(size, 64), 2, 8, 236, 26
    cell = part * scale
    columns = ("mask", "spectrum", *(f"at 1/{round(1 / level)}" for level in LEVELS), "scene")
    scene = synthetic_pictures()["scene"][72 : 72 + cell, 20 : 20 + cell]
    sheet = Image.new("L", (left + len(columns) * (cell + gap), top + len(chosen) * (cell + gap)), 255)
    draw, font = ImageDraw.Draw(sheet), ImageFont.load_default(15)
    for column, title in enumerate(columns):
        draw.text((left + column * (cell + gap), 4), title, 0, font)
    for row, method in enumerate(chosen):
        y = top + row * (cell + gap)
        draw.multiline_text((4, y + cell // 2 - 16), method.name.replace(", ", ",\n"), 0, font)
        power = np.mean([bluenoise.power_spectrum(mask) for mask in method.values[:MEASURED]], axis=0)
        mask, ranks = method.values[0], ranks_of(method.values[:1])[0]
        repeats = cell // size + 1
        dithered = scene + np.tile(mask, (repeats, repeats))[:cell, :cell] >= 1
        cells = [mask[:part, :part], Image.fromarray(np.uint8(255 * np.clip(np.fft.fftshift(power) / 2, 0, 1))),
                 *(1.0 * (ranks[:part, :part] >= level) for level in LEVELS), 1.0 * dithered]
        for column, picture in enumerate(cells):
            if not isinstance(picture, Image.Image):
                picture = Image.fromarray(np.uint8(np.clip(255 * picture + 0.5, 0, 255)))
            kept = picture.resize((cell, cell), Image.Resampling.BOX if picture.width > cell else Image.Resampling.NEAREST)
            sheet.paste(kept, (left + column * (cell + gap), y))
    return sheet


def run(runs: Path | None, sizes: list[int], masks: int, wronski_masks: int, wronski_iterations: int, picture: list[str],
        out: Path) -> None:
    torch.set_num_threads(1)
    runs = runs or default_folder(Path("paper-64.toml")).parent
    pictures = {**synthetic_pictures(), **dict(read_picture(argument) for argument in picture)}
    methods = []
    for size in sizes:
        say(f"masks of {size}x{size}")
        library = library_methods(size, masks)
        paper_ones = [method for suffix in ("", "-sum")
                      for method in perceptron_methods(runs / f"paper-{size}{suffix}", size, masks)]
        descended = wronski_method(size, wronski_masks, wronski_iterations)
        methods += [library[0], *paper_ones, descended, *library[1:]]
    first = {method.kind: method for method in reversed(methods)}
    sigmas = [*SIGMAS, calibrated_sigma(first["white"], first["void-and-cluster"], list(pictures.values()))]
    errors = []
    for method in methods:
        say(f"dithering with {method.size}x{method.size} {method.name}")
        errors.append({name: dithering_errors(method.values, picture, sigmas) for name, picture in pictures.items()})
    diffused = {name: blurred_errors(floyd_steinberg(picture)[None], picture, sigmas)
                for name, picture in pictures.items()}
    say("measuring masks")
    figures = [mask_figures(method) for method in methods]
    n = wronski_iterations
    descent = descent_table(min(sizes), [max(1, n // 10), max(1, n // 3), n, 3 * n])
    tables = {"errors": error_table(methods, list(pictures), errors, diffused, sigmas), "masks": figure_table(methods, figures),
              "descent": descent}
    notes = dict.fromkeys(f"{m.size}x{m.size} {m.name}: {m.note}" for m in methods if m.note and "exact" not in m.name)
    print("\n\n".join([*tables.values(), "; ".join(notes)]))
    sheet = contact_sheet(methods, max(sizes)).quantize(64, dither=Image.Dither.NONE)  # a smaller file
    page = out / "paper.md"
    if page.exists():
        text = with_tables(page.read_text(encoding="utf-8"), tables)
        write_atomically(page, lambda path: path.write_text(text, encoding="utf-8"))
    write_atomically(out / "paper.png", lambda path: sheet.save(path, format="PNG"))
