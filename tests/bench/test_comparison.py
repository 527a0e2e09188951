# SPDX-License-Identifier: Apache-2.0
"""The comparison of two samplers on a page: no ratio from too few seeds or dominated by the reference's error."""

import json
import re

import pytest
from report.pages import comparison


def test_a_ratio_takes_seeds():
    for count in (1, comparison.SEEDS_FOR_RATIO - 1):
        found, why = comparison.judged([2.0] * count, [1.0] * count)
        assert found is None and "seeds" in why
    found, why = comparison.judged([2.0, 2.1, 1.9], [1.0, 1.0, 1.0])
    assert found.value == pytest.approx(2.0, rel=0.01) and why == ""


def test_a_ratio_is_above_the_references_own_error():
    above, below = [2.0, 2.1, 1.9], [1.0, 1.0, 1.0]
    assert comparison.judged(above, below, 0.33)[0] is not None
    found, why = comparison.judged(above, below, 0.34)
    assert found is None and "0.34" in why


def test_numbers_beside_each_other_are_rounded_alike():
    assert comparison.evenly([0.03, 0.0188]) == ["0.0300", "0.0188"]
    assert comparison.evenly([0.09996, 2]) == ["0.100", "2.000"]
    assert comparison.evenly([123.4, 5678]) == ["123", "5678"]
    assert comparison.evenly([0, 0.5]) == ["0.000", "0.500"] and comparison.evenly([0.0]) == ["0.00"]
    text = comparison.verdict("white", "blue", {"white": [0.03] * 3, "blue": [0.0188] * 3}, 0.0)
    assert "white 0.0300, blue 0.0188." in text


def test_verdict_names_the_better_one_and_how_sure_that_is():
    errors = {"white": [2.0, 2.1, 1.9], "blue": [1.0, 1.0, 1.0], "sobol": [1.0, 0.9, 1.1]}
    for left, right in (("white", "blue"), ("blue", "white")):
        text = comparison.verdict(left, right, errors, 0.0)
        low, high = map(float, re.search(r"of blue is 2.00 times smaller \((.*) to (.*) over 3 seeds\)", text).groups())
        assert low < 2 < high
    assert comparison.verdict("blue", "sobol", errors, 0.0).endswith("No significant difference over 3 seeds.")
    assert "smaller" not in comparison.verdict("white", "blue", {"white": [2.0], "blue": [1.0]}, 0.0)


def test_widget_has_a_text_for_every_two():
    samplers = {"white": ("data:,w", [2.0, 2.1, 1.9]), "blue": ("data:,b", 1.0)}
    text = comparison.widget("box", (4, 3), "data:,r", {1: samplers})
    data = json.loads(re.search(r"<script type=.application/json. id=compare-data>(.*?)</script>", text)[1])
    notes = data["counts"]["1"]["notes"]
    names = ("white", "blue", "reference")
    for left in names:
        for right in names:
            assert notes.get(f"{left}|{right}") or notes[f"{right}|{left}"]
    assert "</script>" not in comparison.widget("</script>", (1, 1), "", {1: samplers}).split("id=compare-data>")[1].split("</script>")[0]
