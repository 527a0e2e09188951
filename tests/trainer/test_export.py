# SPDX-License-Identifier: Apache-2.0
"""Exported ONNX files follow libbn's format, match PyTorch, load in libbn and are written atomically. Also tests the built-in models."""

import csv
import functools
import hashlib
import json
import os
from pathlib import Path

import numpy as np
import onnx
import pytest
import torch
from bn_trainer import evaluate
from bn_trainer.config import TrainerError
from bn_trainer.export import check, export, session_of
from bn_trainer.model import Relaxation
from bn_trainer.schedule import schedule

import bluenoise

DATA = Path(__file__).resolve().parents[2] / "libbn" / "data"
SCALAR = ("neural.onnx", "neural_fast.onnx")
BUILTIN = (*SCALAR, "neural_vector.onnx")
RADIUS = 5


def small_model(channels):
    model = Relaxation([4, 5, 2], channels)
    generator = torch.Generator().manual_seed(4)
    model.load_vector(model.vector() + 0.1 * torch.randn(model.vector().shape, dtype=torch.float64, generator=generator))
    model.calibrate(torch.rand(1, 1, 64, 64, generator=generator))
    return model


@pytest.fixture(scope="module", params=[1, 2])
def exported(request, tmp_path_factory):
    """A model with one or two channels, its file, and the result of export()."""
    model, path = small_model(request.param), tmp_path_factory.mktemp("export") / "folder" / "m.onnx"
    return model, path, export(model, path)


@pytest.fixture(scope="module")
def small(exported):
    return exported[0], exported[1].read_bytes()


def metadata_of(data):
    return {p.key: p.value for p in onnx.load_from_string(data).metadata_props}


def quantiles_of(data):
    return np.array([int(word) for word in metadata_of(data)["bn.quantiles"].split(",")])


def test_format(small):
    model, data = small
    proto = onnx.load_from_string(data)
    metadata = metadata_of(data)
    assert {key: value for key, value in metadata.items() if key != "bn.quantiles"} == {
        "bn.receptive_radius": str(RADIUS), "bn.align": "1", "bn.version": "1",
        **({"bn.sparse_spacing": "350"} if model.channels == 1 else {}),
    }
    quantiles = quantiles_of(data)
    assert metadata["bn.quantiles"] == ",".join(map(str, quantiles))
    assert len(quantiles) == 65 and (np.diff(quantiles) > 0).all()
    assert proto.ir_version in (8, 9)
    assert [(o.domain, o.version) for o in proto.opset_import if o.domain in ("", "ai.onnx")][0][1] in (17, 18)
    assert len(proto.graph.input) == len(proto.graph.output) == 1 and not proto.functions
    assert proto.graph.input[0].name == "noise"
    for value, channels in ((proto.graph.input[0], 1), (proto.graph.output[0], model.channels)):
        shape = value.type.tensor_type.shape.dim
        assert value.type.tensor_type.elem_type == onnx.TensorProto.FLOAT
        assert [d.dim_value for d in shape[:2]] == [1, channels] and all(d.dim_param for d in shape[2:])
    assert all(node.domain in ("", "ai.onnx") for node in proto.graph.node)
    assert all(node.op_type != "Pad" for node in proto.graph.node)
    # Every node has a name of its own, without which ONNX Runtime 1.19 to 1.21 rejects models of two channels.
    assert len({node.name for node in proto.graph.node} - {""}) == len(proto.graph.node)
    assert all(t.data_location == onnx.TensorProto.DEFAULT for t in proto.graph.initializer)
    assert str(Path(__file__).resolve().parents[2]).encode() not in data
    # The height and width of every value are named.
    values = [*proto.graph.value_info, *proto.graph.output]
    assert {name for node in proto.graph.node for name in node.output} == {value.name for value in values}
    assert all(axis.dim_param for value in values for axis in value.type.tensor_type.shape.dim[2:])


@pytest.mark.parametrize("shape", [(16, 16), (1, 1), (31, 50), (128, 64)])
def test_torch_and_onnx_runtime_agree(small, shape):
    model, data = small
    noise = torch.rand(1, 1, shape[0] + 2 * RADIUS, shape[1] + 2 * RADIUS, generator=torch.Generator().manual_seed(1))
    (values,) = session_of(data).run(None, {"noise": noise.numpy()})
    assert values.shape == (1, model.channels, *shape)
    assert np.abs(values - model(noise).numpy()).max() < 1e-4


def test_export_is_complete_and_mismatches_are_rejected(exported):
    model, path, done = exported
    data = path.read_bytes()
    assert hashlib.sha256(data).hexdigest() == done["sha256"] and len(data) == done["bytes"]
    assert "ONNX Runtime" in done["compared"]
    assert os.listdir(path.parent) == ["m.onnx"]
    # A file whose results differ from the model's is rejected.
    other = small_model(model.channels)
    other.steps[1].surround += 0.1
    with pytest.raises(TrainerError, match="differ by"):
        check(other, data)
    with pytest.raises(TrainerError, match="returns shape"):
        check(small_model(3 - model.channels), data)


def test_failed_export_keeps_the_old_file(small, tmp_path, monkeypatch):
    model, data = small
    monkeypatch.setattr("bn_trainer.export.onnx_bytes", lambda _: data)

    def refuse(*_):
        raise TrainerError("differ by 1")

    (tmp_path / "m.onnx").write_bytes(b"before")
    with monkeypatch.context() as patch, pytest.raises(TrainerError, match="differ by 1"):
        patch.setattr("bn_trainer.export.check", refuse)
        export(model, tmp_path / "m.onnx")
    with monkeypatch.context() as patch, pytest.raises(TrainerError, match="embeds at most 100"):
        patch.setattr("bn_trainer.export.MOST_BYTES", 100)
        export(model, tmp_path / "m.onnx")
    assert (tmp_path / "m.onnx").read_bytes() == b"before" and os.listdir(tmp_path) == ["m.onnx"]


@pytest.mark.skipif(not hasattr(bluenoise._core, "NeuralGenerator"), reason="the package was built with BN_NEURAL=OFF")
def test_libbn_reads_the_exported_model(exported):
    model, path, _ = exported
    generator = bluenoise.NeuralGenerator(path, threads=1)
    assert generator.channels == model.channels
    noise = generator.noise(-7 - RADIUS, 5 - RADIUS, 120 + 2 * RADIUS, 40 + 2 * RADIUS, seed=3)
    values = model(torch.from_numpy(noise)[None, None]).numpy()[0]
    expected = np.interp(values, quantiles_of(path.read_bytes()) / 2.0**24, np.arange(65) / 64)
    found = generator.window(-7, 5, 120, 40, seed=3)
    np.testing.assert_allclose(found, expected[0] if model.channels == 1 else expected, atol=1e-4)
    noise = torch.from_numpy(generator.noise(0, 0, 50, 30, seed=3))[None, None]
    order = generator.mask((30, 50), seed=3).reshape(model.channels, -1).argsort(1)
    in_order = np.take_along_axis(model.torus(noise).numpy().reshape(model.channels, -1), order, 1)
    if model.channels == 1:
        # libbn reorders the ranks whose points are at least 3.5 texels apart on average.
        ends = (slice(0, 50 * 30 * 4 // 49), slice(-(50 * 30 * 4 // 49), None))
        assert not any((np.diff(in_order[:, end]) > -1e-4).all() for end in ends)
        for end in ends:
            in_order[:, end] = np.sort(in_order[:, end])
    assert (np.diff(in_order) > -1e-4).all()


def limits():
    """For each built-in model, the limit for the mean of each figure. None means no limit."""
    with open(Path(__file__).with_name("limits.csv"), newline="") as file:
        return {row["model"]: {k: float(v) if v else None for k, v in row.items() if k != "model"}
                for row in csv.DictReader(file)}


@functools.cache
def builtin(name):
    """A built-in network and its receptive radius."""
    return evaluate.network_of(DATA / name)[:2]


@pytest.mark.parametrize("name", BUILTIN)
def test_builtin_models_match_their_checksums(name):
    sums = dict(reversed(line.split()) for line in (DATA / "SHA256SUMS").read_text().splitlines())
    data = (DATA / name).read_bytes()
    assert hashlib.sha256(data).hexdigest() == sums[name]
    assert len(data) <= 1 << 20
    # The README states the checksums of the models that its figures describe.
    assert sums[name] in (DATA / "README.md").read_text()
    quantiles = quantiles_of(data)
    assert len(quantiles) == 65 and (np.diff(quantiles) > 0).all()


@pytest.mark.parametrize("name", BUILTIN)
def test_builtin_models_meet_their_error_limits(name):
    network, radius = builtin(name)
    assert radius <= 64
    figures = evaluate.errors(network, radius, 64, 64, 20).mean(0)
    for key, found in (("e_1", figures[1]), ("e_1.5", figures[2])):
        limit = limits()[name][key]
        assert limit is None or found <= limit, (key, found)


def test_builtin_vector_model_meets_its_energy_limit():
    network, radius = builtin("neural_vector.onnx")
    energy = evaluate.energies(network, radius, 64, 20).mean()
    assert energy <= limits()["neural_vector.onnx"]["energy"], energy


@pytest.mark.parametrize("name", BUILTIN)
def test_builtin_models_have_no_fixed_pattern(name):
    spread, independent, worst = evaluate.flatness(*builtin(name), 200)
    assert spread < 1.1 * independent
    # For independent texels, the means of 84 rows, columns and phases exceed 4.5 deviations once in 1,700 runs. For
    # blue noise, they vary less.
    assert worst < 4.5


def test_schedule_contains_the_steps():
    model = Relaxation([2, 5])
    with torch.no_grad():
        model.load_vector(model.vector() + torch.cat([torch.full_like(p.reshape(-1), 0.1 if "sharpness" not in name else 0)
                                                      for name, p in model.named_parameters()]))
    steps = json.loads(schedule(model))
    assert len(steps) == 2
    for step, written in zip(model.steps, steps):
        groups = step.groups()
        assert written["keep"] == pytest.approx(0.12) and len(written["groups"]) == len(groups)
        for (weight, _, offsets), given, found in zip(groups, written["weights"], written["groups"]):
            assert given == pytest.approx(weight) and [tuple(offset) for offset in found] == offsets
        assert written["most"] == pytest.approx(sum(abs(w) * len(o) for w, _, o in groups))
    model.steps[1].sharpness += 0.5
    with pytest.raises(TrainerError, match="softness"):
        schedule(model)
    with pytest.raises(TrainerError, match="one channel"):
        schedule(Relaxation([2], channels=2))
