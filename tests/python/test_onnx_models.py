# SPDX-License-Identifier: Apache-2.0
"""Models are refused before a runtime sees them: what is damaged, what could reach beyond the file, and small files that would
take gigabytes. What is accepted gets as far as the runtime, which is not there."""

import os

import numpy as np
import pytest
from onnx_file import _field, convolution, model, node, tensor, value

import bluenoise
from bluenoise import NeuralGenerator, RuntimeMissingError

pytestmark = pytest.mark.skipif(not hasattr(bluenoise._core, "NeuralGenerator"), reason="a build with BN_NEURAL=OFF")

GOOD, BAD, UNSUPPORTED = "good", "bad data", "not supported"
KERNEL = np.full((1, 3, 3), 0.1)
ONE = convolution(KERNEL)


def verdict(model):
    try:
        NeuralGenerator(model, runtime="nowhere.so")
    except RuntimeMissingError:
        return GOOD
    except ValueError as error:
        return next(words for words in (BAD, UNSUPPORTED) if words in str(error))


def quantiles(count, first, step):
    return ",".join(str(first + i * step) for i in range(count))


@pytest.mark.parametrize("key", ["receptive_radius", "align", "version"])
@pytest.mark.parametrize("value", ["", "-1", " 1", "1 ", "1.0", "x", "1234567890"])
def test_metadata_that_are_no_numbers(key, value):
    assert verdict(convolution(KERNEL, **{key: value})) == BAD


@pytest.mark.parametrize(("key", "value", "expected"), [
    ("receptive_radius", 0, GOOD), ("receptive_radius", 256, GOOD), ("receptive_radius", 257, BAD),
    ("receptive_radius", 999999999, BAD), ("receptive_radius", None, BAD), ("align", None, BAD),
    ("version", None, BAD), ("align", 0, BAD), ("align", 64, GOOD), ("align", 65, BAD),
    ("version", 0, UNSUPPORTED), ("version", 2, UNSUPPORTED),
    ("sparse_spacing", 1, GOOD), ("sparse_spacing", 10000, GOOD), ("sparse_spacing", 10001, BAD),
    ("sparse_spacing", 0, BAD), ("sparse_spacing", 3.5, BAD), ("sparse_spacing", "", BAD),
    ("quantiles", quantiles(65, -1000, 1000), GOOD), ("quantiles", quantiles(65, 7, 0), BAD),
    ("quantiles", quantiles(65, 100000, -1), BAD), ("quantiles", quantiles(64, 0, 1), BAD),
    ("quantiles", quantiles(66, 0, 1), BAD), ("quantiles", "0,2,1," + quantiles(62, 3, 1), BAD),
    *(("quantiles", text, BAD) for text in ("", ",", "1", "0.5", "-", "--1", "1,,2")),
])
def test_ranges_of_metadata(key, value, expected):
    assert verdict(convolution(KERNEL, **{key: value})) == expected


def test_a_key_that_comes_twice():
    assert verdict(ONE + _field(14, _field(1, "bn.align") + _field(2, "1"))) == BAD


# ---- Graphs that are written node by node

WEIGHTS = tensor("weights", (1, 1, 3, 3), bytes(36))
CONV = node("Conv", "noise,weights", "mask") + WEIGHTS
NODE = _field(1, "noise") + _field(1, "weights") + _field(2, "mask") + _field(4, "Conv")


@pytest.mark.parametrize(("bytes_", "expected"), [
    (model(CONV), GOOD),
    (model(CONV, outputs=value("mask", 12, (1, 16, "h", "w"))), GOOD),
    (model(CONV, outputs=value("mask", 12, (1, 17, "h", "w"))), BAD),
    (model(CONV, outputs=value("mask", 12, (1, 0, "h", "w"))), BAD),
    (model(CONV, inputs=value("image", 11)), BAD),
    (model(CONV, inputs=value("noise2", 11)), BAD),
    (model(CONV, outputs=value("", 12)), BAD),
    (model(CONV, outputs=value("a" * 128, 12)), BAD),
    (model(CONV, inputs=value("noise", 11, (1, 2, "h", "w"))), BAD),
    (model(CONV, inputs=value("noise", 11, (1, 1, 64, 64))), BAD),
    (model(CONV, inputs=value("noise", 11, element=10)), BAD),  # float16
    (model(CONV, inputs=value("noise", 11) + value("more", 11)), BAD),
    (model(CONV, outputs=2 * value("mask", 12)), BAD),
    (model(CONV, more=_field(7, CONV)), BAD),
    (model(WEIGHTS), BAD),
    # What could reach beyond the file.
    (model(node("Conv", "noise,weights", "mask") + tensor("weights", (1, 1, 3, 3), b"", _field(14, 1))), UNSUPPORTED),
    (model(node("Conv", "noise,weights", "mask") + tensor("weights", (1, 1, 3, 3), bytes(36), _field(13, ""))), UNSUPPORTED),
    (model(node("Conv", "noise,weights", "mask", "com.example") + WEIGHTS), UNSUPPORTED),
    (model(node("Conv", "noise,weights", "mask", "ai.onnx.ml") + WEIGHTS), UNSUPPORTED),
    (model(CONV + _field(15, "")), UNSUPPORTED),
    (model(CONV, more=_field(20, "")), UNSUPPORTED),
    (model(CONV, more=_field(25, "")), UNSUPPORTED),
    # In an attribute a tensor, which may be there, or a graph, graphs, a sparse tensor, sparse tensors.
    *((model(WEIGHTS + _field(1, NODE + _field(5, _field(1, "any") + _field(number, "")))), GOOD if number == 5 else UNSUPPORTED)
      for number in (5, 6, 11, 22, 23)),
])
def test_graphs(bytes_, expected, capfd):
    assert verdict(bytes_) == expected
    assert capfd.readouterr() == ("", "")


# ---- Memory


def doubled(times, operator):
    """Each value is twice as large as the one before."""
    names = ["noise", *(f"v{i}" for i in range(times - 1)), "last"]
    return b"".join(node(operator, f"{a},{a}", b, axis=1 - 2 * (i % 2)) for i, (a, b) in enumerate(zip(names, names[1:])))


def convolved(channels, **attributes):
    return tensor("weights", (channels, 1, 3, 3)) + node("Conv", "noise,weights", "deep", **attributes)


def padded(*pads):
    return WEIGHTS + node("Conv", "noise,weights", "last", **{f"pads{'_' * i}": pad for i, pad in enumerate(pads)})


CHAIN = b"".join(node("Relu", f"v{i}" if i else "deep", f"v{i + 1}") for i in range(59))


@pytest.mark.parametrize(("graph", "expected"), [
    (tensor("last", (30000, 30000), bytes(4)), UNSUPPORTED),  # weights without data
    (doubled(30, "Concat"), UNSUPPORTED),
    (tensor("many", (50, 1, 1, 1), bytes(200)) + node("Add", "noise,many", "last"), UNSUPPORTED),  # a batch
    (node("DepthToSpace", "noise", "last", blocksize=100), UNSUPPORTED),
    (tensor("deep", (5000, 1, 1)) + node("Add", "noise,deep", "last"), UNSUPPORTED),  # broadcast
    (convolved(2000) + node("Relu", "deep", "last"), UNSUPPORTED),
    (padded((0, 50000, 0, 50000)), UNSUPPORTED),
    (WEIGHTS + node("ConvTranspose", "noise,weights", "last", strides=(200, 200)), UNSUPPORTED),
    (convolved(64) + tensor("wide", (64, 64, 1, 1)) + node("ConvTranspose", "deep,wide", "last", group=64), UNSUPPORTED),
    # All of the values are used at the end, so all are alive at once.
    (convolved(32) + CHAIN + node("Sum", ",".join(f"v{i + 1}" for i in range(59)), "last"), UNSUPPORTED),
    # Two attributes of one name, of which a runtime might take either.
    (padded((0, 0, 0, 0), (90000,) * 4), UNSUPPORTED),
    (node("NoSuchOperator", "noise", "last"), UNSUPPORTED),
    (node("Relu", "nowhere", "last"), BAD),
    (doubled(40, "Add"), GOOD),
    (convolved(64) + tensor("one", (1,), bytes(4)) + node("Clip", "deep,,one", "clipped") + node("Mul", "clipped,one", "scaled")
     + node("GlobalAveragePool", "scaled", "means") + node("Mul", "scaled,means", "last"), GOOD),
])
def test_memory_is_bounded(graph, expected):
    assert verdict(model(graph + node("Identity", "last", "mask"))) == expected


# ---- Damage


def test_a_model_that_is_cut_short_is_refused():
    assert {verdict(ONE[:size]) for size in range(1, len(ONE) - 20)} == {BAD}


def test_flipped_bits_are_refused_or_harmless():
    refused = 0
    for at in range(len(ONE)):
        for bit in range(8):
            damaged = bytearray(ONE)
            damaged[at] ^= 1 << bit
            refused += verdict(damaged) != GOOD
    assert refused > len(ONE)


@pytest.mark.parametrize("bytes_", [
    b"GIF89a\0", b"\x08\0", b"\x3a\0", b"\0\0\0\0", b"{}\0",
    # A length near the end of the address space, a varint that never ends, and groups.
    b"\x3a" + 9 * b"\xff" + b"\x01\0", b"\x08" + 10 * b"\xff" + b"\x01", b"\x3b\x3c" + bytes(10)])
def test_what_is_no_model(bytes_):
    assert verdict(bytes_) == BAD


def test_files(tmp_path):
    path = tmp_path / "a.onnx"
    path.write_bytes(ONE)
    assert verdict(path) == GOOD
    for size in (len(ONE) - 21, 65 << 20):
        os.truncate(path, size)
        assert verdict(path) == BAD
