# SPDX-License-Identifier: Apache-2.0
"""Ways to follow a moving image: motions, tiles, and the errors of simple averages."""

import numpy as np
import pytest

from evidence.realtime import follow
from evidence.realtime.realtime import half_plane

pytest.importorskip("bluenoise")


def test_tiles_follow_their_median_and_layers_their_motion():
    x, y, front = follow.two_layers(follow.FRAMES - 1)
    assert front[follow.SIDE // 2, follow.SIDE // 2] and not front[0, 0]
    assert (x[0, 0], y[0, 0]) == (-2, 0) and (x[front] == 3).all()
    tiles = follow.in_tiles(x)
    assert (tiles[:follow.TILE, :follow.TILE] == -2).all() and (tiles[follow.TILE:-follow.TILE, follow.TILE:-follow.TILE] == 3).all()


INTEGRANDS = [half_plane(np.random.default_rng([7, i])) for i in range(2)]


def test_a_pan_that_follows_has_the_error_at_rest():
    rest, fixed, following = (follow.error("blue", motion, way, INTEGRANDS) for motion, way in (
        ("rest", "fixed"), ("pan by 2.5 pixels", "fixed"), ("pan by 2.5 pixels", "one `bn_pan`")))
    assert following < 1.15 * rest < fixed


def test_choosing_a_lobe_from_the_direction_lowers_the_error():
    rescaled, separate = (follow.settled_blue(0.1, INTEGRANDS, lobe=(0.5, own))[0] for own in (True, False))
    assert rescaled < 0.7 * separate
