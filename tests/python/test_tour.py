# SPDX-License-Identifier: Apache-2.0
"""The notebook runs unchanged and prints the stored output."""

import contextlib
import io
import json
import re
from pathlib import Path

import numpy as np
import pytest

NOTEBOOK = Path(__file__).resolve().parents[2] / "examples" / "python" / "tour.ipynb"


@pytest.fixture(scope="module")
def cells():
    if not NOTEBOOK.exists():
        pytest.skip("the source distribution has no examples")
    return json.loads(NOTEBOOK.read_text(encoding="utf-8"))["cells"]


@pytest.fixture(scope="module")
def printed(cells):
    """The output of each cell."""
    pytest.importorskip("scipy")
    plt = pytest.importorskip("matplotlib.pyplot")
    variables, printed = {}, {}
    with pytest.MonkeyPatch.context() as patch:
        plt.switch_backend("Agg")
        patch.setattr(plt, "show", lambda: plt.close("all"))
        for cell in cells:
            if cell["cell_type"] == "code":
                with contextlib.redirect_stdout(io.StringIO()) as output:
                    exec(compile("".join(cell["source"]), cell["id"], "exec"), variables)
                printed[cell["id"]] = output.getvalue()
    return printed


def stored(cell):
    return "".join("".join(output["text"]) for output in cell["outputs"] if output["output_type"] == "stream")


def numbers(text):
    """The decimal fractions in a text, with the error that rounding and different arithmetic may add to each."""
    found = re.findall(r"\d+\.(\d+)", text), np.array(re.findall(r"\d+\.\d+", text), float)
    return found[1], np.array([1.1 * 0.1 ** len(digits) for digits in found[0]]) + 0.01 * found[1]


def test_it_prints_what_is_stored(cells, printed):
    assert len(printed) == 5
    for cell in cells:
        if cell["cell_type"] == "code":
            expected, tolerance = numbers(stored(cell))
            values, _ = numbers(printed[cell["id"]])
            assert re.sub(r"\d+\.\d+", "", printed[cell["id"]]).split() == re.sub(r"\d+\.\d+", "", stored(cell)).split(), cell["id"]
            assert (np.abs(values - expected) <= tolerance).all(), cell["id"]
