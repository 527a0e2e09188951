# SPDX-License-Identifier: Apache-2.0
"""Writes ONNX models of one convolution. Field numbers are those of onnx.proto."""

import numpy as np


def _varint(value):
    out = b""
    while value > 127:
        out += bytes([value & 127 | 128])
        value >>= 7
    return out + bytes([value])


def _field(number, value):
    if isinstance(value, int):
        return _varint(number << 3) + _varint(value)
    data = value.encode() if isinstance(value, str) else value
    return _varint(number << 3 | 2) + _varint(len(data)) + data


def _value(number, name, channels):
    axes = [_field(1, 1), _field(1, channels), _field(2, f"h{number}"), _field(2, f"w{number}")]
    tensor = _field(1, 1) + _field(2, b"".join(_field(1, axis) for axis in axes))
    return _field(number, _field(1, name) + _field(2, _field(1, tensor)))


def convolution(kernels, domain="", **metadata):
    """The bytes of a model that convolves the noise with kernels, float32 of shape (channels, 2r + 1, 2r + 1)."""
    kernels = np.asarray(kernels, "<f4")
    channels, height, width = kernels.shape
    dims = b"".join(_field(1, extent) for extent in (channels, 1, height, width))
    weights = dims + _field(2, 1) + _field(8, "weights") + _field(9, kernels.tobytes())
    node = _field(1, "noise") + _field(1, "weights") + _field(2, "mask") + _field(4, "Conv") + _field(7, domain)
    graph = _field(1, node) + _field(2, "graph") + _field(5, weights)
    graph += _value(11, "noise", 1) + _value(12, "mask", channels)
    model = _field(1, 8) + _field(7, graph) + _field(8, _field(1, "") + _field(2, 17))
    entries = {"receptive_radius": height // 2, "align": 1, "version": 1, **metadata}
    for key, value in entries.items():
        model += _field(14, _field(1, f"bn.{key}") + _field(2, str(value)))
    return model
