# SPDX-License-Identifier: Apache-2.0
from typing import Any, Optional, overload

import numpy as np
import numpy.typing as npt

from ._arguments import Progress, Ranks

__version__: str
sampler_kinds: dict[str, int]

class CancelledError(RuntimeError): ...
class RuntimeMissingError(RuntimeError): ...

class Sampler:
    def __init__(
        self, kind: int, seed: int, samples_per_pixel: int, mask: Optional[Ranks]
    ) -> None: ...
    def sample(
        self,
        x: npt.NDArray[np.int32],
        y: npt.NDArray[np.int32],
        index: npt.NDArray[np.uint32],
        domain: npt.NDArray[np.uint32],
        out: npt.NDArray[np.float32],
        pair: int = -1,
    ) -> None: ...
    def block(self, x0: int, y0: int, first_index: int, domain: int, out: npt.NDArray[np.float32]) -> None: ...
    def seed_words(self) -> npt.NDArray[np.uint32]: ...

def tables() -> npt.NDArray[np.uint32]: ...

class NeuralGenerator:
    def __init__(
        self,
        model_path: Optional[str],
        model: Optional[bytes],
        runtime: Optional[str],
        threads: int,
        provider: Optional[str],
        channels: int,
        where: str,
    ) -> None: ...
    @property
    def channels(self) -> int: ...
    def mask(self, out: Ranks, seed: int, progress: Optional[Progress]) -> None: ...
    def window(self, x0: int, y0: int, out: npt.NDArray[np.float32], seed: int) -> None: ...

def neural_noise(
    x0: int, y0: int, width: int, height: int, seed: int
) -> npt.NDArray[np.float32]: ...
@overload
def domain_child(domain: int, key: int) -> int: ...
@overload
def domain_child(domain: npt.ArrayLike, key: npt.ArrayLike) -> Any: ...

class VoidAndClusterOptions:
    sigma: float
    initial_fraction: float
    seed: int

class RelaxOptions:
    threads: int
    seed: int

class AnnealOptions:
    sigma: float
    far_sigma: float
    far_weight: float
    value_sigma: float
    start_temperature: float
    end_temperature: float
    sweeps: int
    order_ends: int
    start_from_ranks: int
    seed: int

def void_and_cluster(ranks: Ranks, options: VoidAndClusterOptions, progress: Optional[Progress]) -> None: ...
def anneal(ranks: Ranks, options: AnnealOptions, progress: Optional[Progress]) -> None: ...
def relax(ranks: Ranks, options: RelaxOptions, progress: Optional[Progress]) -> None: ...
def ranks_from_values(values: npt.NDArray[np.float32]) -> Ranks: ...
def ranks_to_float(ranks: Ranks, count: int) -> npt.NDArray[np.float32]: ...
def builtin_mask(size: int) -> Optional[Ranks]: ...
def builtin_mask_exists(size: int) -> bool: ...
def mask_error(ranks: Ranks, sigma: float) -> float: ...
def power_spectrum(ranks: Ranks) -> npt.NDArray[np.float32]: ...
def dither(
    image: npt.NDArray[np.float32], levels: int, srgb: bool, channel_offset: bool, mask: Optional[Ranks]
) -> npt.NDArray[np.float32]: ...
