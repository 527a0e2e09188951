# SPDX-License-Identifier: Apache-2.0
"""Training: an evolution strategy on fresh white noise.

Steps amplify small differences, so gradients through several steps are useless. The strategy needs no gradient: it draws
random parameters around the current ones, ranks them by their loss on the same few masks, and moves towards the better
half, learning which changes belong together. It evaluates the whole network, including exact ranks.

All random numbers are functions of seed and iteration, so a resumed run continues exactly as if it had never stopped.
"""

from __future__ import annotations

import csv
import math
import os
import random
import sys
import time
from pathlib import Path
from typing import Any

import torch
from torch import Tensor

from .config import Config, TrainerError, checked, load
from .evolution import Evolution
from .files import load_checkpoint, write_atomically
from .losses import Direction, DitheringError, VectorEnergy, ranks
from .model import Relaxation

LOG_COLUMNS = ["iteration", "loss", "e_1", "e_1.5", "energy", "step", "seconds"]
HELD_OUT = 4


def noise(seed: int, iteration: int, shape: tuple[int, ...]) -> Tensor:
    """White noise in [0, 1) as a function of (seed, iteration). It is bit-identical on every machine."""
    generator = torch.Generator().manual_seed(random.Random(f"{seed}:{iteration}").getrandbits(63))
    return torch.rand(shape, generator=generator)


class Progress:
    """Reports progress: one updated line on a terminal, occasional lines in a pipe."""

    def __init__(self, quiet: bool) -> None:
        self.quiet, self.terminal, self.last = quiet, sys.stderr.isatty(), 0.0

    def line(self, text: str, final: bool = False) -> None:
        if self.quiet:
            return
        if self.terminal:
            sys.stderr.write("\r\x1b[K" + text + ("\n" if final else ""))
        elif final or time.monotonic() - self.last > 60:
            sys.stderr.write(text + "\n")
            self.last = time.monotonic()
        sys.stderr.flush()


def clock(seconds: float) -> str:
    seconds = max(0, int(seconds))
    return f"{seconds // 3600}:{seconds // 60 % 60:02}:{seconds % 60:02}"


class Trainer:
    """Model, search and loss."""

    def __init__(self, config: Config, device: torch.device) -> None:
        self.config, self.device = config, device
        self.model = Relaxation(config.model.reaches, config.model.channels).to(device)
        start = self.model.vector().cpu()
        population = config.train.population or Evolution.usual_population(start.numel())
        self.search = Evolution(start, self.model.spreads(config.model.sharpness), population=population, step=config.train.step,
                                seed=config.train.seed)
        size, loss = config.train.size, config.loss
        self.errors = DitheringError(size, size, [*loss.sigmas, 1.0, 1.5])
        self.energy, self.direction = VectorEnergy(), Direction(size)
        # Fixed noise that is not used in training.
        self.held_out = noise(config.train.seed, -1, (HELD_OUT, 1, size, size)).to(device)

    @property
    def iteration(self) -> int:
        return self.search.generation

    def figures(self, parameters: Tensor, batch: Tensor) -> tuple[float, float, float, float]:
        """Loss, E_1, E_1.5 (means over channels) and vector energy of the masks generated from the noise."""
        self.model.load_vector(parameters)
        made = ranks(self.model.torus(batch))
        errors = self.errors(made.flatten(0, 1)).mean(1).clamp_min(0)
        shares = torch.tensor(self.config.loss.shares, dtype=errors.dtype)
        loss = float(shares @ errors[: len(shares)])
        if self.config.loss.direction > 0:
            loss += self.config.loss.direction * float(self.direction(made.flatten(0, 1)))
        energy = math.nan
        if made.shape[1] == 2:
            energy = float(self.energy(made).mean())
            loss += self.config.loss.energy * energy
        return loss, math.sqrt(errors[-2]), math.sqrt(errors[-1]), energy

    @torch.no_grad()
    def step(self) -> float:
        """Runs one generation. Returns the mean loss of its better half."""
        t = self.config.train
        batch = noise(t.seed, self.iteration, (t.batch, 1, t.size, t.size)).to(self.device)
        losses = torch.tensor([self.figures(each, batch)[0] for each in self.search.candidates()], dtype=torch.float64)
        self.search.learn(losses)
        return float(losses.sort().values[: len(losses) // 2].mean())

    @torch.no_grad()
    def measure(self) -> tuple[float, float, float]:
        """E_1, E_1.5 and energy of the search's mean parameters on fixed noise."""
        return self.figures(self.search.mean, self.held_out)[1:]

    def state(self) -> dict[str, Any]:
        return {"format": "bn_trainer 2", "config": self.config.model_dump(), "search": self.search.state()}

    def restore(self, checkpoint: dict[str, Any]) -> None:
        try:
            self.search.restore(checkpoint["search"])
        except (RuntimeError, KeyError, ValueError, TypeError, AttributeError):
            raise TrainerError("the checkpoint does not match its configuration; start without --resume") from None


def append_log(path: Path, row: list[str]) -> None:
    new = not path.exists()
    with open(path, "a", newline="") as file:
        writer = csv.writer(file)
        if new:
            writer.writerow(LOG_COLUMNS)
        writer.writerow(row)


def trim_log(path: Path, iteration: int) -> None:
    """Drops the rows after a checkpoint's iteration, because resuming writes them again."""
    if not path.exists():
        return
    with open(path, newline="") as file:
        rows = list(csv.reader(file))
    kept = rows[:1] + [row for row in rows[1:] if row and int(row[0]) <= iteration]

    def write(beside: Path) -> None:
        with open(beside, "w", newline="") as file:
            csv.writer(file).writerows(kept)

    write_atomically(path, write)


def default_folder(config_path: Path) -> Path:
    cache = os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")
    return Path(cache) / "bn_trainer" / config_path.stem


def train(config_path: Path | None, folder: Path | None, *, resume: bool = False, device: str = "cpu",
          threads: int = 0, stop_after: int = 0, quiet: bool = False) -> Path:
    """Trains, and returns the path of the checkpoint. `resume` continues from the folder's checkpoint with its
    configuration; `stop_after` stops after that many iterations in total, so that the run can be resumed later."""
    if config_path is None and folder is None:
        raise TrainerError("give a configuration (--config) or a run folder to resume (--resume --folder FOLDER)")
    if folder is None:
        assert config_path is not None
        folder = default_folder(config_path)
    config = load(config_path, Config) if config_path is not None else None
    if threads:
        torch.set_num_threads(threads)
    where = torch.device(device)
    if where.type == "cuda" and not torch.cuda.is_available():
        raise TrainerError("no CUDA device is available; use --device cpu")
    newest, log = folder / "checkpoint.pt", folder / "log.csv"
    checkpoint = load_checkpoint(newest) if resume and newest.exists() else None
    if resume and checkpoint is None and config is None:
        raise TrainerError(f"{folder} contains no checkpoint; give a configuration (--config)")
    if not resume and newest.exists():
        raise TrainerError(f"{folder} already contains a run; continue it with --resume or choose another --folder")
    if checkpoint is not None:
        config = checked(Config, checkpoint["config"])
    assert config is not None
    trainer = Trainer(config, where)
    if checkpoint is not None:
        trainer.restore(checkpoint)
    write_atomically(folder / "config.toml", lambda path: path.write_text(as_toml(config)))
    trim_log(log, trainer.iteration)
    progress = Progress(quiet)
    total = config.train.iterations
    end = min(total, stop_after) if stop_after else total
    begun, before = time.monotonic(), trainer.iteration
    text = "nothing to do"
    while trainer.iteration < end:
        loss = trainer.step()
        done = trainer.iteration
        last = done == end
        if done % config.train.log_every == 0 or last:
            e1, e15, energy = trainer.measure()
            spent = time.monotonic() - begun
            append_log(log, [str(done), f"{loss:.6f}", f"{e1:.6f}", f"{e15:.6f}",
                             "" if math.isnan(energy) else f"{energy:.6f}", f"{trainer.search.step:.3e}", f"{spent:.1f}"])
            speed = (done - before) / spent
            text = (f"{done}/{total}  E_1 {e1:.4f}  E_1.5 {e15:.4f}  "
                    + ("" if math.isnan(energy) else f"energy {energy:.5f}  ")
                    + f"{speed:.2f} iterations/s  {clock((end - done) / speed)} left")
            progress.line(text)
        if done % config.train.check_every == 0 or last:
            state = trainer.state()
            write_atomically(newest, lambda path: torch.save(state, path))
    progress.line(f"{text}; in {folder}", final=True)
    return newest


def as_toml(config: Config) -> str:
    lines = []
    for table, values in config.model_dump().items():
        lines.append(f"[{table}]")
        for key, value in values.items():
            lines.append(f"{key} = {str(value).lower() if isinstance(value, bool) else value}")
        lines.append("")
    return "\n".join(lines)
