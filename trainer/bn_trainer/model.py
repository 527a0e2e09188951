# SPDX-License-Identifier: Apache-2.0
"""The network: a learned relaxation, stride 1, for any size.

Summed over all thresholds, the squared dithering error of a mask is a constant minus a sum over pairs of
W(p - q) |r_p - r_q|, so its gradient at p is a blurred sign of r_p - r_q. That sign separates into slices: with
ramps F_c(r) = clip(a_c r + b_c, 0, 1) it is a sum over c of G_c(r_p) F_c(r_q), G_c a combination of the ramps. One
step is therefore: ramps of the values, one depthwise convolution, a pointwise mixing, the product with the ramps
of the texel itself, a sum, and a pointwise correction that keeps the histogram flat. Kernels, ramps, mixing and
correction of every step are learned. Kernels have the eight symmetries of the square, so they favour no axis and
have few parameters. Steps start as the relaxation of `bn_relax`, step and softness falling geometrically.
"""

from __future__ import annotations

import torch
from torch import Tensor, nn
from torch.nn import functional as F


def orbit_map(size: int) -> Tensor:
    """For a size x size kernel, which of its free parameters each tap uses under the eight symmetries."""
    half = size // 2
    keys: dict[tuple[int, int], int] = {}
    taps = []
    for y in range(-half, half + 1):
        for x in range(-half, half + 1):
            key = (max(abs(x), abs(y)), min(abs(x), abs(y)))
            taps.append(keys.setdefault(key, len(keys)))
    return torch.tensor(taps).view(size, size)


class _Depthwise(torch.autograd.Function):
    """Depthwise convolution with symmetric kernels, given by their free parameters (channels, orbits). The gradients
    are one more convolution and sums over the texels of each orbit: on a processor several times faster than those
    that come with torch."""

    @staticmethod
    def forward(ctx, values, taps, orbit):  # type: ignore[no-untyped-def]
        ctx.save_for_backward(values, taps, orbit)
        return F.conv2d(values, taps[:, orbit].unsqueeze(1), groups=taps.shape[0])

    @staticmethod
    def backward(ctx, upstream):  # type: ignore[no-untyped-def]
        values, taps, orbit = ctx.saved_tensors
        upstream = upstream.contiguous()
        size = orbit.shape[0]
        m = size // 2
        height, width = upstream.shape[-2:]
        kernel = taps[:, orbit].unsqueeze(1)
        to_values = F.conv2d(upstream, kernel, padding=size - 1, groups=taps.shape[0])
        columns = [values[..., m - x : m - x + width] for x in range(m + 1)]
        columns = [columns[x] + values[..., m + x : m + x + width] if x else columns[0] for x in range(m + 1)]

        def rows(y: int, x: int) -> Tensor:
            above = columns[x][:, :, m - y : m - y + height]
            return above + columns[x][:, :, m + y : m + y + height] if y else above

        to_taps = torch.empty_like(taps)
        for y in range(m + 1):
            for x in range(y + 1):
                total = rows(y, x) + rows(x, y) if x != y else rows(y, x)
                to_taps[:, orbit[m + y, m + x]] = (total * upstream).sum((0, 2, 3))
        return to_values, to_taps, None


class Step(nn.Module):
    """One step: values (n, 1, h + 2m, w + 2m) in, (n, 1, h, w) out, m = kernel // 2."""

    TAP_SCALE = 0.2
    orbit: Tensor
    hats: Tensor
    expected: Tensor

    def __init__(self, channels: int, kernel: int, *, sigma: float, rate: float) -> None:
        super().__init__()
        self.channels, self.kernel, self.margin = channels, kernel, kernel // 2
        self.register_buffer("orbit", orbit_map(kernel), persistent=False)
        # Parameters are of order one, so that one rate suits all; these scales make them what is used.
        self.rate = rate
        c = torch.arange(channels, dtype=torch.float32)
        # Ramps side by side over [0, 1]: how many neighbours lie above the middle of each.
        self.slope = nn.Parameter(torch.ones(channels))
        self.offset = nn.Parameter(-c / channels)
        # Gates: the constant 1, then ramps from one middle to the next. Differences of neighbours are hats that say
        # to which ramp a value belongs.
        self.gate_slope = nn.Parameter(torch.where(c > 0, 1.0, 0.0))
        self.gate_offset = nn.Parameter(torch.where(c > 0, 0.5 - c, float(channels)) / channels)

        axis = torch.arange(-self.margin, self.margin + 1, dtype=torch.float64)
        gauss = torch.exp(-(axis[:, None] ** 2 + axis[None, :] ** 2) / (4 * sigma * sigma))
        gauss[self.margin, self.margin] = 0
        gauss /= gauss.sum()
        taps = torch.zeros(int(self.orbit.max()) + 1, dtype=torch.float64)
        taps[self.orbit.reshape(-1)] = gauss.reshape(-1)
        self.taps = nn.Parameter((taps / self.TAP_SCALE).float().repeat(channels, 1))

        self.register_buffer("hats", torch.eye(channels) - torch.diag(torch.ones(channels - 1), -1), persistent=False)
        self.register_buffer("expected", 1 - (c + 0.5) / channels, persistent=False)
        # Between hats and what lies above each ramp beyond what is expected: there, parameters act apart from each other.
        self.mix = nn.Parameter(-torch.eye(channels))
        self.bias = nn.Parameter(torch.zeros(channels))
        self.keep = nn.Parameter(torch.tensor(1.0))

    def ramps(self, values: Tensor, slope: Tensor, offset: Tensor) -> Tensor:
        weight = (self.channels * slope).view(-1, 1, 1, 1)
        return F.conv2d(values, weight, self.channels * offset).clamp(0.0, 1.0)

    def mixing(self) -> tuple[Tensor, Tensor]:
        """Weight and bias of the pointwise mixing: from ramps around to factors of the gates."""
        hats = self.rate * self.hats
        return hats @ self.mix, hats @ (self.bias - self.mix @ self.expected)

    def kernels(self) -> Tensor:
        """Free parameters of the depthwise kernels, (channels, orbits)."""
        return self.TAP_SCALE * self.taps

    def forward(self, values: Tensor) -> Tensor:
        m = self.margin
        ramps = self.ramps(values, self.slope, self.offset)
        around = _Depthwise.apply(ramps, self.kernels(), self.orbit)
        mix, bias = self.mixing()
        mixed = F.conv2d(around, mix[:, :, None, None], bias)
        inner = values[:, :, m : values.shape[2] - m, m : values.shape[3] - m]
        gates = self.ramps(inner, self.gate_slope, self.gate_offset)
        # A convolution with ones, not a sum: runtimes keep their blocked layout up to here.
        ones = torch.ones(1, self.channels, 1, 1, dtype=values.dtype, device=values.device)
        return self.keep * inner + F.conv2d(gates * mixed, ones)


class Relaxation(nn.Module):
    """Steps one after the other. `receptive_radius` is the sum of their margins."""

    def __init__(self, channels: list[int], kernels: list[int], *, sigma: float = 0.92, first_rate: float = 4.0,
                 last_rate: float = 0.2) -> None:
        super().__init__()
        count = len(channels)
        rates = [first_rate * (last_rate / first_rate) ** (i / max(count - 1, 1)) for i in range(count)]
        self.steps = nn.ModuleList(
            Step(c, k, sigma=sigma, rate=rate) for c, k, rate in zip(channels, kernels, rates, strict=True)
        )
        self.receptive_radius = sum(k // 2 for k in kernels)

    @staticmethod
    def finish(values: Tensor) -> Tensor:
        """Into [0, 1], but for rare outliers, which libbn clamps in windows. What is beyond the ends is squeezed, not cut
        off: that would make ties, and ties rows of dots in the lightest patterns."""
        end = 1 / 256
        middle = values.clamp(end, 1 - end)
        return middle + (values - middle) / 64

    def forward(self, noise: Tensor) -> Tensor:
        """Noise (n, 1, h + 2r, w + 2r), uniform in [0, 1), to values (n, 1, h, w); the unpadded graph."""
        values = noise
        for step in self.steps:
            values = step(values)
        return self.finish(values)

    def torus(self, noise: Tensor, damping: float = 1.0) -> list[Tensor]:
        """Values (n, 1, h, w) after every step on a torus; the last is the output. Gradients that pass from a step
        to the one before are multiplied by `damping`."""
        values, after = noise, []
        for step in self.steps:
            if damping != 1:
                values = damping * values + (1 - damping) * values.detach()
            values = step(wrap(values, step.margin))
            after.append(values)
        after[-1] = self.finish(after[-1])
        return after

    def flop_per_texel(self) -> int:
        """Multiplications and additions per output texel, margins aside."""
        return sum(2 * s.channels * (s.kernel**2 + s.channels + 4) + 2 for s in self.steps) + 6


def wrap(values: Tensor, margin: int) -> Tensor:
    """A toroidal margin, also one wider than the extent."""
    height, width = values.shape[-2:]
    if margin > min(height, width):
        ys, xs = (torch.arange(-margin, extent + margin, device=values.device) % extent for extent in (height, width))
        return values[:, :, ys][:, :, :, xs]
    return F.pad(values, (margin,) * 4, mode="circular") if margin else values
