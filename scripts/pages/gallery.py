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
    for method in ("poisson-disk", "mask"):
        spent = milliseconds(lambda: bluenoise.points(9000, density=(1 - grey) ** 1.5, method=method, seed=1), 1)
        print(f"stippling, {method}: {spent:.0f} ms")


if __name__ == "__main__":
    main()
