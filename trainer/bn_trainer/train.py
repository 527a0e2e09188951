# SPDX-License-Identifier: Apache-2.0
"""Training: an evolution strategy on fresh white noise.

Steps amplify small differences, so gradients through several steps are useless. The strategy needs no gradient: it draws
random parameters around the current ones, ranks them by their loss on the same few masks, and moves towards the better
half, learning which changes belong together. It evaluates the whole network, including exact ranks.

All random numbers are functions of seed and iteration, so a resumed run continues exactly as if it had never stopped.
"""

from __future__ import annotations

import math
import os
import random
import shutil
import sys
import time
from pathlib import Path
from typing import Any

import torch
from torch import Tensor
from tqdm import tqdm

from .config import Config, TrainerError, checked, load
from .evolution import Evolution
from .files import load_checkpoint, save, write_atomically
from .losses import Direction, DitheringError, VectorEnergy, ranks
from .model import Relaxation

LOG_COLUMNS = ["iteration", "loss", "e_1", "e_1.5", "energy", "step", "seconds"]
HELD_OUT = 4


def noise(seed: int, iteration: int, shape: tuple[int, ...]) -> Tensor:
    """White noise in [0, 1) as a function of (seed, iteration). It is bit-identical on every machine."""
    generator = torch.Generator().manual_seed(random.Random(f"{seed}:{iteration}").getrandbits(63))
    return torch.rand(shape, generator=generator)


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


def default_folder(config_path: Path) -> Path:
    cache = os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")
    return Path(cache) / "bn_trainer" / config_path.stem


def run(config: Path | None, folder: Path | None, resume: bool, device: str, threads: int, stop_after: int, quiet: bool) -> None:
    """Trains. `resume` continues from the folder's checkpoint with its configuration, which `config` must equal if it is given;
    `stop_after` stops after that many iterations in total, so that the run can be resumed later."""
    if config is None and folder is None:
        raise TrainerError("give a configuration (--config) or a run folder to resume (--resume --folder FOLDER)")
    settings = load(config, Config) if config else None
    folder = folder or default_folder(config)
    if threads:
        torch.set_num_threads(threads)
    where = torch.device(device)
    if where.type == "cuda" and not torch.cuda.is_available():
        raise TrainerError("no CUDA device is available; use --device cpu")
    newest, log = folder / "checkpoint.pt", folder / "log.csv"
    checkpoint = load_checkpoint(newest) if resume and newest.exists() else None
    if resume and checkpoint is None and settings is None:
        raise TrainerError(f"{folder} contains no checkpoint; give a configuration (--config)")
    if not resume and newest.exists():
        raise TrainerError(f"{folder} already contains a run; continue it with --resume or choose another --folder")
    if checkpoint is not None:
        kept = checked(Config, checkpoint["config"])
        if settings is not None and settings != kept:
            raise TrainerError(f"{folder} has another configuration: {difference(kept, settings)}; leave out --config to continue it, or "
                               "choose another --folder")
        settings = kept
    trainer = Trainer(settings, where)
    if checkpoint is not None:
        trainer.restore(checkpoint)
    if config:
        write_atomically(folder / "config.toml", lambda path: shutil.copyfile(config, path))
    # Resuming writes the rows after the checkpoint again.
    rows = log.read_text().splitlines()[1:] if log.exists() else []
    rows = [row for row in rows if int(row.partition(",")[0]) <= trainer.iteration]
    end = min(settings.train.iterations, stop_after or settings.train.iterations)
    begun = time.monotonic()
    seconds = 0.1 if sys.stderr.isatty() else 60  # between two lines
    with tqdm(total=end, initial=trainer.iteration, unit=" iterations", disable=quiet, mininterval=seconds) as progress:
        while trainer.iteration < end:
            loss = trainer.step()
            last = trainer.iteration == end
            progress.update()
            if trainer.iteration % settings.train.log_every == 0 or last:
                e1, e15, energy = trainer.measure()
                vector, spent = "" if math.isnan(energy) else f"{energy:.6f}", time.monotonic() - begun
                rows.append(f"{trainer.iteration},{loss:.6f},{e1:.6f},{e15:.6f},{vector},{trainer.search.step:.3e},{spent:.1f}")
                write_atomically(log, lambda path: path.write_text("\n".join([",".join(LOG_COLUMNS), *rows, ""])))
                progress.set_postfix_str(f"E_1 {e1:.4f}, E_1.5 {e15:.4f}" + (f", energy {vector}" if vector else ""), refresh=False)
            if trainer.iteration % settings.train.check_every == 0 or last:
                write_atomically(newest, lambda path: save(trainer.state(), path))
    if not quiet:
        print(f"{newest}: {trainer.iteration} of {settings.train.iterations} iterations")


def difference(run: Config, given: Config) -> str:
    """The values that differ, as "train.iterations is 4, not 10"."""
    tables = run.model_dump(), given.model_dump()
    return ", ".join(f"{table}.{key} is {value}, not {tables[1][table][key]}"
                     for table, values in tables[0].items() for key, value in values.items() if value != tables[1][table][key])
