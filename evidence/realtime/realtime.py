# SPDX-License-Identifier: Apache-2.0
"""One sample per frame: `scripts/bench realtime` measures the noise of single frames and of averages

Published space-time masks are read from files if you pass them; otherwise, figures from an earlier run are kept.
"""

import functools
import re
from pathlib import Path

import numpy as np
from PIL import Image
from scipy import fft, ndimage

import bluenoise

from ..base.command import CommandError, Parser, command_shown, named
from ..base.files import read_numbers, write_rows
from ..base.page import write_page
from ..base.plots import plt, save, style
from ..base.tables import md_table
from ..measure.image_error import blurred
from ..renders.views import golden_powers
from ..samplers import heitz, plugins
from . import motion


class Draws:
    """A libbn sampler. The sample index is the frame number; with new_stream, each frame uses its own stream and index 0."""

    def __init__(self, kind, new_stream=False):
        self.kind, self.new_stream = kind, new_stream

    def frame(self, frame, dimensions, seed, size):
        y, x = np.mgrid[:size, :size]
        ray = bluenoise.PathSampler(bluenoise.Sampler(self.kind, seed=seed), x, y, *((0, frame) if self.new_stream else (frame, 0))).ray(0)
        return ray.next_1d()[..., None] if dimensions == 1 else ray.draw()[..., :dimensions]


class Slices:
    """Slices [depth][height][width][channels] in [0, 1), used as their authors recommend: tiled over the screen, with slice
    frame % depth. Numbers beyond a slice's channels come from the same slice at another offset."""

    def __init__(self, *stacks):
        self.stacks = {stack.shape[-1]: stack for stack in stacks}

    def stack_for(self, dimensions):
        """The stack with `dimensions` channels if there is one; otherwise, the best substitute."""
        return self.stacks[min(self.stacks, key=lambda channels: (channels > dimensions, -channels))]

    def pairs(self, frames):
        """A tile's pairs of numbers [depth][height][width][2]. Slices repeat after `depth` frames."""
        stack = self.stack_for(2)
        if stack.shape[-1] < 2:
            raise CommandError("a moving camera needs slices with pairs of numbers, not only with single ones")
        return stack

    def frame(self, frame, dimensions, seed, size):
        stack, random = self.stack_for(dimensions), np.random.default_rng([seed, 5])
        y, x = np.mgrid[:size, :size]
        numbers = []
        while len(numbers) < dimensions:
            down, right = random.integers(0, 4096, 2)
            texels = stack[frame % len(stack), (y + down) % stack.shape[1], (x + right) % stack.shape[2]]
            numbers += list(np.moveaxis(texels, -1, 0))
        return np.stack(numbers[:dimensions], -1)


class MovedMask:
    """The built-in 64x64 mask, with a different offset for each number. Every frame adds a constant to its values."""

    def __init__(self):
        self.still = Slices(bluenoise.to_float(bluenoise.builtin((64, 64)))[None, ..., None])

    def frame(self, frame, dimensions, seed, size):
        moved = self.still.frame(0, dimensions, seed, size) + frame * np.array(golden_powers(dimensions))
        return (moved % 1).astype(np.float32)

    def pairs(self, frames):
        return np.stack([self.frame(frame, 2, 0, 64) for frame in range(frames)])


class GradientNoise:
    """Interleaved gradient noise (Jimenez, 2014), shifted by 5.588238 pixels per frame. Further numbers use other offsets."""

    def frame(self, frame, dimensions, seed, size):
        y, x = np.mgrid[:size, :size]
        away = np.random.default_rng([seed, 6]).integers(0, 4096, (dimensions, 2))
        numbers = [52.9829189 * ((0.06711056 * (x + right + 5.588238 * (frame % 64)) + 0.00583715 * (y + down + 5.588238 * (frame % 64))) % 1) % 1
                   for down, right in away]
        return np.stack(numbers, -1).astype(np.float32)


class HeitzTables:
    """Tables for 256 samples: averages of frames have the lowest errors with these (heitz.Tables)."""

    def __init__(self, tables):
        self.tables = tables

    def frame(self, frame, dimensions, seed, size):
        y, x = np.mgrid[:size, :size]
        return self.tables.numbers(x, y, [frame], dimensions, self.tables.for_count(256), seed)[..., 0, :]


def read_stack(prefix):
    """float32 [depth][height][width][channels] from the files PREFIX0.png, PREFIX1.png ... An integer maps to the middle of its interval. Grey
    files give one channel, and others red and green."""
    prefix = Path(prefix)
    files = sorted((int(match[1]), path) for path in prefix.parent.glob("*.png") if (match := re.fullmatch(rf"{re.escape(prefix.name)}(\d+)\.png", path.name)))
    try:
        pixels = np.stack([np.asarray(Image.open(path)) for _, path in files])
    except (OSError, ValueError) as error:
        raise CommandError(f"cannot read slices from {prefix}0.png, {prefix}1.png ...: {error}") from None
    pixels, steps_of = pixels.reshape(*pixels.shape[:3], -1), np.float32(256 if pixels.dtype.itemsize == 1 else 65536)
    channels = 2 if pixels.shape[-1] > 1 and np.any(pixels[..., 0] != pixels[..., 1]) else 1
    return (pixels[..., :channels] + np.float32(0.5)) / steps_of


# ---- The measure

COMMAND = "scripts/bench realtime"
SIZE, FRAMES = 128, 128
MEANS, WEIGHTS = (8, 32), (0.05, 0.1, 0.2)  # numbers of frames; weights of the newest frame in a moving average
ALONE = range(64, 80)  # the frames measured one by one
SETTLED = range(100, FRAMES, 3)  # ages at which the moving averages are measured
OUTCOMES = ("one frame", *(f"mean of {n}" for n in MEANS), *(f"average, {weight}" for weight in WEIGHTS))
FILTERS = {**{f"sigma {sigma}": functools.partial(blurred, sigma=sigma, mode="wrap") for sigma in (0.0, 1.0, 2.1)},
           **{f"box {n}x{n}": functools.partial(ndimage.uniform_filter, size=n, mode="wrap") for n in (3, 5)}}
WAYS = {
    "white": Draws("white"),
    "sobol": Draws("sobol"),
    "blue": Draws("blue"),
    "blue, a new stream every frame": Draws("blue", new_stream=True),
    "mask + golden ratio, R2": MovedMask(),
    "interleaved gradient noise": GradientNoise(),
}
# Parts of the screen drawn in a frame: the number of frames that make up a screen, and the screen pixel of frame t for each (x, y) in a
# smaller image.
CORNERS = ((0, 0), (1, 1), (1, 0), (0, 1))
PARTS = {
    "checkerboard": (2, lambda x, y, t: (2 * x + (y + t) % 2, y)),
    "one pixel of 2x2": (4, lambda x, y, t: (2 * x + CORNERS[t % 4][0], 2 * y + CORNERS[t % 4][1])),
}
# (x, y in the smaller image, x, y on the screen, frame, frames that make up a screen) -> x, y, index, stream
GIVEN = {
    "the screen's `x, y`, index `t`": lambda x, y, at_x, at_y, t, n: (at_x, at_y, t, 0),
    "the screen's `x, y`, index `t / n`": lambda x, y, at_x, at_y, t, n: (at_x, at_y, t // n, 0),
    "the smaller image's `x, y`, index `t / n`, stream `t % n`": lambda x, y, at_x, at_y, t, n: (x, y, t // n, t % n),
}


# ---- Integrands: (values of numbers (..., dimensions), their mean)

MIDDLES = (np.arange(2048, dtype=np.float32) + np.float32(0.5)) / np.float32(2048)


def step(random):
    edge = np.float32(random.uniform(0.1, 0.9))
    return lambda u: u[..., 0] < edge, float(edge)


def half_plane(random):
    angle, point = random.uniform(0, 2 * np.pi), random.uniform(0.2, 0.8, 2)
    normal = np.array([np.cos(angle), np.sin(angle)], np.float32)

    def values(u):
        return u @ normal < np.float32(normal @ point)

    return values, float(np.mean(values(np.stack(np.meshgrid(MIDDLES, MIDDLES), -1)), dtype=np.float64))


def product(random):
    (first, a), (second, b) = half_plane(random), half_plane(random)
    return lambda u: first(u[..., :2]) & second(u[..., 2:]), a * b


INTEGRANDS = {"step": (1, step), "half-plane": (2, half_plane), "product": (4, product)}


# ---- Errors: averages and filters are linear, so both are applied to spectra

@functools.lru_cache
def transfer(size):
    """(filters, frequencies): the share of the image's power that each filter keeps at each of rfft2's frequencies."""
    delta = np.zeros((size, size))
    delta[0, 0] = 1
    kept = np.array([np.abs(fft.rfft2(keep(delta))) ** 2 for keep in FILTERS.values()])
    kept[..., 1:-1] *= 2  # rfft2 omits the other half of the spectrum; sizes are even
    return kept.reshape(len(FILTERS), -1) / float(size) ** 4


def squares(spectra):
    """(images, filters): mean squares after each filter."""
    return np.abs(spectra.reshape(len(spectra), -1)) ** 2 @ transfer(spectra.shape[1]).T


def errors(frames, integrand):
    """Mean squares (OUTCOMES, FILTERS), and mean squares (frames, FILTERS) of each single frame."""
    values, mean = integrand
    spectra = fft.rfft2(values(frames).astype(np.float32) - np.float32(mean))
    alone = squares(spectra)
    outcomes = [alone[ALONE.start:ALONE.stop].mean(0), *(squares(spectra[:n].mean(0, keepdims=True))[0] for n in MEANS)]
    for weight in WEIGHTS:
        average, kept = spectra[0], []
        for t, frame in enumerate(spectra[1:], 1):
            average = (1 - weight) * average + weight * frame
            if t in SETTLED:
                kept.append(average)
        outcomes.append(squares(np.stack(kept)).mean(0))
    return np.array(outcomes), alone


def measure(ways, seeds, count, kinds=tuple(INTEGRANDS), size=SIZE):
    """{(integrand, way): the two results of errors()}: root mean squares over seeds and `count` integrands of each type."""
    result = {}
    for kind in kinds:
        dimensions, make = INTEGRANDS[kind]
        integrands = [make(np.random.default_rng([7, i])) for i in range(count)]
        for way, source in ways.items():
            found = []
            for seed in range(seeds):
                frames = np.stack([source.frame(frame, dimensions, seed, size) for frame in range(FRAMES)])
                found += [errors(frames, integrand) for integrand in integrands]
            result[kind, way] = [np.sqrt(np.mean(own, 0)) for own in zip(*found)]
    return result


def part_errors(part, kind, given, seed, integrands, size=SIZE):
    """(2, FILTERS) mean squares: of one frame's pixels placed side by side, and of a moving average of the screen."""
    n, pixels = PARTS[part]
    sampler, shown, alone = bluenoise.Sampler(kind, seed=seed), np.zeros((size, size), bool), []
    averages = np.zeros((len(integrands), size, size), np.float32)
    y, x = np.mgrid[:size * 2 // n, :size // 2]
    for t in range(n * SETTLED.start // 2):
        at_x, at_y = pixels(x, y, t)
        u = bluenoise.PathSampler(sampler, *given(x, y, at_x, at_y, t, n)).ray(0).draw_direction()
        weight = np.where(shown[at_y, at_x], np.float32(0.1), np.float32(1))
        shown[at_y, at_x] = True
        for average, (values, mean) in zip(averages, integrands):
            deviation = values(u) - np.float32(mean)
            average[at_y, at_x] += weight * (deviation - average[at_y, at_x])
            if t % n == 0 and t >= n * (SETTLED.start // 2 - 8):
                alone.append([np.mean(keep(deviation.astype(np.float64)) ** 2) for keep in FILTERS.values()])
    return np.array([np.mean(alone, 0), squares(fft.rfft2(averages)).mean(0)])


def measure_parts(seeds, count):
    """{(part, arguments passed): (2, FILTERS) errors relative to white noise}."""
    integrands = [half_plane(np.random.default_rng([7, i])) for i in range(count)]
    result = {}
    for part in PARTS:
        white, *found = (np.mean([part_errors(part, kind, given, seed, integrands) for seed in range(seeds)], 0)
                         for kind, given in [("white", next(iter(GIVEN.values()))), *(("blue", given) for given in GIVEN.values())])
        result.update({(part, name): np.sqrt(own / white) for name, own in zip(GIVEN, found)})
    return result


# ---- The page, from the rows of the CSV

FIELDS = ("integrand", "way", "outcome", "filter", "error")
SHOWN = (("one frame", "sigma 1.0"), ("one frame", "sigma 2.1"), ("average, 0.1", "sigma 0.0"), ("average, 0.1", "sigma 1.0"),
         ("average, 0.1", "sigma 2.1"), ("average, 0.1", "box 5x5"))
HEADS = {"half-plane": "pairs (half-planes)", "product": "four numbers (products)", "step": "single numbers (steps)"}


def rows_of(result, ways):
    """Errors relative to white noise."""
    return [{"integrand": kind, "way": way, "outcome": outcome, "filter": name,
             "error": f"{result[kind, way][0][i, j] / result[kind, 'white'][0][i, j]:.4f}"}
            for kind in INTEGRANDS for way in ways for i, outcome in enumerate(OUTCOMES) for j, name in enumerate(FILTERS)]


def in_order(rows):
    """{way: {(integrand, outcome, filter): error over padded Sobol'}}."""
    found = {}
    for row in rows:
        found.setdefault(row["way"], {})[row["integrand"], row["outcome"], row["filter"]] = float(row["error"])
    return {way: {at: error / found["sobol"][at] for at, error in own.items()} for way, own in found.items()}


def short_table(errors, kind):
    return md_table([HEADS[kind], *(f"{outcome.replace(', 0.1', '')}, {name.replace('sigma 0.0', 'unfiltered')}" for outcome, name in SHOWN)],
                    [[way, *(f"{own[kind, outcome, name]:.2f}" for outcome, name in SHOWN)] for way, own in errors.items() if way != "sobol"])


def winners_table(errors):
    """The method with the lowest error after a 1.0-pixel blur, and every method with at most 3% more."""
    def winners(kind, outcome):
        values = sorted((own[kind, outcome, "sigma 1.0"], way) for way, own in errors.items())
        return ", ".join(f"{way} {value:.2f}" for value, way in values if value <= 1.03 * values[0][0])

    return md_table(["numbers per effect", "a single frame", "averaged frames"], [
        [str(dimensions), winners(kind, "one frame"), winners(kind, "average, 0.1")] for kind, (dimensions, _) in INTEGRANDS.items()], 2)


def parts_table(result):
    names = list(FILTERS)
    places = [(0, "sigma 1.0"), (1, "sigma 0.0"), (1, "sigma 1.0"), (1, "sigma 2.1")]
    return md_table(["drawn in a frame", "passed to the path", *(
        f"{('one frame', 'average')[i]}, {name.replace('sigma 0.0', 'unfiltered')}" for i, name in places)],
        [[part, given, *(f"{own[i, names.index(name)]:.2f}" for i, name in places)] for (part, given), own in result.items()])


def draw_plot(result, ways, path):
    names = list(ways)
    figure, axes = plt.subplots(1, 2, figsize=(10, 4), sharey=True, layout="constrained")
    for axis, kind in zip(axes, ("half-plane", "step")):
        for way in names:
            own = result[kind, way][1][:, 1] / result[kind, "sobol"][0][0, 1]
            axis.plot(own, **{**style(way, names), "marker": "", "linewidth": 1.2})
        axis.set(title=f"{kind}, after sigma 1.0", xlabel="frame", ylim=(0, 1.75))
        axis.grid(True, alpha=.25)
    axes[0].set_ylabel("error of a frame over padded Sobol'")
    figure.legend(*axes[0].get_legend_handles_labels(), fontsize="x-small", loc="outside lower center", ncols=6)
    save(figure, path)


# ---- The command

def run(arguments):
    parser = Parser("realtime", __doc__)
    parser.number("--seeds", 2, "number of seeds per sampler")
    parser.number("--integrands", 12, "number of integrands per type")
    parser.add_argument("--slices", type=named, action="append", default=[], metavar="NAME=PREFIX",
                        help="include slices of a space-time mask: the files PREFIX0.png, PREFIX1.png ...; repeat it for numbers and pairs of one NAME")
    parser.add_argument("--heitz", type=Path, metavar="FOLDER", help="the tables of Heitz et al. 2019: ..._256spp.cpp or spp256.rs")
    parser.add_argument("--motion", action="store_true", help="measure rendered scenes with a moving camera instead: motion.*, and a table in docs/realtime.md")
    parser.hidden("--frames", "build/evidence/programs/render_frames")
    parser.sampler()
    parser.out()
    parser.table("docs/realtime.md")
    options = parser.parse_args(arguments)
    options.command = command_shown("realtime", arguments)
    packs = {name: Slices(*(read_stack(prefix) for own, prefix in options.slices if own == name)) for name, _ in options.slices}
    tables = heitz.Tables(options.heitz) if options.heitz else None
    added = {name: plugins.load(file) for name, file in options.sampler}
    before = options.out  # with the rows of the last run
    if added and options.out == Path("evidence/results"):
        options.out, options.print = Path("out/realtime"), True
    if options.motion:
        earlier = read_numbers(path) if (path := before / "motion.csv").is_file() else []
        return motion.run(options, {"mask + R2": MovedMask(), **packs}, tables, added, earlier)
    ways, path = {**WAYS, **packs, **({"Heitz et al. 2019": HeitzTables(tables)} if tables else {}), **added}, options.out / "realtime.csv"
    result = measure(ways, options.seeds, options.integrands)
    earlier = [row for row in read_numbers(before / path.name) if row["way"] not in ways] if (before / path.name).is_file() else []
    rows = [*rows_of(result, ways), *earlier]
    draw_plot(result, ways, options.out / "realtime.png")
    write_rows(path, FIELDS, rows)
    parts = measure_parts(options.seeds, options.integrands)
    write_rows(options.out / "realtime_parts.csv", ("part", "given", "outcome", "filter", "error"), [
        {"part": part, "given": given, "outcome": outcome, "filter": name, "error": f"{own[i, j]:.4f}"}
        for (part, given), own in parts.items() for i, outcome in enumerate(("one frame", "average, 0.1")) for j, name in enumerate(FILTERS)])
    write_page(options.out / "realtime.md", globals(), errors=in_order(rows), parts=parts, options=options)
