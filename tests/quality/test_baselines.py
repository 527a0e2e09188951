# SPDX-License-Identifier: Apache-2.0
"""Tests SOBOL's scramblings and, for every sampler type, that samples, pixels, digits, domains and seeds are independent. Everything is
seeded; false-alarm rates are for fresh seeds."""

import typing

import numpy as np
import pytest

from bluenoise import Sampler, SamplerType, domain

every_type = pytest.mark.parametrize("type", typing.get_args(SamplerType))
Y, X = np.mgrid[:64, :64]


def digits(sampler, *where):
    """Returns samples (..., 4) as integers of 24 binary digits."""
    return (sampler.sample(*where) * 2.0**24).astype(np.uint32)


def test_sobol_scrambles_both_dimensions_of_a_pair():
    """Two of a pixel's first four samples have identical first digits in both dimensions of a pair. If both dimensions had the same
    scrambling, their second digits would also be identical in both samples or in neither. With independent scramblings, this happens half
    of the time. A limit of six deviations has a false-alarm rate below 1e-8."""
    u = digits(Sampler("sobol", seed=8), np.arange(4096)[:, None], 5, np.arange(4), 9)
    for pair in (0, 2):
        differ = (u[..., pair] ^ u[..., pair + 1]) >> 22
        chosen = differ < 2
        assert (chosen.sum(1) == 2).all()
        alike = (np.bitwise_xor.reduce(differ * chosen, axis=1) == 0).sum()
        assert abs(alike - 2048) < 6 * 32


@every_type
def test_samples_have_no_power_of_two_period(type):
    """No sampler type repeats after a power-of-two number of pixels, as identical tiles would."""
    sampler = Sampler(type, seed=3)
    x, y, index = X[:8, :8, None] - 3, Y[:8, :8, None] - 4, np.arange(4)
    here = sampler.sample(x, y, index, 77)
    for period in 64 * 4 ** np.arange(8):
        for dx, dy in ((period, 0), (0, period), (period, period)):
            assert not (here == sampler.sample(x + dx, y + dy, index, 77)).all((2, 3)).any()


@every_type
def test_digits_are_balanced(type):
    """Each digit is set in half of the pixels, including the digits below those determined by a mask or a tile. The limit is six deviations
    for independent pixels, which gives a total false-alarm rate below 1e-6."""
    y, x = np.ogrid[:512, :512]
    u = digits(Sampler(type, seed=5), x, y, 0, 12)
    for digit in range(24):
        assert (abs((u >> digit & 1).sum((0, 1)) - 2.0**17) < 6 * 256).all()


@every_type
def test_samples_do_not_repeat(type):
    """Among 2^16 samples at distant indices or in an image, no pair of numbers repeats. By chance, 1e-5 repetitions are expected."""
    sampler, i = Sampler(type), np.arange(2**16)
    indices = np.where(i < 2**15, i, i * 65521 % 2**32)
    for where in ((10, 20, indices, 9), ((i & 255) - 99, i >> 8, 0, 9)):
        u = digits(sampler, *where).astype(np.uint64)
        assert len(np.unique(u[:, 0] << np.uint64(24) | u[:, 1])) == 2**16


@every_type
def test_domains_and_seeds_are_independent(type):
    """If two streams are independent and white, the correlation of their first samples over 64 x 64 pixels, times sqrt(pixels), is about
    standard normal. For blue streams, its variance depends on their shifts, so the limit is generous: for white noise, |z| > 6 has a
    probability of 2e-9 per pair. Two MASK lookups do correlate if they hit the same texel or neighbouring texels, of 4096. This happens
    in about one of 400 pairs, so more than 4 correlated pairs of 110 have a probability of 1e-6."""
    def correlation(s, t, d, e, i, j):
        u, v = (sampler.sample(X, Y, 0, number).astype(float) - 0.5 for sampler, number in ((s, d), (t, e)))
        return (u[..., i] * v[..., j]).sum() * 12 / 64

    s, t = Sampler(type, seed=1), Sampler(type, seed=2)
    assert correlation(s, s, 5, 5, 0, 0) > 30  # the statistic detects dependence
    found = []
    for pair in range(40):
        d, e, i, j = domain(pair), domain(pair + 1000), pair % 4, pair // 4 % 4
        found += [correlation(s, s, d, e, i, j), correlation(s, t, d, d, i, j), *([correlation(s, s, d, d, i, j)] if i != j else [])]
    assert (np.abs(found) >= 6).sum() <= (4 if type == "mask" else 0)


def seed_of(key):
    """The seed whose SplitMix64 hash is `key`."""
    mask = 2**64 - 1
    key = (key ^ key >> 31 ^ key >> 62) * pow(0x94D049BB133111EB, -1, 2**64) & mask
    key = (key ^ key >> 27 ^ key >> 54) * pow(0xBF58476D1CE4E5B9, -1, 2**64) & mask
    return (key ^ key >> 30 ^ key >> 60) - 0x9E3779B97F4A7C15 & mask


@every_type
@pytest.mark.parametrize("half", [0, 1])
def test_every_member_depends_on_both_halves_of_a_hashed_seed(type, half):
    """The first two digits of a dimension form sixteen combinations in two samplers. Over 64 x 64 pixels, each occurs about 256 times if
    the samplers are independent. If the shifts, orders or curve are the same, one sampler equals the other with flipped digits, and one
    combination occurs 1,024 times."""
    key = 0x0123456789ABCDEF
    s, t = Sampler(type, seed=seed_of(key)), Sampler(type, seed=seed_of(key ^ 0x5EED5EED << 32 * half))
    assert (s.seed_words() != t.seed_words()).tolist() == [half == 0, half == 1]

    def most_frequent(other, number):
        u, v = (digits(each, X, Y, 0, number).reshape(-1, 4) >> 22 for each in (s, other))
        return np.array([np.bincount(u[:, d] << 2 | v[:, d]).max() for d in range(4)])

    assert all((most_frequent(t, domain(4, child)) < 512).all() for child in range(8))
    assert most_frequent(s, domain(4, 0))[0] >= 1024
