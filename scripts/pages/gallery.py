# SPDX-License-Identifier: Apache-2.0
"""Runs the listings of docs/gallery.md, which make its pictures in docs/gallery, and prints its figures: .venv/bin/python
scripts/pages/gallery.py. Writes the table into the page."""

import os
import re
import sys
import time
from pathlib import Path

import numpy as np
from PIL import Image
from scipy.ndimage import gaussian_filter

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "gallery.md"
sys.path.insert(0, str(ROOT))
import bluenoise
from evidence.base.tables import md_table, update_table

NAMES = {"threshold": "threshold at one half", "bayer": "Bayer matrix, 8x8", "white": "white noise",
         "diffusion": "Floyd-Steinberg (Pillow)", "mask": "libbn's mask"}


def listings():
    return re.findall(r"^```python\n(.*?)^```", PAGE.read_text(encoding="utf-8"), re.M | re.S)


def run_listings():
    """Runs the listings in the current folder and returns their variables."""
    space = {}
    for listing in listings():
        exec(listing, space)
    return space


def rmse(error, sigma):
    return float(np.sqrt((gaussian_filter(error, sigma, mode="wrap") ** 2).mean()))


def milliseconds(call, calls=20):
    """CPU time per call: the shortest of several averages."""
    times = []
    for _ in range(9):
        begun = time.process_time()
        for _ in range(calls):
            call()
        times.append((time.process_time() - begun) / calls * 1000)
    return min(times)


def spread(space):
    """The number of pixels that change with error diffusion when the first one becomes 8 levels brighter."""
    bright = np.array(space["photo"].convert("L"))
    bright[0, 0] += 8
    return int((np.asarray(Image.fromarray(bright).convert("1")) != space["ways"]["diffusion"]()).sum())


def changed(frames, columns):
    """The share of the dots on the moving picture that differ between a frame and the next one."""
    parts = [np.asarray(frame)[:, columns] for frame in frames]
    return np.mean([(a[:, 2:] != b[:, :-2]).mean() for a, b in zip(parts, parts[1:])])


def patch_means(palette):
    """The largest difference in levels between a colour and the mean of its dithered 64 x 64 patch, for the mask and for error diffusion.
    The palette can mix all of the colours."""
    colours = np.random.default_rng(1).integers(0, 256, (100, 3))
    indexed, differences = Image.new("P", (1, 1)), []
    indexed.putpalette(np.array(palette, np.uint8).tobytes())
    for colour in colours:
        patch = Image.new("RGB", (64, 64), tuple(map(int, colour)))
        ways = bluenoise.dither(patch, palette=palette), patch.quantize(palette=indexed)
        differences.append([abs(np.asarray(way.convert("RGB")).mean((0, 1)) - colour).max() for way in ways])
    return np.max(differences, axis=0)


def low_power(points):
    """The mean power of points in the unit square at 0.1 to 0.4 inverse lattice spacings; random points have 1."""
    weights = (np.sin(np.pi * points) ** 2).prod(1)  # hides the edges
    frequencies = np.stack(np.meshgrid(np.arange(-40, 41), np.arange(41)), -1).reshape(-1, 2)
    size = np.hypot(*frequencies.T)
    frequencies = frequencies[(size > 4) & (size > 0.1 * len(points) ** 0.5) & (size < 0.4 * len(points) ** 0.5)]
    return (np.abs(np.exp(-2j * np.pi * (frequencies @ points.T)) @ weights) ** 2).mean() / (weights**2).sum()


def patch_powers(method):
    """low_power() of four patches whose densities are 1, 2, 4 and 8."""
    points = bluenoise.points(12000, density=np.kron([[1, 2], [4, 8]], np.ones((64, 64))), method=method, seed=1)
    patches = [points * 2 - (x, y) for y in range(2) for x in range(2)]
    return [low_power(patch[((patch >= 0) & (patch < 1)).all(1)]) for patch in patches]


def main():
    os.chdir(PAGE.parent / "gallery")
    space = run_listings()
    grey, rows = space["grey"], []
    for name, dither in space["ways"].items():
        error = dither() - grey
        rows.append([f"![{NAMES[name]}](gallery/{name}.png)<br>{NAMES[name]}", f"{milliseconds(dither):.2f} ms",
                     *(f"{rmse(error, sigma):.4f}" for sigma in (1, 2.1))])
    update_table(PAGE, "scripts/pages/gallery.py", md_table(["method", "time", "error, sigma 1", "error, sigma 2.1"], rows))
    print(PAGE.read_text(encoding="utf-8").split("<!-- table")[1].split("<!-- end")[0])
    print(f"error diffusion: {spread(space)} pixels change")
    x, y = space["x"], space["y"]
    edge = 1.4 * (x + 0.4 * y) / 380
    a = np.linspace(0.0005, 0.9995, 1000)
    exact = np.clip((edge[..., None] - 0.4 * a[::10]), 0, 1).mean(-1)
    for name in ("white", "blue"):
        print(f"shadow, {name}: {rmse(space['shadow'](name) - exact, 2.1):.4f} after a blur")
    print(f"dots that change in the pan: error diffusion {changed(space['frames'], slice(0, 180)):.1%}, "
          f"mask {changed(space['frames'], slice(188, 368)):.1%}")
    for name, picture in (("mask", space["paper"]), ("error diffusion", Image.open("paper_diffusion.png"))):
        error = np.asarray(picture.convert("RGB")) / 255 - np.asarray(space["photo"]) / 255
        print(f"seven colours, {name}: " + ", ".join(f"{np.sqrt((gaussian_filter(error, (s, s, 0)) ** 2).mean()):.4f}" for s in (1, 2.1)))
    cube = [(r, g, b) for r in (0, 255) for g in (0, 255) for b in (0, 255)]
    print("flat patches: the mean is off by up to {:.2f} levels with the mask, {:.2f} with error diffusion".format(*patch_means(cube)))
    for method in ("poisson-disk", "mask"):
        uniform = low_power(bluenoise.points(2000, method=method, seed=1))
        patches = ", ".join(f"{power:.2f}" for power in patch_powers(method))
        spent = milliseconds(lambda: bluenoise.points(9000, density=(1 - grey) ** 1.5, method=method, seed=1), 1)
        print(f"stippling, {method}: {spent:.0f} ms")
        print(f"low-frequency power of patches, {method}: {patches}; uniform {uniform:.2f}")


if __name__ == "__main__":
    main()
