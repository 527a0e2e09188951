# SPDX-License-Identifier: Apache-2.0
"""The tests use the trainer in the source tree. `scripts/setup --with-trainer` installs its dependencies."""

import sys
from pathlib import Path

import pytest

TRAINER = Path(__file__).resolve().parents[2] / "trainer"
sys.path.insert(0, str(TRAINER))

torch = pytest.importorskip("torch", reason="scripts/setup --with-trainer installs torch")
pytest.importorskip("onnx", reason="scripts/setup --with-trainer installs onnx")
pytest.importorskip("onnxruntime", reason="scripts/setup --with-trainer installs onnxruntime")


@pytest.fixture(scope="session", autouse=True)
def one_thread() -> None:
    torch.set_num_threads(1)
