# SPDX-License-Identifier: Apache-2.0
"""Ways to follow a moving image: `scripts/bench follow` averages frames of simple motions, and writes three tables in docs/realtime.md"""

import numpy as np
from scipy import ndimage

import bluenoise

from ..base.command import Parser
from ..base.tables import md_table, write_or_print
from ..measure.image_error import blurred
from .realtime import half_plane

GUIDE, COMMAND = "docs/realtime.md", "scripts/bench follow"
SIDE, EDGE, FRAMES, WEIGHT, TILE, RADIUS = 256, 40, 40, 0.1, 64, 70
SIGMA = 1.0
Y, X = np.mgrid[:SIDE, :SIDE]
ACROSS, DOWN = (2 * grid / (SIDE - 1) - 1 for grid in (X, Y))  # -1 to 1
PERIODS, LOBES = (64, 32, 16), (0.5, 0.3)
SETTLED = range(160, 192)  # frames at which settled averages are measured


# ---- Motions: for frame t, the motion in x and y of each pixel, and the layer that it shows

def even(x, y):
    return np.full(X.shape, float(x)), np.full(X.shape, float(y))


def two_layers(t):
    """A disc moves in front of a background, and is in the centre of the last frame."""
    disc = (3.0, 1.0)
    inside = np.hypot(X - SIDE / 2 - disc[0] * (t - FRAMES + 1), Y - SIDE / 2 - disc[1] * (t - FRAMES + 1)) < RADIUS
    return np.where(inside, disc[0], -2.0), np.where(inside, disc[1], 0.0), inside


MOTIONS = {
    "rest": lambda t: (*even(0, 0), X < 0),
    "pan by 2.5 pixels": lambda t: (*even(2.2, 1.2), X < 0),
    "parallax, 1 to 4 pixels": lambda t: (2.5 + 1.5 * DOWN, 0 * DOWN, X < 0),
    "zoom, 0 to 1 pixel": lambda t: (ACROSS, DOWN, X < 0),
    "zoom, 0 to 4 pixels": lambda t: (4 * ACROSS, 4 * DOWN, X < 0),
    "roll, 0 to 4 pixels": lambda t: (-4 * DOWN, 4 * ACROSS, X < 0),
    "a disc that moves by 3 pixels, in front of a background that moves by 2": two_layers,
}


def in_tiles(values):
    """The median of each tile."""
    count = SIDE // TILE
    medians = np.median(values.reshape(count, TILE, count, TILE).transpose(0, 2, 1, 3).reshape(count, count, -1), -1)
    return medians.repeat(TILE, 0).repeat(TILE, 1)


# {way: for the pixels `own` of a layer, the motion that its draws follow}
WAYS = {
    "fixed": lambda x, y, own: even(0, 0),
    "one `bn_pan`": lambda x, y, own: even(np.median(x), np.median(y)),
    "one for each tile": lambda x, y, own: (in_tiles(x), in_tiles(y)),
    "one for each layer": lambda x, y, own: even(x[own][0], y[own][0]),
}


# ---- The measure

def deviations(sampler, x, y, index, integrands):
    """[integrands][height][width]"""
    u = bluenoise.PathSampler(sampler, x, y, index).ray(0).draw_direction()
    return np.stack([values(u) - np.float32(mean) for values, mean in integrands])


def error(kind, motion, way, integrands):
    """RMSE of the averaged frames after a blur. With two layers, of the disc."""
    sampler, pans, average, before = bluenoise.Sampler(kind, seed=1), [bluenoise.Pan(X.shape) for _ in range(2)], None, None
    for t in range(FRAMES):
        x, y, layer = MOTIONS[motion](t)
        if t:
            for pan, own in zip(pans, (~layer, layer)):
                pan.follow(*WAYS[way](x, y, own))
        back, front = pans
        found = deviations(sampler, X - np.where(layer, front.x, back.x), Y - np.where(layer, front.y, back.y), t, integrands)
        if t:
            places = np.stack([Y - y, X - x])
            history = np.stack([ndimage.map_coordinates(own, places, order=1, mode="nearest") for own in average])
            known = before[tuple(np.clip(np.rint(places), 0, SIDE - 1).astype(int))] == layer
            found = np.where(known, history + WEIGHT * (found - history), found)
        average, before = found, layer
    measured = np.zeros(X.shape, bool)
    measured[EDGE:-EDGE, EDGE:-EDGE] = True
    if before.any():
        measured &= np.hypot(X - SIDE / 2, Y - SIDE / 2) < RADIUS - 4 * SIGMA
    return float(np.sqrt(np.mean(blurred(np.moveaxis(average, 0, -1), SIGMA)[measured] ** 2)))


def motion_table(integrands):
    base = error("sobol", "rest", "fixed", integrands)
    return md_table(["error over padded Sobol' at rest", *WAYS], [
        [motion, *("" if way == "one for each layer" and of is not two_layers else f"{error('blue', motion, way, integrands) / base:.2f}" for way in WAYS)]
        for motion, of in MOTIONS.items()])


def settled(new_of, weight):
    """RMSE of a settled average of the deviations new_of(t), and of its change from frame to frame, after a blur."""
    average, found = None, []
    for t in range(SETTLED.stop):
        new = new_of(t)
        last, average = average, new if average is None else average + max(weight, 1 / (t + 1)) * (new - average)
        if t in SETTLED:
            found.append([np.mean(blurred(np.moveaxis(own, 0, -1), SIGMA) ** 2) for own in (average, average - last)])
    return np.sqrt(np.mean(found, 0))


def settled_blue(weight, integrands, period=0, lobe=None):
    """settled() of `blue` with frame numbers that repeat after `period` frames, or of a lobe that is chosen with a probability: lobe =
    (probability, whether it is chosen from the direction's first number, which is then rescaled, or from a separate number)."""
    sampler, (y, x) = bluenoise.Sampler("blue", seed=1), np.mgrid[:SIDE // 2, :SIDE // 2]

    def new_of(t):
        ray = bluenoise.PathSampler(sampler, x, y, t % period if period else t).ray(0)
        u, share, chosen = ray.draw_direction(), 1, True
        if lobe and lobe[1]:
            share = lobe[0]
            chosen, u[..., 0] = bluenoise.choose(share, u[..., 0])
        elif lobe:
            share = lobe[0]
            chosen = ray.next_1d() < share
        return np.stack([np.where(chosen, values(u) / share, 0) - np.float32(mean) for values, mean in integrands])

    return settled(new_of, weight)


NAMED_WEIGHTS = (("1/32", 1 / 32), ("0.1", 0.1))


def period_table(integrands):
    rows = []
    for name, weight in NAMED_WEIGHTS:
        base = settled_blue(weight, integrands)
        found = [settled_blue(weight, integrands, period) / base for period in PERIODS]
        rows += [[f"{what}, weight {name}", *(f"{own[i]:.2f}" for own in found)] for i, what in enumerate(("error", "flicker"))]
    return md_table(["relative to frame numbers that never repeat", *(f"repeats after {period}" for period in PERIODS)], rows)


def lobe_table(integrands):
    def ratio(probability, weight):
        rescaled, separate = (settled_blue(weight, integrands, lobe=(probability, own))[0] for own in (True, False))
        return f"{rescaled / separate:.2f}"

    return md_table(["error over a separate number for the lobe", *(f"probability {probability}" for probability in LOBES)], [
        [f"rescaled remainder, weight {name}", *(ratio(probability, weight) for probability in LOBES)] for name, weight in NAMED_WEIGHTS])


def run(arguments):
    parser = Parser("follow", __doc__)
    parser.number("--integrands", 10, "number of half-planes")
    parser.table(GUIDE)
    options = parser.parse_args(arguments)
    integrands = [half_plane(np.random.default_rng([7, i])) for i in range(options.integrands)]
    for command, table in ((COMMAND, motion_table), (f"{COMMAND}: periods", period_table), (f"{COMMAND}: lobes", lobe_table)):
        write_or_print(options, command, table(integrands))
