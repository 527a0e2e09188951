# SPDX-License-Identifier: Apache-2.0
"""Judges tables of the sampler blue on integrands that no search has seen.

Errors of 64 x 64 pixels, over those of padded Sobol' in the same run unless a row says otherwise: smaller is better. All prefixes come from one
run, those of zorder from one of their own. Families, seeds and integrands are drawn at random."""

import functools
import itertools
from pathlib import Path

import numpy as np
from scipy.stats import qmc

import bluenoise

from ..base.command import CommandError, Parser
from ..base.contact_sheet import grey, sheet

SIDE, PIXELS = 64, 64 * 64
WORDS, BLOCKS, PLACES, POINTS, LATER = 11904, 4096, 6144, 6272, 10368
COUNTS = (1, 2, 4, 8, 16, 32, 64)
PEAKS = PIXELS // 100
Y, X = np.mgrid[:SIDE, :SIDE].astype(np.uint32)


# ---- The draws of BLUE from the words of any table

def u32(value):
    return np.uint32(value & 0xffffffff)


def bits_reversed(v):
    for shift, mask in ((1, 0x55555555), (2, 0x33333333), (4, 0x0f0f0f0f), (8, 0x00ff00ff)):
        v = (v >> u32(shift) & u32(mask)) | (v & u32(mask)) << u32(shift)
    return v >> u32(16) | v << u32(16)


def hashed(v):
    v = (v ^ v >> u32(16)) * u32(0x21f0aaad)
    v = (v ^ v >> u32(15)) * u32(0xd35a2d97)
    return v ^ v >> u32(15)


def blue_bits(words, seed, x, y, index, domain):
    """bn_draw_blue_bits() of arrays; words of 32 bits, `index` along the last axis."""
    with np.errstate(over="ignore"):
        turned = u32(int(domain) << 2 | int(domain) >> 30)
        member = int(turned & u32(3))
        start = u32(int(turned) & 0xfffffffc ^ int(seed[0]))
        family = start * u32(0x21f0aaad)
        family = (family ^ family >> u32(16)) * u32(0xd35a2d97) + u32(int(seed[1]))
        column = (x ^ u32(-int(family >> u32(31)))) + (start >> u32(26))
        row = (y ^ u32(-int(family >> u32(19) & u32(1)))) + (family >> u32(20))
        copy = (column >> u32(6)) + (row >> u32(6)) * u32(0x9e3779b1) + family
        copy = (copy ^ copy >> u32(16)) * u32(0x21f0aaad)
        copy ^= copy >> u32(15)
        at = (row & u32(63)) << u32(6) | column & u32(63)
        place = words[at] >> u32(8 * member) & u32(15)
        keys = copy * u32(member * 0x0bd794d6 + 0xd35a2d97)
        keys ^= keys >> u32(16)
        low = (hashed(x + y * u32(0x9e3779b1)) ^ keys) * u32(0x21f0aaad)
        t = ((index & u32(255)) >> u32(1)) - u32(1)
        flip = u32(2) << (t & u32(15))
        for bit, more in ((5, 5), (6, 11), (7, 2)):
            flip |= (index >> u32(bit) & u32(1)) << (((t + u32(more)) & u32(15)) + u32(1))
        flip &= (t >> u32(31)) - u32(1)
        backwards = bits_reversed(index)
        shuffle = copy[..., None]
        digits = backwards ^ backwards * (shuffle << u32(1)) ^ (shuffle * flip) & u32(0x80000000)
        points = words[POINTS:LATER].reshape(256, 4, 4)[:, member]
        v = points[digits >> u32(24)]
        later = words[LATER:].reshape(6, 16, 4, 4)[:, :, member]
        for four in range(6):
            v = v ^ later[four][digits >> u32(20 - 4 * four) & u32(15)]
        place = words[PLACES:POINTS].reshape(4, 16, 2)[member][place]
        block = words[BLOCKS:PLACES].reshape(256, 4, 2)[:, member][(at >> u32(8) & u32(15)) * 16 + (at >> u32(2) & u32(15))]
        high = place ^ block ^ np.stack([keys, keys << u32(8) | keys >> u32(24)], -1)
        low = np.stack([low, low ^ keys], -1)
        shift = np.stack([high << u32(16) | low & u32(0xffff), high & u32(0xffff0000) | low >> u32(16)], -1)
    return v ^ shift.reshape(*shift.shape[:-2], 1, 4)


def blue_of(words):
    def draw(run, count, member):
        seed = np.random.default_rng([run, 77]).integers(0, 2**32, 2, np.uint32)
        bits = blue_bits(words, seed, X, Y, np.arange(count, dtype=np.uint32), bluenoise.domain(run, 4 * run + member))
        return (bits >> u32(8)).astype(np.float32) * np.float32(2**-24)
    return draw


# ---- Others

def of_library(name):
    def draw(run, count, member):
        told = {"samples_per_pixel": count} if name == "zorder" else {}
        return bluenoise.Sampler(name, seed=run, **told).block(0, 0, SIDE, SIDE, 0, count, bluenoise.domain(run, 4 * run + member))
    return draw


def global_sobol(run, count, member):
    """One sequence over the screen: its first two dimensions are the pixel, member 0 takes the next four, and so on."""
    first = 2 + 4 * member
    points = qmc.Sobol(first + 4, seed=run).random(PIXELS * count)
    order = np.lexsort((np.arange(PIXELS * count), (points[:, 0] * SIDE).astype(int), (points[:, 1] * SIDE).astype(int)))
    return points[order, first:].reshape(SIDE, SIDE, count, 4).astype(np.float32)


def owen_4d(run, count, _member):
    """An Owen-scrambled Sobol' sequence of four dimensions of its own in every pixel of a few."""
    return np.stack([qmc.Sobol(4, seed=1000 * run + p).random(count) for p in range(64)]).reshape(8, 8, count, 4).astype(np.float32)


PEERS = {"Z-order": of_library("zorder"), "global Sobol'": global_sobol}
ONE_COUNT = ("Z-order",)


# ---- Integrands: functions of samples that are 1 or 0, and the mean in every pixel

def area(a, b, c):
    """Of a x + b y < c in the unit square."""
    c = c - min(a, 0) - min(b, 0)
    a, b = max(abs(a), 1e-4), max(abs(b), 1e-4)
    terms = (np.maximum(0, c - sub)**2 for sub in (0, a, b, a + b))
    first, *two, last = terms
    return np.clip((first - sum(two) + last) / (2 * a * b), 0, 1)


def drift(r, period):
    """What moves an edge back and forth across the screen."""
    if not period:
        return np.zeros((SIDE, SIDE))
    angle, phase = r.uniform(0, 2 * np.pi, 2)
    waves = np.round(np.cos(angle) * SIDE / period), np.round(np.sin(angle) * SIDE / period)
    return 0.35 * np.sin(2 * np.pi * ((waves[0] or not any(waves)) * X + waves[1] * Y) / SIDE + phase)


class Plane:
    """a u + b v < c for two of the four numbers."""

    def __init__(self, r, period=0):
        self.a, self.b = (f(angle) for angle in [r.uniform(0, 2 * np.pi)] for f in (np.cos, np.sin))
        self.c = self.a * r.uniform(.2, .8) + self.b * r.uniform(.2, .8) + drift(r, period)
        self.mean = area(self.a, self.b, self.c)

    def __call__(self, u, v):
        return np.float32(self.a) * u + np.float32(self.b) * v < self.c[..., None].astype(np.float32)


@functools.cache
def blur(sigma):
    """A toroidal Gaussian along one axis, as a matrix."""
    if not sigma:
        return np.eye(SIDE, dtype=np.float32)
    kernel = np.exp(-0.5 * (np.minimum(np.arange(SIDE), SIDE - np.arange(SIDE)) / sigma)**2)
    return np.stack([np.roll(kernel / kernel.sum(), k) for k in range(SIDE)]).astype(np.float32)


def error_images(values, mean, counts):
    """(counts, SIDE, SIDE) from values of all samples."""
    sums = (np.arange(values.shape[-1])[:, None] < counts) / np.float32(counts)
    return np.moveaxis(values.astype(np.float32) @ sums.astype(np.float32), -1, 0) - np.asarray(mean, np.float32)


def mean_square(images, down, across):
    return ((blur(down) @ images @ blur(across)) ** 2).mean((1, 2))


def peaks(images):
    """The mean of the largest hundredth of the powers over the mean of all."""
    powers = np.abs(np.fft.fft2(images - images.mean((1, 2), keepdims=True))).reshape(len(images), -1) ** 2
    return np.sort(powers)[:, -PEAKS:].mean(1) / powers.mean(1)


# ---- Measures: each a generator of (row, integrand images, blurs) of one run

SIGMAS = {"": (2.1, 2.1), ", sigma 1.0": (1.0, 1.0), ", single pixels": (0, 0)}


def images_of_run(draw, run, counts):
    """Yields (row, images, blurs) of every integrand."""
    samples = [draw(run, counts[-1], member) for member in range(4)]
    for period, member in itertools.product((0, 64, 24), range(4)):
        r = np.random.default_rng([run, member, period, 5])
        u = np.moveaxis(samples[member], -1, 0)
        for _ in range(6):
            first, second = Plane(r, period), Plane(r, period)
            inside = first(u[0], u[1]), second(u[2], u[3])
            name = f"half-planes, period {period}" if period else "half-planes"
            for pair, plane in enumerate((first, second)):
                images = error_images(inside[pair], plane.mean, counts)
                for ending, sigma in SIGMAS.items():
                    yield name + ending, images, sigma
                yield f"peaks, member {member}, pair {pair}{', drifting' if period else ''}", images, None
            images = error_images(inside[0] & inside[1], first.mean * second.mean, counts)
            for ending, sigma in SIGMAS.items():
                yield f"products of both pairs{f', period {period}' if period else ''}{ending}", images, sigma
    for member, other in itertools.combinations(range(4), 2):
        r = np.random.default_rng([run, member, other, 6])
        for k in range(4):
            first, second = Plane(r), Plane(r)
            values = (first(*np.moveaxis(samples[member], -1, 0)[2 * (k & 1):][:2]) &
                      second(*np.moveaxis(samples[other], -1, 0)[2 * (k >> 1):][:2]))
            images = error_images(values, first.mean * second.mean, counts)
            for ending, sigma in SIGMAS.items():
                yield f"products of two members{ending}", images, sigma
    r = np.random.default_rng([run, 7])
    for k in range(24):
        d, c = k % 2, np.float32((k // 2 + r.uniform()) / 12)
        images = error_images(samples[0][..., d] < c, c, counts)
        yield "edges along the pixel's sides", images, (2.1, 0) if d == 0 else (0, 2.1)
    for k in range(16):  # edges that lean a little
        member, angle = k % 4, np.arctan(r.uniform(.03, .1) * (-1)**(k // 4)) + np.pi / 2 * (k // 8)
        a, b = np.cos(angle), np.sin(angle)
        c = a * r.uniform() + b * r.uniform()
        u = np.moveaxis(samples[member], -1, 0)
        values = np.float32(a) * u[0] + np.float32(b) * u[1] < np.float32(c)
        yield "edges that lean", error_images(values, area(a, b, c), counts), (2.1, 2.1)
    for k in range(24):
        member, d = k % 4, k // 4 % 4
        c = np.clip(r.uniform(.05, .95) + drift(r, (0, 64)[k % 2]) * .7, 0, 1).astype(np.float32)
        images = error_images(samples[member][..., d] < c[..., None], c, counts)
        for ending, sigma in SIGMAS.items():
            yield f"single numbers{ending}", images, sigma
    for member, chosen in itertools.product(range(4), (2, 3)):
        u = np.moveaxis(samples[member], -1, 0)
        for d in range(2):
            values = np.where(u[chosen] < .5, u[d], 1 - u[d])
            images = error_images(values, .5, counts)
            yield f"choice by u[{chosen}], then a pair: ramps, member {member}", images, (2.1, 2.1)
            yield f"choice by u[{chosen}], then a pair: ramps, member {member}, single pixels", images, (0, 0)
        for _ in range(4):
            share, first, second = r.uniform(.25, .75), Plane(r), Plane(r)
            values = np.where(u[chosen] < np.float32(share), first(u[0], u[1]), second(u[0], u[1]))
            images = error_images(values, share * first.mean + (1 - share) * second.mean, counts)
            yield f"choice by u[{chosen}], then a pair", images, (2.1, 2.1)
    for _ in range(48):  # position, and time or lens
        member = 0
        angle, speed = r.uniform(0, 2 * np.pi), 16 * r.uniform(.1, 1)
        a, b = np.cos(angle), np.sin(angle)
        e = speed * np.cos(r.uniform(0, 2 * np.pi))
        c = a * r.uniform(16, 48) + b * r.uniform(16, 48) + e / 2
        normal, at = np.array([a, b, e]), c - a * X - b * Y
        u = np.moveaxis(samples[member], -1, 0)
        values = np.float32(a) * u[0] + np.float32(b) * u[1] + np.float32(e) * u[2] < at[..., None].astype(np.float32)
        yield "edges that move", error_images(values, half_space(normal, at), counts), (2.1, 2.1)


def half_space(normal, at):
    """The volume of normal . u < at in the unit cube of as many dimensions."""
    at = at - np.minimum(normal, 0).sum()
    size = np.maximum(np.abs(normal), 1e-3)
    corners = ((np.array(corner) @ size, (-1) ** sum(corner)) for corner in itertools.product((0, 1), repeat=len(normal)))
    total = sum(sign * np.maximum(0, at - away) ** len(normal) for away, sign in corners)
    return np.clip(total / (np.prod(size) * np.prod(np.arange(1, len(normal) + 1))), 0, 1)


def measure(draw, runs, counts=COUNTS, one_count=False):
    """{row: root mean squares, or mean peaks, at all counts}."""
    found = {}
    for run in range(1, runs + 1):
        for some in [(n,) for n in counts] if one_count else [counts]:
            at = counts.index(some[0])
            for row, images, sigma in images_of_run(draw, run, some):
                sums = found.setdefault(row, np.zeros((2, len(counts))))
                sums[0, at:at + len(some)] += peaks(images) if sigma is None else mean_square(images, *sigma)
                sums[1, at:at + len(some)] += 1
    return {row: sums[0] / sums[1] if row.startswith("peaks") else np.sqrt(sums[0] / sums[1]) for row, sums in found.items()}


def solids(r, dimensions):
    """Half-spaces, balls and Gaussians over a triple: (function, mean)."""
    normal, centre = r.normal(size=3), r.uniform(.3, .7, 3)
    normal /= np.linalg.norm(normal)
    at = normal @ centre
    yield lambda p: p @ normal.astype(np.float32) < at, half_space(normal, at)
    radius = r.uniform(.2, .5)
    centre = r.uniform(radius, 1 - radius, 3)
    yield lambda p: ((p - centre.astype(np.float32))**2).sum(-1) < radius**2, 4 / 3 * np.pi * radius**3
    width, middle = r.uniform(.15, .4), r.uniform(0, 1, 3)
    fine = (np.arange(4096) + .5) / 4096
    yield (lambda p: np.exp(-((p - middle.astype(np.float32))**2).sum(-1) / (2 * width**2)),
           np.prod([np.exp(-(fine - m)**2 / (2 * width**2)).mean() for m in middle]))


def in_three_dimensions(draw, runs, counts):
    """Errors in single pixels, over each triple of the four numbers."""
    found = {}
    for run in range(1, runs + 1):
        for member in range(4):
            samples = draw(run, counts[-1], member)[::8, ::8] if draw is not owen_4d else draw(4 * run + member, counts[-1], 0)
            samples = samples[:8, :8]
            r = np.random.default_rng([run, member, 8])
            for triple in itertools.combinations(range(4), 3):
                points = samples[..., triple]
                for _ in range(2):
                    for name, (function, mean) in zip(("half-spaces", "balls", "Gaussians"), solids(r, 3)):
                        sums = (np.arange(counts[-1])[:, None] < counts) / np.float64(counts)
                        errors = function(points).astype(np.float64) @ sums - mean
                        found.setdefault(name, []).append((errors**2).mean((0, 1)))
    return {name: np.sqrt(np.mean(squares, 0)) for name, squares in found.items()}


# ---- The report

def read_words(path):
    data = Path(path).read_bytes()
    if len(data) != 4 * WORDS:
        raise CommandError(f"{path} is not a table of the sampler blue: it has {len(data)} bytes, not {4 * WORDS}")
    return np.frombuffer(data, "<u4").astype(np.uint32)


def show(name, who, values, digits=2):
    print(f"| {name} | {who} | " + " | ".join("" if np.isnan(v) else f"{v:.{digits}f}" for v in values) + " |", flush=True)


def patterns(tables):
    """Images of two flat half-planes, one of which drifts slowly, at 1 and 4 samples: each pixel enlarged twice."""
    draws = {"white noise": of_library("white"), **{name: blue_of(words) for name, words in tables.items()}, **PEERS}
    cells = []
    for period, count in itertools.product((0, 128), (1, 4)):
        cells.append([])
        for draw in draws.values():
            plane = Plane(np.random.default_rng(3), period)
            u = np.moveaxis(draw(5, count, 1), -1, 0)
            shade = np.uint8(255 * (plane(u[0], u[1]).mean(-1) * .8 + .1))
            cells[-1].append([grey(np.kron(shade, np.ones((2, 2), np.uint8)))])
    names = [f"{'drifting' if period else 'constant'}\n{count} sample{'s' * (count > 1)}" for period, count in itertools.product((0, 1), (1, 4))]
    return sheet(cells, names, list(draws))


def summarised(found):
    """Rows of one kind over all members: the largest of the peaks, and of choices between ramps over white noise."""
    rows = {row: values for row, values in found.items() if not row.startswith(("peaks", "choice by u[2], then a pair: ramps", "choice by u[3], then a pair: ramps"))}
    for ending in ("", ", drifting"):
        of = [values for row, values in found.items() if row.startswith("peaks") and row.endswith("drifting") == bool(ending)]
        rows[f"spectral peaks, the largest of any pair{ending}"] = np.max(of, 0)
    return rows


def run(arguments):
    parser = Parser("table", __doc__)
    parser.add_argument("tables", nargs="*", type=Path, help="files with other tables, to compare; the library's own comes first")
    parser.add_argument("--runs", type=int, default=16, help="seeds (16; two minutes for each table)")
    parser.add_argument("--peers", action="store_true", help="also Z-order and global Sobol'")
    parser.add_argument("--picture", type=Path, help="writes an image of flat half-planes with each sampler, and measures nothing")
    options = parser.parse_args(arguments)
    tables = {"blue": bluenoise.tables()}
    tables |= {str(path): read_words(path) for path in options.tables}
    if options.picture:
        patterns(tables).save(options.picture)
        return
    padded, white = measure(of_library("sobol"), options.runs), measure(of_library("white"), max(1, options.runs // 2))
    found = {name: measure(blue_of(words), options.runs) for name, words in tables.items()}
    if options.peers:
        found |= {name: measure(draw, options.runs, one_count=name in ONE_COUNT) for name, draw in PEERS.items()}
    found["white noise"] = white
    print("| error over padded Sobol' | sampler | " + " | ".join(map(str, COUNTS)) + " |")
    print("| --- | --- |" + " ---: |" * len(COUNTS))
    rows = {name: summarised(each) for name, each in found.items()}
    base = summarised(padded)
    for row in base:
        for name, each in rows.items():
            if row.startswith("spectral"):
                show(row, name, each[row], 1)
            elif name != "white noise":
                show(row, name, each[row] / base[row])
    for chosen, ending in itertools.product((2, 3), ("", ", single pixels")):
        of = [row for row in padded if row.startswith(f"choice by u[{chosen}], then a pair: ramps") and row.endswith("pixels") == bool(ending)]
        for name in (*tables, *(PEERS if options.peers else ())):
            worst = np.max([found[name][row] / white[row] for row in of], 0)
            show(f"choice by u[{chosen}] of mirrored ramps, worst member, over white noise{ending}", name, worst)
    counts = (4, 16, 64, 256, 1024)
    print("\n| single pixels, error over padded Sobol' | sampler | " + " | ".join(map(str, counts)) + " |")
    print("| --- | --- |" + " ---: |" * len(counts))
    solid = {name: in_three_dimensions(draw, max(1, options.runs // 2), counts) for name, draw in
             {"padded": of_library("sobol"), **{name: blue_of(words) for name, words in tables.items()}, "4-D Owen-scrambled Sobol'": owen_4d}.items()}
    for row, name in itertools.product(solid["padded"], solid):
        if name != "padded":
            show(f"three dimensions: {row}", name, solid[name][row] / solid["padded"][row])
