# SPDX-License-Identifier: Apache-2.0
"""The dithering error as a loss: over all thresholds at once, on exact ranks.

For values r uniform in [0, 1], the squared error E_sigma^2 averaged over all thresholds is
1/6 - 1/2 sum over offsets of W(offset) mean |r_p - r_(p + offset)|, where W is the toroidal Gaussian of sigma sqrt(2) with
sum 1. Its gradient is a sum of signs, computed in the same pass. Ranks are not differentiable, but to first order a rank
follows its value minus the common movement of all values of similar rank; the backward pass therefore subtracts a moving
average, in sorted order, from the gradient.
"""

from __future__ import annotations

import math

import torch
from torch import Tensor
from torch.nn import functional as F


def gaussian_weights(extent: int, sigma: float) -> Tensor:
    """The toroidal Gaussian with transfer function exp(-2 pi^2 sigma^2 f^2): extent taps with sum 1 (float64)."""
    f = torch.fft.fftfreq(extent, dtype=torch.float64)
    return torch.fft.ifft(torch.exp(-2 * math.pi**2 * sigma**2 * f**2)).real


def pair_weights(height: int, width: int, sigmas: list[float], shares: list[float]) -> dict[tuple[int, int], float]:
    """Half of the offsets (y, x) and their weights in the mixture of E_sigma^2 over sigmas, weighted by shares."""
    table = torch.zeros(height, width, dtype=torch.float64)
    for sigma, share in zip(sigmas, shares, strict=True):
        wide = sigma * math.sqrt(2)
        table += share * torch.outer(gaussian_weights(height, wide), gaussian_weights(width, wide))
    reach = math.ceil(4.2 * math.sqrt(2) * max(sigmas))
    pairs: dict[tuple[int, int], float] = {}
    for y in range(-(height // 2), height - height // 2):
        for x in range(-(width // 2), width - width // 2):
            weight = float(table[y % height, x % width])
            if (y, x) != (0, 0) and y * y + x * x <= reach * reach and weight > 1e-7 * float(table[0, 0]):
                # An offset and its negative give the same pairs.
                key = min((y % height, x % width), (-y % height, -x % width))
                pairs[key] = pairs.get(key, 0.0) + weight
    return {((y + height // 2) % height - height // 2, (x + width // 2) % width - width // 2): w
            for (y, x), w in pairs.items()}


class _PairSum(torch.autograd.Function):
    """The sum over offsets of w mean |r_p - r_(p + offset)|, one value per mask."""

    @staticmethod
    def forward(ctx, ranks, offsets, weights, reach):  # type: ignore[no-untyped-def]
        n, height, width = ranks.shape
        padded = F.pad(ranks.unsqueeze(1), reach, mode="circular").squeeze(1)
        gradient = torch.zeros_like(padded)
        left, right, top, bottom = reach
        centre = gradient[:, top : top + height, left : left + width]
        total = torch.zeros(n, dtype=ranks.dtype, device=ranks.device)
        for (y, x), weight in zip(offsets, weights, strict=True):
            y0, x0 = top + y, left + x
            difference = ranks - padded[:, y0 : y0 + height, x0 : x0 + width]
            total += weight * difference.abs().sum((1, 2))
            sign = difference.sign_()
            centre.add_(sign, alpha=weight)
            gradient[:, y0 : y0 + height, x0 : x0 + width].sub_(sign, alpha=weight)
        # Fold the margin back onto the torus.
        folded = gradient[:, top : top + height].clone()
        if top:
            folded[:, height - top :] += gradient[:, :top]
        if bottom:
            folded[:, :bottom] += gradient[:, top + height :]
        result = folded[:, :, left : left + width].clone()
        if left:
            result[:, :, width - left :] += folded[:, :, :left]
        if right:
            result[:, :, :right] += folded[:, :, left + width :]
        scale = 1.0 / (height * width)
        ctx.save_for_backward(result * scale)
        return total * scale

    @staticmethod
    def backward(ctx, upstream):  # type: ignore[no-untyped-def]
        (gradient,) = ctx.saved_tensors
        return gradient * upstream.view(-1, 1, 1), None, None, None


class DitheringError:
    """The mixture of E_sigma^2, as (n,), for masks (n, height, width) with values uniform in [0, 1]."""

    def __init__(self, height: int, width: int, sigmas: list[float], shares: list[float]) -> None:
        pairs = pair_weights(height, width, sigmas, shares)
        self.offsets = list(pairs)
        self.weights = list(pairs.values())
        # The far tail of the Gaussian is omitted; texels that far apart differ by 1/3 on average.
        centre = sum(share * float(gaussian_weights(height, s * math.sqrt(2))[0] * gaussian_weights(width, s * math.sqrt(2))[0])
                     for s, share in zip(sigmas, shares))
        left_out = sum(shares) - centre - sum(self.weights)
        self.constant = sum(shares) / 6 - left_out / 6
        ys, xs = [y for y, _ in self.offsets], [x for _, x in self.offsets]
        self.reach = (max(0, -min(xs)), max(0, max(xs)), max(0, -min(ys)), max(0, max(ys)))

    def __call__(self, values: Tensor) -> Tensor:
        return self.constant - 0.5 * _PairSum.apply(values, self.offsets, self.weights, self.reach)


class _Ranks(torch.autograd.Function):
    """(rank + 0.5) / count of each value in its mask, with the gradient described at the top."""

    @staticmethod
    def forward(ctx, values, order, window):  # type: ignore[no-untyped-def]
        n, count = order.shape
        ranks = torch.empty(n, count, dtype=values.dtype, device=values.device)
        steps = (torch.arange(count, device=values.device, dtype=values.dtype) + 0.5) / count
        ranks.scatter_(1, order, steps.expand(n, count))
        ctx.save_for_backward(order)
        ctx.window = window
        return ranks.view_as(values)

    @staticmethod
    def backward(ctx, upstream):  # type: ignore[no-untyped-def]
        (order,) = ctx.saved_tensors
        count = order.shape[1]
        window = min(ctx.window, count) | 1
        sorted_gradient = upstream.reshape(order.shape).gather(1, order)
        half = window // 2
        if half >= count:
            half = (count - 1) // 2
        padded = F.pad(sorted_gradient.unsqueeze(1), (half, half), mode="reflect")
        mean = F.avg_pool1d(padded, 2 * half + 1, stride=1).squeeze(1)
        result = torch.empty_like(sorted_gradient)
        result.scatter_(1, order, sorted_gradient - mean)
        return result.view_as(upstream), None, None


def rank_and_ramp(values: Tensor, window_share: float = 1 / 32) -> tuple[Tensor, Tensor]:
    """Ranks of the masks (n, h, w) and, per mask, the mean squared distance between the sorted values and a ramp."""
    flat = values.reshape(values.shape[0], -1)
    ordered, order = torch.sort(flat, dim=1, stable=True)
    count = flat.shape[1]
    ramp = (torch.arange(count, device=values.device, dtype=values.dtype) + 0.5) / count
    ranks = _Ranks.apply(values, order, max(3, int(count * window_share)))
    return ranks, (ordered - ramp).square().mean(1)
