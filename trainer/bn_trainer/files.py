# SPDX-License-Identifier: Apache-2.0
"""Files that are complete or not there: written beside their place, then renamed. Checkpoints."""

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
    """Calls write with a path beside `path`, then renames; leaves nothing behind when it fails."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(prefix=f".{path.name}.", dir=path.parent)
    except OSError as error:
        raise TrainerError(f"cannot write {path}: {error.strerror}") from None
    os.close(handle)
    beside = Path(name)
    try:
        write(beside)
        umask = os.umask(0)
        os.umask(umask)
        beside.chmod(0o666 & ~umask)
        os.replace(beside, path)
    except OSError as error:
        raise TrainerError(f"cannot write {path}: {error.strerror}") from None
    finally:
        beside.unlink(missing_ok=True)


def model_of(config: Config) -> Relaxation:
    m = config.model
    return Relaxation(m.channels, m.kernels, sigma=m.sigma, first_rate=m.first_rate, last_rate=m.last_rate)


def load_checkpoint(path: Path) -> dict[str, Any]:
    try:
        checkpoint = torch.load(path, map_location="cpu", weights_only=True)
    except OSError as error:
        raise TrainerError(f"cannot read the checkpoint {path}: {error.strerror}") from None
    except Exception:  # torch raises whatever its parser met
        raise TrainerError(f"{path} is no checkpoint, or a damaged one") from None
    if not isinstance(checkpoint, dict) or checkpoint.get("format") != "bn_trainer 1":
        raise TrainerError(f"{path} is no checkpoint of this trainer")
    return checkpoint


def load_model(path: Path) -> Relaxation:
    """The averaged model of a checkpoint, ready to evaluate."""
    checkpoint = load_checkpoint(path)
    model = model_of(from_dict(checkpoint["config"]))
    try:
        model.load_state_dict(checkpoint["average"])
    except (RuntimeError, KeyError):
        raise TrainerError(f"{path} does not hold the model its configuration describes") from None
    return model.eval().requires_grad_(False)
