# SPDX-License-Identifier: Apache-2.0
"""The network: a learned relaxation with stride 1, for masks of any size.

Summed over all thresholds, the squared dithering error of a mask is a constant minus a sum over pairs of
W(p - q) |r_p - r_q|, so its gradient at p is a blurred sign of r_p - r_q. That sign is separable: with ramps
F_c(r) = clip(a_c r + b_c, 0, 1) it is a sum over c of G_c(r_p) F_c(r_q), where G_c is a combination of the ramps. One step
therefore consists of ramps of the values, one depthwise convolution, a pointwise mixing, a product with the ramps of the
texel itself, a sum, and a pointwise correction that keeps the histogram flat. Kernels, ramps, mixing and correction are
learned for each step. Kernels have the eight symmetries of the square, so they favour no axis and have few parameters.
Initially the steps equal the relaxation of `bn_relax`, with geometrically decreasing step and softness.
"""

from __future__ import annotations

import torch
from torch import Tensor, nn
from torch.nn import functional as F


def orbit_map(size: int) -> Tensor:
    """The index of the free parameter used by each tap of a size x size kernel with the eight symmetries."""
    half = size // 2
    keys: dict[tuple[int, int], int] = {}
    taps = []
    for y in range(-half, half + 1):
        for x in range(-half, half + 1):
            key = (max(abs(x), abs(y)), min(abs(x), abs(y)))
            taps.append(keys.setdefault(key, len(keys)))
    return torch.tensor(taps).view(size, size)


class _Depthwise(torch.autograd.Function):
    """Depthwise convolution with symmetric kernels, given by their free parameters (channels, orbits). The backward pass
    is one more convolution and sums over the texels of each orbit, on a CPU several times faster than torch's own."""

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
    """One step: maps values (n, 1, h + 2m, w + 2m) to (n, 1, h, w), with m = kernel // 2."""

    TAP_SCALE = 0.2
    orbit: Tensor
    hats: Tensor
    expected: Tensor

    def __init__(self, channels: int, kernel: int, *, sigma: float, rate: float) -> None:
        super().__init__()
        self.channels, self.kernel, self.margin = channels, kernel, kernel // 2
        self.register_buffer("orbit", orbit_map(kernel), persistent=False)
        # Parameters are of order one, so that a single learning rate suits all; they are scaled where used.
        self.rate = rate
        c = torch.arange(channels, dtype=torch.float32)
        # Adjacent ramps over [0, 1]; blurred, they estimate how many neighbours lie above the middle of each.
        self.slope = nn.Parameter(torch.ones(channels))
        self.offset = nn.Parameter(-c / channels)
        # Gates: the constant 1, then ramps from one middle to the next. Differences of adjacent gates are hat functions
        # that select the ramp to which a value belongs.
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
        # Maps the excess above each ramp to hats; in this basis the parameters act independently.
        self.mix = nn.Parameter(-torch.eye(channels))
        self.bias = nn.Parameter(torch.zeros(channels))
        self.keep = nn.Parameter(torch.tensor(1.0))

    def ramps(self, values: Tensor, slope: Tensor, offset: Tensor) -> Tensor:
        weight = (self.channels * slope).view(-1, 1, 1, 1)
        return F.conv2d(values, weight, self.channels * offset).clamp(0.0, 1.0)

    def mixing(self) -> tuple[Tensor, Tensor]:
        """Weight and bias of the pointwise mixing, from blurred ramps to factors of the gates."""
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
        # A convolution with ones instead of a sum lets runtimes keep their blocked layout.
        ones = torch.ones(1, self.channels, 1, 1, dtype=values.dtype, device=values.device)
        return self.keep * inner + F.conv2d(gates * mixed, ones)


class Relaxation(nn.Module):
    """A sequence of steps. `receptive_radius` is the sum of their margins."""

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
        """Maps values to [0, 1], except for rare outliers, which libbn clamps in windows. Values beyond the ends are
        compressed, not clipped: clipping creates ties, and ties create rows of dots in the lightest patterns."""
        end = 1 / 256
        middle = values.clamp(end, 1 - end)
        return middle + (values - middle) / 64

    def forward(self, noise: Tensor) -> Tensor:
        """Maps noise (n, 1, h + 2r, w + 2r), uniform in [0, 1), to values (n, 1, h, w), without padding."""
        values = noise
        for step in self.steps:
            values = step(values)
        return self.finish(values)

    def torus(self, noise: Tensor, damping: float = 1.0) -> list[Tensor]:
        """Values (n, 1, h, w) after each step on a torus; the last are the output. Gradients passed from a step to the
        previous one are multiplied by `damping`."""
        values, after = noise, []
        for step in self.steps:
            if damping != 1:
                values = damping * values + (1 - damping) * values.detach()
            values = step(wrap(values, step.margin))
            after.append(values)
        after[-1] = self.finish(after[-1])
        return after

    def flop_per_texel(self) -> int:
        """Multiplications and additions per output texel, ignoring margins."""
        return sum(2 * s.channels * (s.kernel**2 + s.channels + 4) + 2 for s in self.steps) + 6


def wrap(values: Tensor, margin: int) -> Tensor:
    """Adds a toroidal margin, which may be wider than the extent."""
    height, width = values.shape[-2:]
    if margin > min(height, width):
        ys, xs = (torch.arange(-margin, extent + margin, device=values.device) % extent for extent in (height, width))
        return values[:, :, ys][:, :, :, xs]
    return F.pad(values, (margin,) * 4, mode="circular") if margin else values
