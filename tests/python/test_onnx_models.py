# SPDX-License-Identifier: Apache-2.0
"""Models that ONNX Runtime rejects, and models it can run but libbn cannot use because their metadata or shapes are wrong."""

import os
import re

import numpy as np
import pytest
from helpers import needs_network
from onnx_file import _field, convolution, model, node, tensor, value

from bluenoise import NeuralGenerator

pytestmark = needs_network

KERNEL = np.full((1, 3, 3), 0.1)
ONE = convolution(KERNEL)
CONV = node("Conv", "noise,weights", "mask") + tensor("weights", (1, 1, 3, 3), bytes(36))


def quantiles(values):
    return ",".join(map(str, values))


# Whether a library older than the package's newest is tested (scripts/platforms).
OLD = bool(re.search(r"\.so\.1\.(19|2\d)\.", os.environ.get("BN_ONNXRUNTIME", "")))

# Valid and invalid values of metadata entries, and a model with the largest radius: its dilated convolution reads every 256th texel.
GOOD = {"align": [1, 64], "sparse_spacing": [1, 10000], "quantiles": [quantiles(range(-1000, 64000, 1000))]}
BAD = {"version": ["", "1.0"], "align": [0, 65, ""], "sparse_spacing": [0, 10001, 3.5],
       "receptive_radius": [257, -1, " 1", 2**32 + 1, "", 2],  # the model's actual radius is not 2
       "quantiles": [*map(quantiles, (range(64), range(66), [7] * 65, range(65, 0, -1))), ",", "0.5", "--1", "1,,2"]}
WIDE = model(node("Conv", "noise,weights", "mask", dilations=(256, 256)) + tensor("weights", (1, 1, 3, 3), bytes(36)),
             receptive_radius=256)


@pytest.mark.parametrize(("bytes_", "words"), [
    *((convolution(KERNEL, version=version), "not supported") for version in (0, 2)),
    *((convolution(KERNEL, **{key: value}), "bad data") for key, values in BAD.items() for value in values),
    (model(node("Transpose", "noise", "mask", perm=(0, 2, 1, 3)), outputs=value("mask", 12, (1, "h", 1, "w")), receptive_radius=0),
     "bad data"),
    (model(node("Concat", "noise,noise", "mask", axis=0), outputs=value("mask", 12, (2, 1, "h", "w")), receptive_radius=0), "bad data"),
    (model(CONV + node("Identity", "noise", "copy"), outputs=value("mask", 12) + value("copy", 12)), "bad data"),
    pytest.param(model(CONV, inputs=value("noise", 11, (1, 1, "w"))), "bad data",
                 marks=pytest.mark.skipif(OLD, reason="ONNX Runtime 1.19 to 1.22 aborts the process")),
    (model(CONV, inputs=value("noise", 11, (1, 2, "h", "w"))), "bad data"),
    (model(CONV, inputs=b""), "bad data"),
    (convolution(np.full((17, 3, 3), 0.1)), "bad data"),
    (convolution(np.full((1, 3, 3), np.nan)), "bad data"),
    (model(CONV, inputs=value("image", 11)), "bad data"),
    (model(CONV, inputs=value("noise", 11, element=10)), "bad data"),  # float16
    (model(CONV, inputs=value("noise", 11) + value("more", 11)), "bad data"),
    (model(node("NoSuchOperator", "noise", "mask")), "bad data"),
    (ONE[:len(ONE) // 2], "bad data"),
    (ONE + _field(7, CONV), "bad data"),
    (b"GIF89a\0", "bad data"),
])
def test_unusable_models_raise_without_output(bytes_, words, capfd):
    with pytest.raises(ValueError, match=words):
        NeuralGenerator(bytes_)
    assert capfd.readouterr() == ("", "")


def test_usable_models():
    assert NeuralGenerator(WIDE).channels == 1
    for key, values in GOOD.items():
        assert all(NeuralGenerator(convolution(KERNEL, **{key: value_})).channels == 1 for value_ in values)
    assert NeuralGenerator(convolution(np.full((16, 3, 3), 0.1))).channels == 16


def test_model_files(tmp_path):
    path = tmp_path / "a.onnx"
    path.write_bytes(ONE)
    assert NeuralGenerator(path).channels == 1
    for size in (len(ONE) // 2, 65 << 20):
        os.truncate(path, size)
        with pytest.raises(ValueError, match="bad data"):
            NeuralGenerator(path)
