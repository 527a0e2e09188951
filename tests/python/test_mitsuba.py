# SPDX-License-Identifier: Apache-2.0
"""The Mitsuba sampler is bit-identical to the library, uses the correct pixel coordinates and works in recorded loops."""

import functools

import numpy as np
import pytest
from helpers import run_python

mitsuba = pytest.importorskip("mitsuba")
drjit = pytest.importorskip("drjit")
import bluenoise.mitsuba

pytestmark = pytest.mark.slow
SAMPLER = bluenoise.Sampler("blue", seed=5)


@functools.cache
def finds_llvm():
    """Tries LLVM in a separate process, because a version that is too old aborts the process."""
    return run_python("import mitsuba; mitsuba.set_variant('llvm_ad_rgb'); "
                      "print(mitsuba.render(mitsuba.load_dict(mitsuba.cornell_box()), spp=1))").returncode == 0


@pytest.fixture
def llvm():
    if not finds_llvm():
        pytest.skip("Mitsuba finds no LLVM; install libllvm19 or set DRJIT_LIBLLVM_PATH")
    mitsuba.set_variant("llvm_ad_rgb")


def scene_of(integrator, width, height, spp, crop=None, border=False, filter="box", sensor=(), seed=5):
    film = {"type": "hdrfilm", "width": width, "height": height, "rfilter": {"type": filter}, "sample_border": border,
            "pixel_format": "rgb", "component_format": "float32"}
    if crop:
        film |= dict(zip(("crop_offset_x", "crop_offset_y", "crop_width", "crop_height"), crop))
    return mitsuba.load_dict({
        "type": "scene", "integrator": integrator,
        "light": {"type": "constant"},
        "floor": {"type": "rectangle", "bsdf": {"type": "diffuse"}},
        "sensor": {"type": "perspective", "to_world": mitsuba.ScalarTransform4f().look_at([0, -3, 2], [0, 0, 0], [0, 0, 1]),
                   "film": film, "sampler": {"type": "bluenoise", "sample_count": spp, "seed": seed}, **dict(sensor)}})


def own(x, y, index, pair, frame=0):
    """The two-dimensional draw number `pair` of each path, from the Python package."""
    ray = bluenoise.PathSampler(SAMPLER, x, y, index, frame).ray(pair // 2)
    return ray.draw_end_light() if pair % 2 else ray.draw_direction()


def single(x, y, index, ray, k, frame=0):
    """Single number `k` of a ray, from the Python package."""
    ray = bluenoise.PathSampler(SAMPLER, x, y, index, frame).ray(ray)
    return [ray.next_1d() for _ in range(k + 1)][k]


def register_probe():
    """Registers an integrator that returns the numbers of a 2-D draw and a 1-D draw as radiance."""
    class Probe(mitsuba.SamplingIntegrator):
        def __init__(self, props):
            mitsuba.SamplingIntegrator.__init__(self, props)
            self.pair = props.get("pair", 1)

        def sample(self, scene, sampler, ray, medium=None, active=True):
            for _ in range(self.pair):
                u = sampler.next_2d()
            return mitsuba.Color3f(u.x, u.y, sampler.next_1d()), True, []

    mitsuba.register_integrator("probe", lambda props: Probe(props))


@pytest.mark.usefixtures("llvm")
@pytest.mark.parametrize("crop", [None, (5, 3, 64, 32)])
def test_film_pixels_match_the_library(crop):
    register_probe()
    width, height = crop[2:] if crop else (64, 32)
    scene = scene_of({"type": "probe", "pair": 3}, 70 if crop else 64, 40 if crop else 32, 1, crop)
    y, x = np.mgrid[0:height, 0:width] + (np.array(crop[1::-1])[:, None, None] if crop else 0)
    for seed in (0, 7):
        picture = np.array(mitsuba.render(scene, spp=1, seed=seed))
        assert np.array_equal(picture[..., :2], own(x, y, 0, 3, seed))
        assert np.array_equal(picture[..., 2], single(x, y, 0, 2, 0, seed))


@pytest.mark.usefixtures("llvm")
def test_frames_of_a_film_continue_the_samples():
    register_probe()
    film = {"sampler": {"type": "bluenoise", "sample_count": 3, "seed": 5, "film": True}}
    y, x, i = np.mgrid[0:6, 0:9, 0:3]
    for frame, first, stream in ((0, 0, 0), (7, 28, 0), (2**30 + 1, 4, 1)):
        picture = np.array(mitsuba.render(scene_of({"type": "probe", "pair": 3}, 9, 6, 3, sensor=film), seed=frame))
        wanted = np.concatenate([own(x, y, first + i, 3, stream), single(x, y, first + i, 2, 0, stream)[..., None]], -1).mean(2)
        np.testing.assert_allclose(picture, wanted, atol=1e-6)


def test_scalar_variants_are_rejected():
    mitsuba.set_variant("scalar_rgb")
    with pytest.raises(RuntimeError, match="llvm_ad_rgb, not scalar_rgb"):
        mitsuba.load_dict({"type": "bluenoise"})


@pytest.mark.usefixtures("llvm")
def test_sample_indices_of_every_bit_length():
    sampler = mitsuba.load_dict({"type": "bluenoise", "seed": 5})
    sampler.seed(0, 1)
    for bits in range(1, 33):
        index, domain = np.array([2**bits - 1, (2**bits - 1) // 3], np.uint32), bluenoise.domain(5)
        lanes = sampler._lanes.at_index(mitsuba.UInt32(index), int(index[0]))
        for pair in range(2):
            found = np.stack([np.array(number) for number in lanes.draw(mitsuba.Int32(mitsuba.UInt32(domain)), mitsuba.Int32(pair))], -1)
            x, y = (np.array(place) for place in (lanes.x, lanes.y))
            assert np.array_equal(found, SAMPLER.sample(x, y, index, domain, pair=pair))


@pytest.mark.usefixtures("llvm")
@pytest.mark.parametrize("spp", [16, 600])
def test_wavefront_indices_and_draws(spp):
    scene = scene_of({"type": "direct"}, 9, 6, spp)
    sampler = scene.sensors()[0].sampler()
    sampler.set_samples_per_wavefront(spp // 2)
    sampler.seed(0, 9 * 6 * (spp // 2))
    lane = np.arange(9 * 6 * (spp // 2))
    pixel = lane // (spp // 2)
    x, y = pixel % 9, pixel // 9
    for first in (0, spp // 2):
        index = first + lane % (spp // 2)
        for pair in range(12):
            # Each ray draws six single numbers before its direction and one after it.
            numbers = 6 if pair % 2 == 0 else 1
            for k in range(numbers):
                expected = single(x, y, index, pair // 2, k if pair % 2 == 0 else 6)
                assert np.array_equal(np.array(sampler.next_1d()), expected)
            assert np.array_equal(np.array(sampler.next_2d()).T, own(x, y, index, pair))
        sampler.advance()


@pytest.mark.usefixtures("llvm")
def test_film_border_is_sampled():
    scene = scene_of({"type": "direct"}, 20, 10, 2, (3, 1, 12, 6), True, "gaussian")
    sensor = scene.sensors()[0]
    border = sensor.film().rfilter().border_size()
    assert border > 0
    width, height = 12 + 2 * border, 6 + 2 * border
    sensor.sampler().set_samples_per_wavefront(2)
    sensor.sampler().seed(0, width * height * 2)
    y, x = np.mgrid[0:height, 0:width]
    expected = own(x[..., None] + 3 - border, y[..., None] + 1 - border, np.arange(2), 0)
    assert np.array_equal(np.array(sensor.sampler().next_2d()).T, expected.reshape(-1, 2))


@pytest.mark.usefixtures("llvm")
@pytest.mark.parametrize("recorded", [True, False])
def test_draws_in_loops_are_counted(recorded):
    scene = scene_of({"type": "direct"}, 16, 16, 1)
    sampler = scene.sensors()[0].sampler()
    sampler.seed(0, 256)
    sampler.next_2d()
    y, x = np.mgrid[0:16, 0:16]
    with drjit.scoped_set_flag(drjit.JitFlag.SymbolicLoops, recorded):
        lane = drjit.arange(mitsuba.UInt32, 256)
        state = drjit.while_loop(
            (mitsuba.UInt32(0), mitsuba.Float(0), mitsuba.Float(0), sampler),
            lambda i, a, b, sampler: i < lane % 5,
            lambda i, a, b, sampler: (i + 1, a + sampler.next_2d().y, b + sampler.next_1d(), sampler),
            labels=("i", "a", "b", "sampler"))
    count = (np.arange(256) % 5).reshape(16, 16)
    pairs = sum(np.where(k < count, own(x, y, 0, 1 + k)[..., 1], 0) for k in range(4))
    # Pairs 1 to 4 are the second pair of ray 0, both pairs of ray 1 and the first pair of ray 2. A single number follows each.
    singles = sum(np.where(k < count, single(x, y, 0, (k + 2) // 2, k % 2), 0) for k in range(4))
    assert np.allclose(np.array(state[1]).reshape(16, 16), pairs, atol=1e-6)
    assert np.allclose(np.array(state[2]).reshape(16, 16), singles, atol=1e-6)
