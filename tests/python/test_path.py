# SPDX-License-Identifier: Apache-2.0
"""Array paths are bit-identical to those of bn_path.h, which tests/c checks. Error messages state the argument's name and value."""

import copy
import pickle

import numpy as np
import pytest
from hashes import hash_of, table

from bluenoise import LoopSampler, PathSampler, Sampler, _path


def test_paths_match_the_c_hash():
    """Repeats the paths that tests/c/test_draw_hashes.c hashes, for sixteen pixels and six indices."""
    pixel, index = np.arange(96) // 6, np.tile([0, 1, 5, 255, 256, 70000], 16)
    path = PathSampler(Sampler(seed=1), 3 * pixel - 20, 100 - 37 * pixel, index)
    found = np.zeros(96, np.uint32)
    for depth in range(8):
        ray = path.ray(depth)
        numbers = [ray.draw(), *(ray.next_1d() for _ in range(5)), *(ray.next_2d() for _ in range(3)), ray.next_4d()]
        rng = ray.next_loop()
        numbers += [rng.next_1d() for _ in range(6)]
        split, running = ray.next_split(3), ray.next_split_from(9)
        numbers += [split[k].ray(1).draw_end_light()[:, 0] for k in range(4)]
        numbers += [running[k].ray(0).draw_direction()[:, 0] for k in range(2)]
        numbers.append(ray.child(77).next_1d())
        for column in np.column_stack(numbers).T:
            assert column.dtype == np.float32
            found = (found ^ column.view(np.uint32)) * np.uint32(0x01000193)
    assert hash_of(found) == table()["paths"]


def test_explicit_counters_match_implicit_ones():
    path = PathSampler(Sampler(seed=2), np.arange(4), 7, [[0], [9]])
    ray, counted = path.ray(1), path.ray(1)
    for k in range(6):
        np.testing.assert_array_equal(ray.draw_1d(k), counted.next_1d())
        np.testing.assert_array_equal(ray.draw_2d(k), counted.next_2d())
        np.testing.assert_array_equal(ray.draw_4d(k), counted.next_4d())
        np.testing.assert_array_equal(ray.draw_split(k, 3)[k].ray(0).draw(), counted.next_split(3)[k].ray(0).draw())
        np.testing.assert_array_equal(ray.draw_loop(k).next_1d(), counted.next_loop().next_1d())
        assert (ray.draw_loop(k).next_1d() != ray.draw_split(k, 3)[0].ray(0).draw()[..., 0]).all()
    np.testing.assert_array_equal(ray.next_1d(), ray.draw_1d(0))  # explicit counters do not advance the implicit ones


def test_shapes_broadcast():
    sampler = Sampler(seed=3)
    y, x = np.mgrid[0:4, 0:5]
    path = PathSampler(sampler, x, y, np.arange(3)[:, None, None])
    assert path.shape == (3, 4, 5)
    ray = path.ray(1)
    split, rng = ray.next_split(2), ray.next_loop()
    assert ray.draw().shape == (3, 4, 5, 4) and ray.draw_direction().shape == ray.next_2d().shape == (3, 4, 5, 2)
    assert [ray.next_1d().shape for _ in range(3)] == [(3, 4, 5)] * 3
    assert [rng.next_1d().shape for _ in range(6)] == [(3, 4, 5)] * 6
    branches = split[np.arange(2)[:, None, None, None]]
    assert branches.shape == (2, 3, 4, 5)
    each = [branch.ray(0).draw() for branch in split]
    assert len(each) == 2
    np.testing.assert_array_equal(branches.ray(0).draw(), each)
    assert path.first_light(4, np.arange(4)[:, None, None, None]).shape == (4, 3, 4, 5, 2)
    # An array of paths at different rays draws the same numbers as each path does alone.
    number = np.arange(3)[:, None, None]
    mixed = path.ray(number)
    assert mixed.shape == (3, 4, 5)
    for i in range(3):
        alone = PathSampler(sampler, x, y, i).ray(i)
        np.testing.assert_array_equal(mixed.draw()[i], alone.draw())
    assert ray.child([[7], [8], [9], [7]]).next_4d().shape == (3, 4, 5, 4)
    one = PathSampler(sampler, 1, 2, 3)
    assert one.shape == () and one.ray(0).draw().shape == (4,) and one.ray(0).next_1d().shape == ()
    assert one.ray(0).next_loop().next_1d().shape == () and one.time_wavelength().shape == (2,)
    assert PathSampler(sampler, [], 0, 0).ray(0).next_split(2)[1].ray(0).draw().shape == (0, 4)


def test_frames_and_samples_differ():
    sampler = Sampler(seed=1)
    seen = [tuple(PathSampler(sampler, 5, 6, index, stream).ray(ray).draw())
            for index in range(4) for stream in range(4) for ray in range(4)]
    assert len(set(seen)) == 64
    assert PathSampler(sampler, 5, 6, 1, stream=[0, 0, 0]).time_wavelength().shape == (3, 2)
    both = PathSampler(sampler, 5, 6, 1, stream=[0, 3]).ray(2).draw()
    assert [tuple(row) for row in both] == [tuple(PathSampler(sampler, 5, 6, 1, stream).ray(2).draw()) for stream in (0, 3)]


def test_paths_copy_their_coordinates():
    x, index = np.arange(5, dtype=np.int32), np.arange(5, dtype=np.uint32)
    path = PathSampler(Sampler(), x, 0, index)
    before = path.ray(1).draw()
    x += 7
    index += 1
    np.testing.assert_array_equal(path.ray(1).draw(), before)


@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy, pickle.dumps])
def test_stateful_samplers_cannot_be_copied(copied):
    path = PathSampler(Sampler(seed=1), 2, 3, 4)
    for each in (path.ray(0), path.ray(0).next_loop()):
        with pytest.raises(TypeError, match=f"a {type(each).__name__} cannot be copied or pickled"):
            copied(each)
    again = pickle.loads(pickle.dumps(path)) if copied is pickle.dumps else copied(path)
    np.testing.assert_array_equal(again.ray(2).draw(), path.ray(2).draw())


@pytest.mark.parametrize("call", ["next_1d", "next_2d", "next_4d", "next_loop", lambda ray: ray.next_split(2),
                                  lambda ray: ray.next_split_from(0)])
def test_interrupted_draws_are_not_counted(monkeypatch, call):
    def draw(ray):
        found = call(ray) if callable(call) else getattr(ray, call)()
        while not isinstance(found, np.ndarray):
            found = found.next_1d() if isinstance(found, LoopSampler) else found[0].ray(0).draw()
        return found

    def interrupt(*_):
        raise KeyboardInterrupt

    path = PathSampler(Sampler(seed=4), [1, 2], 3, 0)
    ray, other = path.ray(1), path.ray(1)
    expected = [draw(other) for _ in range(4)]
    found = [draw(ray), draw(ray)]
    with monkeypatch.context() as patched, pytest.raises(KeyboardInterrupt):
        for name in ("_singles", "draw_2d", "draw_4d", "_split_domain", "draw_loop"):
            patched.setattr(_path.RaySampler, name, interrupt)
        draw(ray)
    np.testing.assert_array_equal([*found, draw(ray), draw(ray)], expected)
