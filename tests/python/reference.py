# SPDX-License-Identifier: Apache-2.0
"""Reference implementations of the package's measures in plain NumPy, written from their definitions."""

import math

import numpy as np


def white(shape, seed=0):
    """A white-noise mask: ranks in random order."""
    return np.random.default_rng(seed).permutation(math.prod(shape)).astype(np.uint32).reshape(shape)


def transform(values):
    """The 2-D discrete Fourier transform, computed from its definition."""
    height, width = values.shape
    fy = np.exp(-2j * np.pi * np.outer(np.arange(height), np.arange(height)) / height)
    fx = np.exp(-2j * np.pi * np.outer(np.arange(width), np.arange(width)) / width)
    return fy @ values @ fx


def power_spectrum(values):
    """The power spectrum, normalised by the variance. The value at frequency 0 is 0."""
    centred = values - values.mean()
    return np.abs(transform(centred)) ** 2 / np.sum(centred**2)


def mask_error(ranks, sigma):
    """The RMS error over 64 grey levels of patterns thresholded with the mask and blurred in the frequency domain by a Gaussian."""
    f = np.fft.fftfreq(ranks.shape[0])[:, None] ** 2 + np.fft.fftfreq(ranks.shape[1])[None, :] ** 2
    levels = (np.arange(64) + 0.5) / 64
    patterns = [((ranks + 0.5) / ranks.size < level) - level for level in levels]
    return np.sqrt(np.mean([(np.abs(transform(p) * np.exp(-2 * np.pi**2 * sigma**2 * f)) ** 2).sum() for p in patterns])) / ranks.size


def rings(shape):
    """Maps each ring of width 1 / max(shape) to the flat indices of its frequencies, excluding frequency 0."""
    fy, fx = (np.minimum(np.arange(extent), extent - np.arange(extent)) / extent for extent in shape)
    ring = (np.hypot(fy[:, None], fx) * max(shape) + 0.5).astype(int).ravel()
    return {number: np.flatnonzero(ring == number) for number in np.unique(ring[ring > 0])}


def anisotropy(masks):
    power = np.mean([power_spectrum(m.astype(float)) for m in masks], axis=0).ravel()
    decibels = [
        10 * np.log10(np.var(power[at], ddof=1) / np.mean(power[at]) ** 2)
        for at in rings(masks[0].shape).values()
        if len(at) >= 32
    ]
    return float(np.mean(decibels))


def low_frequency(ranks, level):
    height, width = ranks.shape
    pattern = ((ranks + 0.5) / ranks.size < level).astype(float)
    power = power_spectrum(pattern)
    f = np.hypot(np.fft.fftfreq(height)[:, None], np.fft.fftfreq(width)[None, :])
    principal = np.sqrt(level if level <= 0.5 else 1 - level)
    return float(power[(f > 0) & (f < principal / 2)].mean())
