# SPDX-License-Identifier: Apache-2.0
"""Dithering keeps shape, type and mean, uses each mask as thresholds, and gives the same parts as whole images."""

import tracemalloc

import numpy as np
import pytest
from helpers import refused

import bluenoise
from bluenoise import dither, mask, to_float


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float16, np.float32, np.float64])
@pytest.mark.parametrize("shape", [(33, 47), (33, 47, 1), (33, 47, 3), (5, 6, 7)])
def test_shape_and_dtype_are_kept_and_extremes_are_exact(dtype, shape):
    full = np.iinfo(dtype).max if np.issubdtype(dtype, np.integer) else 1
    for value in (0, full):
        out = dither(np.full(shape, value, dtype), 2)
        assert out.dtype == dtype and out.shape == shape and (out == value).all()
    levels = dither(np.random.default_rng(1).integers(0, full, shape, endpoint=True).astype(dtype), 4)
    assert set(np.unique(levels)) <= {dtype(full * k / 3) for k in range(4)}


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
@pytest.mark.parametrize("levels", [3, 4, 7, 100, 255])
@pytest.mark.parametrize("srgb", [False, True])
def test_mean_is_kept_with_unevenly_spaced_levels(dtype, levels, srgb):
    """The image covers a mask of 4,096 ranks exactly, so its mean can be off by at most half a rank."""
    def linear(values):
        v = np.asarray(values, float) / np.iinfo(dtype).max
        return np.where(v <= 0.04045, v / 12.92, ((v + 0.055) / 1.055) ** 2.4) if srgb else v

    for value in np.random.default_rng(levels).integers(0, np.iinfo(dtype).max, 5, dtype):
        out = dither(np.full((64, 64), value), levels, srgb=srgb)
        gap = np.ptp(linear(out))
        assert len(np.unique(out)) <= 2 and abs(linear(out).mean() - linear(value)) <= gap / 8192 * 1.01 + 1e-7


def test_parts_match_the_whole_image():
    image = np.random.default_rng(1).random((700, 1601), np.float32)
    ranks = mask((48, 40), seed=1)
    for options in ({}, {"mask": ranks}, {"mask": to_float(ranks)}, {"mask": ranks, "srgb": True}):
        assert (dither(image, 4, **options)[192:] == dither(image[192:], 4, **options)).all()  # a multiple of 48 and 64, the masks' heights


def test_large_images_need_little_extra_memory():
    image = np.zeros((2000, 2000, 3), np.uint8)
    tracemalloc.start()
    dither(image)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 9 * image.size  # 12 bytes per pixel, including the image, plus buffers of constant size


def test_uint8_at_256_levels_is_unchanged():
    image = np.arange(256, dtype=np.uint8).reshape(16, 16)
    assert (dither(image, 256) == image).all()


def test_channels_are_identical_without_offsets():
    grey = dither(np.full((64, 64, 3), 0.5), channel_offset=False)
    assert (grey[..., 0] == grey[..., 1]).all() and (grey[..., 0] == grey[..., 2]).all()
    assert (grey[..., 0] == dither(np.full((64, 64), 0.5))).all()


@pytest.mark.parametrize("srgb", [False, True])
@pytest.mark.parametrize("levels", [2, 5])
@pytest.mark.parametrize("shape", [(50, 70), (50, 70, 3)])
def test_float_masks_are_thresholds(shape, levels, srgb):
    ranks = mask((16, 24), seed=1)
    image = np.random.default_rng(0).random(shape, np.float32)
    expected = dither(image, levels, mask=ranks, srgb=srgb)
    for values in (to_float(ranks), to_float(ranks).astype(np.float64)):
        found = dither(image, levels, mask=values, srgb=srgb)
        assert found.dtype == np.float32 and (found != expected).mean() < 1e-3  # within rounding of a threshold
    for value in (0, 1):
        assert (dither(np.full(shape, value, np.float32), levels, mask=np.zeros((3, 3)), srgb=srgb) == value).all()


@pytest.mark.parametrize("kind", [np.uint32, np.float32])
def test_each_channel_uses_its_own_mask(kind):
    ranks = bluenoise.anneal((16, 16), channels=3, sweeps=2)
    masks = ranks if kind is np.uint32 else to_float(ranks)
    image = np.random.default_rng(1).random((20, 30, 3))
    found = dither(image, 3, mask=masks)
    for channel in range(3):
        assert (found[..., channel] == dither(image[..., channel], 3, mask=masks[channel])).all()
    assert (dither(image[..., :2], 3, mask=masks) == found[..., :2]).all()


def test_one_dimensional_masks():
    row = mask((64,), seed=1)
    image = np.full((3, 100), 0.3)
    assert (dither(image, mask=row) == dither(image, mask=row[None])).all()
    assert (dither(image, mask=to_float(row)) == dither(image, mask=to_float(row)[None])).all()


def test_unconvertible_arrays_raise_with_a_hint():
    class Tensor:
        def __array__(self, dtype=None, copy=None):
            raise RuntimeError("this tensor requires grad")

        def detach(self):
            return self

    for call in (lambda: dither(Tensor()), lambda: dither(np.zeros((4, 4)), mask=Tensor()), lambda: to_float(Tensor()),
                 lambda: bluenoise.measure(Tensor()), lambda: bluenoise.Sampler().sample(Tensor(), 0, 0)):
        with pytest.raises(TypeError, match=r"requires grad.*\.detach\(\)\.cpu\(\)\.numpy\(\)"):
            call()


class TestImages:
    Image = pytest.importorskip("PIL.Image")

    def picture(self, mode):
        y, x = np.mgrid[:40, :60]
        rgba = np.stack([4 * x, 6 * y, 2 * (x + y), 3 * x + y], axis=-1).astype(np.uint8)
        return self.Image.fromarray(rgba).convert(mode)

    @pytest.mark.parametrize(
        ("mode", "result"),
        [("1", "L"), ("L", "L"), ("LA", "LA"), ("P", "RGB"), ("PA", "RGBA"), ("RGB", "RGB"), ("RGBA", "RGBA")],
    )
    def test_modes(self, mode, result):
        out = dither(self.picture(mode), 3)
        assert isinstance(out, self.Image.Image) and out.mode == result and out.size == (60, 40)
        values = np.asarray(out)
        if result in ("LA", "RGBA"):
            assert (values[..., -1] == np.asarray(self.picture(mode).convert(result))[..., -1]).all()
            values = values[..., :-1]
        assert set(np.unique(values)) <= {0, 128, 255}

    @pytest.mark.parametrize(("mode", "result"), [("P", "RGBA"), ("L", "LA"), ("1", "LA"), ("RGB", "RGBA")])
    def test_transparent_colours_become_alpha(self, mode, result):
        picture = self.picture("RGB").convert(mode)
        picture.info["transparency"] = picture.getpixel((10, 10))
        alpha = np.asarray(picture.convert(result))[..., -1]
        assert set(np.unique(alpha)) == {0, 255}
        out = dither(picture, 3)
        assert out.mode == result and (np.asarray(out)[..., -1] == alpha).all()

    def test_image_matches_its_array(self):
        picture = self.picture("RGB")
        assert (np.asarray(dither(picture, 4)) == dither(np.asarray(picture), 4)).all()

    @pytest.mark.parametrize("mode", ["1", "L", "LA", "P", "PA", "RGB", "RGBA"])
    def test_metadata_is_kept(self, mode):
        picture = self.picture(mode)
        picture.info.update(icc_profile=b"profile", dpi=(300, 300), exif=b"Exif")
        out = dither(picture)
        assert out.info == picture.info and out.info is not picture.info

    def test_metadata_of_a_transparent_colour_is_replaced_by_alpha(self):
        picture = self.picture("P")
        picture.info.update(icc_profile=b"profile", transparency=3)
        assert dither(picture).info == {"icc_profile": b"profile"} and picture.info["transparency"] == 3

    def test_16_bit_images_with_a_transparent_colour_are_refused(self):
        picture = self.Image.fromarray(np.array([[300, 70]], np.uint16))
        picture.info["transparency"] = 300
        with refused(ValueError, ["16 bits", "transparent colour", "convert('LA')"]):
            dither(picture)

    def test_16_bit_and_float_images(self):
        ramp = np.linspace(0, 65535, 4096).reshape(64, 64).astype(np.uint16)
        sixteen = dither(self.Image.fromarray(ramp), 2)
        assert sixteen.mode.startswith("I;16")
        assert (np.asarray(sixteen) == dither(ramp, 2)).all()
        assert set(np.unique(np.asarray(sixteen))) == {0, 65535}
        floats = dither(self.Image.fromarray((ramp / 65535).astype(np.float32)), 2)
        assert floats.mode == "F" and set(np.unique(np.asarray(floats))) == {0, 1}

    def test_unsupported_modes(self):
        with pytest.raises(ValueError, match="HSV"):
            dither(self.picture("RGB").convert("HSV"))
        with pytest.raises(ValueError, match="mode"):
            dither(self.Image.fromarray(np.array([[70000]], np.int32)))
