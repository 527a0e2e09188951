# SPDX-License-Identifier: Apache-2.0
"""Export to ONNX in the form libbn reads, verified before the file is written.

One input `noise`, float32 (1, 1, h + 2r, w + 2r), uniform in [0, 1); one output `values`, (1, C, h, w); no padding in the
graph. Metadata: `bn.receptive_radius` r, `bn.align` 1 (any origin and extent), `bn.version` 1 and `bn.quantiles`, which
make the values of windows uniform. A single file without external data, with standard operators only.

Per channel, a step is a convolution that takes all differences, and the value itself on a last channel; an elementwise
function that limits them; and a convolution of 1 x 1 that adds them up. Constant factors are folded into the weights.
"""

from __future__ import annotations

import hashlib
import os
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import torch

from .config import TrainerError
from .files import write_atomically
from .model import FIRST_SCALE, SPLIT, Relaxation

OPSET, IR_VERSION = 18, 9
CHECK_SIZES = ((16, 16), (64, 64), (33, 57), (96, 20))
#: Root mean square difference. Steps amplify rounding errors, so single texels may differ by more if the order of
#: summation differs.
TOLERANCE = 1e-4
#: Largest file libbn embeds.
MOST_BYTES = 1 << 20
QUANTILES, QUANTILE_MASKS, QUANTILE_SIZE = 64, 16, 256


class _Graph:
    def __init__(self) -> None:
        self.nodes: list[Any] = []
        self.constants: dict[str, npt.NDArray[np.float32]] = {}

    def constant(self, name: str, value: Any) -> str:
        self.constants[name] = np.asarray(value, np.float32)
        return name

    def add(self, kind: str, inputs: list[str], output: str, **attributes: Any) -> str:
        import onnx

        self.nodes.append(onnx.helper.make_node(kind, inputs, [output], **attributes))
        return output


def _add_steps(graph: _Graph, model: Relaxation, values: list[str]) -> list[str]:
    """Adds the steps to the graph. `values` are the names of the channels of the noise, not scaled yet."""
    one, lowest = graph.constant("one", 1.0), graph.constant("minus_one", -1.0)
    most = FIRST_SCALE / 2  # the largest magnitude of a value
    for index, step in enumerate(model.steps):
        offsets = [(offset, weight, sharpness) for weight, sharpness, group in step.groups() for offset in group]
        m, count, first, last = step.margin, len(offsets), index == 0, index + 1 == len(model.steps)
        scale = FIRST_SCALE if first else 1.0
        # Small enough on its channel to pass the limiting function unchanged.
        own = 1 / (1.5 * most)
        differences = np.zeros((count + 1, 1, 2 * m + 1, 2 * m + 1))
        differences[-1, 0, m, m] = scale * own
        for i, ((y, x), _, sharpness) in enumerate(offsets):
            differences[i, 0, m, m] = scale * sharpness
            differences[i, 0, m + y, m + x] = -scale * sharpness
        keep, gain = float(step.keep), float(model.gain) if last else 1.0
        sums = gain * np.array([weight for _, weight, _ in offsets] + [keep / own])
        most = abs(keep) * most + sum(abs(weight) for _, weight, _ in offsets)

        name = f"step{index}"
        inputs = [graph.constant(f"{name}.differences", differences)]
        if first:
            inputs.append(graph.constant(f"{name}.middle", [0.0] * count + [-0.5 * scale * own]))
        adding = [graph.constant(f"{name}.weights", sums.reshape(1, -1, 1, 1))]
        if last:
            adding.append(graph.constant(f"{name}.half", [0.5]))
        taken = [graph.add("Conv", [value, *inputs], f"{name}.taken{c}") for c, value in enumerate(values)]
        if len(taken) == 1:
            limited = [graph.add("Clip", [taken[0], lowest, one], f"{name}.limited")]
        else:
            squares = [graph.add("Mul", [value, value], f"{name}.square{c}") for c, value in enumerate(taken)]
            total = graph.add("Max", [graph.add("Add", squares, f"{name}.squares"), one], f"{name}.most")
            length = graph.add("Sqrt", [total], f"{name}.length")
            limited = [graph.add("Div", [value, length], f"{name}.direction{c}") for c, value in enumerate(taken)]
        values = [graph.add("Conv", [value, *adding], f"{name}.value{c}") for c, value in enumerate(limited)]
    return values


def quantiles(model: Relaxation) -> list[int]:
    """2^24 times the values below which i / 64 of all values lie."""
    generator = torch.Generator().manual_seed(0)
    values = [model.torus(torch.rand(1, 1, QUANTILE_SIZE, QUANTILE_SIZE, generator=generator)).numpy().ravel()
              for _ in range(QUANTILE_MASKS)]
    return np.rint(2.0**24 * np.quantile(np.concatenate(values), np.arange(QUANTILES + 1) / QUANTILES)).astype(int).tolist()


def onnx_bytes(model: Relaxation) -> bytes:
    """The model as the bytes of an ONNX file."""
    try:
        import onnx
    except ImportError:
        raise TrainerError("export needs the package onnx; run pip install ./trainer") from None

    graph = _Graph()
    values = ["noise"]
    if model.channels == 2:
        many = graph.add("Mul", ["noise", graph.constant("split", SPLIT)], "noise.many")
        values.append(graph.add("Sub", [many, graph.add("Floor", [many], "noise.whole")], "noise.low"))
    values = _add_steps(graph, model, values)
    graph.add("Concat", values, "values", axis=1)

    def tensor(name: str, channels: int, height: str, width: str) -> Any:
        return onnx.helper.make_tensor_value_info(name, onnx.TensorProto.FLOAT, [1, channels, height, width])

    proto = onnx.helper.make_model(
        onnx.helper.make_graph(
            graph.nodes, "relaxation", [tensor("noise", 1, "height", "width")],
            [tensor("values", model.channels, "out_height", "out_width")],
            [onnx.numpy_helper.from_array(value, name) for name, value in graph.constants.items()],
        ),
        opset_imports=[onnx.helper.make_opsetid("", OPSET)], producer_name="bn_trainer",
    )
    proto.ir_version = IR_VERSION
    onnx.helper.set_model_props(proto, {
        "bn.receptive_radius": str(model.receptive_radius), "bn.align": "1", "bn.version": "1",
        "bn.quantiles": ",".join(map(str, quantiles(model))),
    })
    onnx.checker.check_model(proto, full_check=True)
    return bytes(proto.SerializeToString())


def check(model: Relaxation, data: bytes) -> str:
    """Compares the file with torch at several sizes. Returns a summary, or raises TrainerError if they differ."""
    from onnx.reference import ReferenceEvaluator

    import onnx

    runs = {"the ONNX reference": ReferenceEvaluator(onnx.load_from_string(data)).run}
    try:
        # ONNX Runtime may otherwise send telemetry.
        os.environ.setdefault("ORT_DISABLE_TELEMETRY", "1")
        import onnxruntime

        options = onnxruntime.SessionOptions()
        options.log_severity_level = 3
        session = onnxruntime.InferenceSession(data, options, providers=["CPUExecutionProvider"])
        runs["ONNX Runtime"] = session.run
    except ImportError:
        pass
    worst = largest = 0.0
    for height, width in CHECK_SIZES:
        # The reference evaluator is slow, so use it for one size only if ONNX Runtime is available.
        names = list(runs) if (height, width) == CHECK_SIZES[0] else list(runs)[-1:]
        margin = 2 * model.receptive_radius
        noise = torch.rand(1, 1, height + margin, width + margin, generator=torch.Generator().manual_seed(height))
        expected = model(noise).numpy()
        for name in names:
            values = runs[name](None, {"noise": noise.numpy()})[0]
            if values.shape != expected.shape:
                raise TrainerError(f"{name} returns shape {values.shape} at {width}x{height}, torch {expected.shape}")
            difference = float(np.sqrt(np.square(values - expected, dtype=np.float64).mean()))
            if not difference <= TOLERANCE:
                raise TrainerError(f"{name} and torch differ by {difference:.2g} (rms) at {width}x{height}")
            worst = max(worst, difference)
            largest = max(largest, float(np.abs(values - expected).max()))
    return f"{' and '.join(runs)} agree with torch: rms {worst:.1e}, at most {largest:.1e}"


def export(model: Relaxation, path: Path) -> dict[str, object]:
    """Writes the model atomically. Returns its SHA-256, its size and a summary of the comparison."""
    data = onnx_bytes(model)
    if len(data) > MOST_BYTES:
        raise TrainerError(f"the model takes {len(data)} bytes; libbn embeds at most {MOST_BYTES}")
    compared = check(model, data)
    write_atomically(path, lambda beside: beside.write_bytes(data) and None)
    return {"sha256": hashlib.sha256(data).hexdigest(), "bytes": len(data), "compared": compared}
