# SPDX-License-Identifier: Apache-2.0
"""Draws docs/mistakes.png, a soft shadow with correct and incorrect integrations of blue: .venv/bin/python scripts/pages/mistakes.py"""

import matplotlib.pyplot as plt
import numpy as np
from scipy.ndimage import gaussian_filter

import bluenoise

SIZE, COUNT = 128, 4
y, x = np.mgrid[:SIZE, :SIZE]
pixel = y * SIZE + x
blue = bluenoise.Sampler("blue", seed=1)


def shadow(u):
    """The visible part of a square light above a wall's edge, for pixels at 0.15 to 0.85 of the image width."""
    return u[..., 0] + 0.3 * u[..., 1] < 1.3 * (0.5 + (x / SIZE - 0.5 + 0.1 * (y / SIZE - 0.5)) / 0.7)


def image(draw):
    return np.mean([shadow(draw(index)) for index in range(COUNT)], axis=0)


def seed_per_tile(index, tile=16):
    u = np.empty((SIZE, SIZE, 2))
    for row in range(0, SIZE, tile):
        for column in range(0, SIZE, tile):
            sampler = bluenoise.Sampler("blue", seed=row * SIZE + column)
            u[row:row + tile, column:column + tile] = sampler.block(column, row, tile, tile, index, 1, dims=2)[:, :, 0]
    return u


PANELS = {
    "right": lambda index: blue.sample(x, y, index=index, dims=2),
    "a seed per 16 x 16 tile": seed_per_tile,
    "x, y of a 16 x 16 tile": lambda index: blue.sample(x % 16, y % 16, index=index, dims=2),
    "one index for the whole image": lambda index: blue.sample(x, y, index=pixel * COUNT + index, dims=2),
    "every sample has index 0": lambda index: blue.sample(x, y, index=0, dims=2),
}
truth = np.mean([shadow(np.stack(np.broadcast_arrays((i + 0.5) / 32, (j + 0.5) / 32), -1)) for i in range(32) for j in range(32)], axis=0)
figure, axes = plt.subplots(2, len(PANELS), figsize=(13.2, 5.6))
figure.subplots_adjust(0.022, 0, 0.998, 0.95, 0.03, 0.03)
for (above, below), (title, draw) in zip(axes.T, PANELS.items()):
    rendered = image(draw)
    error = gaussian_filter(rendered - truth, 2.1)
    for axis, shown, limits in ((above, rendered, (0, 1)), (below, error, (-0.08, 0.08))):
        axis.imshow(np.kron(shown, np.ones((2, 2))), cmap="gray", vmin=limits[0], vmax=limits[1], interpolation="nearest")
        axis.axis("off")
    above.set_title(title, fontsize=11)
for axis, text in zip(axes[:, 0], ("as rendered", "error from a distance, x 6")):
    axis.text(-0.02, 0.5, text, rotation=90, ha="right", va="center", fontsize=11, transform=axis.transAxes)
figure.savefig("docs/mistakes.png", dpi=100, metadata={"Software": None})
