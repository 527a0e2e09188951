# SPDX-License-Identifier: Apache-2.0
"""Draws on other libraries' arrays are bit-identical to the library's, stay on their device and can be compiled."""

import importlib

import numpy as np
import pytest
from helpers import refused

import bluenoise
from bluenoise import arrays

SLOW = pytest.mark.slow
LIBRARIES = ["numpy", "array_api_strict", pytest.param("torch", marks=SLOW), pytest.param("jax.numpy", marks=SLOW)]
X, Y, INDEX, DOMAIN = np.random.default_rng(1).integers(0, 2**32, (4, 3000), dtype=np.uint32)
X, Y, INDEX = X.view(np.int32), Y.view(np.int32), INDEX >> np.arange(3000, dtype=np.uint32) % 32  # of every bit length


@pytest.fixture(params=LIBRARIES)
def xp(request):
    return pytest.importorskip(request.param)


@pytest.mark.parametrize("type", ["blue", "sobol", "white"])
def test_bits_match_the_library(xp, type):
    sampler = bluenoise.Sampler(type, seed=2**60 + 5)
    expected = sampler.sample(X, Y, INDEX, DOMAIN)
    given = [xp.asarray(words) for words in (X, Y, INDEX, DOMAIN)]
    found = arrays.sample(xp, sampler, *given)
    assert found.dtype == xp.float32 and np.array_equal(np.asarray(found), expected)
    for dims in (1, 2, 3):
        assert np.array_equal(np.asarray(arrays.sample(xp, sampler, X, Y, INDEX, given[3], dims)), expected[:, :dims])
    for pair in (0, 1):
        found = arrays.sample(xp, sampler, *given[:2], INDEX % 256, DOMAIN, pair=pair)
        assert np.array_equal(np.asarray(found), sampler.sample(X, Y, INDEX % 256, DOMAIN, pair=pair))


def test_shapes(xp):
    sampler = bluenoise.Sampler("white", seed=1)
    assert np.array_equal(np.asarray(arrays.sample(xp, sampler, -3, 5, 70000)), sampler.sample(-3, 5, 70000))
    column = xp.asarray(X[:5, None, None])
    found = arrays.sample(xp, sampler, column, Y[:4, None], [3, 1, 2], DOMAIN[0])
    assert np.array_equal(np.asarray(found), sampler.sample(X[:5, None, None], Y[:4, None], [3, 1, 2], DOMAIN[0]))
    assert np.asarray(arrays.sample(xp, sampler, xp.asarray(X[:0]), 0, 0)).shape == (0, 4)


def test_numpy_wraps_without_warnings():
    with np.errstate(all="raise"):
        arrays.sample(np, bluenoise.Sampler("white"), np.int64(7), np.array(7), 2**32 - 1)


def test_torch_integers_are_taken_modulo_2_to_the_32():
    torch = pytest.importorskip("torch")
    sampler = bluenoise.Sampler("blue")
    found = arrays.sample(torch, sampler, torch.tensor([2**32 + 1]), torch.tensor([-1], dtype=torch.int8), torch.tensor([-1]))
    assert np.array_equal(found.numpy(), sampler.sample([1], -1, 2**32 - 1))


@SLOW
def test_every_array_is_on_the_device_of_the_arguments():
    torch = pytest.importorskip("torch")
    index = torch.zeros(5, dtype=torch.int64, device="meta")  # operations that mix it with the CPU raise an error
    for type in ("blue", "sobol", "white"):
        found = arrays.sample(torch, bluenoise.Sampler(type), X[:5], 3, index)
        assert found.device == index.device and found.shape == (5, 4)


@SLOW
def test_compiled():
    sampler = bluenoise.Sampler("blue", seed=3)
    expected = sampler.sample(X, 5, INDEX % 1000, 77)
    for name in ("jax", "torch"):
        try:
            library = importlib.import_module(name)
        except ImportError:
            continue
        xp = library.numpy if name == "jax" else library

        def draw(x, index, xp=xp):
            return arrays.sample(xp, sampler, x, 5, index, domain=77)

        compiled = library.jit(draw) if name == "jax" else library.compile(draw, fullgraph=True, backend="eager")
        assert np.array_equal(np.asarray(compiled(xp.asarray(X), xp.asarray((INDEX % 1000).view(np.int32)))), expected)


def test_refusals(xp):
    blue = bluenoise.Sampler("blue")
    with refused(ValueError, ["sampler", "blue, sobol, white", "zorder"]):
        arrays.sample(xp, bluenoise.Sampler("zorder"), 0, 0, 0)
    with refused(TypeError, ["sampler", "'blue'"]):
        arrays.sample(xp, "blue", 0, 0, 0)
    with refused(TypeError, ["y", "float"]):
        arrays.sample(xp, blue, 0, xp.asarray([0.5]), 0)
    with refused(TypeError, ["index", "bool"]):
        arrays.sample(xp, blue, 0, 0, xp.asarray([True]))
    for argument in ({"x": 2**31}, {"index": -1}, {"index": np.array([-1])}, {"domain": 2**32}, {"dims": 5}, {"pair": 2}):
        with refused(ValueError, [*argument, "must be in"]):
            arrays.sample(xp, blue, **({"x": 0, "y": 0, "index": 0} | argument))
