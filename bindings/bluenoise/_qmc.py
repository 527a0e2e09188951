# SPDX-License-Identifier: Apache-2.0
"""One pixel of a sampler as a SciPy quasi-Monte Carlo engine; imported on first use."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt
from scipy.stats import qmc

from . import _arguments as arguments
from . import _core

if TYPE_CHECKING:
    from ._sampler import Sampler


class SamplerEngine(qmc.QMCEngine):  # type: ignore[misc]
    """The samples of one pixel; see ``Sampler.qmc``."""

    def __init__(self, sampler: Sampler, d: int, pixel: tuple[int, int] = (0, 0)) -> None:
        d = arguments.integer("d", d, 1, 2**31 - 1)
        try:
            x, y = pixel
        except (TypeError, ValueError):
            raise ValueError(f"pixel must be (x, y), not {pixel!r}") from None
        super().__init__(d=d)
        self._sampler = sampler
        self._x = arguments.integer("pixel", x, *arguments.INT32)
        self._y = arguments.integer("pixel", y, *arguments.INT32)

    def _random(self, n: int = 1, *, workers: int = 1) -> npt.NDArray[np.float64]:
        n = arguments.integer("n", n, 0, 2**32 - self.num_generated)
        points = np.empty((n, self.d), np.float64)
        if n == 0:
            return points
        for first in range(0, self.d, 4):
            width = min(4, self.d - first)
            samples = self._sampler.block(
                self._x, self._y, 1, 1, self.num_generated, n, _core.domain_child(0, first // 4)
            )
            points[:, first : first + width] = samples[0, 0, :, :width]
        return points

    def fast_forward(self, n: int) -> SamplerEngine:
        """Skips n points at no cost and returns the engine."""
        self.num_generated += arguments.integer("n", n, 0, 2**32 - self.num_generated)
        return self

    def __repr__(self) -> str:
        return f"<{self._sampler!r}.qmc({self.d}, pixel=({self._x}, {self._y})) at index {self.num_generated}>"
