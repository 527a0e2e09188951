# SPDX-License-Identifier: Apache-2.0
"""Evolution strategy with covariance matrix adaptation: minimises a noisy function without its gradient.

Based on N. Hansen, "The CMA Evolution Strategy: A Tutorial" (2016), without restarts. All arithmetic uses float64 on the
CPU. Candidates come from a generator seeded by (seed, generation), so a resumed search continues exactly where it stopped.
"""

from __future__ import annotations

import math
import random
from typing import Any

import torch
from torch import Tensor


class Evolution:
    """The candidate distribution: a Gaussian with mean `mean` and covariance step^2 times `covariance`, in units of
    each parameter's spread."""

    def __init__(self, start: Tensor, spreads: Tensor, *, population: int, step: float, seed: int) -> None:
        n = start.numel()
        self.spreads, self.population, self.seed, self.generation = spreads.double(), population, seed, 0
        self.mean, self.step = start.double().clone(), step
        self.covariance = torch.eye(n, dtype=torch.float64)
        self.path, self.step_path = torch.zeros(n, dtype=torch.float64), torch.zeros(n, dtype=torch.float64)
        parents = population // 2
        weights = math.log(parents + 0.5) - torch.log(torch.arange(1, parents + 1, dtype=torch.float64))
        self.weights = weights / weights.sum()
        effective = 1 / float(self.weights.square().sum())
        self.effective = effective
        self.path_rate = 4 / (n + 4)
        self.step_rate = (effective + 2) / (n + effective + 5)
        self.one_rate = 2 / ((n + 1.3) ** 2 + effective)
        self.many_rate = min(1 - self.one_rate, 2 * (effective - 2 + 1 / effective) / ((n + 2) ** 2 + effective))
        self.length = math.sqrt(n) * (1 - 1 / (4 * n) + 1 / (21 * n * n))
        self._decompose()

    @staticmethod
    def usual_population(parameters: int) -> int:
        return 4 + int(3 * math.log(parameters))

    def _decompose(self) -> None:
        values, self.axes = torch.linalg.eigh(self.covariance)
        self.lengths = values.clamp_min(1e-20).sqrt()

    def candidates(self) -> Tensor:
        """Draws candidates of shape (population, parameters)."""
        generator = torch.Generator().manual_seed(random.Random(f"{self.seed}:{self.generation}:candidates").getrandbits(63))
        normal = torch.randn(self.population, self.mean.numel(), dtype=torch.float64, generator=generator)
        self.moves = (normal * self.lengths) @ self.axes.T
        return self.mean + self.step * self.moves * self.spreads

    def learn(self, losses: Tensor) -> None:
        """Moves the distribution towards the better half of the last candidates."""
        best = losses.nan_to_num(nan=math.inf).argsort(stable=True)[: len(self.weights)]
        moves = self.moves[best]
        move = self.weights @ moves
        self.mean = self.mean + self.step * move * self.spreads
        whitened = self.axes @ ((self.axes.T @ move) / self.lengths)
        s, c = self.step_rate, self.path_rate
        self.step_path = (1 - s) * self.step_path + math.sqrt(s * (2 - s) * self.effective) * whitened
        self.path = (1 - c) * self.path + math.sqrt(c * (2 - c) * self.effective) * move
        growth = s / (1 + s) * (float(self.step_path.norm()) / self.length - 1)
        self.step = min(self.step * math.exp(growth), 1.5)
        self.covariance = ((1 - self.one_rate - self.many_rate) * self.covariance
                           + self.one_rate * torch.outer(self.path, self.path)
                           + self.many_rate * (moves.T * self.weights) @ moves)
        self._decompose()
        self.generation += 1

    def state(self) -> dict[str, Any]:
        return {"generation": self.generation, "step": self.step, "mean": self.mean, "covariance": self.covariance,
                "path": self.path, "step_path": self.step_path}

    def restore(self, state: dict[str, Any]) -> None:
        """Restores a state. Raises KeyError, TypeError or ValueError if it belongs to another search."""
        for name in ("mean", "covariance", "path", "step_path"):
            if state[name].shape != getattr(self, name).shape:
                raise ValueError(name)
            setattr(self, name, state[name].double())
        self.generation, self.step = int(state["generation"]), float(state["step"])
        self._decompose()
