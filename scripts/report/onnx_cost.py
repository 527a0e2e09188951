# SPDX-License-Identifier: Apache-2.0
"""The cost of a network: a small ONNX reader, without dependencies, that counts operations per texel.

It counts two operations per weight of a convolution, one per bias, and one per value computed by other operators; copies
(concatenation, slices) are free. Margins are ignored. Field numbers are those of onnx.proto."""

COPIES = {"Concat", "Slice", "Identity", "Split", "Constant", "Reshape", "Shape", "Gather", "Unsqueeze", "Squeeze", "Cast",
          "Pad", "Transpose", "Expand"}


def _varint(data, at):
    value = shift = 0
    while True:
        byte = data[at]
        at += 1
        value |= (byte & 127) << shift
        shift += 7
        if byte < 128:
            return value, at


def fields(data):
    """The (number, value) pairs of a message; length-delimited values are bytes."""
    at = 0
    while at < len(data):
        key, at = _varint(data, at)
        if key & 7 == 0:
            value, at = _varint(data, at)
        elif key & 7 == 2:
            size, at = _varint(data, at)
            value, at = data[at : at + size], at + size
        else:
            size = {1: 8, 5: 4}[key & 7]
            value, at = data[at : at + size], at + size
        yield key >> 3, value


def _all(message, number):
    return [value for field, value in fields(message) if field == number]


def _text(message, number):
    return next((value.decode() for value in _all(message, number)), "")


def _dims(tensor):
    dims = []
    for value in _all(tensor, 1):
        if isinstance(value, int):
            dims.append(value)
        else:  # packed
            at = 0
            while at < len(value):
                number, at = _varint(value, at)
                dims.append(number)
    return dims


def metadata(model):
    """The entries of a model's metadata."""
    return {_text(entry, 1): _text(entry, 2) for entry in _all(model, 14)}


def cost(model):
    """(operations per texel, number of weights) of a model's bytes."""
    (graph,) = _all(model, 7)
    shapes = {_text(tensor, 8): _dims(tensor) for tensor in _all(graph, 5)}
    for node in _all(graph, 1):
        if _text(node, 4) == "Constant":
            tensors = [tensor for attribute in _all(node, 5) for tensor in _all(attribute, 5)]
            shapes[_text(node, 2)] = _dims(tensors[0]) if tensors else []
    weights = sum(_product(shape) for shape in shapes.values())
    channels, operations = {"noise": 1}, 0
    for node in _all(graph, 1):
        inputs, outputs = ([name.decode() for name in _all(node, number)] for number in (1, 2))
        kind = _text(node, 4)
        made = max((channels.get(name, 1) for name in inputs), default=1)
        if kind == "Conv":
            kernel = shapes[inputs[1]]
            made = kernel[0]
            operations += 2 * _product(kernel) + (made if len(inputs) > 2 else 0)
        elif kind == "Concat":
            made = sum(channels.get(name, 1) for name in inputs)
        elif kind not in COPIES:
            for name in inputs:  # a constant with several channels broadcasts
                shape = shapes.get(name, [])
                if len(shape) >= 3:
                    made = max(made, shape[-3])
            if kind.startswith("Reduce"):
                operations += made
                made = 1
            else:
                operations += made
        for name in outputs:
            channels[name] = made
    return operations, weights


def _product(shape):
    product = 1
    for extent in shape:
        product *= extent
    return product
