# SPDX-License-Identifier: Apache-2.0
"""Errors and their power spectra, as images."""

import numpy as np
from scipy import ndimage

from evidence.measure.image_error import LUMINANCE


def luminance_error(image, reference):
    """The signed error, (height, width): in luminance for RGB images, the plain difference for grey images."""
    error = np.asarray(image, np.float64) - np.asarray(reference, np.float64)
    return error @ LUMINANCE if error.ndim == 3 else error


def error_image(error, full_scale):
    """A signed error (height, width) as 8-bit grey: 128 is zero, black and white are -full_scale and +full_scale."""
    return np.clip(np.floor(128 + 127.5 * np.asarray(error) / full_scale), 0, 255).astype(np.uint8)


def windowed_power(error):
    """Power per sample at each frequency of fft2; a Hann window suppresses the image's borders."""
    window = np.hanning(error.shape[0] + 2)[1:-1, None] * np.hanning(error.shape[1] + 2)[None, 1:-1]
    return np.abs(np.fft.fft2((error - error.mean()) * window)) ** 2 / np.sum(window**2)


def radial_spectrum(error, bin_count=32):
    """The radially averaged power spectrum of a signed error (height, width).

    Returns (frequency, power): bin centres in cycles per pixel up to 0.5, and power per sample; white noise of
    variance v has power v everywhere.
    """
    power = windowed_power(np.asarray(error, np.float64))
    frequency = np.hypot(*np.meshgrid(*map(np.fft.fftfreq, power.shape), indexing="ij"))
    bins = np.floor(frequency * 2 * bin_count).astype(int)
    inside = (bins < bin_count) & (frequency > 0)
    count = np.bincount(bins[inside], minlength=bin_count)
    total = np.bincount(bins[inside], weights=power[inside], minlength=bin_count)
    filled = count > 0
    return (np.arange(bin_count)[filled] + 0.5) / (2 * bin_count), total[filled] / count[filled]


def spectrum_image(error, level):
    """The power spectrum of a signed error as 8-bit grey on a logarithmic scale, with frequency 0 in the centre: black
    is a thousandth of `level`, white ten times `level`."""
    power = windowed_power(np.asarray(error, np.float64))
    # A single bin of noise varies as much as its mean, so smooth slightly to show the shape.
    power = np.fft.fftshift(ndimage.gaussian_filter(power, max(1.0, min(power.shape) / 96), mode="wrap"))
    grey = np.clip((np.log10(np.maximum(power, 1e-30) / level) + 3) / 4, 0, 1)
    return np.floor(grey * 255.999).astype(np.uint8)
