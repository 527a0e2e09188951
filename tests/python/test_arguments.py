# SPDX-License-Identifier: Apache-2.0
"""Values outside the documented limits are refused with a message that names the argument and the value. test_inputs tries other types."""

import numpy as np
import pytest
from helpers import refused

from bluenoise import (
    PathSampler,
    Sampler,
    anisotropy,
    anneal,
    builtin,
    choose,
    choose_cdf,
    choose_u32,
    dither,
    dithering_error,
    domain,
    mask,
    measure,
    points,
    power_spectrum,
    radial_power,
    relax,
    to_float,
    visible_noise,
    void_and_cluster,
)

NAN, INF = float("nan"), float("inf")
HERE, BLOCK = {"x": 0, "y": 0, "index": 0}, {"x0": 0, "y0": 0, "width": 1, "height": 1, "first_index": 0, "index_count": 1}
SQUARE, HALF = {"shape": (8, 8)}, {"first": np.ones((2, 2)), "second": np.ones((2, 2))}
PATH = PathSampler(Sampler(), [1, 2, 3], 0, [0, 1, 2])
RAY = PATH.ray(0)
VOLUME, GREY = mask((2, 4, 4)), [[0.5]]


# A function, valid arguments for it, the argument to change, and values outside its limits.
@pytest.mark.parametrize(("call", "valid", "name", "values"), [
    (Sampler, {}, "seed", [-1, 2**64]), (Sampler, {}, "samples_per_pixel", [-1, 2**32]), (Sampler, {}, "type", ["bleu"]),
    (Sampler().sample, HERE, "x", [2**31, -(2**31) - 1, 2**70]), (Sampler().sample, HERE, "index", [-1, 2**32]),
    (Sampler().sample, HERE, "domain", [-1, 2**32]), (Sampler().sample, HERE, "dims", [0, 5]), (Sampler().sample, HERE, "pair", [-1, 4]),
    *((Sampler().block, BLOCK, name, [0]) for name in ("width", "height", "index_count")), (Sampler().block, BLOCK, "x0", [2**31]),
    (Sampler().block, BLOCK, "first_index", [2**32]), (Sampler().block, BLOCK, "domain", [-5]), (Sampler().block, BLOCK, "dims", [0, 5]),
    (Sampler().block, {**BLOCK, "x0": 2**31 - 1}, "width", [2]), (Sampler().block, {**BLOCK, "y0": 2**31 - 1}, "height", [2]),
    (Sampler().block, {**BLOCK, "first_index": 2**32 - 1}, "index_count", [2]),
    (mask, SQUARE, "channels", [5]), (mask, SQUARE, "seed", [-1]), (mask, {}, "shape", [(0, 8), (), (2, 2, 2, 2)]),
    (void_and_cluster, SQUARE, "sigma", [0, NAN, 16.01]), (void_and_cluster, SQUARE, "initial_fraction", [0, 0.51]),
    (relax, SQUARE, "threads", [-1]), (relax, {}, "shape", [(4, 4, 4)]), (anneal, {}, "shape", [(4, 4, 4)]),
    *((anneal, SQUARE, name, values) for name, values in (
        ("sigma", [0.2, 4.1]), ("far_sigma", [0.9]), ("far_weight", [-1]), ("value_sigma", [0]), ("start_temperature", [1.5]),
        ("end_temperature", [0, 1e-3]), ("sweeps", [-1]), ("channels", [5]))),
    (builtin, {}, "shape", [(65, 65), (64,)]), (to_float, {"ranks": [0]}, "count", [-1]),
    (dithering_error, {"mask": [[0, 1]]}, "sigma", [-1, NAN, 1001]), (dither, {"image": GREY}, "levels", [1, 257]),
    (visible_noise, HALF, "sigma", [17]), (visible_noise, HALF, "exposure", [0]), (visible_noise, HALF, "first_share", [1]),
    (visible_noise, HALF, "window", [4]),
    (choose, {"probability": 0.5}, "u", [1.0, -0.1, NAN]), (choose, {"u": 0.1}, "probability", [1.5, -0.5, NAN]),
    (choose_u32, {"u": 0.1}, "count", [0, 2**24 + 1]),
    *((PathSampler, {"sampler": Sampler(), **HERE}, name, [value]) for name, value in (("x", 2**31), ("index", -1), ("stream", 2**32))),
    (PATH.ray, {}, "number", [-1, 2**28]), (PATH.first_light, {}, "count", [0]), (PATH.first_light, {"count": 2}, "k", [2]),
    (RAY.next_split, {}, "count", [-1]), (RAY.next_split_from, {}, "first", [-1]), (RAY.draw_1d, {}, "k", [-1]),
    (RAY.draw_split, {"count": 1}, "k", [2**28]), (RAY.child, {}, "key", [-1]),
    *((points, {"n": 4}, name, [value]) for name, value in (("n", -1), ("method", "grid"), ("candidates", 0), ("seed", -1), ("dims", 4))),
])
def test_limits(call, valid, name, values):
    for value in values:
        with refused(ValueError, [str(value)]) as caught:
            call(**{**valid, name: value})
        assert str(caught.value).startswith(name), caught.value


@pytest.mark.parametrize(("call", "error", "words"), [
    # Python would convert these.
    *((lambda value=value: Sampler(seed=value), TypeError, ["seed", repr(value)]) for value in (True, 1.0, "1")),
    *((lambda value=value: dithering_error([[0, 1]], value), TypeError, ["sigma", repr(value)]) for value in (True, "1", np.ones(1))),
    (lambda: Sampler().sample(True, 0, 0), TypeError, ["x", "bool"]),
    (lambda: Sampler().sample([[0], [1, 2]], 0, 0), TypeError, ["x"]),
    (lambda: Sampler("bleu"), ValueError, ["blue", "zorder"]),
    (lambda: Sampler(mask=[[0, 1]]), ValueError, ["mask", "'blue'"]),
    (lambda: Sampler("mask", mask=[[0, 0]]), ValueError, ["mask", "0 2 times"]),
    (lambda: Sampler("mask", mask=[[0, 2]]), ValueError, ["mask", "1 0 times"]),
    (lambda: Sampler("mask", mask=[[0, -1]]), ValueError, ["mask", "-1"]),
    (lambda: Sampler("mask", mask=VOLUME), ValueError, ["mask", "(2, 4, 4)", "mask[0]"]),
    (lambda: Sampler("mask", mask=np.zeros((0, 4), int)), ValueError, ["mask", "(0, 4)"]),
    (lambda: Sampler().sample([1, 2], [1, 2, 3], 0), ValueError, ["(2,)", "(3,)"]),
    (lambda: Sampler().sample(1, 2, 3, pair=1, dims=3), ValueError, ["pair", "dims", "3"]),
    (lambda: Sampler().sample(1, 2, 3, pair=1, out=np.empty(4, np.float32)), ValueError, ["out", "(2,)"]),
    (lambda: Sampler().block(0, 0, 2**31, 2**31, 0, 2**32 - 1), MemoryError, [str(2**31)]),
    (lambda: domain([0, -1]), ValueError, ["key", "-1"]),
    (lambda: domain(0, 2**32), ValueError, ["key", str(2**32)]),
    (lambda: domain("light"), TypeError, ["key", "'light'"]),
    (lambda: domain([1, 2], [1, 2, 3]), ValueError, ["keys do not broadcast: shapes (2,), (3,)"]),
    # On the command line, 64 means a square; in NumPy, it means a row.
    *((lambda number=number: mask(number), TypeError, ["(64, 64) is a square, (64,) a row"]) for number in (64, np.int64(64))),
    (lambda: mask((8.0, 8)), TypeError, ["shape", "8.0"]),
    (lambda: mask((2**32, 1)), MemoryError, ["shape", str(2**32), "2**31 - 1"]),
    (lambda: mask(memoryview(np.zeros((2, 2), int))), TypeError, ["shape", "memory"]),
    (lambda: mask((4, 4, 4), channels=2), ValueError, ["2-channel mask", "(4, 4, 4)"]),
    (lambda: builtin((65, 65)), ValueError, ["shape", "(64, 64)"]),
    (lambda: anneal((8, 8), start_from_ranks=np.zeros((8, 9), int)), ValueError, ["start_from_ranks", "(8, 9)"]),
    (lambda: anneal((8, 8), start_from_ranks=np.zeros((8, 8), int)), ValueError, ["start_from_ranks", "64 times"]),
    (lambda: anneal((8, 8), start_from_ranks=np.zeros((8, 8))), TypeError, ["start_from_ranks", "float64"]),
    (lambda: to_float([0, 1, 2, 4]), ValueError, ["ranks", "4"]),
    (lambda: to_float([0, -1]), ValueError, ["ranks", "-1"]),
    *((lambda bad=bad: dither([[0.5, bad]]), ValueError, ["image", str(bad)]) for bad in (NAN, INF, 1.001, -0.1)),
    *((lambda shape=shape: dither(np.zeros(shape)), ValueError, ["image", str(shape)])
      for shape in ((1,), (0, 4), (4, 4, 0), (2, 2, 2, 2))),
    (lambda: dither([[1, 0]]), TypeError, ["image", "int64"]),
    (lambda: dither(np.zeros((3, 40, 50))), ValueError, ["(3, 40, 50)", "moveaxis"]),
    (lambda: dither(GREY, mask=[[0, 0]]), ValueError, ["mask", "0 2 times"]),
    (lambda: dither(GREY, mask=np.repeat(np.arange(4), 16).reshape(8, 8)), ValueError, ["mask", "0 16 times; ", "rank=True"]),
    *((lambda bad=bad: dither(GREY, mask=[[bad]]), ValueError, ["mask", str(bad)]) for bad in (1.0, NAN)),
    (lambda: dither(GREY, mask=np.zeros((1, 1, 1, 1))), ValueError, ["mask", "(1, 1, 1, 1)"]),
    (lambda: dither(np.zeros((4, 4, 3)), mask=np.zeros((2, 3, 3))), ValueError, ["mask has 2 channels and the image 3", "mask[0]"]),
    (lambda: dither(GREY, mask=VOLUME), ValueError, ["mask (2, 4, 4)", "to_float(mask)[0]"]),
    *((lambda measured=measured, bad=bad: measured(bad), ValueError, ["mask", words])
      for measured in (measure, dithering_error, power_spectrum, radial_power)
      for bad, words in ((np.int64(3), "()"), (np.zeros((2, 2, 2, 2), int), "(2, 2, 2, 2)"), (np.zeros((0, 3), int), "(0, 3)"),
                         ([[1.0, NAN]], "element 1 is NaN"))),
    (lambda: measure(anneal((8, 8), channels=2, sweeps=1)), ValueError, ["mask", "mask[0]"]),
    (lambda: setattr(measure([[0, 1]]), "exact", False), AttributeError, []),
    (lambda: anisotropy([]), ValueError, ["masks"]),
    (lambda: anisotropy([mask((8, 8)), mask((8, 9))]), ValueError, ["masks", "equal shapes"]),
    (lambda: anisotropy(mask((8, 8))), ValueError, ["masks", "give [mask]"]),
    (lambda: anisotropy(memoryview(mask((8, 8)))), ValueError, ["masks", "give [mask]"]),
    (lambda: visible_noise(np.ones((2, 2), np.uint8), GREY), TypeError, ["first must hold linear light as floats, not uint8"]),
    (lambda: visible_noise(np.ones((2, 2)), np.ones((2, 3))), ValueError, ["equal shapes, not (2, 2) and (2, 3)"]),
    (lambda: visible_noise(np.ones((2, 2, 2, 2)), GREY), ValueError, ["first", "(2, 2, 2, 2)"]),
    (lambda: visible_noise(np.ones((0, 2)), GREY), ValueError, ["first", "(0, 2)"]),
    (lambda: visible_noise(np.ones((2, 2)), np.array([[1, 2], [NAN, 3]])), ValueError, ["second must not contain NaN", "(1, 0) is NaN"]),
    (lambda: choose([0.1, 0.2], [0.1, 0.2, 0.3]), ValueError, ["probability and u", "(2,)", "(3,)"]),
    (lambda: choose_u32([1, 2], [0.1, 0.2, 0.3]), ValueError, ["count and u", "(2,)", "(3,)"]),
    *((lambda cdf=cdf: choose_cdf(cdf, 0.1), ValueError, ["cdf", words]) for cdf, words in (
        ([0.5, 0.4, 1], "0.4"), ([0.5, 2e30], "2e+30"), ([0, 1e-31], "1e-31"), ([-1, 1], "-1"), ([0.5, NAN], "nan"), ([], "(0,)"),
        (0.5, "()"))),
    (lambda: PathSampler(Sampler(), [0, 1], [0, 1, 2], 0), ValueError, ["x, y, index and stream", "(2,)", "(3,)"]),
    (lambda: PATH.ray([0, 1]), ValueError, ["number", "(2,)", "(3,)"]),
    (lambda: PATH.first_light(4, [0, 1]), ValueError, ["k", "(2,)"]),
    (lambda: PATH.first_light(2**31), ValueError, ["count", str(2**32)]),
    (lambda: RAY.next_split(2)[-1], ValueError, ["k", "-1"]),
    (lambda: RAY.next_split(2)[[0, 1]], ValueError, ["k", "(2,)"]),
    (lambda: RAY.next_split(2**31)[0], ValueError, ["count", str(2**32), "index 2"]),
    (lambda: RAY.next_split_from([0, 1]), ValueError, ["first", "(2,)"]),
    (lambda: RAY.next_split_from(2**32 - 1)[1], ValueError, ["k", str(2**32)]),
    *((lambda use=use: use(RAY.next_split_from(0)), TypeError, ["next_split_from", "length"]) for use in (len, list)),
    (lambda: RAY.child([0, 1]), ValueError, ["key", "(2,)"]),
    *((lambda options=options: points(4, method="mask", **options), error, words) for options, error, words in (
        ({"jitter": "no"}, TypeError, ["jitter", "no"]), ({"mask": [[0, 1], [2, 2]]}, ValueError, ["mask", "every rank"]),
        ({"mask": [[0, 1, 2]]}, ValueError, ["n = 4", "3"]), ({"dims": 3, "mask": [[0, 1], [2, 3]]}, ValueError, ["mask", "3 axes"]),
        ({"mask": [[0, 1], [2, 3]], "density": [[0, 1]]}, ValueError, ["n = 4", "density", "2"]))),
    (points, TypeError, ["n", "None"]),
    (lambda: points(4, method="best-candidate", jitter=True), TypeError, ["jitter", "True"]),
    (lambda: points(4, method="best-candidate", density=[[1]]), TypeError, ["best-candidate", "density"]),
    *((lambda density=density, dims=dims: points(4, density=density, dims=dims), ValueError, ["density", *words])
      for density, dims, words in (
          ([[[1]]], 2, ["(height, width), not (1, 1, 1)"]), ([[1]], 3, ["(depth, ", " not (1, 1)"]), ([[1, -2]], 2, ["-2"]),
          ([[1, NAN]], 2, ["nan"]), ([[0, 0]], 2, ["sum"]))),
])
def test_messages(call, error, words):
    with refused(error, words):
        call()
