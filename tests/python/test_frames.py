# SPDX-License-Identifier: Apache-2.0
"""Following a moving image keeps the error that averaged frames have at rest. Pans and the frames of films are those of bn_path.h."""

import functools

import numpy as np
import pytest
from helpers import refused
from scipy import ndimage

import bluenoise

SIDE, EDGE, FRAMES, WEIGHT = 128, 32, 40, 0.1
Y, X = np.mgrid[0:SIDE, 0:SIDE]


def half_planes():
    """(normal, offset, area) of half-planes through the unit square."""
    random, middles = np.random.default_rng(5), (np.arange(256) + 0.5) / 256
    grid = np.stack(np.meshgrid(middles, middles), -1)
    for angle in random.uniform(0, 2 * np.pi, 8):
        normal = np.array([np.cos(angle), np.sin(angle)])
        offset = normal @ random.uniform(0, 1, 2)
        yield normal, offset, (grid @ normal < offset).mean()


PLANES = list(half_planes())


@functools.cache
def error_of_average(motion, followed=(0.0, 0.0), cut=None):
    """RMSE, after a blur of 1.0, of frames averaged along their motion. A cut discards the history and makes one motion useless."""
    sampler, pan, averages = bluenoise.Sampler("blue", seed=1), bluenoise.Pan(), None
    for frame in range(FRAMES):
        u = bluenoise.PathSampler(sampler, X - pan.x, Y - pan.y, frame).ray(0).draw_direction()
        errors = np.stack([(u @ normal < offset) - area for normal, offset, area in PLANES])
        if averages is None or frame == cut:
            averages = errors
        else:
            shifted = ndimage.shift(averages, (0, motion[1], motion[0]), order=1, mode="nearest")
            averages = (1 - WEIGHT) * shifted + WEIGHT * errors
        pan.follow(*((np.nan, 1e9) if frame + 1 == cut else followed))
    blurred = ndimage.gaussian_filter(averages, (0, 1, 1))[:, EDGE:-EDGE, EDGE:-EDGE]
    return np.sqrt(np.mean(blurred**2))


@pytest.mark.slow
@pytest.mark.parametrize("motion", [(2, 1), (-2.3, -1.6)])
def test_following_keeps_the_error_at_rest(motion):
    rest = error_of_average((0, 0))
    assert error_of_average(motion, motion) < 1.15 * rest
    assert error_of_average(motion) > 1.4 * rest


@pytest.mark.slow
def test_following_after_a_cut():
    assert error_of_average((2.5, 1.2), (2.5, 1.2), cut=5) < 1.15 * error_of_average((0, 0), cut=5)


def test_pans_are_exact_sums():
    motions = np.random.default_rng(3).normal(0, 3, (500, 2, 4)).astype(np.float32)
    pans, one = bluenoise.Pan((4,)), bluenoise.Pan()
    for x, y in motions:
        pans.follow(x, y)
        one.follow(x[0], y[0])
    units = np.trunc(motions.astype(np.float64) * 2**24).astype(np.int64).sum(0)
    expected = (units + 2**23) >> 24
    assert pans.x.tolist() == expected[0].tolist() and pans.y.tolist() == expected[1].tolist()
    assert (one.x, one.y) == tuple(expected[:, 0]) and type(one.x) is int
    assert pans.x.dtype == np.int32 and repr(one) == f"Pan(x={one.x}, y={one.y})"


def test_useless_motions_count_as_zero():
    pan = bluenoise.Pan()
    pan.follow(-1.5, 2.5)
    for motion in (np.nan, np.inf, -np.inf, 2.0**24, -1e300):
        pan.follow(motion, motion)
    assert (pan.x, pan.y) == (-1, 3)


def test_arguments_of_pans():
    pan = bluenoise.Pan((2, 3))
    with refused(ValueError, ["x must broadcast to (2, 3)", "(4,)"]):
        pan.follow(np.ones(4), 1)
    with refused(TypeError, ["y must hold numbers", "up"]):
        pan.follow(1, "up")
    assert not pan.x.any()


def test_frames_of_a_film():
    frames, most = np.arange(40), 100
    first = bluenoise.frame_index(frames, most)
    assert first.dtype == np.uint32 and first.tolist() == (128 * frames).tolist()
    assert not bluenoise.frame_stream(frames, most).any()
    assert (bluenoise.frame_index(2**22 + 1, 1000), bluenoise.frame_stream(2**22 + 1, 1000)) == (1024, 1)
    assert bluenoise.frame_index(7, [1, 2**32 - 1]).tolist() == [7, 0]
    assert bluenoise.frame_stream(7, [1, 2**32 - 1]).tolist() == [0, 7]
    with refused(ValueError, ["frame must be in", "-1"]):
        bluenoise.frame_index(-1, 16)
    with refused(TypeError, ["most must hold integers", "1.5"]):
        bluenoise.frame_stream(1, 1.5)
