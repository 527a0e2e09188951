# SPDX-License-Identifier: Apache-2.0
"""The ONNX file: libbn's format, equal to torch, written atomically; and the built-in models."""

import csv
import hashlib
import os
from pathlib import Path

import numpy as np
import pytest
import torch

os.environ.setdefault("ORT_DISABLE_TELEMETRY", "1")
import onnx
import onnxruntime

from bn_trainer import evaluate
from bn_trainer.config import TrainerError
from bn_trainer.export import check, export
from bn_trainer.model import Relaxation

DATA = Path(__file__).resolve().parents[2] / "libbn" / "data"
BUILTIN = ("neural.onnx", "neural_fast.onnx")


def small_model():
    torch.manual_seed(4)
    model = Relaxation([4, 6], [5, 3], first_rate=1.0)
    with torch.no_grad():
        for parameter in model.parameters():
            parameter.add_(0.02 * torch.randn_like(parameter))
    return model.eval().requires_grad_(False)


def session_of(data):
    options = onnxruntime.SessionOptions()
    options.log_severity_level, options.intra_op_num_threads = 3, 1
    return onnxruntime.InferenceSession(data, options, providers=["CPUExecutionProvider"])


@pytest.fixture(scope="module")
def exported(tmp_path_factory):
    """The model, its file, and the result of export."""
    model, path = small_model(), tmp_path_factory.mktemp("export") / "folder" / "m.onnx"
    return model, path, export(model, path)


@pytest.fixture(scope="module")
def small(exported):
    return exported[0], exported[1].read_bytes()


def test_format(small):
    model, data = small
    proto = onnx.load_from_string(data)
    assert {p.key: p.value for p in proto.metadata_props} == {
        "bn.receptive_radius": "3", "bn.align": "1", "bn.version": "1",
    }
    assert proto.ir_version in (8, 9)
    assert [(o.domain, o.version) for o in proto.opset_import if o.domain in ("", "ai.onnx")][0][1] in (17, 18)
    assert len(proto.graph.input) == len(proto.graph.output) == 1 and not proto.functions
    assert proto.graph.input[0].name == "noise"
    for value in (proto.graph.input[0], proto.graph.output[0]):
        shape = value.type.tensor_type.shape.dim
        assert value.type.tensor_type.elem_type == onnx.TensorProto.FLOAT
        assert [d.dim_value for d in shape[:2]] == [1, 1] and all(d.dim_param for d in shape[2:])
    assert all(node.domain in ("", "ai.onnx") for node in proto.graph.node)
    assert all(node.op_type != "Pad" for node in proto.graph.node)
    assert all(t.data_location == onnx.TensorProto.DEFAULT for t in proto.graph.initializer)
    assert str(Path(__file__).resolve().parents[2]).encode() not in data


@pytest.mark.parametrize("shape", [(16, 16), (1, 1), (31, 50), (128, 64)])
def test_torch_and_onnx_runtime_agree(small, shape):
    model, data = small
    noise = torch.rand(1, 1, shape[0] + 6, shape[1] + 6, generator=torch.Generator().manual_seed(1))
    (values,) = session_of(data).run(None, {"noise": noise.numpy()})
    assert values.shape == (1, 1, *shape)
    assert np.abs(values - model(noise).numpy()).max() < 1e-4


def test_export_is_checked_and_complete(exported):
    _, path, done = exported
    data = path.read_bytes()
    assert hashlib.sha256(data).hexdigest() == done["sha256"] and len(data) == done["bytes"]
    assert "ONNX Runtime" in done["compared"]
    assert os.listdir(path.parent) == ["m.onnx"]
    # A file that does not compute what the model does is refused.
    other = small_model()
    with torch.no_grad():
        other.steps[1].bias.add_(0.01)
    with pytest.raises(TrainerError, match="differ by"):
        check(other, data)


def test_a_failed_export_leaves_nothing(small, tmp_path, monkeypatch):
    model, data = small
    monkeypatch.setattr("bn_trainer.export.onnx_bytes", lambda _: data)

    def refuse(*_):
        raise TrainerError("differ by 1")

    monkeypatch.setattr("bn_trainer.export.check", refuse)
    (tmp_path / "m.onnx").write_bytes(b"before")
    with pytest.raises(TrainerError):
        export(model, tmp_path / "m.onnx")
    assert (tmp_path / "m.onnx").read_bytes() == b"before" and os.listdir(tmp_path) == ["m.onnx"]


def limits():
    with open(Path(__file__).with_name("limits.csv"), newline="") as file:
        return {row["model"]: {k: float(v) for k, v in row.items() if k != "model"} for row in csv.DictReader(file)}


@pytest.mark.parametrize("name", BUILTIN)
def test_builtin_models_are_what_they_were(name):
    sums = dict(reversed(line.split()) for line in (DATA / "SHA256SUMS").read_text().splitlines())
    data = (DATA / name).read_bytes()
    assert hashlib.sha256(data).hexdigest() == sums[name]
    assert len(data) <= 1 << 20
    # The README says which bytes its figures are of.
    assert sums[name] in (DATA / "README.md").read_text()


@pytest.mark.parametrize("name", BUILTIN)
def test_builtin_models_keep_their_quality(name):
    network, radius, _ = evaluate.network_of(DATA / name)
    table = evaluate.errors(network, radius, 64, 64, 20)
    limit = limits()[name]
    assert table[:, 1].mean() <= limit["e_1"] and table[:, 2].mean() <= limit["e_1.5"], table.mean(0)
    values = evaluate.values_of(network, radius, 128, 128, 99)
    # Windows have no ranks to fall back on: the raw values must be uniform.
    assert abs(values.std() - 12**-0.5) < 0.01 and abs(values.mean() - 0.5) < 0.01
    assert len(np.unique(values)) > 0.99 * values.size
    assert radius <= 64


@pytest.mark.parametrize("name", BUILTIN)
def test_builtin_models_have_no_fixed_pattern(name):
    network, radius, _ = evaluate.network_of(DATA / name)
    spread, independent, worst = evaluate.flatness(network, radius, 200)
    assert spread < 1.1 * independent
    # Means of 84 rows, columns and phases of independent texels exceed 4.5 deviations once in 1,700 runs; those of
    # blue noise vary less.
    assert worst < 4.5
