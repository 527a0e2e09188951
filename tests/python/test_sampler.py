# SPDX-License-Identifier: Apache-2.0
"""Sampler: array shapes and types, agreement of single draws and blocks, seeds, domains, copies, and `out`."""

import copy
import pickle
import typing

import numpy as np
import pytest

import bluenoise
from bluenoise import Sampler

TYPES = typing.get_args(bluenoise.SamplerType)
# Coordinates and indices at the limits of their ranges.
EDGE_X = np.array([-(2**31), -65537, -1, 0, 1, 127, 128, 2**31 - 1], np.int32)
EDGE_INDEX = np.array([0, 1, 255, 256, 65535, 65536, 2**31, 2**32 - 1], np.uint32)


@pytest.mark.parametrize("type", TYPES)
def test_sample_shape_range_and_precision(type):
    u = Sampler(type, seed=7).sample(EDGE_X[:, None], EDGE_X[None, :], EDGE_INDEX[:, None], 5)
    assert u.shape == (8, 8, 4) and u.dtype == np.float32
    assert (u >= 0).all() and (u < 1).all()
    assert (u * 2.0**24 == np.floor(u * 2.0**24)).all()


@pytest.mark.parametrize("type", TYPES)
@pytest.mark.parametrize("dims", (1, 2, 3, 4))
def test_samples_in_any_array_layout_match_a_block(type, dims):
    sampler = Sampler(type, seed=4)
    domain = bluenoise.domain(9)
    block = sampler.block(-20, -5, 37, 11, 250, 9, domain)[..., :dims]
    for grid in (np.mgrid, np.ogrid):
        y, x, index = grid[-5:6, -20:17, 250:259]  # 3663 lanes, processed in multiple parts of which the last is shorter
        np.testing.assert_array_equal(sampler.sample(x, y, index, domain, dims), block)
    transposed = sampler.sample(x.T, y.T, index.T, domain, dims)
    np.testing.assert_array_equal(transposed, block.transpose(2, 1, 0, 3))
    y, x, index = (array.ravel() for array in np.mgrid[-5:6, -20:17, 250:259])
    order = np.random.default_rng(1).permutation(x.size)
    shuffled = sampler.sample(x[order], y[order], index[order], domain, dims)
    np.testing.assert_array_equal(shuffled, block.reshape(-1, dims)[order])


def test_large_block_matches_its_rows():
    block = Sampler(seed=4).block(-20, -5, 512, 700, 3, 4)
    for rows in (0, 300, 699):
        np.testing.assert_array_equal(block[rows:rows + 1], Sampler(seed=4).block(-20, rows - 5, 512, 1, 3, 4))


@pytest.mark.parametrize("type", TYPES)
def test_pairs_match_four_dimensional_samples(type):
    sampler = Sampler(type, seed=9)
    where = np.arange(3000), 3, np.arange(3000) % 300, bluenoise.domain(np.arange(3000) % 5)
    four = sampler.sample(*where)
    for pair in (0, 1):
        np.testing.assert_array_equal(sampler.sample(*where, pair=pair), four[:, 2 * pair:2 * pair + 2])
        out = np.empty((3000, 2), np.float32)
        assert sampler.sample(*where, dims=2, pair=pair, out=out) is out
        np.testing.assert_array_equal(out, four[:, 2 * pair:2 * pair + 2])
    assert sampler.sample(1, 2, 3, pair=1).shape == (2,)


def test_scalar_arguments():
    u = Sampler().sample(1, 2, 3)
    assert u.shape == (4,)
    np.testing.assert_array_equal(u, Sampler().sample([1], [2], [3])[0])
    np.testing.assert_array_equal(u, Sampler().sample(np.int8(1), np.uint64(2), np.int16(3)))


def test_broadcasting_matches_full_arrays():
    sampler = Sampler(seed=2)
    x, y = np.arange(5), np.arange(-3, 0)[:, None]
    index = np.arange(4)[:, None, None]
    domains = np.array([0, bluenoise.domain(1)])[:, None, None, None]
    u = sampler.sample(x, y, index, domains)
    assert u.shape == (2, 4, 3, 5, 4)
    full = np.broadcast_arrays(x, y, index, domains)
    np.testing.assert_array_equal(u, sampler.sample(*(np.array(a) for a in full)))
    d, i, j, k = 1, 3, 2, 4
    np.testing.assert_array_equal(u[d, i, j, k], sampler.sample(k, j - 3, i, bluenoise.domain(1)))


def test_empty_arrays():
    assert Sampler().sample([], 0, 0).shape == (0, 4)
    assert Sampler().sample(np.zeros((3, 0), int), 0, 0, dims=2).shape == (3, 0, 2)
    assert Sampler().sample(np.zeros((0, 3), int), 0, 0).shape == (0, 3, 4)


@pytest.mark.parametrize(
    "dtype", ["i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8", ">i2", ">u8"]
)
def test_every_integer_dtype_is_accepted(dtype):
    values = np.arange(100, dtype=dtype)
    expected = Sampler().sample(np.arange(100), np.arange(100), np.arange(100), np.arange(100))
    np.testing.assert_array_equal(Sampler().sample(values, values, values, values), expected)


def test_seed_from_a_generator():
    one, two = (Sampler(seed=np.random.default_rng(5)) for _ in range(2))
    assert one == two and 0 <= one.seed < 2**64 and one.seed != Sampler(seed=5).seed
    generator = np.random.default_rng(5)
    assert Sampler(seed=generator) != Sampler(seed=generator)


def test_domains():
    assert bluenoise.domain() == 0
    assert 0 <= bluenoise.domain(1) < 2**32
    assert bluenoise.domain(1, 2) != bluenoise.domain(2, 1)
    assert bluenoise.domain(np.uint32(7)) == bluenoise.domain(7)
    keys = {bluenoise.domain(a, b) for a in range(64) for b in range(64)}
    assert len(keys) > 4090  # 0.002 collisions are expected among 4,096 32-bit hashes


def test_mask_sampler_accepts_ranks():
    ranks = bluenoise.mask((16, 24), seed=4)
    sampler = Sampler("mask", seed=1, mask=ranks)
    assert not sampler.mask.flags.writeable and sampler.mask.dtype == np.uint32
    expected = sampler.block(0, 0, 24, 16, 0, 2)
    # At index 0, samples repeat the toroidal mask, except for bits finer than its 384 ranks.
    first, next_tile = expected[:, :, 0], sampler.block(24, -16, 24, 16, 0, 1)[:, :, 0]
    assert (np.floor(first * 512) == np.floor(next_tile * 512)).all()
    given = ranks.astype(np.int64).tolist()
    again = Sampler("mask", seed=1, mask=given)
    np.testing.assert_array_equal(again.block(0, 0, 24, 16, 0, 2), expected)
    ranks[:] = 0  # the sampler has copied them
    np.testing.assert_array_equal(sampler.block(0, 0, 24, 16, 0, 2), expected)


@pytest.mark.parametrize("type", TYPES)
@pytest.mark.parametrize("protocol", range(2, pickle.HIGHEST_PROTOCOL + 1))
def test_pickle_and_copy(type, protocol):
    sampler = Sampler(type, seed=2**63 + 1, samples_per_pixel=4, mask=bluenoise.mask((8, 8)) if type == "mask" else None)
    for twin in (pickle.loads(pickle.dumps(sampler, protocol)), copy.copy(sampler), copy.deepcopy(sampler)):
        assert twin == sampler and hash(twin) == hash(sampler)
        np.testing.assert_array_equal(twin.block(0, 0, 4, 4, 0, 4), sampler.block(0, 0, 4, 4, 0, 4))


def test_equality_and_hash():
    assert Sampler() == Sampler("blue", seed=0, samples_per_pixel=0)
    assert len({Sampler(), Sampler(), Sampler("white"), Sampler(seed=1), Sampler(samples_per_pixel=4)}) == 4
    ranks = bluenoise.mask((8, 8))
    assert Sampler("mask", mask=ranks) == Sampler("mask", mask=ranks.astype(np.int8))
    assert Sampler("mask", mask=ranks) != Sampler("mask", mask=ranks[::-1])
    assert Sampler("mask", mask=ranks) != Sampler("mask", mask=ranks.reshape(4, 16))
    assert Sampler("mask", mask=ranks) != Sampler("mask")
    assert Sampler() != "blue"


def test_samplers_are_immutable():
    sampler = Sampler()
    for name in ("seed", "type", "mask", "samples_per_pixel", "_seed", "other"):
        with pytest.raises(AttributeError, match=name):
            setattr(sampler, name, 1)
    with pytest.raises(AttributeError, match="seed"):
        del sampler._seed


def test_seed_none_is_random_and_reusable():
    sampler, other = Sampler(seed=None), Sampler(seed=None)
    assert sampler.seed != other.seed  # identical with probability 2**-64
    assert Sampler(seed=sampler.seed) == sampler == eval(repr(sampler))
    assert (bluenoise.relax((8, 8), seed=None) != bluenoise.relax((8, 8), seed=None)).any()


def test_repr():
    assert repr(Sampler("sobol", seed=3)) == "Sampler('sobol', seed=3)"
    text = repr(Sampler("mask", samples_per_pixel=4, mask=bluenoise.mask((4, 6))))
    assert text == "Sampler('mask', seed=0, samples_per_pixel=4, mask=<4 x 6>)"


def test_shader_tables_and_seeds():
    words = bluenoise.tables()
    assert words.dtype == np.uint32 and words.shape == (11904,)
    words[:] = 0  # a copy
    assert bluenoise.tables().any()
    seeds = {tuple(Sampler(type, seed=seed).seed_words()) for type in TYPES for seed in (0, 1, 2**64 - 1)}
    assert len(seeds) == 3 and tuple(Sampler(seed=0).seed_words()) == (0x7B1DCDAF, 0xE220A839)  # SplitMix64


@pytest.mark.parametrize("type", TYPES)
@pytest.mark.parametrize("shape", [(7, 6, 3), (2, 3, 1), (1, 1, 1), (5, 1, 1), (1, 5, 1), (1, 1, 3)])
@pytest.mark.parametrize("dims", [1, 2, 3, 4])
def test_blocks_overwrite_all_of_out(type, shape, dims):
    """At the first and the last coordinates and indices."""
    sampler, (height, width, count) = Sampler(type, seed=3, samples_per_pixel=4), shape
    for x0, y0, first in ((-(2**31), 5, 2**32 - count), (2**31 - width, 2**31 - height, 0)):
        y, x, index = np.ogrid[y0 : y0 + height, x0 : x0 + width, first : first + count]
        out = np.full((*shape, dims), 7, np.float32)
        assert sampler.block(x0, y0, width, height, first, count, 9, dims, out=out) is out
        np.testing.assert_array_equal(out, sampler.sample(x, y, index, 9)[..., :dims])


@pytest.mark.parametrize("dims", [2, 4])
def test_out(dims):
    sampler = Sampler(seed=1)
    out = np.full((7, 6, dims), np.nan, np.float32)
    y, x = np.mgrid[:7, :6]
    assert sampler.sample(x, y, 5, dims=dims, out=out) is out
    np.testing.assert_array_equal(out, sampler.sample(x, y, 5, dims=dims))
    one = np.empty(dims, np.float32)
    np.testing.assert_array_equal(sampler.sample(1, 2, 3, 0, dims, out=one), sampler.sample(1, 2, 3)[:dims])


def test_bad_out():
    sampler = Sampler()
    for call in (lambda out: sampler.block(0, 0, 4, 4, 0, 4, out=out), lambda out: sampler.sample([[0] * 4] * 4, 0, [[[0]]] * 4, out=out)):
        for out in (np.empty((4, 4, 4, 3), np.float32), np.empty((4, 4, 4, 4)), np.empty((4, 4, 4, 8), np.float32)[..., ::2]):
            with pytest.raises(ValueError, match="^out must"):
                call(out)


def test_array_domains():
    keys = np.array([[0, 1, 2**32 - 1], [7, 8, 9]])
    found = bluenoise.domain(3, keys, [4, 5, 6])
    assert found.dtype == np.uint32 and found.shape == (2, 3)
    for at, domain in np.ndenumerate(found):
        assert domain == bluenoise.domain(3, int(keys[at]), 4 + at[1])
    assert type(bluenoise.domain(np.array(7), np.uint8(3))) is int
    assert Sampler().sample(0, 0, 0, found).shape == (2, 3, 4)


def test_out_may_overlap_the_coordinates():
    sampler, shared = Sampler(), np.arange(64, dtype=np.uint32)
    expected = sampler.sample(3, 4, np.arange(16))
    assert (sampler.sample(3, 4, shared[:16], out=shared.view(np.float32).reshape(16, 4)) == expected).all()
