# SPDX-License-Identifier: Apache-2.0
"""One pixel of a sampler as a SciPy quasi-Monte Carlo engine. `_sampler` imports it on first use, so nothing here imports `_sampler`."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.stats import qmc

from . import _arguments as arguments
from . import _core


class SamplerEngine(qmc.QMCEngine):  # type: ignore[misc]
    """The samples of one pixel; see ``Sampler.qmc``. A ``seed`` replaces the sampler's seed."""

    def __init__(self, sampler: Any, d: int, pixel: tuple[int, int] = (0, 0), *, seed: arguments.Seed = None) -> None:
        d = arguments.integer("d", d, 1, 2**31 - 1)
        try:
            x, y = pixel
        except (TypeError, ValueError, NotImplementedError):  # the latter from memoryview
            raise ValueError(f"pixel must be (x, y), not {arguments.said(pixel)}") from None
        super().__init__(d=d)
        if seed is not None:
            sampler = type(sampler)(sampler.type, seed=seed, samples_per_pixel=sampler.samples_per_pixel, mask=sampler.mask)
        self._sampler = sampler
        # scipy.integrate.qmc_quad() makes engines with these arguments and with seeds derived from this engine's generator. They
        # are reproducible only if the generator is created again: before NumPy 2, a copy of a generator loses its seed.
        self._init_quad = {"sampler": sampler, "d": d, "pixel": pixel}
        self.rng_seed = self.rng = np.random.default_rng(sampler.seed)
        self._x = arguments.integer("pixel", x, *arguments.INT32)
        self._y = arguments.integer("pixel", y, *arguments.INT32)

    def _random(self, n: int = 1, *, workers: int = 1) -> npt.NDArray[np.float64]:
        n = arguments.integer("n", n, 0, 2**32 - self.num_generated)
        points = np.empty((n, self.d), np.float64)
        if n == 0:
            return points
        for first in range(0, self.d, 4):
            width = min(4, self.d - first)
            four = np.empty((n, 4), np.float64)
            self._sampler._core.points(self._x, self._y, self.num_generated, _core.domain_child(0, first // 4), four)
            points[:, first : first + width] = four[:, :width]
        return points

    def reset(self) -> SamplerEngine:
        """Restarts at the first point and returns the engine."""
        self.num_generated = 0
        self.rng_seed = self.rng = np.random.default_rng(self._sampler.seed)
        return self

    def fast_forward(self, n: int) -> SamplerEngine:
        """Skips n points at no cost and returns the engine."""
        self.num_generated += arguments.integer("n", n, 0, 2**32 - self.num_generated)
        return self

    def __repr__(self) -> str:
        return f"<{self._sampler!r}.qmc({self.d}, pixel=({self._x}, {self._y})) at index {self.num_generated}>"
