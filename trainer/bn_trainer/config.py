# SPDX-License-Identifier: Apache-2.0
"""Configurations: TOML files with the tables [model], [loss] and [train]. All keys are checked."""

from __future__ import annotations

import dataclasses
import math
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar


class TrainerError(Exception):
    """An error that the user can fix; the message is one line."""


@dataclasses.dataclass(frozen=True)
class ModelConfig:
    reaches: list[int]  # of each step: the square of the largest distance between interacting texels
    channels: int = 1  # 1, or 2 for vectors
    sharpness: bool = True  # whether sharpness is trained; if not, it is 1 everywhere

    def check(self) -> None:
        need(1 <= len(self.reaches) <= 64, "model.reaches must name 1 to 64 steps", self.reaches)
        need(all(1 <= r <= 200 for r in self.reaches), "model.reaches must be 1 to 200 each", self.reaches)
        need(self.channels in (1, 2), "model.channels must be 1 or 2", self.channels)


@dataclasses.dataclass(frozen=True)
class LossConfig:
    sigmas: list[float]  # viewing blurs, in texels
    shares: list[float]  # weights of the squared errors, averaged over channels
    direction: float = 0.0  # weight of the spectrum's dependence on direction
    energy: float = 0.0  # weight of the energy of vectors

    def check(self) -> None:
        need(1 <= len(self.sigmas) <= 8, "loss.sigmas must be 1 to 8 numbers", self.sigmas)
        need(all(0.25 <= s <= 6 for s in self.sigmas), "loss.sigmas must be 0.25 to 6", self.sigmas)
        need(len(self.shares) == len(self.sigmas), "loss.shares must be as long as loss.sigmas", self.shares)
        need(all(s > 0 and math.isfinite(s) for s in self.shares), "loss.shares must be positive", self.shares)
        need(0 <= self.direction < 1e6, "loss.direction must not be negative", self.direction)
        need(0 <= self.energy < 1e6, "loss.energy must not be negative", self.energy)


@dataclasses.dataclass(frozen=True)
class TrainConfig:
    iterations: int
    seed: int = 0
    size: int = 64  # side of the square training masks, in texels
    batch: int = 2  # masks per candidate
    population: int = 0  # candidates per iteration; 0: as many as usual for the number of parameters
    step: float = 1.0  # initial width of the search
    log_every: int = 20  # iterations
    check_every: int = 100  # iterations between checkpoints

    def check(self) -> None:
        need(1 <= self.iterations <= 10**9, "train.iterations must be 1 to 1e9", self.iterations)
        need(0 <= self.seed < 2**63, "train.seed must be 0 to 2^63 - 1", self.seed)
        need(16 <= self.size <= 4096, "train.size must be 16 to 4096", self.size)
        need(1 <= self.batch <= 65536, "train.batch must be 1 to 65536", self.batch)
        need(self.population == 0 or 4 <= self.population <= 65536, "train.population must be 0 or 4 to 65536",
             self.population)
        need(0 < self.step <= 1.5, "train.step must lie in (0, 1.5]", self.step)
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
    if kind in ("bool", "str"):
        return type(value).__name__ == kind
    if kind == "int":
        return isinstance(value, int) and not isinstance(value, bool)
    if kind == "float":
        return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)
    return isinstance(value, list) and all(_fits(kind[5:-1], item) for item in value)


def read_table(kind: type, name: str, given: Any) -> Any:
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
    need(isinstance(given, dict), "a configuration must be a table", given)
    for key in given:
        need(key in kinds, f"the tables of a configuration are {', '.join(kinds)}", key)
    config = Config(**{name: read_table(kind, name, given.get(name, {})) for name, kind in kinds.items()})
    need(config.loss.energy == 0 or config.model.channels == 2, "loss.energy needs model.channels = 2", config.loss.energy)
    return config


Kind = TypeVar("Kind")


def load(path: Path, read: Callable[[dict[str, Any]], Kind]) -> Kind:
    """What `read` makes of a TOML file."""
    try:
        with open(path, "rb") as file:
            given = tomllib.load(file)
    except OSError as error:
        raise TrainerError(f"cannot read the configuration {path}: {error.strerror}") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise TrainerError(f"{path} is not valid TOML: {error}") from None
    try:
        return read(given)
    except TrainerError as error:
        raise TrainerError(f"{path}: {error}") from None
