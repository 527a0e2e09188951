# SPDX-License-Identifier: Apache-2.0
"""Dithers a quiet tone to a few bits with white noise and with a one-dimensional mask, and plots the spectra.

    audio_dither.py -o spectrum.png [--bits 8] [--wav FOLDER]

Without dither, quantisation distorts the tone. White noise makes the error independent of the tone, but audible as hiss. A blue
mask does so too, and moves the hiss to high frequencies, where the ear is less sensitive and filters and decimation
remove it. The mask repeats after 1.4 seconds.
"""

import argparse
from pathlib import Path

import numpy as np
from scipy.signal import welch

import bluenoise

RATE = 48000  # samples per second
TONE, BAND = 997, 6000  # Hz; the noise is measured below BAND
LENGTH = 2**16  # of the mask


def quantise(signal, bits, dither=0.5):
    """Rounds a signal in [-1, 1] to 2**bits levels; dither in [0, 1), 0.5 for none, decides which way."""
    steps = 2 ** (bits - 1)
    return np.clip(np.floor(signal * steps + dither), -steps, steps - 1) / steps


def dithers(count, seed=1):
    mask = bluenoise.to_float(bluenoise.mask((LENGTH,), seed=seed))
    white = np.random.default_rng(seed).random(count, np.float32)
    return {"none": 0.5, "white noise": white, "blue mask": np.resize(mask, count)}


def decibels(power):
    return 10 * np.log10(np.maximum(power, 1e-30))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", dest="output", required=True, metavar="FILE.png", help="the plot")
    parser.add_argument("--bits", type=int, default=8, choices=range(2, 17), metavar="N", help="bits per sample (default 8)")
    parser.add_argument("--seconds", type=float, default=5)
    parser.add_argument("--wav", type=Path, help="also write the tones, 16-bit WAV, to this folder")
    options = parser.parse_args()
    count = int(RATE * options.seconds)
    # Less than two steps from peak to peak
    tone = 0.9 * 2.0 ** (1 - options.bits) * np.sin(2 * np.pi * TONE / RATE * np.arange(count))

    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(1, 3, figsize=(12, 3.6), sharey=True)
    print(f"| dither | noise and distortion below {BAND // 1000} kHz, dB of full scale | in all |\n| --- | ---: | ---: |")
    for axis, (name, dither) in zip(axes, dithers(count).items()):
        output = quantise(tone, options.bits, dither)
        frequency, power = welch(output, RATE, "blackmanharris", 8192)
        axis.plot(frequency / 1000, decibels(power), color="#0050b0", linewidth=0.8)
        axis.set(title=f"dither: {name}", xlabel="kHz", xlim=(0, RATE / 2000), ylim=(-130, -60))
        axis.grid(True, alpha=0.25)
        # A full-scale sine has a mean square of one half.
        frequency, power = welch(output - tone, RATE, "blackmanharris", 8192)
        below, everywhere = (2 * power[frequency < limit].sum() * frequency[1] for limit in (BAND, RATE))
        print(f"| {name} | {decibels(below):.1f} | {decibels(everywhere):.1f} |")
        if options.wav:
            from scipy.io import wavfile

            options.wav.mkdir(parents=True, exist_ok=True)
            wavfile.write(options.wav / f"{name.replace(' ', '-')}.wav", RATE, np.round(output * 32767).astype(np.int16))
    axes[0].set_ylabel("dB per Hz, of full scale")
    figure.tight_layout()
    figure.savefig(options.output, dpi=80)
    try:
        from PIL import Image
    except ImportError:
        return
    # A third of the size
    Image.open(options.output).convert("RGB").quantize(32, dither=0).save(options.output)


if __name__ == "__main__":
    main()
