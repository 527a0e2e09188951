# SPDX-License-Identifier: Apache-2.0
"""Export to ONNX in the form libbn reads, verified before the file is written.

One input `noise`, float32 (1, 1, h + 2r, w + 2r), uniform in [0, 1); one output `values`, (1, C, h, w); no padding in the
graph. Metadata: `bn.receptive_radius` r, `bn.align` 1 (any origin and extent), `bn.version` 1. A single file without
external data, with standard operators only.
"""

from __future__ import annotations

import hashlib
import logging
import os
import warnings
from pathlib import Path

import numpy as np
import torch
from torch import Tensor, nn

from .config import TrainerError
from .files import write_atomically
from .model import Relaxation, Step

OPSET, IR_VERSION = 18, 9
CHECK_SIZES = ((16, 16), (64, 64), (33, 57), (96, 20))
#: Root mean square difference. Steps amplify rounding errors a hundredfold, so single texels may differ by more if the
#: order of summation differs.
TOLERANCE = 1e-4
#: Largest file libbn embeds.
MOST_BYTES = 1 << 20


class _FoldedStep(nn.Module):
    """A step as plain convolutions, with everything that depends only on parameters precomputed."""

    def __init__(self, step: Step) -> None:
        super().__init__()
        c, self.margin = step.channels, step.margin

        def convolution(weight: Tensor, bias: Tensor | None, groups: int = 1) -> nn.Conv2d:
            layer = nn.Conv2d(weight.shape[1] * groups, weight.shape[0], weight.shape[2], groups=groups,
                              bias=bias is not None)
            layer.weight.data = weight.detach().clone()
            if bias is not None and layer.bias is not None:
                layer.bias.data = bias.detach().clone()
            return layer

        self.ramps = convolution((c * step.slope).view(-1, 1, 1, 1), c * step.offset)
        self.gates = convolution((c * step.gate_slope).view(-1, 1, 1, 1), c * step.gate_offset)
        self.around = convolution(step.kernels()[:, step.orbit].unsqueeze(1), None, groups=c)
        mix, bias = step.mixing()
        self.mix = convolution(mix[:, :, None, None], bias)
        self.total = convolution(torch.ones(1, c, 1, 1), None)
        self.keep = float(step.keep)

    def forward(self, values: Tensor) -> Tensor:
        m = self.margin
        mixed = self.mix(self.around(self.ramps(values).clamp(0.0, 1.0)))
        inner = values[:, :, m:-m, m:-m]
        return inner * self.keep + self.total(self.gates(inner).clamp(0.0, 1.0) * mixed)


class _Folded(nn.Module):
    def __init__(self, model: Relaxation) -> None:
        super().__init__()
        self.steps = nn.ModuleList(_FoldedStep(step) for step in model.steps)

    def forward(self, noise: Tensor) -> Tensor:
        for step in self.steps:
            noise = step(noise)
        return Relaxation.finish(noise)


def onnx_bytes(model: Relaxation) -> bytes:
    """The model as the bytes of an ONNX file."""
    try:
        import onnx
    except ImportError:
        raise TrainerError("export needs the packages onnx and onnxscript; run pip install ./trainer") from None

    radius = model.receptive_radius
    extent = 2 * radius + 32
    height, width = torch.export.Dim("h", min=2 * radius + 1), torch.export.Dim("w", min=2 * radius + 1)
    logging.getLogger("torch.onnx").setLevel(logging.ERROR)
    with warnings.catch_warnings(), torch.no_grad():
        warnings.simplefilter("ignore")
        program = torch.onnx.export(
            _Folded(model).eval(), (torch.rand(1, 1, extent, extent + 8),), dynamo=True, opset_version=OPSET,
            input_names=["noise"], output_names=["values"], dynamic_shapes=({2: height, 3: width},), verbose=False,
        )
    assert program is not None
    proto = program.model_proto
    proto.ir_version = IR_VERSION
    proto.producer_name, proto.producer_version, proto.doc_string = "bn_trainer", "", ""
    del proto.metadata_props[:]
    entries = {"bn.receptive_radius": str(radius), "bn.align": "1", "bn.version": "1"}
    onnx.helper.set_model_props(proto, entries)
    for value in (*proto.graph.value_info, *proto.graph.node):
        del value.metadata_props[:]
    del proto.graph.value_info[:]
    for node in proto.graph.node:
        node.doc_string = ""
    for value, names in ((proto.graph.input[0], ("1", "1", "height", "width")),
                         (proto.graph.output[0], ("1", "1", "out_height", "out_width"))):
        for dimension, name in zip(value.type.tensor_type.shape.dim, names):
            if not dimension.HasField("dim_value"):
                dimension.dim_param = name
    onnx.checker.check_model(proto, full_check=True)
    if any(node.domain not in ("", "ai.onnx") for node in proto.graph.node):
        raise TrainerError("the exported graph contains non-standard operators")
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
        with torch.no_grad():
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
