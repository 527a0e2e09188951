# SPDX-License-Identifier: Apache-2.0
"""One sample per frame: `scripts/bench realtime` measures the noise that remains after averaging frames

It draws with the Python package and renders nothing: in every pixel the integrand is the same half-plane, and frames are
averaged as a real-time renderer does. The table goes to docs/porting.md.
"""

import argparse

import numpy as np

import bluenoise

from ..base.command import positive
from ..base.tables import add_options, md_table, write_or_print
from ..measure.image_error import rmse
from .paths import half_planes, inside

COMMAND = "scripts/bench realtime"
SIZE, FRAMES, SETTLED = 128, 80, 64  # pixels; frames drawn; frames after which the moving average has settled
WEIGHT = 0.1  # of the newest frame in the moving average
SIGMA = 2.1
# name -> (kind, frames that share a key; None: all of them)
WAYS = {
    "`white`": ("white", None),
    "`sobol`, the index goes on": ("sobol", None),
    "`blue`, the index goes on": ("blue", None),
    "`blue`, a new key every 8 frames": ("blue", 8),
    "`blue`, a new key every frame": ("blue", 1),
}
COLUMNS = ("one frame", "mean of 16", "moving average", "moving average, unblurred")


def place(frame, run):
    """The key and the index of a frame, where `run` frames share a key."""
    return (0, frame) if run is None else divmod(frame, run)


def draw_frames(kind, run, seed, size=SIZE, count=FRAMES):
    """The first pair of one decision, float32 (count, size, size, 2)."""
    sampler = bluenoise.Sampler(kind, seed=seed)
    frames = []
    for frame in range(count):
        key, index = place(frame, run)
        frames.append(sampler.block(0, 0, size, size, index, 1, bluenoise.domain(key, 0))[:, :, 0, :2])
    return np.stack(frames)


def mean_inside(plane, side=1024):
    """The area of the unit square inside a half-plane."""
    grid = (np.arange(side) + 0.5) / side
    return np.mean(grid[:, None] * plane[0] + grid * plane[1] < plane[2])


def errors(frames, plane):
    """{column: squared error} of the frames for one half-plane."""
    deviation = inside(plane, frames) - np.float32(mean_inside(plane))
    average, settled = deviation[0], []
    for t, frame in enumerate(deviation[1:], 1):
        average = (1 - WEIGHT) * average + WEIGHT * frame
        # Several ages: a key that changes every 8 frames is at a different stage in each.
        if t >= SETTLED and t % 3 == 0:
            settled.append(average)

    def squared(pictures, sigma=SIGMA):
        return np.mean([rmse(picture, np.zeros_like(picture), sigma, "toroidal") ** 2 for picture in pictures])

    return dict(zip(COLUMNS, (squared(deviation[SETTLED:SETTLED + 8]), squared([deviation[:16].mean(0)]), squared(settled),
                              squared(settled, 0.0))))


def measure(seeds, integrands, size=SIZE):
    """{way: {column: error}}, root mean squares over seeds and half-planes."""
    planes = half_planes(np.random.default_rng(7), integrands)
    result = {}
    for name, (kind, run) in WAYS.items():
        found = [errors(frames, plane) for seed in range(seeds)
                 for frames in [draw_frames(kind, run, seed, size)] for plane in planes]
        result[name] = {column: float(np.sqrt(np.mean([row[column] for row in found]))) for column in COLUMNS}
    return result


def table(result):
    """Every error divided by that of white noise in the same column: lower is better."""
    white = result["`white`"]
    return md_table(["draws", *COLUMNS],
                    [[name, *(f"{row[column] / white[column]:.2f}" for column in COLUMNS)] for name, row in result.items()])


def run(arguments):
    parser = argparse.ArgumentParser(prog=COMMAND, description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=positive, default=2, metavar="N", help="seeds of each sampler (default 2)")
    parser.add_argument("--integrands", type=positive, default=8, metavar="N", help="half-planes (default 8)")
    add_options(parser, "docs/porting.md")
    options = parser.parse_args(arguments)
    write_or_print(options, COMMAND, table(measure(options.seeds, options.integrands)))
