# SPDX-License-Identifier: Apache-2.0
"""Atomic file writes, and checkpoints."""

from __future__ import annotations

import io
import os
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import torch

from .config import Config, TrainerError, checked
from .model import Relaxation


def write_atomically(path: Path, write: Callable[[Path], None]) -> None:
    """Calls `write` with a path in a private folder next to `path`, flushes that file to disk and renames it to `path`.
    On failure, `path` is untouched."""
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


def save(state: dict[str, Any], path: Path) -> None:
    """torch.save(), which raises OSError with the reason if the file cannot be written: torch's own writer does not name it."""
    stream = io.BytesIO()
    torch.save(state, stream)
    path.write_bytes(stream.getbuffer())


def load_checkpoint(path: Path) -> dict[str, Any]:
    try:
        checkpoint = torch.load(path, map_location="cpu", weights_only=True)
    except OSError as error:
        raise TrainerError(f"cannot read the checkpoint {path}: {error.strerror}") from None
    except Exception:  # torch passes on all exception types of its parser
        raise TrainerError(f"{path} is not a checkpoint, or is damaged") from None
    if not isinstance(checkpoint, dict) or checkpoint.get("format") != "bn_trainer 2" or "config" not in checkpoint:
        raise TrainerError(f"{path} is not a checkpoint of this trainer")
    return checkpoint


def load_model(path: Path) -> Relaxation:
    """The calibrated model of a checkpoint."""
    checkpoint = load_checkpoint(path)
    config = checked(Config, checkpoint["config"])
    model = Relaxation(config.model.reaches, config.model.channels)
    try:
        mean = checkpoint["search"]["mean"]
        if mean.shape != model.vector().shape:
            raise ValueError
        model.load_vector(mean)
    except (KeyError, TypeError, ValueError, AttributeError):
        raise TrainerError(f"{path}: the parameters do not fit the model in its configuration") from None
    model.calibrate(torch.rand(4, 1, 128, 128, generator=torch.Generator().manual_seed(config.train.seed)))
    return model.eval()
