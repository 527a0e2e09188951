# SPDX-License-Identifier: Apache-2.0
"""Quality and cost of a model. libbn computes the errors through the `bluenoise` package."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import onnx
import torch

import bluenoise

from .config import TrainerError
from .export import onnx_bytes, session_of
from .files import load_model
from .losses import VectorEnergy
from .model import wrap

SIGMAS = (0.75, 1.0, 1.5, 2.0)
#: Height and width.
SIZES = ((64, 64), (128, 128), (256, 256), (67, 93), (48, 200))
ANISOTROPY_MASKS, FLATNESS_SIZE = 16, 32

#: Maps noise (h + 2r, w + 2r) to values (c, h, w).
Network = Callable[[npt.NDArray[np.float32]], npt.NDArray[np.float32]]


def network_of(path: Path) -> tuple[Network, int, str]:
    """Opens an ONNX file, or a checkpoint as the ONNX file that `export` would write. Returns the network, its radius and its cost."""
    model = None if path.suffix == ".onnx" else load_model(path)
    try:
        data = path.read_bytes() if model is None else onnx_bytes(model)
        proto = onnx.load_from_string(data)
        radius = int({p.key: p.value for p in proto.metadata_props}["bn.receptive_radius"])
        session = session_of(data)
    except ImportError:
        raise
    except OSError as error:
        raise TrainerError(f"cannot read {path}: {error.strerror}") from None
    except Exception:  # the parsers of onnx and ONNX Runtime raise many exception types
        raise TrainerError(f"{path} is not a model for this library") from None

    def run(noise: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
        return np.asarray(session.run(None, {"noise": noise[None, None]})[0][0])

    numbers = f"{sum(int(np.prod(t.dims)) for t in proto.graph.initializer)} stored numbers" if model is None else \
        f"{model.vector().numel()} parameters"
    return run, radius, f"{numbers}, {flop_of(proto) / 1000:.2f} kFLOP per texel, radius {radius}"


def flop_of(proto: Any) -> int:
    """Operations per texel in a graph written by export.py, without crops and concatenations."""
    channels = {value.name: value.type.tensor_type.shape.dim[1].dim_value
                for values in (proto.graph.value_info, proto.graph.output) for value in values}
    return sum(channels.get(node.output[0], 1) for node in proto.graph.node if node.op_type not in ("Slice", "Concat"))


def values_of(network: Network, radius: int, height: int, width: int, seed: int) -> npt.NDArray[np.float32]:
    """The network's values (c, h, w) for torch noise with this seed."""
    noise = torch.rand(1, 1, height, width, generator=torch.Generator().manual_seed(seed))
    return network(wrap(noise, radius).numpy()[0, 0])


def ranks_of(values: npt.NDArray[np.float32]) -> npt.NDArray[np.uint32]:
    """The ranks of each channel of values (c, h, w)."""
    ranks = np.empty((len(values), values[0].size), np.uint32)
    for channel, into in zip(values, ranks):
        into[np.argsort(channel.reshape(-1), kind="stable")] = np.arange(into.size, dtype=np.uint32)
    return ranks.reshape(values.shape)


def errors(network: Network, radius: int, height: int, width: int, seeds: int) -> npt.NDArray[np.float64]:
    """E_sigma for every seed, channel and sigma in SIGMAS, with shape (seeds * channels, 4)."""
    masks = (mask for seed in range(seeds) for mask in ranks_of(values_of(network, radius, height, width, seed)))
    return np.array([[bluenoise.dithering_error(mask, sigma) for sigma in SIGMAS] for mask in masks])


def energies(network: Network, radius: int, size: int, seeds: int) -> npt.NDArray[np.float64]:
    """The energy of two-channel masks for every seed."""
    energy = VectorEnergy()
    masks = [ranks_of(values_of(network, radius, size, size, seed)) for seed in range(seeds)]
    return np.array([float(energy(torch.from_numpy((mask[None] + 0.5) / size**2))[0]) for mask in masks])


def run(model: Path, seeds: int, flatness_seeds: int, threads: int) -> None:
    """Prints the quality and cost of a checkpoint or an ONNX file."""
    if threads:
        torch.set_num_threads(threads)
    network, radius, cost = network_of(model)
    print(f"{model.name}: {cost}")
    print(f"mean and standard deviation over {seeds} seeds")
    print(f"{'size':>9}" + "".join(f"{f'E_{sigma:g}':>17}" for sigma in SIGMAS))
    for height, width in SIZES:
        table = errors(network, radius, height, width, seeds)
        cells = "".join(f"{mean:>9.4f} {deviation:.4f} " for mean, deviation in zip(table.mean(0), table.std(0)))
        print(f"{f'{width}x{height}':>9} {cells}", flush=True)
    values = values_of(network, radius, 256, 256, 0)
    if len(values) == 2:
        print(f"vector energy at 64x64: {energies(network, radius, 64, seeds).mean():.5f} (white noise: 0.6119)")
    print(f"raw values at 256x256: mean {values.mean():.4f}, standard deviation {values.std():.4f} (uniform: 0.5, 0.2887), "
          f"{values.min():.4f} to {values.max():.4f}")
    masks = [ranks_of(values_of(network, radius, 128, 128, seed))[0] for seed in range(ANISOTROPY_MASKS)]
    print(f"anisotropy of the first channel over {ANISOTROPY_MASKS} masks of 128x128: {bluenoise.anisotropy(masks):.1f} dB")
    if flatness_seeds:
        spread, expected, worst = flatness(network, radius, flatness_seeds)
        print(f"mean over {flatness_seeds} masks of {FLATNESS_SIZE}x{FLATNESS_SIZE}: standard deviation over texels "
              f"{spread:.5f}, expected {expected:.5f}; largest row, column or phase mean {worst:.1f} standard deviations")


def flatness(network: Network, radius: int, seeds: int) -> tuple[float, float, float]:
    """Tests the last channel for a pattern that all masks share. Returns the standard deviation over texels of the mean over masks,
    its expected value for independent uniform masks, and the largest mean of a row, a column or a phase of period 2 or 4, in standard
    deviations for independent texels (those of blue noise are smaller)."""
    size = FLATNESS_SIZE
    total = np.zeros((size, size))
    for seed in range(seeds):
        total += (ranks_of(values_of(network, radius, size, size, seed))[-1] + 0.5) / size**2
    mean = total / seeds - 0.5
    one = 1 / np.sqrt(12 * seeds)
    groups = [mean.mean(0) * np.sqrt(size), mean.mean(1) * np.sqrt(size)]
    for period in (2, 4):
        part = size // period
        groups.append(mean.reshape(part, period, part, period).mean((0, 2)).ravel() * part)
    return float(mean.std()), float(one), float(max(np.abs(g).max() for g in groups) / one)
