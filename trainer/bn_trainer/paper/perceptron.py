# SPDX-License-Identifier: Apache-2.0
"""The perceptron of Giunchi, Sztrajman and Steed, "Fast blue-noise generation via unsupervised learning" (IJCNN 2022).

Each size has its own network: n = size^2 white values in [-1, 1] as input, two layers of 100 units and one layer of n units,
each followed by tanh, and n mask values as output. Three losses act on the output: `blue_spectrum_loss` (little power at low
frequencies), `uniform_spectrum_loss` (no structure in the spectrum) and `histogram_loss` (a flat histogram), with weights
0.1, 0.01 and 2.2. Training uses Adam at 5e-4, batches of 64, and 12 epochs of 32,000 white inputs.

`histogram = "mean"` averages the histogram loss over texels, as in the paper; `"sum"` sums it, which makes it size^2 times
as strong, as in Wronski's "Optimizing blue noise dithering" (2020), the source of the three losses.

Where the paper is ambiguous, this module follows the authors' published program: the spectrum is the absolute value of the
unscaled transform, losses are means over all frequencies, weights are initialised Glorot-uniform with zero biases, and
Adam's epsilon is 1e-7. (That program trains on 6,400 inputs, not 32,000.) There are two differences. Inputs come from a
counter-based generator, so they need no storage. Values are not sorted but compared with the ramp at their rank, which gives
the same loss and gradient.

`python -m bn_trainer train-paper --config configs/paper-64.toml` runs 6,000 iterations, which take 0.05 s each at 64x64
and 0.16 s at 128x128 on one core.
"""

from __future__ import annotations

import time
from collections.abc import Iterable
from pathlib import Path
from typing import Literal, Optional

import numpy as np
import torch
from pydantic import Field, model_validator
from torch import Tensor
from tqdm import trange

from ..config import Table, TrainerError, checked, load
from ..files import save, write_atomically
from ..train import default_folder


class PaperConfig(Table):
    """The settings of a training run; the defaults are the paper's."""

    size: int = Field(128, ge=2)
    histogram: Literal["mean", "sum"] = "mean"
    hidden: int = 100
    uniform_weight: float = 0.01
    histogram_weight: float = 2.2
    blue_weight: float = 0.1
    cutoff: float = 0.7
    rate: float = 5e-4
    batch: int = Field(64, ge=1)
    epochs: int = Field(12, ge=1)
    inputs: int = 32000
    seed: int = 0

    @model_validator(mode="after")
    def agree(self) -> PaperConfig:
        if self.inputs < self.batch:
            raise ValueError("inputs must be at least batch")
        return self

    @property
    def iterations_per_epoch(self) -> int:
        return self.inputs // self.batch

    @property
    def iterations(self) -> int:
        return self.epochs * self.iterations_per_epoch


class Perceptron(torch.nn.Module):
    """n-hidden-hidden-n with tanh: maps (batch, size, size) in [-1, 1] to the same shape in (-1, 1)."""

    def __init__(self, size: int, hidden: int = 100, generator: Optional[torch.Generator] = None) -> None:
        super().__init__()
        texels = size * size
        self.layers = torch.nn.ModuleList(
            torch.nn.Linear(inputs, outputs) for inputs, outputs in ((texels, hidden), (hidden, hidden), (hidden, texels))
        )
        for layer in self.layers:
            torch.nn.init.xavier_uniform_(layer.weight, generator=generator)
            torch.nn.init.zeros_(layer.bias)

    def forward(self, noise: Tensor) -> Tensor:
        values = noise.flatten(1)
        for layer in self.layers:
            values = torch.tanh(layer(values))
        return values.reshape(noise.shape)


def spectrum(masks: Tensor) -> Tensor:
    """Absolute values of the unscaled Fourier transform of masks (..., size, size), frequency 0 at [0, 0].

    Only half of them are computed: the values at -f and f are identical.
    """
    half = torch.fft.rfft2(masks).abs()
    mirrored = half[..., 1 : (masks.shape[-1] + 1) // 2].flip(-2, -1).roll(1, -2)
    return torch.cat((half, mirrored), -1)


def low_frequency_weights(size: int, cutoff: float = 0.7) -> Tensor:
    """The square of max(cutoff - x^2 - y^2, 0) / cutoff, for a spectrum with frequency 0 at [0, 0].

    x and y run from 1 to -1, inclusive, over a spectrum with frequency 0 at [size / 2, size / 2], as in the paper and in
    Wronski's program; the weights are therefore half a step off centre.
    """
    square = torch.linspace(1, -1, size).square()
    weights = ((cutoff - square[:, None] - square[None, :]).clamp(min=0) / cutoff).square()
    return torch.fft.ifftshift(weights)


def blue_spectrum_loss(amplitude: Tensor, weights: Tensor) -> Tensor:
    """The unwanted power: the mean over frequencies and masks of weights * amplitude^2."""
    return (weights * amplitude.square()).mean()


def uniform_spectrum_loss(amplitude: Tensor) -> Tensor:
    """Mean over frequencies and masks of the squared Laplacian (divided by 5) and the two squared differences (divided by
    2) of the spectrum, on a torus."""
    down = amplitude - amplitude.roll(1, -2)
    right = amplitude - amplitude.roll(1, -1)
    laplacian = (down.roll(-1, -2) - down + right.roll(-1, -1) - right) / 5
    return laplacian.square().mean() + (down.square().mean() + right.square().mean()) / 4


def histogram_loss(masks: Tensor, reduction: str = "mean") -> Tensor:
    """Squared difference between sorted values and a ramp from -1 to 1: mean or sum over texels, mean over masks."""
    flat = masks.flatten(1)
    order = np.argsort(flat.detach().cpu().numpy(), axis=1)
    ramp = np.linspace(-1, 1, flat.shape[1], dtype=np.float32)
    places = np.empty(order.shape, np.float32)
    np.put_along_axis(places, order, ramp[None, :], axis=1)
    squares = (flat - torch.from_numpy(places).to(flat)).square()
    return squares.mean() if reduction == "mean" else squares.sum(1).mean()


def paper_loss(masks: Tensor, config: PaperConfig, weights: Tensor) -> tuple[Tensor, dict[str, Tensor]]:
    """The weighted sum of the three losses, and the losses by name, for masks (batch, size, size). `weights` is
    low_frequency_weights(config.size, config.cutoff)."""
    amplitude = spectrum(masks)
    terms = {
        "uniform": uniform_spectrum_loss(amplitude),
        "histogram": histogram_loss(masks, config.histogram),
        "blue": blue_spectrum_loss(amplitude, weights),
    }
    total = (config.uniform_weight * terms["uniform"] + config.histogram_weight * terms["histogram"]
             + config.blue_weight * terms["blue"])
    return total, terms


def white_noise(size: int, seed: int, indices: Iterable[int]) -> Tensor:
    """White noise in [-1, 1), float32 (count, size, size): element i depends only on (seed, indices[i])."""
    indices = list(indices)
    noise = np.empty((len(indices), size * size), np.float32)
    for row, index in zip(noise, indices):
        np.random.Generator(np.random.Philox(key=[seed, int(index)])).random(out=row, dtype=np.float32)
    return torch.from_numpy(noise.reshape(-1, size, size) * 2 - 1)


def batch_indices(config: PaperConfig, iteration: int) -> np.ndarray:
    """Indices of the inputs in the batch of an iteration; each epoch is a new permutation of all inputs."""
    epoch, step = divmod(iteration, config.iterations_per_epoch)
    order = np.random.default_rng([config.seed, epoch]).permutation(config.inputs)
    return order[step * config.batch : (step + 1) * config.batch]


def generate(model: Perceptron, seeds: Iterable[int], size: int) -> np.ndarray:
    """Masks for inputs not used in training, one per seed: float32 (count, size, size) in (-1, 1)."""
    test_inputs = 1 << 62  # far from the indices used in training
    with torch.no_grad():
        return model(white_noise(size, test_inputs, seeds)).numpy()


class PaperTraining:
    """A run: model, optimiser and iteration count."""

    def __init__(self, config: PaperConfig) -> None:
        self.config = config
        self.model = Perceptron(config.size, config.hidden, torch.Generator().manual_seed(config.seed))
        self.optimiser = torch.optim.Adam(self.model.parameters(), lr=config.rate, eps=1e-7, fused=True)
        self.weights = low_frequency_weights(config.size, config.cutoff)
        self.iteration = 0
        self.seconds = 0.0

    def step(self) -> dict[str, float]:
        """Runs one iteration and returns the loss and its three terms."""
        start = time.perf_counter()
        noise = white_noise(self.config.size, self.config.seed, batch_indices(self.config, self.iteration))
        loss, terms = paper_loss(self.model(noise), self.config, self.weights)
        self.optimiser.zero_grad()
        loss.backward()
        self.optimiser.step()
        self.iteration += 1
        self.seconds += time.perf_counter() - start
        return {"loss": loss.item(), **{name: term.item() for name, term in terms.items()}}

    def save(self, path: Path) -> None:
        """Atomically writes the configuration and model to a file."""
        state = {"config": self.config.model_dump(), "iteration": self.iteration, "seconds": self.seconds,
                 "model": self.model.state_dict()}
        write_atomically(path, lambda beside: save(state, beside))

    @staticmethod
    def load(path: Path) -> PaperTraining:
        """Reads a file written by `save`, to generate masks. Raises TrainerError if it cannot be read or is not such a file."""
        try:
            state = torch.load(path, map_location="cpu", weights_only=True)
            run = PaperTraining(checked(PaperConfig, state["config"]))
            run.model.load_state_dict(state["model"])
            run.iteration, run.seconds = state["iteration"], state["seconds"]
        except OSError as error:
            raise TrainerError(f"cannot read the checkpoint {path}: {error.strerror}") from None
        except Exception:  # torch's parser raises many exception types
            raise TrainerError(f"{path} is not a checkpoint of train-paper, or is damaged") from None
        return run


def train(config: PaperConfig, folder: Path) -> PaperTraining:
    """Trains and writes checkpoint.pt to the folder. Returns the run."""
    checkpoint = folder / "checkpoint.pt"
    if checkpoint.exists():
        raise TrainerError(f"{checkpoint} exists; choose another --folder")
    run, progress = PaperTraining(config), trange(config.iterations, mininterval=1, unit=" iterations")
    for _ in progress:
        progress.set_postfix(run.step(), refresh=False)
    run.save(checkpoint)
    return run


def run(config: Path, folder: Path | None, threads: int) -> None:
    torch.set_num_threads(threads)
    folder = folder or default_folder(config)
    done = train(load(config, PaperConfig), folder)
    print(f"{folder / 'checkpoint.pt'}: {done.iteration} iterations, {done.seconds:.0f} s")
