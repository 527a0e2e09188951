# SPDX-License-Identifier: Apache-2.0
"""The draws of the Mitsuba sampler without Mitsuba: NumPy stands in for what it takes of Dr.Jit and of Mitsuba, so that these tests run
everywhere. tests/python/test_mitsuba.py has those with Mitsuba."""

import importlib
import sys
from types import SimpleNamespace

import numpy as np
import pytest

import bluenoise

SIZE, SEED = 64, 5


def reversed_bits(v):
    return np.array([int(f"{int(each):032b}"[::-1], 2) for each in np.ravel(v)], np.uint32).reshape(np.shape(v))


class Sampler:
    """mitsuba.Sampler: its constructor, and the wavefront that it remembers."""

    def __init__(self, props):
        self._size = 1

    def seed(self, seed, wavefront_size):
        self._size = wavefront_size

    def wavefront_size(self):
        return self._size

    def sample_count(self):
        return 16


def no_sensor(*_):
    raise RuntimeError("nothing has the number")


@pytest.fixture
def module(monkeypatch):
    """bluenoise.mitsuba with the stand-ins, in a vectorised variant."""
    words = SimpleNamespace(UInt32=lambda v=0: np.array(v, np.uint32, ndmin=1), Float=lambda v: np.asarray(v, np.float32),
                            Point2f=lambda x, y: (x, y), Sampler=Sampler, SensorPtr=None, variant=lambda: "stand_in",
                            detail=SimpleNamespace(add_variant_callback=lambda callback: None),
                            register_sampler=lambda name, make: made.append(make))
    arrays = SimpleNamespace(
        select=lambda which, yes, no: np.where(which, yes, no).astype(np.result_type(yes, no)), brev=reversed_bits,
        gather=lambda kind, table, at: table[at], opaque=lambda kind, v: kind(v), make_opaque=lambda v: None,
        arange=lambda kind, size: np.arange(size, dtype=np.uint32), schedule=lambda *_: None, reinterpret_array=no_sensor)
    made = []
    monkeypatch.setitem(sys.modules, "drjit", arrays)
    monkeypatch.setitem(sys.modules, "mitsuba", words)
    monkeypatch.delitem(sys.modules, "bluenoise.mitsuba", raising=False)
    module = importlib.import_module("bluenoise.mitsuba")
    monkeypatch.setattr(module, "_registered_film", lambda sampler: None)
    yield SimpleNamespace(make=lambda: made[0]({"seed": SEED}), lanes=module._Lanes, words=words)
    sys.modules.pop("bluenoise.mitsuba", None)


def test_every_pair_of_a_domain_has_the_bits_of_the_library(module):
    random = np.random.default_rng(3)
    x, y = (random.integers(-5000, 5000, 4096).astype(np.int32) for _ in range(2))
    domain = random.integers(0, 2**32, 4096, dtype=np.uint32)
    sampler = bluenoise.Sampler("blue", seed=SEED)
    lanes = module.lanes(bluenoise.tables(), [np.uint32(word) for word in sampler.seed_words()], np.zeros(1, np.uint32),
                         x.astype(np.uint32), y.astype(np.uint32))
    with np.errstate(over="ignore"):
        for last in (1, 255, 256, 5000, 2**32 - 1):
            index = random.integers(0, last + 1, 4096, dtype=np.uint32)
            at = lanes.at_index(index, last)
            for pair in range(4):
                found = np.stack(at.draw(domain, np.full(4096, pair, np.uint32)), -1)
                np.testing.assert_array_equal(found, sampler.sample(x, y, index, domain, pair=pair))


def test_draws_come_in_the_order_that_the_guide_gives(module):
    """Pairs 2 r and 2 r + 1 are where ray r goes and the light where it ends; numbers between belong to the next ray."""
    sampler, blue = module.make(), bluenoise.Sampler("blue", seed=SEED)
    with np.errstate(over="ignore"):
        sampler.seed(0, SIZE)
        y, x = np.divmod(np.arange(SIZE), 8)
        for index in range(3):
            path = bluenoise.Path(blue, x, y, index)
            for number in range(5):
                ray = path.ray(number)
                singles = [sampler.next_1d() for _ in range(3)] if number else []
                np.testing.assert_array_equal(np.stack(sampler.next_2d(), -1), ray.draw_where())
                for each in singles:
                    np.testing.assert_array_equal(each, ray.next_1d())
                np.testing.assert_array_equal(np.stack(sampler.next_2d(), -1), ray.draw_light())
            sampler.advance()


def test_scalar_variants_draw_in_the_same_order(module):
    module.words.variant = lambda: "scalar_rgb"
    sampler, blue = module.make(), bluenoise.Sampler("blue", seed=SEED)
    sampler._order = SimpleNamespace(pixel=lambda number: (0, number % 8, number // 8))
    for pixel in (0, 13):
        sampler.seed(pixel)
        for index in range(2):
            path = bluenoise.Path(blue, pixel % 8, pixel // 8, index)
            for number in range(3):
                ray = path.ray(number)
                single = sampler.next_1d()
                assert sampler.next_2d() == tuple(ray.draw_where().tolist())
                assert single == ray.next_1d()
                assert sampler.next_2d() == tuple(ray.draw_light().tolist())
            sampler.advance()
