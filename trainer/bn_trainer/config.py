# SPDX-License-Identifier: Apache-2.0
"""Configurations: TOML files with the tables [model], [loss] and [train]. All keys are checked."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar

from pydantic import BaseModel, ConfigDict, Field, PositiveFloat, ValidationError, model_validator


class TrainerError(Exception):
    """An error that the user can fix; the message is one line."""


class Table(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False)


class ModelConfig(Table):
    # For each step, the square of the largest distance between interacting texels.
    reaches: list[Annotated[int, Field(ge=1, le=200)]] = Field(min_length=1, max_length=64)
    channels: Literal[1, 2] = 1  # 2 for vectors
    sharpness: bool = True  # whether sharpness is trained; if not, it is 1 everywhere


class LossConfig(Table):
    sigmas: list[Annotated[float, Field(ge=0.25, le=6)]] = Field(min_length=1, max_length=8)  # viewing blurs, in texels
    shares: list[PositiveFloat]  # weights of the squared errors, averaged over channels
    direction: float = Field(0.0, ge=0, lt=1e6)  # weight of the spectrum's dependence on direction
    energy: float = Field(0.0, ge=0, lt=1e6)  # weight of the energy of vectors


class TrainConfig(Table):
    iterations: int = Field(ge=1, le=10**9)
    seed: int = Field(0, ge=0, lt=2**63)
    size: int = Field(64, ge=16, le=4096)  # side of the square training masks, in texels
    batch: int = Field(2, ge=1, le=65536)  # masks per candidate
    population: int = Field(0, ge=0, le=65536)  # candidates per iteration; 0: the usual number for this many parameters
    step: float = Field(1.0, gt=0, le=1.5)  # initial width of the search
    log_every: int = Field(20, ge=1)  # iterations
    check_every: int = Field(100, ge=1)  # iterations between checkpoints


class Config(Table):
    model: ModelConfig
    loss: LossConfig
    train: TrainConfig

    @model_validator(mode="after")
    def agree(self) -> Config:
        if len(self.loss.shares) != len(self.loss.sigmas):
            raise ValueError("loss.shares must be as long as loss.sigmas")
        if 0 < self.train.population < 4:
            raise ValueError("train.population must be 0 or at least 4")
        if self.loss.energy > 0 and self.model.channels != 2:
            raise ValueError("loss.energy needs model.channels = 2")
        return self


Kind = TypeVar("Kind", bound=Table)


def checked(kind: type[Kind], given: Any) -> Kind:
    try:
        return kind.model_validate(given)
    except ValidationError as errors:
        first = errors.errors()[0]
        given = f", not {first['input']!r}" if isinstance(first["input"], (int, float, str)) else ""
        raise TrainerError(f"{'.'.join(map(str, first['loc'])) or 'a configuration'}: {first['msg']}{given}") from None


def load(path: Path, kind: type[Kind]) -> Kind:
    """The configuration in a TOML file."""
    try:
        with open(path, "rb") as file:
            return checked(kind, tomllib.load(file))
    except OSError as error:
        raise TrainerError(f"cannot read the configuration {path}: {error.strerror}") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise TrainerError(f"{path} is not valid TOML: {error}") from None
    except TrainerError as error:
        raise TrainerError(f"{path}: {error}") from None
