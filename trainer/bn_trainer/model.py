# SPDX-License-Identifier: Apache-2.0
"""The network: a learned relaxation with stride 1, for one- and two-channel masks of any size.

Summed over all thresholds, a mask's squared dithering error is a constant minus a sum over pairs of
W(p - q) |r_p - r_q|, so its gradient at p is a sum of W(p - q) sign(r_p - r_q). One step replaces every value by such a
sum, with a softened sign and weights that are a learned difference of two Gaussians:

    v_p <- keep v_p + sum over offsets o of w_o direction(s_o (v_p - v_(p + o))),    direction(d) = d / max(|d|, 1)

For one channel, direction(d) is clip(d, -1, 1). For two channels, d is a vector, and the directions match the forces in
"Blue-noise dithered sampling" (Georgiev and Fajardo, 2016). The sharpness s_o controls how soft the sign is: differences
below 1 / s_o count only partly. Weight and sharpness depend only on the distance, so no axis is favoured. An offset and its
negative give the same differences with opposite signs, so each pair of texels is computed once.
"""

from __future__ import annotations

import math

import torch
from torch import Tensor, nn
from torch.nn import functional as F

#: The factor of the uniform noise in [0, 1) before the first step.
FIRST_SCALE = 8.0
#: The maximum factor by which a step may scale its sum. Beyond it, rounding errors would grow from step to step.
MOST_SCALE = 128.0
#: The second channel of a vector starts from the low bits of the noise, which has 24 bits.
SPLIT = 4096.0


def orbits(reach: int) -> list[list[tuple[int, int]]]:
    """The offsets (y, x) with 0 < y^2 + x^2 <= reach, grouped by the symmetries of the square."""
    half = math.isqrt(reach)
    groups: dict[tuple[int, int, int], list[tuple[int, int]]] = {}
    for y in range(-half, half + 1):
        for x in range(-half, half + 1):
            if 0 < y * y + x * x <= reach:
                near, far = sorted((abs(y), abs(x)))
                groups.setdefault((y * y + x * x, far, near), []).append((y, x))
    return [groups[key] for key in sorted(groups)]


def halves(group: list[tuple[int, int]]) -> list[tuple[int, int]]:
    """One offset of each opposite pair."""
    return [offset for offset in group if offset > (0, 0)]


def crop(values: Tensor, top: int, left: int, bottom: int, right: int) -> Tensor:
    """A view of values (n, c, h, w) without the given number of texels at each side."""
    return values[:, :, top : values.shape[2] - bottom, left : values.shape[3] - right]


def _within(value: Tensor | float, least: float, most: float) -> float:
    return max(min(float(value), most), least)


class Step(nn.Module):
    """One step: maps values (n, c, h + 2m, w + 2m) to (n, c, h, w), where m is `margin`.

    The weights are a difference of two Gaussians, evaluated at the distance, so a step has seven parameters for any reach. Separate
    weights for each group of offsets took five times as long to train and resulted in higher error."""

    def __init__(self, reach: int, *, sigma: float, scale: float, keep: float) -> None:
        super().__init__()
        self.reach, self.margin, self.orbits = reach, math.isqrt(reach), orbits(reach)
        #: The logarithm of the sum of the magnitudes of all weights.
        self.scale = nn.Parameter(torch.tensor(math.log(scale)))
        self.keep = nn.Parameter(torch.tensor(keep))
        #: The logarithm of the blur sigma whose error kernel is the inner Gaussian; and the logarithm of the ratio of the
        #: outer width to the inner, minus 1.2.
        self.inner = nn.Parameter(torch.tensor(math.log(sigma)))
        self.outer = nn.Parameter(torch.tensor(0.0))
        #: The factor of the outer Gaussian, which is subtracted.
        self.surround = nn.Parameter(torch.tensor(0.0))
        #: The logarithm of the sharpness at distance 1, and how much it grows per 10 of squared distance.
        self.sharpness = nn.Parameter(torch.tensor(0.0))
        self.sharpness_slope = nn.Parameter(torch.tensor(0.0))

    def groups(self) -> list[tuple[float, float, list[tuple[int, int]]]]:
        """Weight, sharpness and offsets of each group."""
        inner = math.exp(_within(self.inner, -1.5, 1.5))
        outer = inner * (1.2 + math.exp(_within(self.outer, -2.0, 1.5)))
        squares = [y * y + x * x for ((y, x), *_) in self.orbits]
        weights = [math.exp(-square / (4 * inner * inner)) - float(self.surround) * math.exp(-square / (4 * outer * outer))
                   for square in squares]
        total = sum(abs(weight) * len(group) for weight, group in zip(weights, self.orbits, strict=True)) or 1e-9
        factor = min(math.exp(_within(self.scale, -50.0, 50.0)), MOST_SCALE) / total
        slope = float(self.sharpness_slope)
        sharpness = [math.exp(_within(float(self.sharpness) + slope * (square - 1) / 10, -3.0, 3.0)) for square in squares]
        return [(weight * factor, sharp, group)
                for weight, sharp, group in zip(weights, sharpness, self.orbits, strict=True)]

    def forward(self, values: Tensor) -> Tensor:
        m = self.margin
        total = float(self.keep) * crop(values, m, m, m, m)
        for weight, sharpness, group in self.groups():
            sharp = values * sharpness
            for y, x in halves(group):
                left, right = max(x, 0), max(-x, 0)
                # Differences from each texel to its neighbour at the offset, and to it from the neighbour at the negative offset.
                difference = crop(sharp, m - y, m - left, m, m - right) - crop(sharp, m, m - right, m - y, m - left)
                if values.shape[1] == 1:
                    difference.clamp_(-1, 1)
                else:
                    difference.div_(difference.square().sum(1, keepdim=True).clamp_min_(1).sqrt_())
                total.add_(crop(difference, y, left, 0, right), alpha=weight)
                total.sub_(crop(difference, 0, right, y, left), alpha=weight)
        return total


class Relaxation(nn.Module):
    """A sequence of steps, evaluated without gradients. `reaches` are the squared radii of their discs of offsets;
    `receptive_radius` is the sum of their margins."""

    def __init__(self, reaches: list[int], channels: int = 1) -> None:
        super().__init__()
        self.channels = channels
        last = max(len(reaches) - 1, 1)
        # Steps become wider and sharper. Training soon finds better values, but these initial values work for any number of steps.
        self.steps = nn.ModuleList(
            Step(reach, sigma=0.35 + 0.65 * min(1.0, 1.7 * i / last), keep=0.02,
                 scale=3.0 * 20.0 ** (i / last) if i < len(reaches) - 1 else 1.0)
            for i, reach in enumerate(reaches)
        )
        self.receptive_radius = sum(step.margin for step in self.steps)
        # The factor that makes the last step's values most uniform in [0, 1]; see `calibrate`.
        self.register_buffer("gain", torch.tensor(1.0))
        self.requires_grad_(False)

    def begin(self, noise: Tensor) -> Tensor:
        """The initial values (n, c, h, w) for noise (n, 1, h, w), uniform in [0, 1)."""
        if self.channels == 2:
            low = noise * SPLIT
            noise = torch.cat([noise, low - low.floor()], 1)
        return FIRST_SCALE * (noise - 0.5)

    def forward(self, noise: Tensor) -> Tensor:
        """Maps noise (n, 1, h + 2r, w + 2r) to values (n, c, h, w), without padding."""
        values = self.begin(noise)
        for step in self.steps:
            values = step(values)
        return 0.5 + self.gain * values

    def torus(self, noise: Tensor) -> Tensor:
        """Maps noise (n, 1, h, w) to values (n, c, h, w) on a torus."""
        values = self.begin(noise)
        for step in self.steps:
            values = step(wrap(values, step.margin))
        return 0.5 + self.gain * values

    def vector(self) -> Tensor:
        """Returns all parameters as one float64 vector; `load_vector` sets them."""
        return torch.cat([p.reshape(-1) for p in self.parameters()]).double()

    def load_vector(self, vector: Tensor) -> None:
        at = 0
        for parameter in self.parameters():
            parameter.copy_(vector[at : at + parameter.numel()].view_as(parameter))
            at += parameter.numel()

    def spreads(self, sharpness: bool = True) -> Tensor:
        """The initial spread of each parameter of `vector` in training. Without `sharpness`, sharpness stays 1 at all offsets."""
        parts = {"scale": 0.5, "keep": 0.05, "inner": 0.15, "outer": 0.3, "surround": 0.15, "sharpness": 0.3,
                 "sharpness_slope": 0.3}
        if not sharpness:
            parts["sharpness"] = parts["sharpness_slope"] = 0.0
        return torch.tensor([parts[name.rsplit(".", 1)[-1]] for name, _ in self.named_parameters()], dtype=torch.float64)

    def calibrate(self, noise: Tensor) -> None:
        """Sets `gain` so that the values have the standard deviation of a uniform distribution."""
        self.gain.fill_(1.0)
        self.gain.fill_(12**-0.5 / float((self.torus(noise) - 0.5).square().mean().sqrt().clamp_min(1e-9)))


def wrap(values: Tensor, margin: int) -> Tensor:
    """Adds a toroidal margin, which may be wider than the extent."""
    height, width = values.shape[-2:]
    if margin > min(height, width):
        ys, xs = (torch.arange(-margin, extent + margin, device=values.device) % extent for extent in (height, width))
        return values[:, :, ys][:, :, :, xs]
    return F.pad(values, (margin,) * 4, mode="circular") if margin else values
