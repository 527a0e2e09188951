# SPDX-License-Identifier: Apache-2.0
"""Draws docs/spectra.png, the spectra of error images at 4 samples per pixel: .venv/bin/python scripts/pages/spectra.py"""

import matplotlib.pyplot as plt
import numpy as np

import bluenoise

SIZE, COUNT, EDGES = 128, 4, 384
MIDDLES = (np.arange(256) + 0.5) / 256


def spectrum(type):
    """The mean power of half-plane errors by frequency, divided by the power of white noise with one sample."""
    random, power = np.random.default_rng(1), np.zeros((SIZE, SIZE))
    for edge in range(EDGES):
        x, y = np.cos(angle := random.uniform(0, 2 * np.pi)), np.sin(angle)
        limit = np.quantile(x * MIDDLES[:, None] + y * MIDDLES, share := random.uniform(0.2, 0.8))
        u = bluenoise.Sampler(type, seed=edge).block(0, 0, SIZE, SIZE, 0, COUNT, bluenoise.domain(edge), dims=2)
        error = (u @ (x, y) < limit).mean(axis=2) - share
        power += np.abs(np.fft.fft2(error - error.mean())) ** 2 / (share * (1 - share) * SIZE**2)
    return np.fft.fftshift(power / EDGES)


samplers = {"white noise": "white", "padded Sobol'": "sobol", "blue": "blue"}
figure, axes = plt.subplots(1, 4, figsize=(11.5, 2.9), layout="constrained", width_ratios=(1, 1, 1, 1.5))
frequency = (np.arange(SIZE) - SIZE // 2) / SIZE
radius = np.hypot(frequency[:, None], frequency)
for axis, (name, type), colour in zip(axes, samplers.items(), ("#888888", "#d95f02", "#1f77b4")):
    found = spectrum(type)
    axis.imshow(found, cmap="gray", vmin=0, vmax=0.35)
    axis.set_title(name, fontsize=11)
    axis.axis("off")
    edges = np.linspace(0.004, 0.7, 50)
    rings = [found[(radius >= low) & (radius < high)].mean() for low, high in zip(edges, edges[1:])]
    axes[3].plot((edges[1:] + edges[:-1]) / 2, rings, color=colour, label=name)
axes[3].set(xlabel="cycles per pixel", ylabel="power", xlim=(0, 0.7), ylim=(0, 0.35))
axes[3].legend(frameon=False, fontsize=9)
axes[3].spines[["top", "right"]].set_visible(False)
figure.savefig("docs/spectra.png", dpi=90, metadata={"Software": None})
