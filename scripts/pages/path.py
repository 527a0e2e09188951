# SPDX-License-Identifier: Apache-2.0
"""Draws docs/path.png, a diagram of a path's random numbers: .venv/bin/python scripts/pages/path.py"""

import matplotlib.pyplot as plt

COLOURS = ["#1f77b4", "#d95f02", "#2a9d4e"]
VERTICES = [(0.3, 1.2), (3.2, 0.35), (6.2, 1.25), (9.1, 0.35)]
WHERE = ["position in the pixel", "direction", "direction"]

figure, axis = plt.subplots(figsize=(9.6, 3.5), layout="constrained")


def arrow(start, end, colour, style):
    axis.annotate("", end, start, arrowprops={"arrowstyle": "-|>", "color": colour, "linestyle": style, "lw": 1.8,
                                              "shrinkA": 7, "shrinkB": 7})


for ray, colour in enumerate(COLOURS):
    start, end = VERTICES[ray:ray + 2]
    light = (end[0] + 0.3, 2.75)
    arrow(start, end, colour, "-")
    arrow(end, light, colour, (0, (4, 3)))
    axis.text((start[0] + end[0]) / 2, -0.3, f"ray {ray}", color=colour, ha="center", fontsize=13, weight="bold")
    axis.text((start[0] + end[0]) / 2, -0.62, f"u[0], u[1]: {WHERE[ray]}\nu[2], u[3]: light at vertex {ray + 1}", color=colour,
              ha="center", va="top", fontsize=9.5)
    axis.text(end[0] + 0.28, (end[1] + light[1]) / 2 + 0.1, "u[2], u[3]", color=colour, fontsize=9.5)
    axis.text((start[0] + end[0]) / 2, (start[1] + end[1]) / 2 + 0.24, "u[0], u[1]", color=colour, ha="center", fontsize=9.5)
    axis.text(*light, "☀", color="#e0a800", ha="center", va="center", fontsize=22, family="DejaVu Sans")
for vertex, (x, y) in enumerate(VERTICES):
    axis.plot(x, y, "s" if vertex == 0 else "o", color="0.25", markersize=9 if vertex == 0 else 7, zorder=3)
    axis.text(x, y - 0.2, "camera" if vertex == 0 else f"vertex {vertex}", ha="center", va="top", fontsize=10, color="0.25")
arrow(VERTICES[-1], (10.3, 1.0), "0.7", "-")
axis.set(xlim=(-0.3, 10.4), ylim=(-1.35, 3.1))
axis.axis("off")
figure.savefig("docs/path.png", dpi=90, metadata={"Software": None})
