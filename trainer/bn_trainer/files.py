# SPDX-License-Identifier: Apache-2.0
"""Atomic file writes, and checkpoints."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import torch

from .config import Config, TrainerError, from_dict
from .model import Relaxation


def write_atomically(path: Path, write: Callable[[Path], None]) -> None:
    """Calls write with a path in a private folder next to `path`, flushes that file to disk and renames it to `path`.
    On failure `path` is untouched."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix=".bn_trainer-", dir=path.parent) as folder:
            beside = Path(folder) / path.name
            write(beside)
            with open(beside, "r+b") as file:
                os.fsync(file.fileno())
            os.replace(beside, path)
    except OSError as error:
        raise TrainerError(f"cannot write {path}: {error.strerror}") from None


def model_of(config: Config) -> Relaxation:
    m = config.model
    return Relaxation(m.channels, m.kernels, sigma=m.sigma, first_rate=m.first_rate, last_rate=m.last_rate)


def load_checkpoint(path: Path) -> dict[str, Any]:
    try:
        checkpoint = torch.load(path, map_location="cpu", weights_only=True)
    except OSError as error:
        raise TrainerError(f"cannot read the checkpoint {path}: {error.strerror}") from None
    except Exception:  # torch raises whatever its parser met
        raise TrainerError(f"{path} is not a checkpoint, or is damaged") from None
    if not isinstance(checkpoint, dict) or checkpoint.get("format") != "bn_trainer 1":
        raise TrainerError(f"{path} is not a checkpoint of this trainer")
    return checkpoint


def load_model(path: Path) -> Relaxation:
    """The averaged model of a checkpoint, in evaluation mode."""
    checkpoint = load_checkpoint(path)
    model = model_of(from_dict(checkpoint["config"]))
    try:
        model.load_state_dict(checkpoint["average"])
    except (RuntimeError, KeyError):
        raise TrainerError(f"{path}: the weights do not fit the model in its configuration") from None
    return model.eval().requires_grad_(False)
