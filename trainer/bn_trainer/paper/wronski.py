# SPDX-License-Identifier: Apache-2.0
"""Wronski, "Optimizing blue noise dithering: backpropagation through Fourier transform and sorting" (2020).

Optimises a mask's texels directly, without a network, starting from white noise. It uses the losses that the paper later
adopted (see perceptron.py), but sums the histogram loss over texels. Wronski uses plain gradient descent. This module uses
Adam with cosine decay of the learning rate to 0, which reaches a much lower loss in the same number of iterations. Masks are
independent of one another and run as one batch.

One iteration for a mask of n texels needs a forward and an inverse transform, a sort and about 60 operations per texel.
1,000 iterations take 1 s per mask at 64x64 and 6 s at 128x128 on one core.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Optional

import numpy as np
import torch

from . import perceptron

RATE = 0.03
INPUTS = 1 << 61  # seed of the initial noise; differs from the seeds in perceptron.py


def optimise(size: int, seeds: Sequence[int], iterations: int = 1000,
             progress: Optional[Callable[[float], object]] = None) -> np.ndarray:
    """One mask per seed: float32 (len(seeds), size, size), nearly uniform in [-1, 1]. `progress` is called with the mean
    loss over masks after every iteration."""
    config = perceptron.PaperConfig(size=size, histogram="sum")
    weights = perceptron.low_frequency_weights(size, config.cutoff)
    masks = perceptron.white_noise(size, INPUTS, seeds).requires_grad_()
    optimiser = torch.optim.Adam([masks], lr=RATE)
    for iteration in range(iterations):
        optimiser.param_groups[0]["lr"] = RATE * 0.5 * (1 + math.cos(math.pi * iteration / iterations))
        loss, _ = perceptron.paper_loss(masks, config, weights)
        optimiser.zero_grad()
        (loss * len(seeds)).backward()  # the loss is a mean over masks; this makes them independent
        optimiser.step()
        if progress:
            progress(loss.item())
    return masks.detach().numpy()


def flop_per_texel(size: int, iterations: int) -> float:
    """Floating-point operations per texel: two real transforms of 2.5 n log2 n, and 60 for weights, differences, gradients
    and the update. Comparisons in the sort are not counted."""
    return iterations * (2 * 2.5 * math.log2(size * size) + 60)
