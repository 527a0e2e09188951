# SPDX-License-Identifier: Apache-2.0
"""Integrands that were never used in a search, and the samplers' errors and spectral peaks for them.

Images are 64 x 64 pixels. One run gives all sample counts, except for zorder, which needs one run per sample count. Families, seeds and
integrands are random."""

import functools
import itertools
import math

import numpy as np
from scipy.stats import qmc

import bluenoise

from ..base.contact_sheet import grey, sheet

SIDE, PIXELS = 64, 64 * 64
COUNTS = (1, 2, 4, 8, 16, 32, 64)
EVERY_COUNT = (*range(1, 33), 64, 128, 256, 512, 1024, 2048, 4096)
PEAKS = PIXELS // 100
Y, X = np.mgrid[:SIDE, :SIDE].astype(np.uint32)


# ---- Draws: functions of (run, count, member) that return [y][x][sample][4]

def of_library(name):
    def draw(run, count, member):
        tuned = {"samples_per_pixel": count} if name == "zorder" else {}
        return bluenoise.Sampler(name, seed=run, **tuned).block(0, 0, SIDE, SIDE, 0, count, bluenoise.domain(run, 4 * run + member))
    return draw


def global_sobol(run, count, member):
    """One sequence over the screen: its first two dimensions give the pixel, member 0 takes the next four dimensions, and so on."""
    first = 2 + 4 * member
    points = qmc.Sobol(first + 4, seed=run).random(PIXELS * count)
    order = np.lexsort((np.arange(PIXELS * count), (points[:, 0] * SIDE).astype(int), (points[:, 1] * SIDE).astype(int)))
    return points[order, first:].reshape(SIDE, SIDE, count, 4).astype(np.float32)


def of_heitz(tables):
    """The tables for each count. A member of a family takes four of the eight optimised dimensions: members 2 and 3 from another part of the tile."""
    def draw(run, count, member):
        u = tables.numbers(X.astype(int), Y.astype(int), range(count), 8, tables.for_count(count), 2 * run + member // 2)
        return u[..., 4 * (member % 2):][..., :4]
    return draw


# ---- Integrands: functions of the samples with values 0 or 1, and their mean in every pixel

def half_space(normal, at, least=1e-4):
    """The volume of normal . u < at in the unit cube with as many dimensions as `normal`, whose components count as at least `least`."""
    at = at - np.minimum(normal, 0).sum()
    size = np.maximum(np.abs(normal), least)
    corners = ((np.array(corner) @ size, (-1) ** sum(corner)) for corner in itertools.product((0, 1), repeat=len(normal)))
    total = sum(sign * np.maximum(0, at - away) ** len(normal) for away, sign in corners)
    return np.clip(total / (np.prod(size) * math.factorial(len(normal))), 0, 1)


def drift(r, period):
    """An offset that moves an edge back and forth across the screen."""
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
        self.mean = half_space((self.a, self.b), self.c)

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
    """(counts, SIDE, SIDE) from the values of all samples."""
    sums = (np.arange(values.shape[-1])[:, None] < counts) / np.float32(counts)
    return np.moveaxis(values.astype(np.float32) @ sums.astype(np.float32), -1, 0) - np.asarray(mean, np.float32)


def mean_square(images, down, across):
    return ((blur(down) @ images @ blur(across)) ** 2).mean((1, 2))


def peaks(images):
    """The mean of the largest hundredth of the powers, relative to the mean of all powers."""
    powers = np.abs(np.fft.fft2(images - images.mean((1, 2), keepdims=True))).reshape(len(images), -1) ** 2
    return np.sort(powers)[:, -PEAKS:].mean(1) / np.maximum(powers.mean(1), 1e-30)  # an image without errors has no peaks


# ---- Measures: each a generator of (row, integrand images, blurs) of one run

SIGMAS = {"": (2.1, 2.1), ", sigma 1.0": (1.0, 1.0), ", single pixels": (0, 0)}


def with_sigmas(row, images):
    return [(row + ending, images, sigma) for ending, sigma in SIGMAS.items()]


def images_of_run(draw, run, counts):
    """Yields (row, images, blurs) of every integrand."""
    samples = [np.moveaxis(draw(run, counts[-1], member), -1, 0) for member in range(4)]
    for period, member in itertools.product((0, 64, 24), range(4)):
        r = np.random.default_rng([run, member, period, 5])
        u = samples[member]
        for _ in range(6):
            first, second = Plane(r, period), Plane(r, period)
            inside = first(u[0], u[1]), second(u[2], u[3])
            name = f"half-planes, period {period}" if period else "half-planes"
            for pair, plane in enumerate((first, second)):
                images = error_images(inside[pair], plane.mean, counts)
                yield from with_sigmas(name, images)
                yield f"peaks, member {member}, pair {pair}{', drifting' if period else ''}", images, None
            images = error_images(inside[0] & inside[1], first.mean * second.mean, counts)
            yield from with_sigmas(f"products of both pairs{f', period {period}' if period else ''}", images)
    for member, other in itertools.combinations(range(4), 2):
        r = np.random.default_rng([run, member, other, 6])
        for k in range(4):
            first, second = Plane(r), Plane(r)
            values = first(*samples[member][2 * (k & 1):][:2]) & second(*samples[other][2 * (k >> 1):][:2])
            yield from with_sigmas("products of two members", error_images(values, first.mean * second.mean, counts))
    r = np.random.default_rng([run, 7])
    for k in range(24):
        d, c = k % 2, np.float32((k // 2 + r.uniform()) / 12)
        images = error_images(samples[0][d] < c, c, counts)
        yield "edges along the pixel's sides", images, (2.1, 0) if d == 0 else (0, 2.1)
    for k in range(16):  # edges that lean slightly
        member, angle = k % 4, np.arctan(r.uniform(.03, .1) * (-1)**(k // 4)) + np.pi / 2 * (k // 8)
        a, b = np.cos(angle), np.sin(angle)
        c = a * r.uniform() + b * r.uniform()
        values = np.float32(a) * samples[member][0] + np.float32(b) * samples[member][1] < np.float32(c)
        yield "edges that lean", error_images(values, half_space((a, b), c), counts), (2.1, 2.1)
    for k in range(24):
        member, d = k % 4, k // 4 % 4
        c = np.clip(r.uniform(.05, .95) + drift(r, (0, 64)[k % 2]) * .7, 0, 1).astype(np.float32)
        yield from with_sigmas("single numbers", error_images(samples[member][d] < c[..., None], c, counts))
    for member, chosen in itertools.product(range(4), (2, 3)):
        u = samples[member]
        for _ in range(4):
            share, first, second = r.uniform(.25, .75), Plane(r), Plane(r)
            values = np.where(u[chosen] < np.float32(share), first(u[0], u[1]), second(u[0], u[1]))
            images = error_images(values, share * first.mean + (1 - share) * second.mean, counts)
            yield f"choice by u[{chosen}], then a pair", images, (2.1, 2.1)
    for _ in range(48):  # pixel position, and time or lens
        angle, speed = r.uniform(0, 2 * np.pi), 16 * r.uniform(.1, 1)
        a, b = np.cos(angle), np.sin(angle)
        e = speed * np.cos(r.uniform(0, 2 * np.pi))
        c = a * r.uniform(16, 48) + b * r.uniform(16, 48) + e / 2
        u, at = samples[0], c - a * X - b * Y
        values = np.float32(a) * u[0] + np.float32(b) * u[1] + np.float32(e) * u[2] < at[..., None].astype(np.float32)
        yield "edges that move", error_images(values, half_space((a, b, e), at, 1e-3), counts), (2.1, 2.1)


def images_at_every_count(draw, run, counts):
    """Like images_of_run(), but only for half-planes and products of two, which leaves time for thousands of samples."""
    u, r = np.moveaxis(draw(run, counts[-1], run % 4), -1, 0), np.random.default_rng([run, 9])
    for _ in range(6):
        first, second = Plane(r), Plane(r)
        inside = first(u[0], u[1])
        for name, values, mean in (("half-planes", inside, first.mean), ("products of both pairs", inside & second(u[2], u[3]), first.mean * second.mean)):
            images = error_images(values, mean, counts)
            yield name, images, (2.1, 2.1)
            yield f"{name}, single pixels", images, (0, 0)


def images_of_pairs(draw, run, counts):
    """Half-planes over each pair of a domain's four numbers."""
    u, r = np.moveaxis(draw(run, counts[-1], run % 4), -1, 0), np.random.default_rng([run, 10])
    for plane in [Plane(r) for _ in range(12)]:
        for a, b in itertools.combinations(range(4), 2):
            images = error_images(plane(u[a], u[b]), plane.mean, counts)
            yield f"({a},{b})", images, (2.1, 2.1)
            yield f"({a},{b}), domain {run % 4}", images, (2.1, 2.1)


def measure(draw, runs, counts=COUNTS, one_count=False, images_of=images_of_run):
    """{row: root mean squares, or mean peaks, at all counts}."""
    found = {}
    for run in range(1, runs + 1):
        for some in [(n,) for n in counts] if one_count else [counts]:
            at = counts.index(some[0])
            for row, images, sigma in images_of(draw, run, some):
                sums = found.setdefault(row, np.zeros((2, len(counts))))
                sums[0, at:at + len(some)] += peaks(images) if sigma is None else mean_square(images, *sigma)
                sums[1, at:at + len(some)] += 1
    return {row: sums[0] / sums[1] if row.startswith("peaks") else np.sqrt(sums[0] / sums[1]) for row, sums in found.items()}


# ---- The image, and the rows of the page

def patterns():
    """Images of a constant and a slowly drifting half-plane at 1 and 4 samples, enlarged by a factor of two."""
    draws = {"white noise": of_library("white"), "blue": of_library("blue"), "Z-order": of_library("zorder"), "global Sobol'": global_sobol}
    cells = []
    for period, count in itertools.product((0, 128), (1, 4)):
        cells.append([])
        for draw in draws.values():
            plane = Plane(np.random.default_rng(3), period)
            u = np.moveaxis(draw(5, count, 1), -1, 0)
            shade = np.uint8(255 * (plane(u[0], u[1]).mean(-1) * .8 + .1))
            cells[-1].append(grey(np.kron(shade, np.ones((2, 2), np.uint8))))
    names = [f"{'drifting' if period else 'constant'}\n{count} sample{'s' * (count > 1)}" for period, count in itertools.product((0, 1), (1, 4))]
    return sheet(cells, names, list(draws))


def summarised(found):
    """Merges the peak rows of all members and pairs into their maximum."""
    rows, largest = {}, {}
    for row, values in found.items():
        if row.startswith("peaks"):
            name = "spectral peaks, the largest of any pair" + ", drifting" * row.endswith("drifting")
            largest[name] = np.maximum(values, largest.get(name, 0))
        else:
            rows[row] = values
    return {**rows, **largest}
