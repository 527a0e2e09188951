# SPDX-License-Identifier: Apache-2.0
"""The losses that training minimises: the dithering error of masks, and the energy of vector masks.

For values r uniform in [0, 1], the squared error E_sigma^2 averaged over all thresholds is 1/6 - 1/2 sum over offsets of
W(offset) mean |r_p - r_(p + offset)|, where W is the toroidal Gaussian of width sigma sqrt(2) and sum 1. For vectors, the
energy is the one that `bn_anneal` minimises for two channels.
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


def pair_weights(height: int, width: int, sigma: float) -> dict[tuple[int, int], float]:
    """Half of the offsets (y, x) and their weights in E_sigma^2."""
    wide = sigma * math.sqrt(2)
    table = torch.outer(gaussian_weights(height, wide), gaussian_weights(width, wide))
    reach = math.ceil(4.2 * wide)
    pairs: dict[tuple[int, int], float] = {}
    for y in range(-(height // 2), height - height // 2):
        for x in range(-(width // 2), width - width // 2):
            weight = float(table[y % height, x % width])
            if (y, x) != (0, 0) and y * y + x * x <= reach * reach and weight > 1e-7 * float(table[0, 0]):
                # An offset and its negative give identical pairs.
                key = min((y % height, x % width), (-y % height, -x % width))
                pairs[key] = pairs.get(key, 0.0) + weight
    return {((y + height // 2) % height - height // 2, (x + width // 2) % width - width // 2): w
            for (y, x), w in pairs.items()}


class _Pairs:
    """Views of images (n, c, h, w) on a torus, shifted by offsets."""

    def __init__(self, offsets: list[tuple[int, int]]) -> None:
        self.offsets = offsets
        self.reach = max(max(abs(y), abs(x)) for y, x in offsets)

    def means(self, images: Tensor, distance) -> Tensor:  # type: ignore[no-untyped-def]
        """The mean over texels of distance(image - shifted image) for each offset, (offsets, n)."""
        height, width = images.shape[-2:]
        padded = F.pad(images, (self.reach,) * 4, mode="circular")
        difference = torch.empty_like(images)
        means = []
        for y, x in self.offsets:
            top, left = self.reach + y, self.reach + x
            torch.sub(images, padded[:, :, top : top + height, left : left + width], out=difference)
            means.append(distance(difference).mean((1, 2, 3)))
        return torch.stack(means).double()


class DitheringError:
    """E_sigma^2 for several sigmas, (sigmas, n), of masks (n, h, w) with values uniform in [0, 1]."""

    def __init__(self, height: int, width: int, sigmas: list[float]) -> None:
        weights = [pair_weights(height, width, sigma) for sigma in sigmas]
        offsets = list(max(weights, key=len))
        self.pairs = _Pairs(offsets)
        self.weights = torch.tensor([[w.get(offset, 0.0) for offset in offsets] for w in weights], dtype=torch.float64)
        # The far tail of the Gaussian is omitted; such distant texels differ by 1/3 on average.
        centres = torch.tensor([float(gaussian_weights(height, s * math.sqrt(2))[0] * gaussian_weights(width, s * math.sqrt(2))[0])
                                for s in sigmas], dtype=torch.float64)
        self.constants = 1 / 6 - (1 - centres - self.weights.sum(1)) / 6

    def __call__(self, values: Tensor) -> Tensor:
        means = self.pairs.means(values.unsqueeze(1), lambda difference: difference.abs_())
        return self.constants[:, None] - 0.5 * self.weights @ means


class VectorEnergy:
    """The energy, (n), of vector masks (n, 2, h, w): the mean over pairs of texels of exp(-|difference of values|),
    weighted by exp(-distance^2 / 4). White noise has an energy of 0.612."""

    def __init__(self) -> None:
        offsets = [(y, x) for y in range(7) for x in range(-6, 7) if (y > 0 or x > 0) and y * y + x * x <= 36]
        self.pairs = _Pairs(offsets)
        weights = torch.tensor([math.exp(-(y * y + x * x) / 4) for y, x in offsets], dtype=torch.float64)
        self.weights = weights / weights.sum()

    def __call__(self, values: Tensor) -> Tensor:
        def closeness(difference: Tensor) -> Tensor:
            return difference.square_().sum(1, keepdim=True).sqrt_().neg_().exp_()

        return self.weights @ self.pairs.means(values, closeness)


class Direction:
    """The direction dependence of the mean spectrum of masks (n, h, h): the mean over frequency rings of max(|A - D| / (A +
    D) - TOLERANCE, 0)^2, where A is the power within 22.5 degrees of an axis and D the power closer to a diagonal. Without
    this term, training finds masks with low error but visible rows and columns."""

    #: Void-and-cluster reaches up to 0.14.
    TOLERANCE = 0.1
    RINGS = torch.arange(0.25, 0.5, 0.03125).tolist()

    def __init__(self, size: int) -> None:
        f = torch.fft.fftfreq(size, dtype=torch.float64)
        radius = torch.hypot(f[:, None], f[None, :])
        angle = torch.atan2(f[:, None].expand(size, size), f[None, :].expand(size, size)).abs() % (math.pi / 2)
        axis = (angle < math.pi / 8) | (angle > 3 * math.pi / 8)
        sectors = []
        for low in self.RINGS:
            ring = (radius >= low) & (radius < low + 0.03125)
            sectors += [ring & axis, ring & ~axis]
        weights = torch.stack([s.double() / s.sum().clamp_min(1) for s in sectors])
        self.weights = weights.reshape(len(self.RINGS), 2, -1).float()

    def __call__(self, values: Tensor) -> Tensor:
        power = torch.fft.fft2(values - 0.5).abs().square().mean(0).reshape(-1)
        a, d = (self.weights.to(power.device) @ power).unbind(1)
        return (((a - d) / (a + d).clamp_min(1e-12)).abs() - self.TOLERANCE).clamp_min(0).square().mean()


def ranks(values: Tensor) -> Tensor:
    """(rank + 0.5) / count of each value in its channel, for values (n, c, h, w)."""
    flat = values.reshape(values.shape[0] * values.shape[1], -1)
    count = flat.shape[1]
    order = flat.argsort(dim=1, stable=True)
    steps = (torch.arange(count, device=values.device, dtype=values.dtype) + 0.5) / count
    return torch.empty_like(flat).scatter_(1, order, steps.expand_as(flat)).view_as(values)
