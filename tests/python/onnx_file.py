# SPDX-License-Identifier: Apache-2.0
"""Writes ONNX models. The field numbers are taken from onnx.proto."""

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


def value(name, number, shape=(1, 1, "h", "w"), element=1):
    axes = b"".join(_field(1, _field(1 if isinstance(axis, int) else 2, axis)) for axis in shape)
    return _field(number, _field(1, name) + _field(2, _field(1, _field(1, element) + _field(2, axes))))


def node(operator, inputs, outputs, **attributes):
    body = b"".join(_field(1, name) for name in inputs.split(",")) + b"".join(_field(2, name) for name in outputs.split(","))
    for name, given in attributes.items():
        several = isinstance(given, tuple)
        values = b"".join(_field(8, each) for each in given) if several else _field(3, given)
        body += _field(5, _field(1, name) + values + _field(20, 7 if several else 2))
    return _field(1, body + _field(4, operator))


def tensor(name, extents, data):
    """A float tensor of shape `extents`."""
    return _field(5, b"".join(_field(1, extent) for extent in extents) + _field(2, 1) + _field(8, name) + _field(9, data))


def model(graph, inputs=value("noise", 11), outputs=value("mask", 12), **metadata):
    entries = {"receptive_radius": 1, "align": 1, "version": 1, **metadata}
    return (_field(1, 8) + _field(7, graph + inputs + outputs) + _field(8, _field(1, "") + _field(2, 17))
            + b"".join(_field(14, _field(1, f"bn.{key}") + _field(2, str(entry))) for key, entry in entries.items()))


def convolution(kernels, **metadata):
    """The bytes of a model that convolves the noise with float32 kernels of shape (channels, 2r + 1, 2r + 1)."""
    kernels = np.asarray(kernels, "<f4")
    channels, height, width = kernels.shape
    graph = node("Conv", "noise,weights", "mask") + tensor("weights", (channels, 1, height, width), kernels.tobytes())
    metadata = {"receptive_radius": height // 2, **metadata}
    return model(graph, outputs=value("mask", 12, (1, channels, "h", "w")), **metadata)
