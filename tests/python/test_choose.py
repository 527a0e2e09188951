# SPDX-License-Identifier: Apache-2.0
"""Choices on arrays: the bits of bn_choose.h, whose own tests judge the choices, and refusals with name and value."""

import ctypes
import doctest
import os
import subprocess
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

import bluenoise
from bluenoise import _choose

ROOT = Path(__file__).resolve().parents[2]
STEPS = 2**24
RANDOM = np.random.default_rng(7)
# Draws at both ends, near round numbers and anywhere.
DRAWS = np.concatenate([[0, 1, 2, STEPS - 2, STEPS - 1], *(STEPS * k // 20 + np.arange(-2, 3) for k in range(1, 20)),
                        RANDOM.integers(0, STEPS, 2000)]) / STEPS
PROBABILITIES = np.float32([0, 1e-40, 2.0**-24, 1e-5, 0.1, 0.25, 0.3, np.nextafter(np.float32(0.5), np.float32(0)), 0.7, 1])


@pytest.fixture(scope="module")
def in_c(tmp_path_factory):
    """bn_choose.h, compiled as the functions of a shared library."""
    folder = tmp_path_factory.mktemp("choose")
    (folder / "choose.c").write_text("""
        #include <bn/bn_choose.h>
        int one(float p, float *u) { return bn_choose(p, u); }
        uint32_t even(uint32_t count, float *u) { return bn_choose_u32(count, u); }
        uint32_t table(const float *cdf, uint32_t count, float *u) { return bn_choose_cdf(cdf, count, u); }
    """)
    command = [os.environ.get("CC", "cc"), "-std=c99", "-O1", "-shared", "-fPIC", "-I", ROOT / "libbn/include",
               folder / "choose.c", "-o", folder / "choose.so"]
    try:
        subprocess.run(command, check=True)
    except FileNotFoundError:
        pytest.skip("no C compiler")
    library = ctypes.CDLL(str(folder / "choose.so"))
    library.one.argtypes = [ctypes.c_float, ctypes.POINTER(ctypes.c_float)]
    library.even.restype = library.table.restype = ctypes.c_uint32

    def call(function, *arguments):
        results = []
        for draw in DRAWS:
            u = ctypes.c_float(draw)
            results.append((function(*arguments, ctypes.byref(u)), u.value))
        chosen, rest = zip(*results)
        return np.array(chosen), np.array(rest, np.float32)

    return library, call


def same(python, c):
    np.testing.assert_array_equal(python[0], c[0])
    np.testing.assert_array_equal(python[1], c[1])
    assert python[1].dtype == np.float32


@pytest.mark.parametrize("probability", PROBABILITIES)
def test_choose_is_that_of_c(in_c, probability):
    library, call = in_c
    same(bluenoise.choose(probability, DRAWS), call(library.one, float(probability)))


@pytest.mark.parametrize("count", [1, 2, 3, 7, 255, 1000, STEPS - 1, STEPS])
def test_choose_u32_is_that_of_c(in_c, count):
    library, call = in_c
    same(bluenoise.choose_u32(count, DRAWS), call(library.even, ctypes.c_uint32(count)))


@pytest.mark.parametrize("cdf", [
    [1], [0.5], [0, 0.25, 0.25, 0.3, 0.7, 1], [0.1, 1, 1], np.linspace(0, 1, 3001)[1:], [3, 4, 11], [1e-29, 3e-29, 3e-29],
    np.cumsum(np.random.default_rng(2).random(2000)) * 1e20])
def test_choose_cdf_is_that_of_c(in_c, cdf):
    library, call = in_c
    table = (ctypes.c_float * len(cdf))(*cdf)
    same(bluenoise.choose_cdf(cdf, DRAWS), call(library.table, table, ctypes.c_uint32(len(cdf))))


@pytest.mark.parametrize("probability", [Fraction(1, 4), Fraction(5, 7)])
def test_what_is_left_is_the_stretched_middle_of_the_step(probability):
    """By exact fractions, apart from what C and Python share."""
    limit = int(np.ceil(np.float64(np.float32(float(probability))) * STEPS))
    chosen, rest = bluenoise.choose(float(probability), DRAWS)
    for draw, yes, left in zip(DRAWS, chosen, rest):
        step = int(draw * STEPS)
        low, width = (0, limit) if step < limit else (limit, STEPS - limit)
        assert yes == (step < limit)
        assert int(float(left) * STEPS) == Fraction((2 * (step - low) + 1) * STEPS, 2 * width).__floor__()


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


@pytest.mark.parametrize(
    ("function", "arguments", "error", "words"),
    [
        ("choose", (0.5, 1.0), ValueError, ["u", "1.0"]),
        ("choose", (0.5, -0.1), ValueError, ["u", "-0.1"]),
        ("choose", (0.5, [0.1, np.nan]), ValueError, ["u", "nan"]),
        ("choose", (0.5, "half"), TypeError, ["u", "half"]),
        ("choose", (0.5, True), TypeError, ["u", "bool"]),
        ("choose", (1.5, 0.1), ValueError, ["probability", "1.5"]),
        ("choose", (-0.5, 0.1), ValueError, ["probability", "-0.5"]),
        ("choose", (np.nan, 0.1), ValueError, ["probability", "nan"]),
        ("choose_u32", (0, 0.1), ValueError, ["count", "0"]),
        ("choose_u32", (STEPS + 1, 0.1), ValueError, ["count", str(STEPS + 1)]),
        ("choose_u32", (2.0, 0.1), TypeError, ["count", "2.0"]),
        ("choose_u32", (2, 1), ValueError, ["u", "1"]),
        ("choose_cdf", ([0.5, 0.4, 1], 0.1), ValueError, ["cdf", "0.4"]),
        ("choose_cdf", ([0.5, 2e30], 0.1), ValueError, ["cdf", "2e+30"]),
        ("choose_cdf", ([0, 1e-31], 0.1), ValueError, ["cdf", "1e-31"]),
        ("choose_cdf", ([-1, 1], 0.1), ValueError, ["cdf", "-1"]),
        ("choose_cdf", ([0.5, np.nan], 0.1), ValueError, ["cdf", "nan"]),
        ("choose_cdf", ([], 0.1), ValueError, ["cdf", "(0,)"]),
        ("choose_cdf", (0.5, 0.1), ValueError, ["cdf", "()"]),
    ],
)
def test_bad_arguments(function, arguments, error, words):
    with pytest.raises(error) as caught:
        getattr(bluenoise, function)(*arguments)
    assert all(word in str(caught.value) for word in words), str(caught.value)


def test_examples():
    assert doctest.testmod(_choose).attempted == 6 and doctest.testmod(_choose).failed == 0
