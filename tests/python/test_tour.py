# SPDX-License-Identifier: Apache-2.0
"""The code blocks of docs/tour.md run in order and print the output shown below them."""

import contextlib
import io
import re
from pathlib import Path

import numpy as np
import pytest

TOUR = Path(__file__).resolve().parents[2] / "docs" / "tour.md"
NUMBER = r"-?\d+\.\d+(?:e-\d+)?"


def test_tour_output_matches_the_page():
    pytest.importorskip("scipy")
    if not TOUR.exists():
        pytest.skip("the source distribution has no guides")
    blocks = re.findall(r"^```python\n(.*?)^```\n(?:\n```text\n(.*?)^```)?", TOUR.read_text(encoding="utf-8"), re.M | re.S)
    variables = {}
    assert len(blocks) == 4
    for code, shown in blocks:
        with contextlib.redirect_stdout(io.StringIO()) as output:
            exec(code, variables)
        printed = output.getvalue()
        assert re.sub(NUMBER, "", printed).split() == re.sub(NUMBER, "", shown).split(), printed
        # Other versions of SciPy may round differently.
        np.testing.assert_allclose(*(np.array(re.findall(NUMBER, text), float) for text in (printed, shown)), rtol=0.02, atol=0.002)
