# SPDX-License-Identifier: Apache-2.0
"""Tests BLUE's domains over many keys, and pairs of domains from different families: means converge to the integral, and samples are
practically independent. Everything is seeded; false-alarm rates are for fresh seeds. Run with -s to print all figures."""

import itertools

import numpy as np
import pytest
from conftest import blur_gain, plane_at_angle

import bluenoise
from bluenoise._core import domain_child, path_ray_domain, stream_domain

ndimage = pytest.importorskip("scipy.ndimage")

# Each family's shift and reflection of the tile: the position of pixel (0, 0) as 64 row + column, and the reflections from bit 12.
VIEWS = """
#include <bn/bn_draw.h>
void views(const uint32_t *words, const uint32_t *seeds, const uint32_t *domains, uint32_t *found, int count) {
    for (int i = 0; i < count; ++i) {
        const bn_uint2 seed = {seeds[2 * i], seeds[2 * i + 1]};
        const uint32_t at = bn_draw_blue_pixel(words, seed, 0, 0, domains[i]).at;
        const uint32_t right = bn_draw_blue_pixel(words, seed, 1, 0, domains[i]).at - at;
        const uint32_t below = bn_draw_blue_pixel(words, seed, 0, 1, domains[i]).at - at;
        found[i] = at | ((right & 63) != 1) << 12 | ((below >> 6 & 63) != 1) << 13;
    }
}"""


def plane(number):
    """A half-plane at a well-spread angle, through a well-spread point near the middle."""
    x, y = (0.25 + 0.5 * (share * number % 1) for share in (0.7548776662466927, 0.5698402909980532))
    return plane_at_angle(x, y, 2.3999632297286533 * (number + 0.3))


def inside(half_plane, u, pair):
    a, b, c, _ = half_plane
    return a * u[..., 2 * pair].astype(float) + b * u[..., 2 * pair + 1] < c


# The factors of each product, as (member, pair). Members are counted from a first member; NEXT is member 0 of the next family.
NEXT = 4
PRODUCTS = {"one pair": [(0, 0)], "both pairs": [(0, 0), (0, 1)], "two members": [(0, 0), (1, 1)],
            "three members": [(0, 0), (1, 1), (2, 0)], "four members": [(0, 0), (1, 1), (2, 0), (3, 1)],
            "two families": [(0, 0), (NEXT, 0)]}


def test_means_over_keys_are_unbiased():
    """Averages each of 12 products over 2^20 keys, at two indices. Over keys, each sample is jointly uniform in both pairs, all members and
    two families, so the sum of z squared is chi-square with 24 degrees of freedom. It exceeds 74 with probability 5e-7."""
    sampler, key, squares = bluenoise.Sampler("blue", seed=31), np.arange(2**20, dtype=np.uint32), dict.fromkeys(PRODUCTS, 0.0)
    for k, (i, index) in itertools.product(range(12), enumerate((0, 5))):
        parent = domain_child(2 * k + i, 4 * key)
        samples = [sampler.sample(5, 9, index, domain_child(parent, child)) for child in range(5)]
        planes = [plane(4 * k + factor) for factor in range(4)]
        for name, factors in PRODUCTS.items():
            chosen, mean = True, 1.0
            for half_plane, (member, pair) in zip(planes, factors):
                chosen = chosen & inside(half_plane, samples[NEXT if member == NEXT else (k + member) % 4], (k // 4 + pair) % 2)
                mean *= half_plane[3]
            squares[name] += (chosen.sum() - key.size * mean) ** 2 / (key.size * mean * (1 - mean))
    print(f"\n{squares}")
    assert max(squares.values()) < 74


# ---- Domains of different families

@pytest.fixture(scope="module")
def views(compiled):
    """function(seed words (..., 2), domains (...)) -> the tile's shifts and reflections."""
    function = compiled(VIEWS).views

    def views(seeds, domains):
        found = np.empty(domains.shape, np.uint32)
        seeds = np.broadcast_to(np.asarray(seeds, np.uint32), (*domains.shape, 2))
        words = [np.ascontiguousarray(array, np.uint32) for array in (bluenoise.tables(), seeds, domains)]
        function(*(array.ctypes for array in (*words, found)), found.size)
        return found

    return views


def test_first_families_have_different_shifts(views):
    """A parent's first thirty families have different shifts along x. Parents are the root and rays, with many seeds and frames, including
    two for which an earlier version gave two families the same shift."""
    run = np.arange(4096)
    seeds = np.array([bluenoise.Sampler("blue", seed=seed).seed_words() for seed in (1377, *range(4096 // 7 + 1))])
    root = stream_domain(np.where(run == 0, 0, np.where(run == 1, 122, run)).astype(np.uint32))
    parent = np.where((run < 2) | (run % 2 == 0), root, path_ray_domain(root, (run // 2 % 8).astype(np.uint32)))
    domains = domain_child(parent[:, None].astype(np.uint32), 4 * np.arange(30, dtype=np.uint32))
    found = views(seeds[np.where(run == 0, 0, 1 + run // 7)][:, None], domains)
    shifts = np.sort((found + (found >> 12 & 1)) & 63, 1)
    assert (np.diff(shifts, axis=1) > 0).all()


COUNTS = np.array([1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64])


def product_errors(sampler, domains, number):
    """Errors for f g, where f and g are half-planes minus their means, so that f g averages to zero if samples are independent. Returns
    mean squares (2, COUNTS) over an image, raw and after a blur (sigma = 2.1), relative to white noise."""
    values, variance = 1.0, 1.0
    for d, domain in enumerate(domains):
        half_plane = plane(2 * number + d)
        values = values * (inside(half_plane, sampler.block(0, 0, 64, 64, 0, 64, int(domain)), number >> d & 1) - half_plane[3])
        variance *= half_plane[3] * (1 - half_plane[3])
    errors = values.cumsum(2)[..., COUNTS - 1] / COUNTS
    blurred = ndimage.gaussian_filter(errors, (2.1, 2.1, 0), truncate=7 / 2.1)[7:-7, 7:-7]
    return np.array([(errors**2).mean((0, 1)), (blurred**2).mean((0, 1)) / blur_gain(2.1)]) * COUNTS / variance


@pytest.mark.parametrize(("relation", "raw", "blurred"), [
    ("any shifts", 1.20, 1.26), ("same shift", 1.20, 2.40), ("same shift and member", 1.20, 3.40), ("neighbouring shifts", 1.22, 1.34)])
def test_products_over_two_families(views, relation, raw, blurred):
    """Errors, raw and after a blur, are relative to white noise; independent SOBOL sequences have 1.14 and 1.15. If all pixels and families
    had the same order, errors at 64 samples would be 1.54 and 1.63 for arbitrary families, 1.63 and 10.6 for families with the same shift,
    and 1.53 and 2.41 for families with neighbouring shifts. One in 2^14 pairs of families has the same shift, but no two of a parent's
    first thirty families do. With the same shift, the samples of the two families differ by the same digits in all pixels of a copy, so a
    blur removes less of their error than of white noise."""
    sampler, squares, first = bluenoise.Sampler("blue", seed=33), [], {}
    parents = np.random.default_rng(2).integers(0, 2**32, 8192, np.uint32)
    for family, view in enumerate(views(sampler.seed_words(), domain_child(parents, 0)).tolist()):
        # Neighbouring shifts differ by one to the right or downwards.
        beside = view & ~63 | (view + 1) & 63 if family % 2 == 0 else view & ~0xFC0 | (view + 64) & 0xFC0
        other = family - 1 if relation == "any shifts" else first.get(beside if relation == "neighbouring shifts" else view, -1)
        first[view] = family
        if other >= 0:
            number = len(squares)
            members = number % 4, (number + (0 if "member" in relation else number // 4)) % 4
            domains = [domain_child(int(parents[at]), member) for at, member in zip((other, family), members)]
            squares.append(product_errors(sampler, domains, number))
            if len(squares) == 96:
                break
    found = np.sqrt(np.mean(squares, 0))
    print(f"\n{relation}: raw {found[0].round(3)}, blurred {found[1].round(3)}")
    assert len(squares) == 96 and (found[0] < raw).all() and (found[1] < blurred).all()
