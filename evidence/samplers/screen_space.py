# SPDX-License-Identifier: Apache-2.0
"""The screen-space error of a sampler.

An integrand has the same form in every pixel of a picture. The image of per-pixel errors at n samples is blurred with a Gaussian, and
its RMSE taken inside a margin that the blur does not reach over; with sigma inf it is the error of the whole picture's mean. One run of
a sampler is stopped at every count; zorder, which is made for one count, gets a run of its own for each. The protocol is that of Heitz
and Belcour, "Distributing Monte Carlo Errors as a Blue Noise in Screen Space by Permuting Pixel Seeds Between Frames", 2019, widened.
"""

import functools
import math
import subprocess
import sys

import numpy as np
from scipy.special import erf

import bluenoise

SIZE, DOMAINS, INTEGRANDS, MARGIN = 128, 16, 48, 8
PLACES, MEMBERS, SINGLE, OTHER_FAMILY = 6, 4, 4, 5
COUNTS = (1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 128, 256)
SIGMAS = (2.1, 1.0, 0.0, math.inf)
OWN, DECLARED = ("white", "sobol", "zorder", "mask", "blue"), ("zorder",)
SIBLINGS = np.array([(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)])
K = np.arange(INTEGRANDS)


# ---- Samples

def draws(program, name, spp, domains=DOMAINS):
    """Yields float32 (pairs, 2, SIZE, SIZE, spp) of each domain: what the sampler draws, two pairs of numbers at each of PLACES: the members
    of the domain's family, single numbers of the first, and a member of another family of the same parent."""
    if name not in OWN:
        yield from others_draws(program, name, spp, domains)
        return
    for domain in range(domains):
        sampler = bluenoise.Sampler(name, seed=domain + 1, samples_per_pixel=spp if name in DECLARED else 0)
        first, *others = (bluenoise.domain(domain + 1, 4 * domain + key) for key in (0, 1, 2, 3, domain % MEMBERS + 4 * DOMAINS))
        *family, other = (sampler.block(0, 0, SIZE, SIZE, 0, spp, each) for each in (first, *others))
        places = (*family, family[0], other)  # single numbers are those of the first member
        yield np.concatenate([np.moveaxis(numbers, -1, 0).reshape(2, 2, SIZE, SIZE, spp) for numbers in places])


def others_draws(program, name, spp, domains):
    """The same of a sampler that libbn does not have, by the program bench_samplers."""
    try:
        process = subprocess.Popen([program, name, str(spp), str(domains)], stdout=subprocess.PIPE)
    except OSError as error:
        sys.exit(f"bench: cannot run {program} ({error.strerror}); build it with scripts/setup")
    with process:
        for _ in range(domains):
            samples = np.empty((2 * PLACES, 2, SIZE, SIZE, spp), np.float32)
            for row in range(SIZE):
                data = process.stdout.read(4 * PLACES * SIZE * spp * 4)
                if len(data) < 4 * PLACES * SIZE * spp * 4:
                    sys.exit(f"bench: {program} failed")
                numbers = np.frombuffer(data, np.float32).reshape(PLACES, SIZE, spp, 2, 2)
                samples[:, :, row] = numbers.transpose(0, 3, 4, 1, 2).reshape(2 * PLACES, 2, SIZE, spp)
            yield samples


# ---- Integrands: three numbers for each, and their means

def spread(points):
    """A low-discrepancy sequence of pairs."""
    return (0.5 + 0.7548776662466927 * points) % 1, (0.5 + 0.5698402909980532 * points) % 1


def half_planes(domain, other=0):
    """a x + b y < c at evenly spread angles, through well-spread points; a second set at other ones."""
    angle = 2 * np.pi * ((K * (1 + 6 * other) + 11 * other) % INTEGRANDS + 0.41) / INTEGRANDS
    a, b = np.cos(angle), np.sin(angle)
    x, y = spread(K + INTEGRANDS * (domain + DOMAINS * other))
    c, columns = a * x + b * y, (np.arange(4096) + 0.5) / 4096
    below = np.clip((c[:, None] - np.outer(a, columns)) / b[:, None], 0, 1).mean(1)
    return np.stack([a, b, c], -1).astype(np.float32), np.where(b > 0, below, 1 - below)


def steps(domain):
    """x < c and y < c in turn, at irrational places: nets are exact at multiples of 1/16."""
    c = (0.2 + 0.6180339887498949 * (K // 2 + INTEGRANDS // 2 * domain)) % 1
    return np.stack([K % 2 == 0, K % 2 == 1, c], -1).astype(np.float32), c


def discs(domain):
    """(x - a)^2 + (y - b)^2 < c, within the square."""
    r = 0.1 + 0.35 * (K + 0.5) / INTEGRANDS
    a, b = (r + (1 - 2 * r) * place for place in spread(K + INTEGRANDS * domain))
    return np.stack([a, b, r * r], -1).astype(np.float32), np.pi * r * r


def bumps(domain):
    """exp(-c ((x - a)^2 + (y - b)^2))."""
    sigma = 0.1 + 0.3 * (K + 0.5) / INTEGRANDS
    places, scale = spread(K + INTEGRANDS * domain), sigma * math.sqrt(2)
    means = [sigma * math.sqrt(math.pi / 2) * (erf((1 - place) / scale) + erf(place / scale)) for place in places]
    return np.stack([*places, 0.5 / sigma**2], -1).astype(np.float32), means[0] * means[1]


def in_half_plane(a, b, c, x, y):
    return a * x + b * y < c


def in_disc(a, b, c, x, y):
    return (x - a) ** 2 + (y - b) ** 2 < c


def of_bump(a, b, c, x, y):
    return np.exp(-c * ((x - a) ** 2 + (y - b) ** 2))


def rolled(made):
    return [np.roll(part, -(INTEGRANDS // 3), 0) for part in made]


def figures(domain):
    """{figure: (function, factors)} of a domain; a factor is what half_planes() and its like make, and the pair it looks at."""
    own, pairs, one, two = 2 * (domain % MEMBERS), K // 6 % 4, half_planes(domain), half_planes(domain, 1)
    first, second = 2 * SIBLINGS[K % 6].T
    return {
        "half-planes-01": (in_half_plane, [(one, own)]),
        "half-planes-23": (in_half_plane, [(one, own + 1)]),
        "products": (in_half_plane, [(one, own), (two, own + 1)]),
        "siblings": (in_half_plane, [(one, first + pairs % 2), (two, second + pairs // 2)]),
        "families": (in_half_plane, [(one, own + pairs % 2), (two, 2 * OTHER_FAMILY + pairs // 2)]),
        "singles": (in_half_plane, [(steps(domain), 2 * SINGLE + K // 2 % 2)]),
        "steps": (in_half_plane, [(steps(domain), 0)]),
        "discs": (in_disc, [(discs(domain), own)]),
        "smooth": (of_bump, [(bumps(domain), own)]),
        "smooth-products": (of_bump, [(bumps(domain), own), (rolled(bumps(domain)), own + 1)])}


# ---- Errors

def error_images(samples, counts, function, factors):
    """Yields (counts, SIZE, SIZE) of each integrand."""
    spp = samples.shape[-1]
    sums, rows = (np.arange(spp)[:, None] < counts).astype(np.float32), max(1, COUNTS[-1] // spp)  # so much fits into a cache
    for k in K:
        images = np.empty((len(counts), SIZE, SIZE), np.float32)
        for at in range(0, SIZE, rows):
            values = [function(*numbers[k], *samples[np.broadcast_to(pair, K.shape)[k], :, at:at + rows]) for (numbers, _), pair in factors]
            means = functools.reduce(np.multiply, values) @ sums / np.float64(counts)
            images[:, at:at + rows] = np.moveaxis(means - math.prod(mean[k] for (_, mean), _ in factors), -1, 0)
        yield images


@functools.cache
def blur(sigma):
    """The matrix that blurs a column of pixels, without a margin."""
    kernel = np.exp(-0.5 * (np.arange(-MARGIN, MARGIN + 1) / max(sigma, 1e-9)) ** 2)
    return sum(weight * np.eye(SIZE - 2 * MARGIN, SIZE, d) for d, weight in enumerate(kernel / kernel.sum())).astype(np.float32)


def rmse(images, down, across):
    """RMSE of images after blurs along columns and rows."""
    if math.inf in (down, across):
        return np.abs(images.mean((1, 2), np.float64))
    return np.sqrt(np.mean((blur(down) @ images @ blur(across).T) ** 2, (1, 2), np.float64))


def measure(program, name, counts=COUNTS, domains=DOMAINS):
    """{(figure, count, sigma): RMSE}: means over integrands and domains. Steps are blurred along their edge alone."""
    found = {}
    for told in [(n,) for n in counts] if name in DECLARED else [counts]:
        for domain, samples in enumerate(draws(program, name, told[-1], domains)):
            for figure, integrands in figures(domain).items():
                for k, images in enumerate(error_images(samples, told, *integrands)):
                    for sigma in SIGMAS:
                        down, across = (0.0 if figure == "steps" and k % 2 == way and sigma < math.inf else sigma for way in (1, 0))
                        for n, error in zip(told, rmse(images, down, across)):
                            found[figure, n, sigma] = found.get((figure, n, sigma), 0.0) + error / (INTEGRANDS * domains)
    return found
