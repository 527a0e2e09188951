# SPDX-License-Identifier: Apache-2.0
"""Array choices are bit-identical to those of bn_choose.h, which tests/c checks. Error messages state the argument's name and value."""

import numpy as np
from hashes import hash_of, random_u64, table

import bluenoise

STEPS = 2**24


def words(choices):
    chosen, rest = choices
    assert rest.dtype == np.float32
    return chosen, rest.view(np.uint32)


def test_choices_match_the_c_hash():
    """Repeats the choices that tests/c/test_draw_hashes.c hashes."""
    random = random_u64(np.arange(2 * 4096)).reshape(-1, 2)
    i = np.arange(4096)
    u = np.where(i % 16 > 1, random[:, 0] >> np.uint64(40), i % 16 * (STEPS - 1)) / STEPS
    shares = np.float32([0, 0.125, 0.125, 0.25, 0.3125, 0.75, 0.875, 1])
    found = np.empty((4096, 6), np.uint32)
    found[:, 0], found[:, 1] = words(bluenoise.choose((random[:, 1] >> np.uint64(40)) / STEPS, u))
    counts = 1 + ((random[:, 1] & np.uint64(0xFFFFFF)).astype(int) >> i % 24)
    found[:, 2], found[:, 3] = words(bluenoise.choose_u32(counts, u))
    for k, scale in enumerate(np.float32([1, 3, 0.75, 1e10])):
        found[k::4, 4], found[k::4, 5] = words(bluenoise.choose_cdf(shares * scale, u[k::4]))
    assert hash_of(found) == table()["choices"]


def test_u_is_truncated_to_24_bits():
    steps = np.array([0, 1, STEPS // 3, STEPS - 1])
    index, rest = bluenoise.choose_u32(STEPS, (steps + 0.9) / STEPS)
    assert index.tolist() == steps.tolist() and (rest < 1).all()


def test_shapes_broadcast():
    u = bluenoise.Sampler(seed=3).block(0, 0, 5, 4, 0, 3)[..., 0]
    for function, first in ((bluenoise.choose, np.full((4, 1, 1), 0.25)), (bluenoise.choose_u32, np.arange(1, 4))):
        chosen, rest = function(first, u)
        assert chosen.shape == rest.shape == (4, 5, 3)
    chosen, rest = bluenoise.choose([0.2, 0.8], 0.5)
    assert chosen.tolist() == [False, True]
    index, rest = bluenoise.choose_cdf([0.25, 1], u)
    assert index.shape == rest.shape == u.shape and index.dtype == np.uint32
    for function, first in ((bluenoise.choose, 0.5), (bluenoise.choose_u32, 3), (bluenoise.choose_cdf, [1.0])):
        assert all(np.ndim(part) == 0 for part in function(first, 0.25))
        assert all(np.shape(part) == (0,) for part in function(first, []))
