# SPDX-License-Identifier: Apache-2.0
"""The ``bluenoise`` sampler for Mitsuba 3. Importing this module registers it in the current variant and every later one.

    import mitsuba
    import bluenoise.mitsuba

    mitsuba.set_variant("llvm_ad_rgb")
    scene["sensor"]["sampler"] = {"type": "bluenoise", "sample_count": 16, "seed": 0}

Samples are bit-identical to those of ``bluenoise.Sampler("blue", seed=seed)`` at the film's pixels, including its crop offset.
``seed`` ranges from 0 to 2**31 - 1. The seed passed to ``mitsuba.render`` becomes the stream of a ``bluenoise.PathSampler``. With the
property ``"film": True``, it is the number of a film's frame instead, and samples continue from frame to frame: the first index is
``bluenoise.frame_index(seed, sample_count)``.

Two-dimensional draws 2 r and 2 r + 1 are ``draw_direction`` and ``draw_end_light`` of ray r: for the camera ray, the pixel position and
the first light; for later rays, the direction and the next light. One-dimensional draws are ``next_1d`` calls on the ray whose direction
or light is drawn next.

Draws run in Dr.Jit, even inside recorded loops. Scalar variants are not supported.
"""

from __future__ import annotations

import copy
import math
import weakref
from typing import Any, Optional

try:
    import drjit
    import mitsuba
except ImportError as error:
    raise ImportError(f"the sampler needs Mitsuba 3; run: pip install 'mitsuba>=3.9' ({error})") from None

from . import arrays
from ._frames import frame_index, frame_stream
from ._sampler import Sampler

__all__: list[str] = []

# The types in both modules depend on the variant.
dr: Any = drjit
mi: Any = mitsuba

_UNSEEDED = 0xFFFFFFFF  # Mitsuba's value for "keep the wavefront size"
_CAMERA_KEY, _STREAMS_KEY = 3, -(2**31)  # as in bn_path.glsl


def _ray_domain(stream: Any, ray: Any) -> Any:
    return arrays.domain_child(stream, dr.select(ray >= _CAMERA_KEY, ray + 1, ray))


class _Lanes:
    """Identifies the sample of each lane, except for the domain. Dr.Jit does not traverse objects of this class, so recorded loops
    capture their contents instead of carrying them as state."""

    def __init__(self, words: Any, seed: Any, frame: Any, x: Any, y: Any) -> None:
        self.words, self.seed, self.x, self.y = words, seed, x, y
        below = arrays.domain_child(arrays.domain_child(mi.Int32(0), mi.Int32(_STREAMS_KEY)), frame)
        self.stream = dr.select(frame == 0, mi.Int32(0), below)

    def at_index(self, index: Any, last: int) -> _Lanes:
        """The same lanes at other indices, the largest of which is `last`."""
        self = copy.copy(self)
        self.index, self.rounds = mi.Int32(index), arrays.rounds_of(last)
        return self

    def draw(self, domain: Any, pair: Any) -> tuple[Any, Any]:
        """Pair 0 or 1 of a domain."""
        words = lambda at: dr.gather(mi.Int32, self.words, mi.UInt32(at))
        first, second = arrays.blue(words, self.seed, self.x, self.y, self.index, domain, (pair,), self.rounds)
        return mi.Float(mi.UInt32(first) >> 8) * 2.0**-24, mi.Float(mi.UInt32(second) >> 8) * 2.0**-24


class _Film:
    """The film of the sensor that uses a sampler. It is hidden from Dr.Jit in the same way as `_Lanes`."""

    def __init__(self, sampler: Any) -> None:
        self.sampler = weakref.ref(sampler)
        self.film: Any = None

    def extent(self) -> tuple[int, int, int, int]:
        """x and y of the first sampled pixel, width and height."""
        size, offset = self.film.crop_size(), self.film.crop_offset()
        border = self.film.rfilter().border_size() if self.film.sample_border() else 0
        x0, y0, width, height = offset[0] - border, offset[1] - border, size[0] + 2 * border, size[1] + 2 * border
        return int(x0), int(y0), int(width), int(height)


def _sensor(number: int) -> Any:
    """The sensor with this number in Dr.Jit's registry, or None.

    Dr.Jit numbers the existing sensors from 1, and an array of sensors is an array of these numbers. Mitsuba does not pass the
    sensor to a sampler, and cannot list sensors without a scene, so this function uses an array with one number instead."""
    try:
        return dr.reinterpret_array(mi.SensorPtr, mi.UInt32(number))[0]
    except RuntimeError:  # no sensor has this number
        return None


def _registered_film(sampler: Any) -> Any:
    """The film of the sensor that uses this sampler; None if there is none yet."""
    number = last = 0
    while number < last + 64:  # numbers of deleted sensors stay unused for a while
        number += 1
        sensor = _sensor(number)
        if sensor is None:
            continue
        last = number
        if sensor.sampler() is sampler:
            return sensor.film()
    return None


# ---- The plugin, for the current variant


def _create_class() -> Any:
    if mi.variant().startswith("scalar"):
        raise RuntimeError(f"the bluenoise sampler needs a vectorised variant, such as llvm_ad_rgb, not {mi.variant()}")
    base: Any = mi.Sampler

    class BlueNoiseSampler(base):  # type: ignore[misc]
        def __init__(self, props: Any) -> None:
            base.__init__(self, props)
            self._sampler = Sampler("blue", seed=int(props.get("seed", 0)))
            self._is_film = bool(props.get("film", False))
            self._first = 0  # the index of a frame's first sample
            self._film = _Film(self)
            self._per_wavefront = 1  # samples per pixel in a wavefront
            self._advances = 0
            self._lanes: Optional[_Lanes] = None
            # How many pairs have been drawn, and how many single numbers at this ray. Dr.Jit finds both counts and carries them
            # through loops.
            self._pairs = mi.Int32(0)
            self._singles = mi.Int32(0)

        def _like(self) -> Any:
            """A sampler with the same properties, not seeded."""
            props = mi.Properties("bluenoise")
            props["sample_count"] = self.sample_count()
            other = type(self)(props)
            other._sampler, other._film, other._is_film = self._sampler, self._film, self._is_film
            return other

        def fork(self) -> Any:
            return self._like()

        def clone(self) -> Any:
            other = self._like()
            if self._lanes is not None:
                mi.Sampler.seed(other, 0, self.wavefront_size())
            other._per_wavefront, other._advances, other._lanes = self._per_wavefront, self._advances, self._lanes
            other._first = self._first
            other._pairs, other._singles = mi.Int32(self._pairs), mi.Int32(self._singles)
            return other

        def set_samples_per_wavefront(self, samples_per_wavefront: int) -> None:
            # Mitsuba does not call this when rendering; with a film, seed() computes the number itself.
            mi.Sampler.set_samples_per_wavefront(self, samples_per_wavefront)
            self._per_wavefront = samples_per_wavefront

        def seed(self, seed: Any, wavefront_size: int = _UNSEEDED) -> None:
            mi.Sampler.seed(self, seed, wavefront_size)  # for wavefront_size()
            key = mi.Int32(mi.UInt32(seed))
            if self._is_film:
                frame, most = int(key[0]) & 0xFFFFFFFF, self.sample_count()
                self._first, key = int(frame_index(frame, most)), mi.Int32(mi.UInt32(frame_stream(frame, most)))
            dr.make_opaque(key)
            x0, y0, width = self._place()
            pixel = dr.arange(mi.UInt32, self.wavefront_size()) // self._per_wavefront
            row = pixel // width
            x, y = mi.Int32(pixel - row * width) + x0, mi.Int32(row) + y0
            first, second = self._sampler._words
            self._lanes = _Lanes(mi.Int32(arrays.WORDS), (dr.opaque(mi.Int32, first), dr.opaque(mi.Int32, second)), key, x, y)
            self._advances = -1
            self.advance()

        def _place(self) -> tuple[int, int, int]:
            """x and y of the first pixel, and the row length; without a sensor, pixels fill a square."""
            lanes = self.wavefront_size()
            if self._film.film is None:
                self._film.film = _registered_film(self._film.sampler())
            if self._film.film is None:
                return 0, 0, max(1, math.isqrt(lanes // self._per_wavefront))
            x0, y0, width, height = self._film.extent()
            self._per_wavefront = max(1, lanes // (width * height))
            return x0, y0, width

        def advance(self) -> None:
            self._advances += 1
            self._pairs, self._singles = mi.Int32(0), mi.Int32(0)
            if self._lanes is None:
                return
            first = self._first + self._advances * self._per_wavefront
            lane = dr.arange(mi.UInt32, self.wavefront_size())
            index = dr.opaque(mi.UInt32, first) + lane % self._per_wavefront
            self._lanes = self._lanes.at_index(index, first + self._per_wavefront - 1)

        def schedule_state(self) -> None:
            dr.schedule(self._pairs, self._singles)

        def next_2d(self, active: Any = True) -> Any:
            lanes = self._seeded()
            half = self._pairs & 1
            first, second = lanes.draw(_ray_domain(lanes.stream, self._pairs >> 1), half)
            self._pairs += 1
            self._singles = dr.select(half == 0, self._singles, mi.Int32(0))  # the next ray begins
            return mi.Point2f(first, second)

        def next_1d(self, active: Any = True) -> Any:
            lanes = self._seeded()
            k = self._singles
            ray = _ray_domain(lanes.stream, self._pairs >> 1)
            first, second = lanes.draw(arrays.domain_child(ray, k & -4), k >> 1 & 1)
            number = dr.select((k & 1) == 0, first, second)
            self._singles += 1
            return number

        def _seeded(self) -> _Lanes:
            if self._lanes is None:
                raise RuntimeError("seed() must come before the first sample")
            return self._lanes

        def to_string(self) -> str:
            return f"BlueNoiseSampler[sample_count = {self.sample_count()}, seed = {self._sampler.seed}]"

    return BlueNoiseSampler


# ---- Registration


def _register(_old: Optional[str], new: Optional[str]) -> None:
    if new is not None:
        mi.register_sampler("bluenoise", lambda props: _classes.setdefault(new, _create_class())(props))


_classes: dict[str, Any] = {}
mi.detail.add_variant_callback(_register)
_register(None, mi.variant())
