# SPDX-License-Identifier: Apache-2.0
"""Arrays as NumPy users have them: functions take any memory order, and refuse other values with one line that names the argument."""

import functools

import numpy as np
import pytest
from helpers import refused

import bluenoise
from bluenoise import Sampler, dither

RANKS = bluenoise.mask((6, 8), seed=1)
LAYOUTS = {
    "Fortran order": np.asfortranarray,
    "transposed": lambda array: np.ascontiguousarray(np.swapaxes(array, 0, -1)).swapaxes(0, -1),
    "reversed": lambda array: np.ascontiguousarray(array[::-1])[::-1],
    "strided": lambda array: np.repeat(np.repeat(array, 2, axis=0), 3, axis=-1)[::2, ..., ::3],
    "unaligned": lambda array: np.frombuffer(b"?" + array.tobytes(), array.dtype, offset=1).reshape(array.shape),
    "read-only": lambda array: np.frombuffer(array.tobytes(), array.dtype).reshape(array.shape),
    "big-endian": lambda array: array.astype(array.dtype.newbyteorder(">")),
    "convertible": lambda array: Convertible(np.asfortranarray(array)),
}


class Convertible:
    """Stands for a pandas DataFrame or an xarray DataArray."""

    def __init__(self, array):
        self.array = array

    def __array__(self, dtype=None, copy=None):
        return self.array if dtype is None else self.array.astype(dtype)

    def __repr__(self):
        return "  a  b\n0 1  2"


def image(dtype, *shape):
    full = np.iinfo(dtype).max if np.issubdtype(dtype, np.integer) else 1
    return (np.random.default_rng(2).random(shape) * full).astype(dtype)


@pytest.mark.parametrize("layout", LAYOUTS.values(), ids=LAYOUTS)
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float16, np.float32, np.float64])
@pytest.mark.parametrize("shape", [(9, 11), (9, 11, 3)])
def test_dither_takes_any_layout(layout, dtype, shape):
    given = image(dtype, *shape)
    values = bluenoise.to_float(RANKS)
    for mask, arranged in ((None, None), (RANKS, layout(RANKS)), (values, layout(values)), (np.stack([RANKS] * 3), np.stack([RANKS] * 3))):
        expected, found = dither(given, 4, mask=mask), dither(layout(given), 4, mask=arranged)
        assert found.dtype == np.asarray(layout(given)).dtype and (found == expected).all()


@pytest.mark.parametrize("layout", LAYOUTS.values(), ids=LAYOUTS)
def test_other_functions_take_any_layout(layout):
    values = bluenoise.to_float(RANKS)
    grid, sampler = np.arange(48, dtype=np.int32).reshape(6, 8), Sampler(seed=1)
    for call in (
            bluenoise.to_float, bluenoise.dithering_error, bluenoise.power_spectrum,
            lambda ranks: Sampler("mask", mask=ranks).sample(3, 4, 5),
            lambda ranks: bluenoise.points(9, method="mask", mask=ranks, jitter=False),
            lambda ranks: bluenoise.anneal((6, 8), sweeps=1, start_from_ranks=ranks)):
        assert np.array_equal(call(layout(RANKS)), call(RANKS))
    assert repr(bluenoise.measure(layout(values))) == repr(bluenoise.measure(values))  # NaN differs from itself
    for call in (lambda x: sampler.sample(x, grid.T[:6, :1], 3), lambda x: sampler.sample(0, 0, 0, x), lambda x: bluenoise.domain(x, 3),
                 lambda x: bluenoise.PathSampler(sampler, x, 0, 0).ray(x).next_1d(), lambda x: bluenoise.choose_u32(x, 0.3)):
        for found, expected in zip(call(layout(grid + 1)), call(grid + 1)):
            assert np.array_equal(found, expected)
    for found, expected in zip(bluenoise.choose(layout(values), layout(values)), bluenoise.choose(values, values)):
        assert np.array_equal(found, expected)


@pytest.mark.parametrize("dtype", [np.float32, np.float64, np.longdouble])
@pytest.mark.parametrize("levels", [2, 4, 7, 256])
def test_levels_have_the_precision_of_the_image(dtype, levels):
    expected = np.arange(levels).astype(dtype) / dtype(levels - 1)
    assert np.array_equal(np.unique(dither(np.linspace(0, 1, 64 * 64, dtype=dtype).reshape(64, 64), levels)), expected)


def test_masked_elements_are_refused():
    masked = np.ma.masked_equal(image(np.uint8, 4, 4), 3)
    masked[0, 0] = np.ma.masked
    for call in (dither, bluenoise.measure, bluenoise.to_float):
        with refused(ValueError, ["masked elements", ".filled(0)"]):
            call(masked)
    whole = np.ma.array(RANKS)
    assert (bluenoise.to_float(whole) == bluenoise.to_float(RANKS)).all()


class Broken:
    def __array__(self, dtype=None, copy=None):
        raise AttributeError("two\nlines")


HOSTILE = [
    None, "text", "x" * 1000, b"bytes", object(), Broken(), True, -1, 2**64, 10**400, 1.5, float("nan"), 1j, [], [[]], [1, [2, 3]], {},
    {"a": 1}, np.float64(0.5), np.array(3), np.array([[3]]), np.array(None), np.array(["a"]), np.array([1, None], object),
    np.array([1, 2], object),
    np.zeros((4, 4)), np.zeros((4, 4), bool), np.zeros((4, 4), complex), np.zeros(4, "M8[s]"), np.zeros(4, [("a", "u4")]), np.zeros((0, 4)),
    np.zeros((2,) * 5), np.ma.array(RANKS, mask=RANKS == 3), memoryview(RANKS), Convertible(RANKS), Convertible(np.zeros(3)),
    *(layout(RANKS) for layout in LAYOUTS.values()), iter([1]), (4.0, 4), ("4", "4"), (0, 4), (4, 4, 4, 4), np.random.default_rng(0), type,
]
CALLS = {
    bluenoise.mask: {"shape": (6, 8), "seed": 0, "channels": 1, "out": None, "progress": None},
    bluenoise.void_and_cluster: {"shape": (6, 8), "sigma": 1.5, "initial_fraction": 0.1, "out": None},
    bluenoise.relax: {"shape": (6, 8), "threads": 1, "out": None},
    bluenoise.anneal: {"shape": (6, 8), "channels": 1, "far_sigma": None, "order_ends": True, "start_from_ranks": None, "sweeps": 1},
    bluenoise.builtin: {"shape": (16, 16), "out": None},
    bluenoise.to_float: {"ranks": RANKS, "count": None},
    bluenoise.dither: {"image": np.zeros((4, 4), np.uint8), "levels": 2, "mask": None, "srgb": False, "channel_offset": True},
    functools.partial(dither, srgb=True): {"image": np.zeros((4, 4, 3), np.uint8), "palette": [[0, 0, 0], [9, 255, 3]], "mask": None},
    bluenoise.measure: {"mask": RANKS, "progress": None},
    bluenoise.dithering_error: {"mask": RANKS, "sigma": 1},
    bluenoise.anisotropy: {"masks": [RANKS]},
    bluenoise.radial_power: {"mask": RANKS},
    bluenoise.visible_noise: {"first": np.zeros((4, 4)), "second": np.zeros((4, 4)), "sigma": 1, "window": 3, "progress": None},
    bluenoise.points: {"n": 4, "method": "mask", "seed": 0, "candidates": None, "mask": RANKS, "jitter": None},
    functools.partial(bluenoise.points, 4, method="poisson-disk"): {"density": np.ones((4, 4)), "dims": 2},
    bluenoise.Pan: {"shape": (4,)},
    bluenoise.Pan((4,)).follow: {"x": 1.5, "y": 2},
    bluenoise.frame_index: {"frame": 3, "most": 4},
    bluenoise.frame_stream: {"frame": 3, "most": 4},
    bluenoise.Sampler: {"type": "mask", "seed": 0, "samples_per_pixel": 0, "mask": RANKS},
    Sampler().sample: {"x": np.arange(4), "y": 0, "index": 0, "domain": 0, "dims": 2, "pair": None, "out": None},
    Sampler().block: {"x0": 0, "y0": 0, "width": 2, "height": 2, "first_index": 0, "index_count": 1, "domain": 0, "dims": 4, "out": None},
    bluenoise.PathSampler: {"sampler": Sampler(), "x": 0, "y": 0, "index": 0, "stream": 0},
    bluenoise.PathSampler(Sampler(), [1, 2], 0, 0).ray: {"number": 0},
    bluenoise.choose: {"probability": 0.5, "u": 0.5},
    bluenoise.choose_u32: {"count": 3, "u": 0.5},
    bluenoise.choose_cdf: {"cdf": [0.5, 1], "u": 0.5},
}


# These have tests of their own, here or in other files, or take no arrays.
ELSEWHERE = {"NeuralGenerator", "domain", "load", "neural", "power_spectrum", "save", "tables"}


def test_every_public_function_is_tried():
    tried = {call.func.__name__ if isinstance(call, functools.partial) else call.__name__ for call in CALLS}
    made = {"LoopSampler", "MaskMeasures", "RaySampler", "Split"}  # by methods
    named = {name for name in bluenoise.__all__ if callable(getattr(bluenoise, name)) and getattr(bluenoise, name).__module__ != "typing"
             and not (isinstance(getattr(bluenoise, name), type) and issubclass(getattr(bluenoise, name), Exception))}
    assert named <= tried | made | ELSEWHERE, named - tried - made - ELSEWHERE


@pytest.mark.parametrize("call", CALLS, ids=lambda call: getattr(call, "__name__", "partial"))
def test_other_values_are_refused_with_one_line(call):
    """No message of pybind11 or of another library reaches the caller."""
    known, refusals = CALLS[call], 0
    for name in known:
        for value in HOSTILE:
            if name == "index_count" and isinstance(value, np.ndarray):
                continue
            try:
                call(**{**known, name: value})
            except ImportError:
                pytest.skip("needs SciPy")
            except (ValueError, TypeError, MemoryError, bluenoise.CancelledError) as error:
                refusals += 1
                said = str(error)
                assert "\n" not in said and "incompatible function" not in said and len(said) < 330, (name, value, said)
                # A valid type may contradict another argument, which the message names.
                others = [] if isinstance(error, TypeError) else [each.rstrip("s") for each in known]
                assert isinstance(error, bluenoise.CancelledError) or any(each in said for each in (name, *others)), (name, value, said)
    assert refusals > 20 * len(known)


@pytest.mark.parametrize("value", HOSTILE, ids=lambda value: type(value).__name__)
def test_save_refuses_other_values_with_one_line(value, tmp_path):
    for name in ("mask.npy", "mask.png"):
        try:
            bluenoise.save(tmp_path / name, value)
        except (ValueError, TypeError) as error:
            assert "mask" in str(error) and "\n" not in str(error)
