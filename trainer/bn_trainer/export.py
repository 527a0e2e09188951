# SPDX-License-Identifier: Apache-2.0
"""Exports to the ONNX format that libbn reads, and verifies the model before writing the file.

The model has one input `noise`, float32 (1, 1, h + 2r, w + 2r), uniform in [0, 1), and one output `values`, (1, C, h, w).
The graph uses no padding. Metadata: `bn.receptive_radius` r, `bn.align` 1 (any origin and extent), `bn.version` 1,
`bn.quantiles` to make the values of windows uniform, and for one channel `bn.sparse_spacing`. It is a single file without
external data, and uses only standard operators.

A step consists of elementwise operations on cropped images: six nodes for each pair of opposite offsets, or thirteen for
vectors. This is more than twice as fast as convolutions, which also multiply by the zeros between the two texels of a
difference, and whose many channels do not fit in the cache.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import onnx
import torch
from onnx.reference import ReferenceEvaluator

from .config import TrainerError
from .files import load_model, write_atomically
from .model import FIRST_SCALE, SPLIT, Relaxation, Step, halves

OPSET, IR_VERSION = 18, 9
CHECK_SIZES = ((16, 16), (64, 64), (33, 57), (96, 20))
#: Limit for the root mean square difference. Steps amplify rounding errors, so single texels may differ more if the
#: summation order differs.
TOLERANCE = 1e-4
#: The largest file that libbn embeds.
MOST_BYTES = 1 << 20
#: The end index of a slice that extends to the end of its axis.
TO_THE_END = 2**62
#: In float32, the squares of smaller weights would underflow to 0, and 0 would be divided by 0.
LEAST_SQUARE = 1e-30
#: libbn orders points farther apart than this, in hundredths of a texel, as in bn_relax.
SPARSE_SPACING = 350
QUANTILES, QUANTILE_MASKS, QUANTILE_SIZE = 64, 16, 256


class _Graph:
    def __init__(self) -> None:
        self.nodes: list[Any] = []
        self.constants: dict[str, npt.NDArray[Any]] = {}

    def number(self, value: float) -> str:
        """A constant."""
        name = f"{np.float32(value)}"
        self.constants[name] = np.float32(value).reshape(())
        return name

    def integers(self, *values: int) -> str:
        name = ",".join("end" if value == TO_THE_END else str(value) for value in values)
        self.constants[name] = np.array(values, np.int64)
        return name

    def add(self, kind: str, *inputs: str, output: str = "", **attributes: Any) -> str:
        output = output or f"v{len(self.nodes)}"
        # Without names, ONNX Runtime 1.19 to 1.21 gives two fused nodes the same name and rejects the model.
        self.nodes.append(onnx.helper.make_node(kind, inputs, [output], name=output, **attributes))
        return output

    def crop(self, values: str, top: int, left: int, bottom: int, right: int) -> str:
        ends = (-side if side > 0 else TO_THE_END for side in (bottom, right))
        return self.add("Slice", values, self.integers(top, left), self.integers(*ends), self.integers(2, 3))


def _add_direction(graph: _Graph, difference: str, channels: int, weight: float) -> str:
    """|weight| times direction(difference / |weight|)."""
    limit = abs(weight)
    if channels == 1:
        return graph.add("Clip", difference, graph.number(-limit), graph.number(limit))
    # A reduction over the channels would take twice as long.
    squares = graph.add("Mul", difference, difference)
    first, second = (graph.add("Slice", squares, graph.integers(c), graph.integers(c + 1), graph.integers(1)) for c in (0, 1))
    length = graph.add("Sqrt", graph.add("Max", graph.add("Add", first, second), graph.number(max(limit * limit, LEAST_SQUARE))))
    return graph.add("Mul", graph.add("Div", difference, length), graph.number(limit))


def _add_step(graph: _Graph, step: Step, values: str, channels: int) -> str:
    """Each direction is added at the texel where it starts and subtracted at the texel where it ends. For offsets to the
    right, directions are computed for the result plus m rows above and m columns left of it; for offsets to the left, plus
    m rows above and m columns right of it. Starts therefore need no crop, and each end needs one."""
    m = step.margin
    # Crops at the left and right: first for offsets to the right, then for offsets to the left.
    frames = ((0, m), (m, 0))
    starts, ends = ["", ""], ""

    def plus(total: str, term: str) -> str:
        return graph.add("Add", total, term) if total else term

    for weight, sharpness, group in step.groups():
        scaled = graph.add("Mul", values, graph.number(weight * sharpness))
        here = ["", ""]
        for y, x in halves(group):
            frame = 0 if x >= 0 else 1
            left, right = frames[frame]
            here[frame] = here[frame] or graph.crop(scaled, 0, left, m, right)
            there = graph.crop(scaled, y, left + x, m - y, right - x)
            direction = _add_direction(graph, graph.add("Sub", here[frame], there), channels, weight)
            starts[frame] = plus(starts[frame], direction)
            ends = plus(ends, graph.crop(direction, m - y, m - left - x, y, m - right + x))
    total = graph.add("Mul", graph.crop(values, m, m, m, m), graph.number(float(step.keep)))
    for sums, (left, right) in zip(starts, frames):
        if sums:
            total = graph.add("Add", total, graph.crop(sums, m, m - left, 0, m - right))
    return graph.add("Sub", total, ends)


def _name_shapes(proto: Any) -> None:
    """Names the extents of all intermediate values after how much smaller they are than the noise. Without names, ONNX
    Runtime cannot tell which values have the same shape, and opening the model takes time quadratic in the number of values."""
    extents = 1 << 20, 1 << 21
    sized = onnx.ModelProto.FromString(proto.SerializeToString())
    for axis, extent in zip(sized.graph.input[0].type.tensor_type.shape.dim[2:], extents):
        axis.dim_value = extent
    for axis in sized.graph.output[0].type.tensor_type.shape.dim[2:]:
        axis.Clear()
    for value in onnx.shape_inference.infer_shapes(sized, strict_mode=True).graph.value_info:
        for name, axis, extent in zip(("height", "width"), value.type.tensor_type.shape.dim[2:], extents, strict=True):
            axis.dim_param = f"{name[0]}{extent - axis.dim_value}" if axis.dim_value < extent else name
        proto.graph.value_info.append(value)


def quantiles(model: Relaxation) -> list[int]:
    """The i / 64 quantiles of all values, times 2^24."""
    generator = torch.Generator().manual_seed(0)
    values = [model.torus(torch.rand(1, 1, QUANTILE_SIZE, QUANTILE_SIZE, generator=generator)).numpy().ravel()
              for _ in range(QUANTILE_MASKS)]
    return np.rint(2.0**24 * np.quantile(np.concatenate(values), np.arange(QUANTILES + 1) / QUANTILES)).astype(int).tolist()


def onnx_bytes(model: Relaxation) -> bytes:
    """The model as the bytes of an ONNX file."""
    graph = _Graph()
    values = "noise"
    if model.channels == 2:
        low = graph.add("Mul", values, graph.number(SPLIT))
        values = graph.add("Concat", values, graph.add("Sub", low, graph.add("Floor", low)), axis=1)
    values = graph.add("Mul", graph.add("Sub", values, graph.number(0.5)), graph.number(FIRST_SCALE))
    for step in model.steps:
        values = _add_step(graph, step, values, model.channels)
    graph.add("Add", graph.add("Mul", values, graph.number(float(model.gain))), graph.number(0.5), output="values")

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
    _name_shapes(proto)
    metadata = {"bn.receptive_radius": str(model.receptive_radius), "bn.align": "1", "bn.version": "1",
                "bn.quantiles": ",".join(map(str, quantiles(model)))}
    if model.channels == 1:
        metadata["bn.sparse_spacing"] = str(SPARSE_SPACING)
    onnx.helper.set_model_props(proto, metadata)
    onnx.checker.check_model(proto, full_check=True)
    return bytes(proto.SerializeToString())


def session_of(data: bytes) -> Any:
    """An ONNX Runtime session with the same number of threads as torch."""
    # ONNX Runtime may otherwise send telemetry.
    os.environ.setdefault("ORT_DISABLE_TELEMETRY", "1")
    import onnxruntime

    options = onnxruntime.SessionOptions()
    options.log_severity_level, options.intra_op_num_threads = 3, torch.get_num_threads()
    return onnxruntime.InferenceSession(data, options, providers=["CPUExecutionProvider"])


def check(model: Relaxation, data: bytes) -> str:
    """Compares the model with torch at several sizes. Returns a summary. Raises TrainerError if they differ."""
    runs = {"the ONNX reference": ReferenceEvaluator(onnx.load_from_string(data)).run}
    with contextlib.suppress(ImportError):
        runs["ONNX Runtime"] = session_of(data).run
    worst = largest = 0.0
    for height, width in CHECK_SIZES:
        # The reference evaluator is slow, so use it for only one size if ONNX Runtime is available.
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


def run(checkpoint: Path, output: Path) -> None:
    done = export(load_model(checkpoint), output)
    print(f"{output}: {done['bytes']} bytes, {done['compared']}\nSHA-256 {done['sha256']}")
