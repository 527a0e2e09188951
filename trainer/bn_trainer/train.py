# SPDX-License-Identifier: Apache-2.0
"""Training: Adam on fresh white noise, with weights averaged over iterations.

Steps amplify small differences, so the gradient of the final error with respect to an early step's parameters is noise
(about six steps back, it has no common direction between masks). Each step is therefore trained mainly on the error
after it and after the next few steps: errors after several steps are summed, and gradients are damped on their way back.

All random numbers are functions of seed and iteration, so a resumed run continues exactly as if it had never stopped, and
several processes (`torchrun`) share the batch of a single one.
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
from torch import Tensor, distributed

from . import config as configs
from .config import Config, TrainerError
from .files import load_checkpoint, model_of, write_atomically
from .losses import DitheringError, rank_and_ramp
from .model import Relaxation

LOG_COLUMNS = ["iteration", "loss", "e_1", "e_1.5", "rate", "seconds"]


def noise(seed: int, iteration: int, shape: tuple[int, ...]) -> Tensor:
    """White noise in [0, 1), a function of (seed, iteration), equal on every machine."""
    generator = torch.Generator().manual_seed(random.Random(f"{seed}:{iteration}").getrandbits(63))
    return torch.rand(shape, generator=generator)


class Progress:
    """Progress: one updated line on a terminal, occasional lines in a pipe."""

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
    """Model, averaged model, optimiser and number of completed iterations."""

    def __init__(self, config: Config, device: torch.device) -> None:
        self.config, self.device, self.iteration = config, device, 0
        self.rank = distributed.get_rank() if distributed.is_initialized() else 0
        self.world = distributed.get_world_size() if distributed.is_initialized() else 1
        if config.train.batch % self.world:
            raise TrainerError(
                f"train.batch ({config.train.batch}) must be a multiple of the number of processes ({self.world})"
            )
        self.model = model_of(config).to(device)
        self.average = model_of(config).to(device).eval().requires_grad_(False)
        self.average.load_state_dict(self.model.state_dict())
        self.optimiser = torch.optim.Adam(self.model.parameters(), lr=config.train.rate, betas=(0.9, 0.99))
        size, loss = config.train.size, config.loss
        self.error = DitheringError(size, size, loss.sigmas, loss.shares)
        # Fixed noise that training does not use.
        self.held_out = noise(config.train.seed, -1, (4, 1, size, size)).to(device)
        self.gauges = [DitheringError(size, size, [sigma], [1.0]) for sigma in (1.0, 1.5)]

    def rate(self, iteration: int) -> float:
        t = self.config.train
        along = min(1.0, max(0, iteration - t.warmup) / max(1, t.iterations - t.warmup))
        rate = t.last_rate + (t.rate - t.last_rate) * 0.5 * (1 + math.cos(math.pi * along))
        return rate * min(1.0, (iteration + 1) / max(1, t.warmup))

    def loss_of(self, values: Tensor) -> Tensor:
        ranks, ramp = rank_and_ramp(values[:, 0].float())
        return (self.config.loss.scale * self.error(ranks) + self.config.loss.ramp * ramp).mean()

    def step(self) -> float:
        t, count = self.config.train, len(self.model.steps)
        for group in self.optimiser.param_groups:
            group["lr"] = self.rate(self.iteration)
        share = t.batch // self.world
        batch = noise(t.seed, self.iteration, (t.batch, 1, t.size, t.size))
        batch = batch[self.rank * share : (self.rank + 1) * share].to(self.device)
        self.model.train()
        with torch.autocast(self.device.type, torch.bfloat16, enabled=t.bfloat16):
            after = self.model.torus(batch, self.config.loss.damping)
        loss = self.loss_of(after[-1])
        draw = random.Random(f"{t.seed}:{self.iteration}:steps")
        early = max(0, count - self.config.loss.tail)
        for inner in sorted(draw.sample(range(early), min(self.config.loss.inner_steps, early))):
            loss = loss + self.config.loss.inner * self.loss_of(after[inner])
        self.optimiser.zero_grad(set_to_none=False)
        loss.backward()
        value = loss.detach()
        gradients = [p.grad for p in self.model.parameters() if p.grad is not None]
        if self.world > 1:
            flat = torch.cat([g.reshape(-1) for g in gradients] + [value.reshape(1)]) / self.world
            distributed.all_reduce(flat)
            value = flat[-1]
            for gradient, part in zip(gradients, flat[:-1].split([g.numel() for g in gradients])):
                gradient.copy_(part.view_as(gradient))
        norm = torch.nn.utils.clip_grad_norm_(self.model.parameters(), t.clip)
        # A single bad mask must not ruin a run, so skip such a step, on all processes alike.
        if bool(torch.isfinite(norm)):
            self.optimiser.step()
        self.iteration += 1
        decay = min(t.average, self.iteration / (self.iteration + 10))
        with torch.no_grad():
            for mean, now in zip(self.average.parameters(), self.model.parameters()):
                mean.lerp_(now, 1 - decay)
        return float(value)

    @torch.no_grad()
    def measure(self) -> tuple[float, float]:
        """E_1 and E_1.5 of the averaged model on fixed noise."""
        ranks, _ = rank_and_ramp(self.average.torus(self.held_out)[-1][:, 0])
        e1, e15 = (float(gauge(ranks).mean().clamp(min=0).sqrt()) for gauge in self.gauges)
        return e1, e15

    def state(self) -> dict[str, Any]:
        return {
            "format": "bn_trainer 1",
            "config": configs.to_dict(self.config),
            "iteration": self.iteration,
            "model": self.model.state_dict(),
            "average": self.average.state_dict(),
            "optimiser": self.optimiser.state_dict(),
        }

    def restore(self, checkpoint: dict[str, Any]) -> None:
        try:
            self.model.load_state_dict(checkpoint["model"])
            self.average.load_state_dict(checkpoint["average"])
            self.optimiser.load_state_dict(checkpoint["optimiser"])
            self.iteration = int(checkpoint["iteration"])
        except (RuntimeError, KeyError, ValueError):
            raise TrainerError("the checkpoint does not match its configuration; start without --resume") from None


def append_log(path: Path, row: list[str]) -> None:
    new = not path.exists()
    with open(path, "a", newline="") as file:
        writer = csv.writer(file)
        if new:
            writer.writerow(LOG_COLUMNS)
        writer.writerow(row)


def trim_log(path: Path, iteration: int) -> None:
    """Drops rows after a checkpoint's iteration, which will be written again."""
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
    configuration; `stop_after` stops after that many iterations in total, to be resumed later."""
    if config_path is None and folder is None:
        raise TrainerError("give a configuration (--config) or a run folder to resume (--resume --folder FOLDER)")
    if folder is None:
        assert config_path is not None
        folder = default_folder(config_path)
    config = configs.load(config_path) if config_path is not None else None
    if threads:
        torch.set_num_threads(threads)
    where = torch.device(device)
    if where.type == "cuda" and not torch.cuda.is_available():
        raise TrainerError("no CUDA device is available; use --device cpu")
    workers = int(os.environ.get("WORLD_SIZE", "1"))
    if workers > 1:
        if where.type == "cuda":
            where = torch.device("cuda", int(os.environ.get("LOCAL_RANK", "0")))
            torch.cuda.set_device(where)
        distributed.init_process_group("nccl" if where.type == "cuda" else "gloo")
    try:
        return _run(config, folder, resume, where, stop_after, quiet)
    finally:
        if workers > 1:
            distributed.destroy_process_group()


def _run(config: Config | None, folder: Path, resume: bool, device: torch.device, stop_after: int,
         quiet: bool) -> Path:
    newest, best, log = folder / "checkpoint.pt", folder / "best.pt", folder / "log.csv"
    checkpoint = load_checkpoint(newest) if resume and newest.exists() else None
    if resume and checkpoint is None and config is None:
        raise TrainerError(f"{folder} contains no checkpoint; give a configuration (--config)")
    if not resume and newest.exists():
        raise TrainerError(f"{folder} already contains a run; continue it with --resume or choose another --folder")
    if checkpoint is not None:
        config = configs.from_dict(checkpoint["config"])
    assert config is not None
    trainer = Trainer(config, device)
    if checkpoint is not None:
        trainer.restore(checkpoint)
    first = trainer.rank == 0
    least = math.inf
    if first:
        write_atomically(folder / "config.toml", lambda path: path.write_text(as_toml(config)))
        trim_log(log, trainer.iteration)
        if best.exists():
            if checkpoint is None:
                best.unlink()
            else:
                least = float(load_checkpoint(best).get("score", math.inf))
    progress = Progress(quiet or not first)
    total = config.train.iterations
    end = min(total, stop_after) if stop_after else total
    begun, before = time.monotonic(), trainer.iteration
    loss, errors, text = math.nan, (math.nan, math.nan), "nothing to do"
    while trainer.iteration < end:
        loss = trainer.step()
        done = trainer.iteration
        last = done == end
        if first and (done % config.train.log_every == 0 or last):
            errors = trainer.measure()
            spent = time.monotonic() - begun
            append_log(log, [str(done), f"{loss:.6f}", f"{errors[0]:.6f}", f"{errors[1]:.6f}",
                             f"{trainer.rate(done - 1):.3e}", f"{spent:.1f}"])
            speed = (done - before) / spent
            text = (f"{done}/{total}  loss {loss:.4f}  E_1 {errors[0]:.4f}  E_1.5 {errors[1]:.4f}  "
                    f"{speed:.2f} iterations/s  {clock((end - done) / speed)} left")
            progress.line(text)
        if first and (done % config.train.check_every == 0 or last):
            errors = trainer.measure()
            state = trainer.state()
            state["score"] = sum(share * error**2 for share, error in zip((0.5, 0.5), errors))
            write_atomically(newest, lambda path: torch.save(state, path))
            if state["score"] < least:
                least = state["score"]
                write_atomically(best, lambda path: torch.save(state, path))
    progress.line(f"{text}; in {folder}", final=True)
    return newest


def as_toml(config: Config) -> str:
    lines = []
    for table, values in configs.to_dict(config).items():
        lines.append(f"[{table}]")
        for key, value in values.items():
            lines.append(f"{key} = {str(value).lower() if isinstance(value, bool) else value}")
        lines.append("")
    return "\n".join(lines)
