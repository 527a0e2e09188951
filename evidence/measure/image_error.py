# SPDX-License-Identifier: Apache-2.0
"""Measures the error of an image against its reference.

Blue noise does not reduce the error of individual pixels; it moves the error to high frequencies, where the eye and any
later filter average it away. The error is therefore measured without a blur and after Gaussian blurs of sigma 1.0 and
2.1 pixels, which model a near and a distant viewer. Images are float arrays (height, width) or (height, width, channels) of
linear radiance. MEASURES names the measures.
"""

import numpy as np
from scipy import ndimage

SIGMAS = (0.0, 1.0, 2.1)

# Rec. 709 luminance of linear RGB
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])

KINDS = {"rmse": "RMSE", "displayed": "RMSE as displayed"}
MEASURES = tuple(f"{kind}_{sigma}" if sigma else kind for kind in KINDS for sigma in SIGMAS)


def _difference(image, reference):
    assert np.shape(image) == np.shape(reference), "images have different sizes"
    return np.asarray(image, np.float64) - np.asarray(reference, np.float64)


def blurred(image, sigma, mode="reflect"):
    """The image convolved with a Gaussian of `sigma` pixels, truncated at four sigma. mode: SciPy's, "wrap" for tiles."""
    image = np.asarray(image, np.float64)
    sigmas = (sigma, sigma) + (0,) * (image.ndim - 2)
    return ndimage.gaussian_filter(image, sigmas, mode=mode)


def _rms(error, sigma=0.0):
    return float(np.sqrt(np.mean(blurred(error, sigma) ** 2)))


def rmse(image, reference, sigma=0.0):
    """Root mean square, over pixels and channels, of the blurred difference; identical to the path tracer's RMSE."""
    return _rms(_difference(image, reference), sigma)


def measure_name(name):
    """The name of a measure as printed in tables."""
    kind, _, sigma = name.partition("_")
    return f"{KINDS[kind]} after sigma {sigma}" if sigma else f"{KINDS[kind]}, unblurred"


def displayed(image, exposure=0.0):
    """The image as displayed at `exposure` stops: linear light, clipped to 0..1."""
    return np.clip(np.asarray(image, np.float64) * 2.0**exposure, 0, 1)


def displayed_rmse(image, reference, exposure=0.0, sigma=0.0):
    """RMSE of the displayed images. Pixels are clipped before the blur, as on a screen."""
    return rmse(displayed(image, exposure), displayed(reference, exposure), sigma)


def encoded(light):
    """The sRGB curve of linear light in 0..1, in steps of an 8-bit display."""
    light = np.asarray(light, np.float64)
    return 255 * np.where(light <= 0.0031308, 12.92 * light, 1.055 * np.maximum(light, 1e-9) ** (1 / 2.4) - 0.055)


def visible_error(image, reference, exposure=0.0, sigma=2.1):
    """The error of the displayed image as seen through a blur, in steps of an 8-bit display, for each pixel and channel."""
    return encoded(blurred(displayed(image, exposure), sigma)) - encoded(blurred(displayed(reference, exposure), sigma))


def relative_rmse(image, reference):
    """RMSE of the difference divided by the reference plus a tenth of its mean, as in the path tracer's relative_rmse."""
    floor = 0.1 * np.mean(reference, dtype=np.float64)
    return float(np.sqrt(np.mean((_difference(image, reference) / (np.asarray(reference, np.float64) + floor)) ** 2)))


def all_errors(image, reference, exposure=0.0):
    """{measure: error} for all of MEASURES."""
    errors = {"rmse": _difference(image, reference), "displayed": displayed(image, exposure) - displayed(reference, exposure)}
    return {f"{kind}_{sigma}" if sigma else kind: _rms(error, sigma) for kind, error in errors.items() for sigma in SIGMAS}


def own_errors(reference, first_half, exposure=0.0, errors=all_errors):
    """{measure: error} of a reference itself: half the difference between the means of its two halves."""
    second_half = 2 * np.asarray(reference, np.float64) - first_half
    return {name: error / 2 for name, error in errors(first_half, second_half, exposure).items()}
