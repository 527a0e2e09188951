# SPDX-License-Identifier: Apache-2.0
"""Models that ONNX Runtime rejects, and those that it runs but libbn cannot use. tests/c/test_neural.c checks every rule."""

import os

import numpy as np
import pytest
from onnx_file import _field, convolution, model, node, tensor, value

import bluenoise
from bluenoise import NeuralGenerator

pytestmark = pytest.mark.skipif(not hasattr(bluenoise._core, "NeuralGenerator"), reason="a build with BN_NEURAL=OFF")

KERNEL = np.full((1, 3, 3), 0.1)
ONE = convolution(KERNEL)
CONV = node("Conv", "noise,weights", "mask") + tensor("weights", (1, 1, 3, 3), bytes(36))


@pytest.mark.parametrize(("bytes_", "words"), [
    (convolution(KERNEL, version=2), "not supported"),
    (convolution(KERNEL, receptive_radius=257), "bad data"),
    (convolution(KERNEL, receptive_radius=2), "bad data"),  # not what the model does
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
def test_what_cannot_be_used_gets_one_line(bytes_, words, capfd):
    with pytest.raises(ValueError, match=words):
        NeuralGenerator(bytes_)
    assert capfd.readouterr() == ("", "")


def test_what_can_be_used():
    assert NeuralGenerator(ONE).channels == 1
    assert NeuralGenerator(convolution(np.full((16, 3, 3), 0.1))).channels == 16


def test_files(tmp_path):
    path = tmp_path / "a.onnx"
    path.write_bytes(ONE)
    assert NeuralGenerator(path).channels == 1
    for size in (len(ONE) // 2, 65 << 20):
        os.truncate(path, size)
        with pytest.raises(ValueError, match="bad data"):
            NeuralGenerator(path)
