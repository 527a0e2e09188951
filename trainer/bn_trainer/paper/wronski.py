# SPDX-License-Identifier: Apache-2.0
"""Wronski, "Optimizing blue noise dithering: backpropagation through Fourier transform and sorting" (2020).

The texels of the mask are optimised directly, without a network, from white noise, with the losses that the paper later
adopted (see perceptron.py) and the histogram loss summed over texels. Wronski uses plain gradient descent,
`rule="descent"`; the default, `rule="adam"` with a cosine decay of the rate to 0, reaches a much lower loss in the same
number of iterations. Masks are independent of each other and run as one batch.

One iteration for a mask of n texels is a forward and an inverse transform, a sort and about 60 operations per texel; 1,000
iterations take 1 s per mask at 64x64 and 6 s at 128x128 on one core.
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Optional

import numpy as np
import torch

from ..config import TrainerError
from ..files import write_atomically
from . import perceptron

RATES = {"adam": 0.03, "descent": 0.4}
INPUTS = 1 << 61  # seed of the initial noise, different from those in perceptron.py


def optimise(size: int, seeds: Sequence[int], iterations: int = 1000, rule: str = "adam", rate: Optional[float] = None,
             config: Optional[perceptron.PaperConfig] = None,
             progress: Optional[Callable[[int, float, dict[str, float]], object]] = None) -> np.ndarray:
    """One mask per seed: float32 (len(seeds), size, size), nearly uniform in [-1, 1].

    `config` supplies weights, cutoff and histogram (default: the paper's with "sum"). `progress(iteration, loss, terms)`
    is called after every iteration with the mean loss over masks.
    """
    if rule not in RATES:
        raise TrainerError(f"rule must be one of {', '.join(RATES)}, not {rule!r}")
    if iterations < 0 or len(seeds) == 0:
        raise TrainerError(f"iterations must be at least 0 and seeds must not be empty, not {iterations} and {seeds}")
    rate = RATES[rule] if rate is None else rate
    config = perceptron.PaperConfig(size=size, histogram="sum") if config is None else config
    weights = perceptron.low_frequency_weights(size, config.cutoff)
    masks = perceptron.white_noise(size, INPUTS, seeds).requires_grad_()
    optimiser = torch.optim.Adam([masks], lr=rate) if rule == "adam" else torch.optim.SGD([masks], lr=rate)
    for iteration in range(iterations):
        if rule == "adam":
            optimiser.param_groups[0]["lr"] = rate * 0.5 * (1 + math.cos(math.pi * iteration / iterations))
        loss, terms = perceptron.paper_loss(masks, config, weights)
        optimiser.zero_grad()
        (loss * len(seeds)).backward()  # the loss is a mean over masks; this makes them independent
        optimiser.step()
        if progress:
            progress(iteration + 1, loss.item(), {name: term.item() for name, term in terms.items()})
    return masks.detach().numpy()


def flop_per_texel(size: int, iterations: int) -> float:
    """Floating-point operations per texel: two real transforms of 2.5 n log2 n, and 60 for weights, differences, their
    gradients and the update. The comparisons of the sort are not counted."""
    return iterations * (2 * 2.5 * math.log2(size * size) + 60)


def save_array(path: Path, masks: np.ndarray) -> None:
    with open(path, "wb") as file:  # given a name, np.save would add a suffix
        np.save(file, masks)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--size", type=int, default=64, help="width and height in texels (default 64)")
    parser.add_argument("--seed", type=int, default=0, help="seed of the first mask; the others follow (default 0)")
    parser.add_argument("--count", type=int, default=1, help="number of masks (default 1)")
    parser.add_argument("--iterations", type=int, default=1000, help="number of iterations (default 1000)")
    parser.add_argument("--rule", choices=sorted(RATES), default="adam", help="update rule (default adam)")
    parser.add_argument("--rate", type=float, help=f"step size (default {RATES['adam']} for adam, {RATES['descent']} for descent)")
    parser.add_argument("--threads", type=int, default=1, help="threads of torch (default 1)")
    parser.add_argument("--out", type=Path, required=True, help="the .npy file to write: float32 (count, size, size), nearly in [-1, 1]")


def main(options: argparse.Namespace) -> None:
    if options.size < 2 or options.count < 1 or options.iterations < 0:
        raise TrainerError(f"--size must be at least 2, --count 1, --iterations 0, not {options.size}, {options.count}, "
                           f"{options.iterations}")
    torch.set_num_threads(options.threads)
    told = [time.monotonic()]

    def progress(iteration: int, loss: float, terms: dict[str, float]) -> None:
        if iteration == options.iterations or time.monotonic() - told[0] > perceptron.PROGRESS_SECONDS:
            told[0] = time.monotonic()
            print(f"iteration {iteration} of {options.iterations}  loss {loss:.5g}  "
                  + "  ".join(f"{name} {value:.5g}" for name, value in terms.items()), flush=True)

    seeds = range(options.seed, options.seed + options.count)
    start = time.perf_counter()
    masks = optimise(options.size, seeds, options.iterations, options.rule, options.rate, progress=progress)
    seconds = time.perf_counter() - start
    write_atomically(options.out, lambda beside: save_array(beside, masks))
    print(f"{options.out}: {options.count} masks of {options.size}x{options.size} in {seconds:.1f} s")
