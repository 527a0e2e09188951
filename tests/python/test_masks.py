# SPDX-License-Identifier: Apache-2.0
"""Masks are permutations; options, progress, `out` and errors are the same for all generators."""

import inspect

import numpy as np
import pytest
from helpers import needs_network, needs_package, progress_of, refused, run_python
from reference import white

import bluenoise
from bluenoise import _arguments, anneal, builtin, mask, neural, relax, to_float, void_and_cluster


def is_permutation(ranks):
    return np.array_equal(np.sort(ranks, axis=None), np.arange(ranks.size))


QUICK = {"sweeps": 20}


@pytest.mark.parametrize(("make", "shape"), [(void_and_cluster, (5, 6, 7)), *(
    (make, shape) for make in (void_and_cluster, relax, anneal) for shape in ((1,), (40,), (1, 9), (13, 30)))])
def test_every_rank_occurs_once(make, shape):
    options = QUICK if make is anneal else {}
    ranks = make(shape, seed=3, **options)
    assert ranks.shape == shape and ranks.dtype == np.uint32 and ranks.flags.c_contiguous
    assert is_permutation(ranks)
    assert (ranks == make(shape, seed=3, **options)).all()


@pytest.mark.parametrize(("make", "name", "value"), [
    (void_and_cluster, "sigma", 1.9), (void_and_cluster, "initial_fraction", 0.3),
    *((make, "seed", 1) for make in (mask, void_and_cluster, relax, anneal)), (anneal, "sigma", 2),
    (anneal, "far_sigma", 3), (anneal, "far_weight", 0),
    (anneal, "value_sigma", 0.5), (anneal, "start_temperature", 0.1), (anneal, "end_temperature", 1e-9), (anneal, "sweeps", 21),
    (anneal, "order_ends", False)])
def test_options_reach_the_library(make, name, value):
    options = {**(QUICK if make is anneal else {}), **({"channels": 2} if name == "value_sigma" else {})}
    differ = (make((24, 24), **options) != make((24, 24), **{**options, name: value})).mean()
    # The seed breaks ties at all ranks, not only at the first and last ones, so it determines the whole pattern.
    assert differ > (0.95 if name == "seed" else 0)


@pytest.mark.parametrize("make", [void_and_cluster, relax, anneal])
def test_defaults_match_the_library(make):
    library = getattr(bluenoise._core, make.__name__.title().replace("_", "") + "Options")()
    for name, parameter in inspect.signature(make).parameters.items():
        if hasattr(library, name) and parameter.default is not None:
            assert getattr(library, name) == parameter.default, name


def test_anneal_uses_but_does_not_modify_start_ranks():
    start = white((16, 16), seed=1)
    kept = start.copy()
    none = anneal((16, 16), sweeps=0, order_ends=False, start_from_ranks=start.astype(np.int64))
    assert (none == start).all() and none is not start
    some = anneal((16, 16), start_from_ranks=start, **QUICK)
    assert (start == kept).all() and is_permutation(some) and (some != start).any()
    stacked = np.stack([start, start.T])
    vectors = anneal((16, 16), sweeps=0, channels=2, start_from_ranks=stacked)
    assert (vectors == stacked).all()


def test_builtin_mask():
    ranks = builtin((64, 64))
    assert is_permutation(ranks) and ranks.dtype == np.uint32
    assert (ranks == builtin((64, 64))).all()
    ranks[:] = 0
    assert is_permutation(builtin((64, 64)))


def test_mask_selects_the_documented_generator():
    for shape in ((64, 48), (100,), (4, 8, 8)):
        assert (mask(shape, seed=2) == void_and_cluster(shape, seed=2)).all()
    large = (513, 512)
    assert (mask(large, seed=2) == relax(large, seed=2)).all()
    four = mask((8, 8), channels=4, seed=2)
    assert (four == anneal((8, 8), channels=4, sweeps=100, seed=2)).all()


@needs_network
@needs_package
def test_two_channel_masks_come_from_the_network():
    assert (mask((20, 24), channels=2, seed=2) == neural((20, 24), channels=2, seed=2)).all()


def test_two_channel_masks_without_onnx_runtime_recommend_anneal():
    program = "import os; os.environ['BN_ONNXRUNTIME'] = '/nowhere.so'; import bluenoise; bluenoise.mask((16, 16), channels=2)"
    said = run_python(program).stderr.splitlines()[-1]
    assert "pip install 'onnxruntime" in said and "without it, anneal makes two-channel masks" in said


GENERATORS = [(void_and_cluster, {}), (relax, {}), (anneal, {"sweeps": 3}), (mask, {}),
              pytest.param(neural, {}, marks=[needs_network, needs_package])]


@pytest.mark.parametrize(("make", "options"), GENERATORS)
@pytest.mark.parametrize("size", [16, 128])
def test_progress_ends_at_one(make, options, size):
    ranks, fractions = progress_of(lambda progress: make((size, size), progress=progress, **options), cancel_at=1)
    assert fractions.count(1) == 1 and (ranks == make((size, size), **options)).all()


@pytest.mark.parametrize(("make", "options"), [*GENERATORS, (builtin, {})])
def test_out(make, options):
    out = np.full((64, 64), 7, np.uint32)
    assert make((64, 64), out=out, **options) is out
    assert (out == make((64, 64), **options)).all()
    stack = np.zeros((3, 64, 64), np.uint32)
    make((64, 64), out=stack[1], **options)
    assert (stack[1] == out).all() and not stack[::2].any()


def read_only(array):
    array.setflags(write=False)
    return array


@pytest.mark.parametrize(
    ("out", "error", "words"),
    [
        (np.zeros((8, 9), np.uint32), ValueError, ["out", "(8, 8)", "(8, 9)"]),
        (np.zeros((8, 8), np.int32), ValueError, ["out", "uint32", "int32"]),
        (np.zeros((8, 8), ">u4"), ValueError, ["out", "uint32", ">u4"]),
        (np.zeros((8, 8), np.uint32, order="F"), ValueError, ["out", "C order"]),
        (read_only(np.zeros((8, 8), np.uint32)), ValueError, ["out", "read-only"]),
        ([[0] * 8] * 8, TypeError, ["out"]),
    ],
)
def test_bad_out(out, error, words):
    for make in (void_and_cluster, relax, anneal):
        with refused(error, words):
            make((8, 8), out=out)


@pytest.mark.parametrize(("make", "options"), GENERATORS)
def test_masks_too_large_for_memory_are_rejected_immediately(make, options, monkeypatch):
    monkeypatch.setattr(_arguments, "memory", lambda: 1e6)
    monkeypatch.setattr(np, "empty", None)
    with pytest.raises(MemoryError, match=r"\(1000, 1000\).* GB"):
        make((1000, 1000), **options)


def test_shape_of_start_ranks_is_checked_before_they_are_read(monkeypatch):
    monkeypatch.setattr(_arguments, "integers", None)
    with pytest.raises(ValueError, match=r"start_from_ranks .*\(16, 16\)"):
        anneal((8, 8), start_from_ranks=np.zeros((16, 16), int))


@pytest.fixture
def changing(monkeypatch):
    """Ranks that change while they are being checked, as if another thread wrote to them."""
    ranks = mask((16, 16), seed=1)
    check = _arguments.is_permutation

    def check_while_changing(flat):
        ranks[:] = 2**32 - 1
        return check(flat)

    monkeypatch.setattr(_arguments, "is_permutation", check_while_changing)
    return ranks


@pytest.mark.parametrize(
    "call",
    [
        lambda ranks: bluenoise.Sampler("mask", mask=ranks).sample(3, 4, 0),
        lambda ranks: bluenoise.dither(np.full((16, 16), 0.3), mask=ranks),
        lambda ranks: anneal((16, 16), sweeps=2, start_from_ranks=ranks),
        lambda ranks: bluenoise.points(20, method="mask", mask=ranks),
        bluenoise.dithering_error,
        bluenoise.power_spectrum,
    ],
)
def test_arrays_are_copied_before_they_are_checked(call, changing):
    expected_ranks = changing.copy()
    found = call(changing)
    assert (changing == 2**32 - 1).all()
    np.testing.assert_array_equal(found, call(expected_ranks))


def test_exceptions_in_progress_callbacks_propagate():
    def fail(fraction):
        raise LookupError("enough")

    with pytest.raises(LookupError, match="enough"):
        mask((128, 128), progress=fail)

    class Unclear:
        def __bool__(self):
            raise ArithmeticError("neither true nor false")

    with pytest.raises(ArithmeticError):
        mask((128, 128), progress=lambda fraction: Unclear())


def test_to_float():
    ranks = mask((16, 16), seed=1)
    values = to_float(ranks)
    assert values.dtype == np.float32 and values.shape == (16, 16)
    np.testing.assert_array_equal(values, ((ranks + 0.5) / 256).astype(np.float32))
    assert to_float(np.arange(4).reshape(2, 2)).tolist() == [[0.125, 0.375], [0.625, 0.875]]
    assert to_float(ranks[3], count=256).tolist() == values[3].tolist()
    assert (to_float(np.asfortranarray(ranks)) == values).all()
    assert to_float([]).shape == (0,)
    assert to_float(ranks.T[::-1]).tolist() == values.T[::-1].tolist()


@pytest.mark.parametrize("shape", [(16, 16), (40,)])
@pytest.mark.parametrize("channels", [2, 4])
def test_to_float_converts_each_channel_separately(shape, channels):
    ranks = anneal(shape, channels=channels, **QUICK)
    values = to_float(ranks)
    assert ranks.shape == (channels, *shape) and all(is_permutation(own) for own in ranks)
    for own, found in zip(ranks, values):
        assert (found == to_float(own)).all()
    assert values.max() > 0.98
    deep = mask((4, 8, 8))
    assert (to_float(deep) == to_float(deep.reshape(-1)).reshape(4, 8, 8)).all()
    assert (to_float(ranks.reshape(-1), count=ranks.size) == to_float(ranks, count=ranks.size).reshape(-1)).all()
