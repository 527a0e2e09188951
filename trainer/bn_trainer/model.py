# SPDX-License-Identifier: Apache-2.0
"""The network: a learned relaxation with stride 1, for masks of any size, of one channel or of two.

Summed over all thresholds, the squared dithering error of a mask is a constant minus a sum over pairs of
W(p - q) |r_p - r_q|, so its gradient at p is a sum of W(p - q) sign(r_p - r_q). One step replaces every value by such a
sum, with the sign softened and the weights learned:

    v_p <- keep v_p + sum over offsets o of w_o direction(s_o (v_p - v_(p + o))),    direction(d) = d / max(|d|, 1)

For one channel, direction(d) is clip(d, -1, 1): a convolution that takes differences, a clip and a convolution of 1 x 1.
For two channels d is a vector, and the directions are those of the forces in "Blue-noise dithered sampling" (Georgiev and
Fajardo, 2016). The sharpness s_o sets how soft the sign is: differences of less than 1 / s_o count in part. Offsets related
by the eight symmetries of the square share weight and sharpness, so no axis is favoured and parameters are few.
"""

from __future__ import annotations

import math

import torch
from torch import Tensor, nn
from torch.nn import functional as F

#: Uniform noise in [0, 1) is multiplied by this before the first step.
FIRST_SCALE = 8.0
#: The most a step may scale its sum by: beyond, rounding errors would grow from step to step.
MOST_SCALE = 128.0
#: The second channel of a vector starts from the low bits of the noise, which has 24 of them.
SPLIT = 4096.0


def orbits(reach: int) -> list[list[tuple[int, int]]]:
    """The offsets (y, x) with 0 < y^2 + x^2 <= reach, in groups that the symmetries of the square map to each other."""
    half = math.isqrt(reach)
    groups: dict[tuple[int, int, int], list[tuple[int, int]]] = {}
    for y in range(-half, half + 1):
        for x in range(-half, half + 1):
            if 0 < y * y + x * x <= reach:
                near, far = sorted((abs(y), abs(x)))
                groups.setdefault((y * y + x * x, far, near), []).append((y, x))
    return [groups[key] for key in sorted(groups)]


class Step(nn.Module):
    """One step: maps values (n, c, h + 2m, w + 2m) to (n, c, h, w), where m is `margin`.

    `taps` are the weights of the groups of offsets, up to a factor; `scale` is the logarithm of the sum of the
    magnitudes of all weights; `sharpness` the logarithm of that of each group."""

    def __init__(self, reach: int, *, sigma: float, scale: float, keep: float) -> None:
        super().__init__()
        self.reach, self.margin, self.orbits = reach, math.isqrt(reach), orbits(reach)
        squares = torch.tensor([float(y * y + x * x) for ((y, x), *_) in self.orbits])
        self.scale = nn.Parameter(torch.tensor(math.log(scale)))
        self.keep = nn.Parameter(torch.tensor(keep))
        self.taps = nn.Parameter(torch.exp(-squares / (4 * sigma * sigma)))
        self.sharpness = nn.Parameter(torch.zeros(len(self.orbits)))

    def groups(self) -> list[tuple[float, float, list[tuple[int, int]]]]:
        """Weight, sharpness and offsets of each group."""
        sharpness = self.sharpness.double().clamp(-3.0, 3.0).exp().tolist()
        return list(zip(self._weights(), sharpness, self.orbits, strict=True))

    def _weights(self) -> list[float]:
        taps = self.taps.double()
        counts = torch.tensor([len(group) for group in self.orbits], dtype=torch.float64)
        total = (counts * taps.abs()).sum().clamp_min(1e-9)
        return (taps * min(math.exp(min(float(self.scale), 50.0)), MOST_SCALE) / total).tolist()

    def forward(self, values: Tensor) -> Tensor:
        m = self.margin
        height, width = values.shape[2] - 2 * m, values.shape[3] - 2 * m
        inner = values[:, :, m : m + height, m : m + width]
        total = float(self.keep) * inner
        difference = torch.empty_like(inner)
        for weight, sharpness, group in self.groups():
            sharp, sharp_inner = values * sharpness, inner * sharpness
            for y, x in group:
                torch.sub(sharp_inner, sharp[:, :, m + y : m + y + height, m + x : m + x + width], out=difference)
                if values.shape[1] == 1:
                    total.add_(difference.clamp_(-1, 1), alpha=weight)
                else:
                    length = difference.square().sum(1, keepdim=True).clamp_min_(1).sqrt_()
                    total.addcdiv_(difference, length, value=weight)
        return total


class Relaxation(nn.Module):
    """A sequence of steps. `reaches` are the squared radii of their discs of offsets; `receptive_radius` is the sum of
    their margins. Evaluated without gradients."""

    def __init__(self, reaches: list[int], channels: int = 1) -> None:
        super().__init__()
        self.channels = channels
        last = max(len(reaches) - 1, 1)
        # Steps grow wider and sharper. Training soon finds better ones; this start works for every number of steps.
        self.steps = nn.ModuleList(
            Step(reach, sigma=0.35 + 0.65 * min(1.0, 1.7 * i / last), keep=0.02,
                 scale=3.0 * 20.0 ** (i / last) if i < len(reaches) - 1 else 1.0)
            for i, reach in enumerate(reaches)
        )
        self.receptive_radius = sum(step.margin for step in self.steps)
        # Makes the values of the last step as uniform in [0, 1] as a factor can; see `calibrate`.
        self.register_buffer("gain", torch.tensor(1.0))
        self.requires_grad_(False)

    def begin(self, noise: Tensor) -> Tensor:
        """Values (n, c, h, w) of noise (n, 1, h, w), uniform in [0, 1)."""
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
        """All parameters in one float64 vector, and back."""
        return torch.cat([p.reshape(-1) for p in self.parameters()]).double()

    def load_vector(self, vector: Tensor) -> None:
        at = 0
        for parameter in self.parameters():
            parameter.copy_(vector[at : at + parameter.numel()].view_as(parameter))
            at += parameter.numel()

    def spreads(self, sharpness: bool = True) -> Tensor:
        """How far training first varies each parameter of `vector`. Without `sharpness`, that of all groups stays 1."""
        parts = {"scale": 0.5, "keep": 0.05, "taps": 0.15, "sharpness": 0.3 if sharpness else 0.0}
        return torch.cat([torch.full((p.numel(),), parts[name.rsplit(".", 1)[-1]], dtype=torch.float64)
                          for name, p in self.named_parameters()])

    def calibrate(self, noise: Tensor) -> None:
        """Sets `gain` so that the values have the standard deviation of uniform ones."""
        self.gain.fill_(1.0)
        self.gain.fill_(12**-0.5 / float((self.torus(noise) - 0.5).square().mean().sqrt().clamp_min(1e-9)))

    def flop_per_texel(self) -> int:
        """Multiplications and additions per output texel of the exported graph, ignoring margins."""
        total = 0
        for step in self.steps:
            offsets = sum(len(group) for group in step.orbits) + 1
            each = 2 * (2 * step.margin + 1) ** 2 + 2 + (2 if self.channels == 1 else 6)
            total += self.channels * offsets * each
        return total + 4 * self.channels


def wrap(values: Tensor, margin: int) -> Tensor:
    """Adds a toroidal margin, which may be wider than the extent."""
    height, width = values.shape[-2:]
    if margin > min(height, width):
        ys, xs = (torch.arange(-margin, extent + margin, device=values.device) % extent for extent in (height, width))
        return values[:, :, ys][:, :, :, xs]
    return F.pad(values, (margin,) * 4, mode="circular") if margin else values
