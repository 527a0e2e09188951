# SPDX-License-Identifier: Apache-2.0
"""The error of a picture against its reference, as a number, as a picture and as a spectrum.

Blue noise does not reduce the error of single pixels; it moves the error to high frequencies, where the eye and any
later filter average it away. The error is therefore measured unblurred and after Gaussians of sigma 1.0 and 2.1 pixels,
which model a near and a far viewer. Pictures are float arrays (height, width) or (height, width, channels) of linear
radiance. MEASURES names the measures, WHAT_FOR describes them.
"""

import numpy as np
from scipy import ndimage

SIGMAS = (0.0, 1.0, 2.1)

# Rec. 709 luminance of linear RGB
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])

KINDS = {"rmse": "RMSE", "displayed": "RMSE as displayed", "trimmed": "trimmed relative RMSE"}
MEASURES = tuple(f"{kind}_{sigma}" if sigma else kind for kind in KINDS for sigma in SIGMAS)
WHAT_FOR = {
    "rmse": "RMSE of linear radiance is the error of Monte Carlo theory, and the one that matters if the picture is composited or "
            "filtered later. A single lamp or firefly can dominate it.",
    "displayed": "RMSE as displayed multiplies by the exposure, clips to 0..1 like a screen, and then blurs, in linear light "
                 "without a tone curve, because the eye adds light linearly. It measures the noise that a viewer sees; values "
                 "above white count as white.",
    "trimmed": "Trimmed relative RMSE divides each pixel's error by the reference's luminance and excludes the 0.1 % of pixels "
               "that are too bright by the largest factor. It weighs dark and bright areas equally and ignores fireflies.",
}
TRIMMED_SHARE = 0.001
# Share of the mean luminance that keeps black pixels from dominating relative errors.
RELATIVE_FLOOR = 0.1


def _difference(image, reference):
    assert np.shape(image) == np.shape(reference), "pictures of different sizes"
    return np.asarray(image, np.float64) - np.asarray(reference, np.float64)


def blurred(image, sigma, edge="mirror"):
    """The picture convolved with a Gaussian of `sigma` pixels, truncated at four sigma.

    edge: "mirror" for pictures (the outermost pixel is repeated: c b a | a b c), "toroidal" for tiles.
    """
    image = np.asarray(image, np.float64)
    sigmas = (sigma, sigma) + (0,) * (image.ndim - 2)
    return ndimage.gaussian_filter(image, sigmas, mode={"mirror": "reflect", "toroidal": "wrap"}[edge])


def _rms(error, sigma=0.0, edge="mirror"):
    return float(np.sqrt(np.mean(blurred(error, sigma, edge) ** 2)))


def rmse(image, reference, sigma=0.0, edge="mirror"):
    """Root mean square, over pixels and channels, of the blurred difference; equal to the path tracer's."""
    return _rms(_difference(image, reference), sigma, edge)


def measure_name(name):
    """The name of a measure for people."""
    kind, _, sigma = name.partition("_")
    return f"{KINDS[kind]} after sigma {sigma}" if sigma else f"{KINDS[kind]}, unblurred"


def displayed(image, exposure=0.0):
    """The picture as displayed at `exposure` stops: linear light, clipped to 0..1."""
    return np.clip(np.asarray(image, np.float64) * 2.0**exposure, 0, 1)


def displayed_rmse(image, reference, exposure=0.0, sigma=0.0):
    """RMSE of the displayed pictures. Pixels are clipped before the blur, as on a screen."""
    return rmse(displayed(image, exposure), displayed(reference, exposure), sigma)


def _trimmed_relative_error(image, reference):
    """Error divided by the reference's luminance, 0 in the pixels that are too bright by the largest factor."""
    error = _difference(image, reference)
    light = np.asarray(reference, np.float64)
    light = np.maximum(light @ LUMINANCE if light.ndim == 3 else light, 0)
    scale = np.maximum(np.sqrt(light**2 + (RELATIVE_FLOOR * light.mean()) ** 2), 1e-30)
    brighter = (error @ LUMINANCE if error.ndim == 3 else error) / scale
    count = int(np.ceil(TRIMMED_SHARE * brighter.size))
    trimmed = np.argpartition(brighter.ravel(), -count)[-count:]
    error = error / (scale[..., None] if error.ndim == 3 else scale)
    error.reshape(brighter.size, -1)[trimmed] = 0
    return error


def trimmed_relative_rmse(image, reference, sigma=0.0):
    """RMSE relative to the reference's luminance, without the 0.1 % of pixels that are too bright by the largest factor.

    These are excluded before the blur, which would spread them over their neighbours.
    """
    return _rms(_trimmed_relative_error(image, reference), sigma)


def relative_rmse(image, reference):
    """RMSE of the difference divided by the reference plus a tenth of its mean, as in the path tracer's relative_rmse."""
    floor = 0.1 * np.mean(reference, dtype=np.float64)
    return float(np.sqrt(np.mean((_difference(image, reference) / (np.asarray(reference, np.float64) + floor)) ** 2)))


def all_errors(image, reference, exposure=0.0):
    """{measure: error} for all of MEASURES."""
    errors = {"rmse": _difference(image, reference),
              "displayed": displayed(image, exposure) - displayed(reference, exposure),
              "trimmed": _trimmed_relative_error(image, reference)}
    return {f"{kind}_{sigma}" if sigma else kind: _rms(error, sigma) for kind, error in errors.items() for sigma in SIGMAS}


def own_errors(reference, first_half, exposure=0.0, errors=all_errors):
    """{measure: error} of a reference itself: half the difference between the means of its two halves."""
    second_half = 2 * np.asarray(reference, np.float64) - first_half
    return {name: error / 2 for name, error in errors(first_half, second_half, exposure).items()}


def luminance_error(image, reference):
    """The signed error, (height, width): luminance of RGB pictures, plain difference of grey ones."""
    error = _difference(image, reference)
    return error @ LUMINANCE if error.ndim == 3 else error


def error_image(error, full_scale):
    """A signed error (height, width) as 8-bit grey: 128 is zero, black and white are -full_scale and +full_scale."""
    return np.clip(np.floor(128 + 127.5 * np.asarray(error) / full_scale), 0, 255).astype(np.uint8)


def windowed_power(error):
    """Power per sample at each frequency of fft2; a Hann window suppresses the picture's borders."""
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
    """The power spectrum of a signed error as 8-bit grey, logarithmic, frequency 0 in the middle: black is a thousandth
    of `level`, white is ten times `level`."""
    power = windowed_power(np.asarray(error, np.float64))
    # A single bin of noise varies as much as its mean, so smooth slightly to show the shape.
    power = np.fft.fftshift(ndimage.gaussian_filter(power, max(1.0, min(power.shape) / 96), mode="wrap"))
    grey = np.clip((np.log10(np.maximum(power, 1e-30) / level) + 3) / 4, 0, 1)
    return np.floor(grey * 255.999).astype(np.uint8)
