# SPDX-License-Identifier: Apache-2.0
"""Writes the steps of a one-channel network as the learned schedule of bn_relax, libbn/data/relax.json.

bn_relax computes the same steps in integers, with one softness per step. `libbn/tools/make_relax.py` converts the file to
a C table."""

from __future__ import annotations

import json
from pathlib import Path

from .config import TrainerError
from .files import load_model, write_atomically
from .model import Relaxation


def schedule(model: Relaxation) -> str:
    """The JSON text. Each step has `keep`, groups of offsets [y, x] with one weight per group, and `most`, the sum of the
    magnitudes of all weights."""
    steps = []
    for step in model.steps:
        groups = step.groups()
        if model.channels != 1 or any(abs(sharpness - 1) > 1e-6 for _, sharpness, _ in groups):
            raise TrainerError("bn_relax takes one channel and one softness per step (model.sharpness = false)")
        steps.append("{" + f'"keep": {float(step.keep)!r}, "most": {sum(abs(w) * len(g) for w, _, g in groups)!r},\n "groups": [\n  '
                     + ",\n  ".join(json.dumps([list(offset) for offset in group]) for _, _, group in groups)
                     + f'],\n "weights": {json.dumps([weight for weight, _, _ in groups])}' + "}")
    return "[\n" + ",\n".join(steps) + "\n]\n"


def run(checkpoint: Path, output: Path) -> None:
    text = schedule(load_model(checkpoint))
    write_atomically(output, lambda beside: beside.write_text(text) and None)
