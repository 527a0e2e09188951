# SPDX-License-Identifier: Apache-2.0
"""Films: which samples a frame takes, the model of the eye, and crops that move with the image."""

import numpy as np
import pytest

from evidence.films import films

pytest.importorskip("bluenoise")


def test_frames_of_a_way_share_no_samples_and_the_base_shares_no_seed():
    for way in films.STILL:
        taken = [(seed, first + i) for seed, first in (films.own_samples(way, 1, frame, 16) for frame in range(4)) for i in range(16)]
        assert len(set(taken)) == 64 and {seed for seed, _ in taken} == {1}
    assert len({films.own_samples(films.BASE, seed, frame, 16) for seed in range(3) for frame in range(8)}) == 24


@pytest.mark.parametrize("rate", films.RATES)
def test_the_eye_weighs_recent_frames_most(rate):
    weights = films.eye_weights(rate)
    assert weights.sum() == pytest.approx(1) and (weights > 0).all()
    # The response has its peak 60 ms after the light.
    assert abs((len(weights) - 1 - weights.argmax() + 0.5) / rate - films.PEAK) <= 0.5 / rate


def test_gazes_see_what_stays_in_place_for_them():
    random, speed = np.random.default_rng(1), 3
    weights = films.eye_weights(24)
    image = random.normal(size=films.PAN_CROP[::-1])
    assert np.allclose(films.seen(np.stack([image] * len(weights)), weights, speed, "follows"), image)
    screen = random.normal(size=(films.PAN_CROP[1], films.PAN_CROP[0] + speed * len(weights)))
    frames = np.stack([screen[:, speed * k:][:, :films.PAN_CROP[0]] for k in range(len(weights))])
    seen = films.seen(frames, weights, speed, "is fixed")
    assert np.allclose(seen, screen[:, speed * (len(weights) - 1):films.PAN_CROP[0]])


@pytest.mark.parametrize("scene", films.PAN_SCENES)
def test_crops_of_a_pan_move_with_the_image(scene):
    for speed in films.SPEEDS:
        film = films.pan_film(scene, speed)
        middle = [np.add(corner, np.array(films.PAN_CROP) / 2) for _, corner, _ in film]
        point = film[0][0].points(*middle[0], np.array(2.0))
        for (camera, _, offset), at in zip(film, middle):
            x, y, _ = camera.project(point)
            assert abs(x - at[0]) < 1e-3 and abs(y - at[1]) < 0.6
            assert offset == tuple((at - middle[0]).astype(int))
