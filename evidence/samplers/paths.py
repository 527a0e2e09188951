# SPDX-License-Identifier: Apache-2.0
"""Ways to draw the harder decisions of a path: `scripts/bench paths` measures what docs/paths.md advises

It draws with the Python package. Every experiment is a small integrand, the same in all pixels, with several ways to draw its
numbers. The tables go to evidence/results/paths.md.
"""

import itertools

import numpy as np

import bluenoise

from ..base.command import Parser
from ..base.tables import md_table, write_or_print
from ..measure.image_error import rmse

COMMAND = "scripts/bench paths"
SIZE, SIGMA = 128, 2.1
COUNTS = (1, 4, 16)
INTEGRANDS = 6


def paths(kind, seed, index, size=SIZE):
    y, x = np.mgrid[0:size, 0:size]
    return bluenoise.PathSampler(bluenoise.Sampler(kind, seed=seed), x, y, index)


def half_planes(rng, count):
    """Random half-planes that cut the unit square: (count, 3), a u + b v < c."""
    angle = rng.uniform(0, 2 * np.pi, count)
    normal = np.stack([np.cos(angle), np.sin(angle)], -1)
    return np.column_stack([normal, np.sum(normal * rng.uniform(0.2, 0.8, (count, 2)), -1)])


def inside(plane, pair):
    """Of one half-plane, or of one for each pair."""
    plane = np.asarray(plane, np.float32)
    return pair[..., 0] * plane[..., 0] + pair[..., 1] * plane[..., 1] < plane[..., 2]


# ---- The experiments: {way: function(rng) -> function(path) -> values}. All ways of one estimate the same integral.

def lights(rng):
    """A light and a point on it: 12 lights of unequal power, each half hidden by an edge of its own."""
    power = rng.uniform(0.2, 2, 12)
    cdf = np.cumsum(power / power.sum()).astype(np.float32)
    edges = half_planes(rng, 12)

    def one_pair(path):
        draw = path.ray(0).draw_end_light()
        light, u = bluenoise.choose_cdf(cdf, draw[..., 0])
        return inside(edges[light], np.stack([u, draw[..., 1]], -1))

    def with_number(number, pair):
        return inside(edges[bluenoise.choose_cdf(cdf, number)[0]], pair)

    # Vose's table: a column, then one of two lights; the rest of the number is stretched.
    share, other = np.array(power / power.sum() * 12), np.arange(12)
    small, large = [i for i in range(12) if share[i] < 1], [i for i in range(12) if share[i] >= 1]
    while small and large:
        i, k = small.pop(), large[-1]
        other[i] = k
        share[k] -= 1 - share[i]
        if share[k] < 1:
            small.append(large.pop())

    def alias(path):
        draw = path.ray(0).draw_end_light()
        column, u = bluenoise.choose_u32(12, draw[..., 0])
        own = np.clip(share, 0, 1).astype(np.float32)[column]
        stays = u < own
        rest = np.where(stays, u / np.maximum(own, 1e-9), (u - own) / np.maximum(1 - own, 1e-9))
        return inside(edges[np.where(stays, column, other[column])], np.stack([rest, draw[..., 1]], -1))

    return {"one pair, from a table in order": one_pair,
            "a number and a pair of one domain": lambda path: with_number((draw := path.ray(0).next_4d())[..., 2], draw[..., :2]),
            "a number and a pair of two domains": lambda path: with_number(path.ray(0).next_1d(), path.ray(0).draw_end_light()),
            "one pair, from an alias table": alias}


def environment_map(rng):
    """A map of 64 x 32 texels, a sky with a sun, a part of it hidden by an edge."""
    width, height = 64, 32
    y, x = np.mgrid[0:height, 0:width]
    sun = rng.uniform(0.2, 0.8, 2) * (width, height)
    sky = 1 + np.cos(2 * np.pi * (x / width - rng.uniform())) + 2 * y / height
    radiance = sky + 60 * np.exp(-((x - sun[0]) ** 2 + (y - sun[1]) ** 2) / 8)
    # A table for each row, one for the rows, one for all texels.
    columns = np.cumsum(radiance, 1).astype(np.float32)
    rows, flat = np.cumsum(radiance.sum(1)).astype(np.float32), np.cumsum(radiance.ravel()).astype(np.float32)
    edge = half_planes(rng, 1)[0]

    def seen(column, row):
        return inside(edge, np.stack([column / width, row / height], -1))

    def row_and_column(path):
        draw = path.ray(0).draw_end_light()
        row, v = bluenoise.choose_cdf(rows, draw[..., 1])
        column, u = np.empty_like(row), np.empty_like(v)
        for i in np.unique(row):
            at = row == i
            column[at], u[at] = bluenoise.choose_cdf(columns[i], draw[..., 0][at])
        return seen(column + u, row + v)

    def one_search(path):
        draw = path.ray(0).draw_end_light()
        texel, u = bluenoise.choose_cdf(flat, draw[..., 0])
        return seen(texel % width + u, texel // width + draw[..., 1])

    return {"the row with u[1], the column with u[0]": row_and_column, "one search over all texels with u[0]": one_search}


def disc(pair):
    """The concentric map: (..., 2)."""
    a, b = 2 * pair[..., 0] - 1, 2 * pair[..., 1] - 1
    wide = np.abs(a) > np.abs(b)
    r, other = np.where(wide, a, b), np.where(wide, b, a)
    phi = np.pi / 4 * np.divide(other, r, out=np.zeros_like(r), where=r != 0)
    phi = np.where(wide, phi, np.pi / 2 - phi)
    return np.stack([r * np.cos(phi), r * np.sin(phi)], -1)


def coin(rng):
    """One direction of a surface, in the plane, from its lobe or to one of six lights that are half hidden, behind an edge that moves
    with the position in the pixel. Divided by the mean of both densities."""
    middle, power = rng.uniform(-0.6, 0.6, (6, 2)), rng.uniform(0.5, 2, 6)
    middle, half = middle[np.argsort(middle[:, 0])], rng.uniform(0.05, 0.25, (6, 2))
    share = power * half.prod(1) / np.sum(power * half.prod(1))
    cdf, edges = np.cumsum(share).astype(np.float32), half_planes(rng, 6)
    sharp, lobe, shift = rng.choice([1.0, 1.5, 2.0]), rng.uniform(-0.2, 0.2, 2), rng.uniform(-0.4, 0.4, 2)

    def estimate(path, to_light, light, point, lobe_point):
        """Of points in the squares of the light and the lobe."""
        at = disc(lobe_point)
        by_lobe = lobe + at * np.hypot(at[..., 0], at[..., 1])[..., None] ** (sharp - 1)
        direction = np.where(to_light[..., None], middle[light] + (2 * point - 1) * half[light], by_lobe)
        r = np.maximum(np.hypot(*np.moveaxis(direction - lobe, -1, 0)), 1e-9)
        lobe_density = np.where(r < 1, r ** (2 / sharp - 2) / (np.pi * sharp), 0)
        light_density, found, moved = 0, 0, path.ray(0).draw_direction() @ shift
        for i in range(6):
            place = (direction - middle[i]) / (2 * half[i]) + 0.5
            met = np.all((place >= 0) & (place < 1), -1)
            light_density = light_density + met * share[i] / (4 * half[i].prod())
            found = found + met * (place @ edges[i, :2] < edges[i, 2] + moved) * power[i]
        return 2 * found * lobe_density / (0.5 * lobe_density + 0.5 * light_density)

    def one_pair(path):
        draw = path.ray(1).draw_direction()
        to_light, u = bluenoise.choose(0.5, draw[..., 0])
        light, rest = bluenoise.choose_cdf(cdf, u)
        return estimate(path, to_light, light, np.stack([rest, draw[..., 1]], -1), np.stack([u, draw[..., 1]], -1))

    def with_coin(path, draw, number):
        light, rest = bluenoise.choose_cdf(cdf, draw[..., 0])
        return estimate(path, number < 0.5, light, np.stack([rest, draw[..., 1]], -1), draw[..., :2])

    def third_and_fourth(path):
        draw = path.ray(1).draw()
        return estimate(path, draw[..., 2] < 0.5, bluenoise.choose_cdf(cdf, draw[..., 3])[0], draw[..., :2], draw[..., :2])

    def all_apart(path):
        ray = path.ray(1)
        to_light, light = ray.next_1d() < 0.5, bluenoise.choose_cdf(cdf, ray.next_1d())[0]
        return estimate(path, to_light, light, ray.next_2d(), ray.draw_direction())

    return {"coin and light with u[0], one after the other": one_pair,
            "the coin with u[2], the light with u[0]": lambda path: with_coin(path, draw := path.ray(1).draw(), draw[..., 2]),
            "the coin with u[2], the light with u[3]": third_and_fourth,
            "the coin with `next_1d()`, the light with u[0]": lambda path: with_coin(path, path.ray(1).draw_direction(), path.ray(1).next_1d()),
            "coin and light with `next_1d()`, the point with `next_2d()`": all_apart}


def light_tree(rng):
    """A light tree of six levels: 64 lights in a row, each half hidden."""
    left = rng.uniform(0.3, 0.7, 64).astype(np.float32)
    edges = half_planes(rng, 64)

    def descend(path, apart):
        ray, node = path.ray(0), np.zeros(path.shape, np.int64)
        pair = ray.draw_end_light()
        u = pair[..., 0]
        for level in range(6):
            u, probability = ray.next_1d() if apart else u, left[(2**level + node) % 64]
            low = u < probability
            rest = np.where(low, u / probability, (u - probability) / (1 - probability))
            node, u = 2 * node + ~low, np.minimum(rest, np.float32(1 - 2.0**-24))
        return inside(edges[node], pair if apart else np.stack([u, pair[..., 1]], -1))

    return {"one number all the way down, the rest for the point": lambda path: descend(path, False),
            "a number for each level, a pair for the point": lambda path: descend(path, True)}


def density(t):
    return 0.6 + 0.4 * np.sin(7 * t)


def free_flight(rng):
    """Does a ray cross a medium whose density varies? Optical depth 2, by delta tracking."""
    most = np.float32(2 / np.mean(density(np.linspace(0, 1, 1001))) * rng.uniform(0.8, 1.2))
    depth = most * np.cumsum(density((np.arange(1000) + 0.5) / 1000) / 1000)

    def track(path, numbers):
        t, alive, crossed = np.zeros(path.shape, np.float32), np.ones(path.shape, bool), np.zeros(path.shape, bool)
        for _ in range(40):
            t = t - np.log1p(-numbers()) / most
            crossed |= alive & (t >= 1)
            alive &= t < 1
            alive &= ~(numbers() < density(t))
        return crossed

    generator = np.random.default_rng(5)
    return {"one number, inverted": lambda path: path.ray(0).next_1d() < np.exp(-np.float32(depth[-1])),
            "`next_loop()`: four stratified, then a generator": lambda path: track(path, path.ray(0).next_loop().next_1d),
            "a number of the sampler for each step": lambda path: track(path, path.ray(0).next_1d),
            "a generator alone": lambda path: track(path, lambda: generator.random(path.shape, np.float32))}


def random_walk(rng):
    """A walk below a surface: does it leave, and on which side of an edge?"""
    edge = half_planes(rng, 1)[0] - [0, 0, 0.5]

    def walk(path, numbers, first=None):
        place = np.zeros((*path.shape, 3), np.float32)
        alive, left = np.ones(path.shape, bool), np.zeros(path.shape, bool)
        for step in range(12):
            a, b, c = np.moveaxis(first, -1, 0)[:3] if step == 0 and first is not None else (numbers(), numbers(), numbers())
            z = 1 - (a if step == 0 else 2 * a)  # down at first, then anywhere
            r, phi = np.sqrt(np.maximum(1 - z * z, 0)), 2 * np.pi * b
            length = -np.log1p(-c)
            place += (length[..., None] * np.stack([r * np.cos(phi), r * np.sin(phi), z], -1)) * alive[..., None]
            left |= alive & (place[..., 2] < 0)
            alive &= (place[..., 2] >= 0) & (numbers() < 0.9)
        return left & inside(edge, place[..., :2])

    def stratified(path):
        ray = path.ray(0)
        numbers = ray.next_loop().next_1d
        return walk(path, numbers, ray.next_4d())

    generator = np.random.default_rng(6)
    return {"first step from `next_4d()`, then `next_loop()`": stratified,
            "all of it from `next_loop()`": lambda path: walk(path, path.ray(0).next_loop().next_1d),
            "a number of the sampler for each decision": lambda path: walk(path, path.ray(0).next_1d),
            "a generator alone": lambda path: walk(path, lambda: generator.random(path.shape, np.float32))}


def transparency(rng):
    """Two leaves of different colours, each seen with a probability, in another order from pixel to pixel. What the order changes is not
    noise: each pixel's own mean is subtracted."""
    alpha, color = rng.uniform(0.3, 0.7, 2), np.array([1.0, 0.35])
    leaves = (np.random.default_rng(7).random((SIZE, SIZE)) < 0.5).astype(int)  # in front

    def first_seen(path, numbers):
        """numbers(front): those of the leaves in front and behind."""
        front = leaves[:path.shape[-2], :path.shape[-1]]
        back = 1 - front
        near, far = numbers(front)
        seen = np.where(near < alpha[front], color[front], np.where(far < alpha[back], color[back], 0))
        return seen - (color[front] * alpha[front] + (1 - alpha[front]) * alpha[back] * color[back])

    def by_leaf(path):
        one, other = (path.ray(0).child(1000 + leaf).draw_direction()[..., 0] for leaf in (0, 1))
        return first_seen(path, lambda front: (np.where(front, other, one), np.where(front, one, other)))

    def by_order(path):
        ray = path.ray(0)
        return first_seen(path, lambda front: (ray.next_1d(), ray.next_1d()))

    return {"a number for each leaf, by key": by_leaf, "numbers in the order of intersection": by_order}


def moving_edge(rng):
    """function(where, time): whether an edge that moves across the pixel while the shutter is open covers the place."""
    edge, speed = half_planes(rng, 1)[0], rng.uniform(0.5, 1.5)
    return lambda where, time: inside(edge, where - np.stack([(time - 0.5) * speed, 0 * time], -1).astype(np.float32))


def time_alone(rng):
    covered = moving_edge(rng)
    return {"time from the second pair of ray 0": lambda path: covered((draw := path.ray(0).draw())[..., :2], draw[..., 2]),
            "time from `time_wavelength()`": lambda path: covered(path.ray(0).draw_direction(), path.time_wavelength()[..., 0]),
            "time from `next_1d()`": lambda path: covered(path.ray(0).draw_direction(), path.ray(0).next_1d())}


def time_and_lens(rng):
    """The same edge, out of focus."""
    covered, blur = moving_edge(rng), rng.uniform(0.5, 1.5)

    def blurred(where, lens, time):
        r, phi = np.sqrt(lens[..., 0]), 2 * np.pi * lens[..., 1]
        return covered(where + blur * np.stack([r * np.cos(phi), r * np.sin(phi)], -1), time)

    def second_pair(path, time):
        draw = path.ray(0).draw()
        return blurred(draw[..., :2], draw[..., 2:], time)

    return {"lens from the second pair of ray 0, time from `time_wavelength()`": lambda path: second_pair(path, path.time_wavelength()[..., 0]),
            "lens from the second pair of ray 0, time from `next_1d()`": lambda path: second_pair(path, path.ray(0).next_1d()),
            "lens and time from `next_4d()`": lambda path: blurred(
                path.ray(0).draw_direction(), (more := path.ray(0).next_4d())[..., 2:], more[..., 0])}


def wavelength(rng):
    """A spectrum with a narrow line, seen at four wavelengths 1/4 apart."""
    line, width = rng.uniform(0, 1), 0.06

    def four(w):
        return np.mean([np.exp(-(((w + k / 4) % 1 - line) / width) ** 2) for k in range(4)], 0)

    return {"w = (floor(4 v) + u) / 4": lambda path: four((np.floor(4 * (time := path.time_wavelength())[..., 0]) + time[..., 1]) / 4),
            "w = u": lambda path: four(path.time_wavelength()[..., 1])}


def splits(rng):
    """About four light samples for each camera ray: an edge seen from the light, shaded by where the camera ray went. Where
    their number varies, brighter paths take more."""
    edge, shade = half_planes(rng, 1)[0], rng.uniform(0.3, 1, 2)
    domains, taken = itertools.count(1000), [0]

    def weight(path):
        where = path.ray(0).draw_direction()
        return 0.5 + shade[0] * where[..., 0] + shade[1] * where[..., 1]

    def varying(path):
        """2 to 6."""
        return np.floor(2 + 4.99 * (weight(path) - 0.5) / shade.sum())

    def estimate(path, number, ray):
        """ray(k): the one that draws light sample k."""
        return weight(path) * sum((k < number) * inside(edge, ray(k).draw_direction()) for k in range(6)) / number

    def split(path, most, number):
        branches = path.ray(0).next_split(most)
        return estimate(path, number, lambda k: branches[k].ray(0))

    def running(path, index):
        first, number = taken[0] if index else np.zeros(path.shape, np.int64), varying(path)
        branches, taken[0] = path.ray(0).next_split_from(first), first + number.astype(np.int64)
        return estimate(path, number, lambda k: branches[k].ray(0))

    def own_domain(path):
        domain = next(domains)
        return estimate(path, varying(path), lambda k: paths("blue", domain, k, path.shape[0]).ray(1))

    return {"four branches of `next_split(4)`": lambda path: split(path, 4, np.float32(4)),
            "two to six of `next_split(4)`": lambda path: split(path, 4, varying(path)),
            "two to six of `next_split(8)`": lambda path: split(path, 8, varying(path)),
            "two to six of `next_split_from(taken)`": running,
            "two to six, a domain for each path": own_domain,
            "two to six, a domain for each branch": lambda path: estimate(path, varying(path), path.ray(0).child)}


EXPERIMENTS = {"lights": lights, "environment map": environment_map, "coin": coin, "light tree": light_tree, "free flight": free_flight,
               "random walk": random_walk, "transparency": transparency, "time": time_alone, "time and lens": time_and_lens,
               "wavelength": wavelength, "splitting": splits}


def measure(experiment, seeds, kind="blue", size=SIZE):
    """{way: {count: error}}: root mean squares over integrands and seeds, after the blur."""
    squares = {}
    for integrand in range(INTEGRANDS):
        ways = experiment(np.random.default_rng(100 + integrand))
        for seed in range(seeds):
            for way, values in ways.items():
                sums, total = np.zeros((size, size)), {}
                for index in range(max(COUNTS)):
                    path = paths(kind, 10 * integrand + seed, index, size)
                    sums += values(path, index) if values.__code__.co_argcount == 2 else values(path)
                    if index + 1 in COUNTS:
                        total[index + 1] = sums / (index + 1)
                # All ways estimate one integral: the mean over pixels and samples of the most samples.
                squares.setdefault(way, []).append(total)
    truth = [np.mean([np.mean(squares[way][i][max(COUNTS)]) for way in squares]) for i in range(INTEGRANDS * seeds)]
    return {way: {count: float(np.sqrt(np.mean([rmse(total[count], np.full((size, size), truth[i]), SIGMA, "toroidal") ** 2
                                                for i, total in enumerate(totals)]))) for count in COUNTS}
            for way, totals in squares.items()}


def table(name, seeds):
    """Errors over those of white noise drawn in the first way: lower is better."""
    experiment = EXPERIMENTS[name]
    found = measure(experiment, seeds)
    first = next(iter(found))
    white = measure(lambda rng: {first: experiment(rng)[first]}, seeds, "white")[first]
    return md_table([f"{name}: how it is drawn", *(f"{count} spp" for count in COUNTS)],
                    [[way, *(f"{row[count] / white[count]:.2f}" for count in COUNTS)] for way, row in found.items()])


def run(arguments):
    parser = Parser("paths", __doc__)
    parser.number("--seeds", 2, "seeds of each integrand")
    parser.table("evidence/results/paths.md")
    options = parser.parse_args(arguments)
    for name in EXPERIMENTS:
        write_or_print(options, f"{COMMAND}: {name}", table(name, options.seeds))
