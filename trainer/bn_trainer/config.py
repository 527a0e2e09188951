# SPDX-License-Identifier: Apache-2.0
"""Configurations: TOML files with the tables [model], [loss] and [train]. All keys are checked."""

from __future__ import annotations

import dataclasses
import math
import tomllib
from pathlib import Path
from typing import Any


class TrainerError(Exception):
    """An error that the user can fix; the message is one line."""


@dataclasses.dataclass(frozen=True)
class ModelConfig:
    channels: list[int]  # one per step
    kernels: list[int]  # one per step, odd
    sigma: float = 0.92  # of the initial kernels, in texels
    first_rate: float = 4.0  # initial rate of the first step; geometric decrease to
    last_rate: float = 0.5  # that of the last

    def check(self) -> None:
        need(1 <= len(self.channels) <= 64, "model.channels must name 1 to 64 steps", self.channels)
        need(len(self.kernels) == len(self.channels), "model.kernels must be as long as model.channels", self.kernels)
        need(all(2 <= c <= 64 for c in self.channels), "model.channels must be 2 to 64 each", self.channels)
        need(all(k in (3, 5, 7, 9, 11, 13, 15) for k in self.kernels), "model.kernels must be odd, 3 to 15", self.kernels)
        need(0.25 <= self.sigma <= 4, "model.sigma must be 0.25 to 4", self.sigma)
        need(0 < self.last_rate <= self.first_rate <= 16, "model rates must fall and lie in (0, 16]", self.first_rate)


@dataclasses.dataclass(frozen=True)
class LossConfig:
    sigmas: list[float]  # viewing blurs, in texels
    shares: list[float]  # weights of their squared errors
    scale: float = 100.0  # of the errors
    ramp: float = 10.0  # weight of the distance between sorted values and a ramp
    inner: float = 0.5  # weight of the loss after each sampled inner step
    inner_steps: int = 4  # number of inner steps sampled in each iteration
    tail: int = 5  # inner steps are sampled from all but this many last ones
    damping: float = 0.7  # of gradients passed from a step to the previous one; see train.py

    def check(self) -> None:
        need(1 <= len(self.sigmas) <= 8, "loss.sigmas must be 1 to 8 numbers", self.sigmas)
        need(all(0.25 <= s <= 6 for s in self.sigmas), "loss.sigmas must be 0.25 to 6", self.sigmas)
        need(len(self.shares) == len(self.sigmas), "loss.shares must be as long as loss.sigmas", self.shares)
        need(all(s > 0 and math.isfinite(s) for s in self.shares), "loss.shares must be positive", self.shares)
        need(0 < self.scale < 1e6, "loss.scale must be positive", self.scale)
        need(0 <= self.ramp < 1e6, "loss.ramp must not be negative", self.ramp)
        need(0 <= self.inner < 1e3, "loss.inner must not be negative", self.inner)
        need(0 <= self.inner_steps <= 64, "loss.inner_steps must be 0 to 64", self.inner_steps)
        need(1 <= self.tail <= 64, "loss.tail must be 1 to 64", self.tail)
        need(0 <= self.damping <= 1, "loss.damping must be 0 to 1", self.damping)


@dataclasses.dataclass(frozen=True)
class TrainConfig:
    iterations: int
    seed: int = 0
    size: int = 64  # side of the square training masks, in texels
    batch: int = 4  # masks per iteration, over all processes
    rate: float = 1e-3  # Adam's, after the warm-up
    last_rate: float = 1e-5  # at the end, after a cosine decay
    warmup: int = 100  # iterations
    clip: float = 1.0  # maximum norm of the gradient
    average: float = 0.998  # decay of the averaged weights, which make the final model
    bfloat16: bool = False  # autocast; faster where the hardware supports it
    log_every: int = 50  # iterations
    check_every: int = 500  # iterations between checkpoints

    def check(self) -> None:
        need(1 <= self.iterations <= 10**9, "train.iterations must be 1 to 1e9", self.iterations)
        need(0 <= self.seed < 2**63, "train.seed must be 0 to 2^63 - 1", self.seed)
        need(16 <= self.size <= 4096, "train.size must be 16 to 4096", self.size)
        need(1 <= self.batch <= 65536, "train.batch must be 1 to 65536", self.batch)
        need(0 < self.last_rate <= self.rate < 1, "train.rate and last_rate must fall and lie in (0, 1)", self.rate)
        need(0 <= self.warmup <= 10**9, "train.warmup must not be negative", self.warmup)
        need(self.clip > 0, "train.clip must be positive", self.clip)
        need(0 <= self.average < 1, "train.average must be in [0, 1)", self.average)
        need(self.log_every >= 1 and self.check_every >= 1, "train.log_every and check_every must be 1 or more",
             self.log_every)


@dataclasses.dataclass(frozen=True)
class Config:
    model: ModelConfig
    loss: LossConfig
    train: TrainConfig


def need(condition: bool, message: str, value: object) -> None:
    if not condition:
        raise TrainerError(f"{message}, not {value!r}")


def _fits(kind: str, value: Any) -> bool:
    if kind == "bool":
        return isinstance(value, bool)
    if kind == "int":
        return isinstance(value, int) and not isinstance(value, bool)
    if kind == "float":
        return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)
    return isinstance(value, list) and all(_fits(kind[5:-1], item) for item in value)


def _table(kind: type, name: str, given: Any) -> Any:
    need(isinstance(given, dict), f"{name} must be a table", given)
    fields = {field.name: field for field in dataclasses.fields(kind)}
    for key, value in given.items():
        need(key in fields, f"the keys of [{name}] are {', '.join(fields)}", key)
        need(_fits(str(fields[key].type), value), f"{name}.{key} must be of type {fields[key].type}", value)
    for key, field in fields.items():
        if field.default is dataclasses.MISSING:
            need(key in given, f"[{name}] needs {key}", given)
    table = kind(**given)
    table.check()
    return table


def from_dict(given: dict[str, Any]) -> Config:
    kinds = {"model": ModelConfig, "loss": LossConfig, "train": TrainConfig}
    for key in given:
        need(key in kinds, f"the tables of a configuration are {', '.join(kinds)}", key)
    return Config(**{name: _table(kind, name, given.get(name, {})) for name, kind in kinds.items()})


def to_dict(config: Config) -> dict[str, Any]:
    return dataclasses.asdict(config)


def load(path: Path) -> Config:
    try:
        with open(path, "rb") as file:
            given = tomllib.load(file)
    except OSError as error:
        raise TrainerError(f"cannot read the configuration {path}: {error.strerror}") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise TrainerError(f"{path} is not valid TOML: {error}") from None
    try:
        return from_dict(given)
    except TrainerError as error:
        raise TrainerError(f"{path}: {error}") from None
