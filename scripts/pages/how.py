# SPDX-License-Identifier: Apache-2.0
"""Draws docs/how.png: sixteen pixels with one sample each, and one pixel with sixteen samples. Run .venv/bin/python scripts/pages/how.py"""

import itertools

import matplotlib.pyplot as plt
import numpy as np

import bluenoise


def is_net(points):
    """Whether each box contains one of the 16 points, for all shapes with power-of-two sides and area 1/16."""
    return all(len({(int(x * 2**k), int(y * 2 ** (4 - k))) for x, y in points}) == 16 for k in range(5))


sampler = bluenoise.Sampler("blue", seed=1)
# Find the first aligned square of 4 x 4 pixels, because a domain shifts the squares.
for y0, x0 in itertools.product(range(4), range(4)):
    pixels = sampler.block(x0, y0, 4, 4, 0, 16)[..., :2]
    if is_net(pixels[:, :, 0].reshape(16, 2)):
        break
figure, axes = plt.subplots(1, 3, figsize=(9, 3.3), layout="constrained")
colours = plt.cm.turbo(np.linspace(0.05, 0.95, 16))
axes[0].imshow(colours.reshape(4, 4, 4), extent=(0, 4, 4, 0))
axes[0].set_title("16 pixels")
for i, (row, column) in enumerate(itertools.product(range(4), range(4))):
    axes[0].text(column + 0.5, row + 0.5, f"{i + 1}", ha="center", va="center", color="white", fontsize=13)
for axis, points, title, own in ((axes[1], pixels[:, :, 0].reshape(16, 2), "the first point of each pixel", colours),
                                 (axes[2], pixels[1, 1], "the first 16 points of pixel 6", [colours[5]] * 16)):
    assert is_net(points)
    axis.scatter(*points.T, c=own, s=60, zorder=2)
    for i, (x, y) in enumerate(points):
        axis.text(x + 0.03, y, f"{i + 1}" if axis is axes[1] else "", va="center", fontsize=8)
    axis.set(xlim=(0, 1), ylim=(0, 1), title=title, aspect="equal", xticks=np.arange(5) / 4, yticks=np.arange(5) / 4)
    axis.grid(True, color="0.8")
    axis.tick_params(labelbottom=False, labelleft=False, length=0)
axes[0].axis("off")
figure.savefig("docs/how.png", dpi=90, metadata={"Software": None})
