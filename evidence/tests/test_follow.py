# SPDX-License-Identifier: Apache-2.0
"""What draws follow: motions, tiles, and the errors of simple averages."""

import pytest

from evidence.realtime import follow

pytest.importorskip("bluenoise")


def test_tiles_follow_their_median_and_layers_their_motion():
    x, y, front = follow.two_layers(follow.FRAMES - 1)
    assert front[follow.SIDE // 2, follow.SIDE // 2] and not front[0, 0]
    assert (x[0, 0], y[0, 0]) == (-2, 0) and (x[front] == 3).all()
    tiles = follow.in_tiles(x)
    assert (tiles[:follow.TILE, :follow.TILE] == -2).all() and (tiles[follow.TILE:-follow.TILE, follow.TILE:-follow.TILE] == 3).all()


def test_a_pan_that_follows_has_the_error_at_rest():
    integrands = follow.planes(2)
    rest, fixed, following = (follow.error("blue", motion, way, integrands) for motion, way in (
        ("rest", "fixed"), ("pan by 2.5 pixels", "fixed"), ("pan by 2.5 pixels", "one pan")))
    assert following < 1.15 * rest < fixed


def test_choosing_a_lobe_from_the_direction_lowers_the_error():
    integrands = follow.planes(2)
    assert follow.lobe_error(0.5, 0.1, True, integrands) < 0.7 * follow.lobe_error(0.5, 0.1, False, integrands)
