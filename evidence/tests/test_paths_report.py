# SPDX-License-Identifier: Apache-2.0
"""Experiments on decisions: all ways of one estimate the same integral, and what docs/paths.md advises is best."""

import re
from pathlib import Path

import numpy as np
import pytest

from evidence.samplers import paths

bluenoise = pytest.importorskip("bluenoise")
REPORT = (Path(__file__).resolve().parents[2] / "evidence" / "results" / "paths.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", paths.EXPERIMENTS)
def test_all_ways_estimate_one_integral(name):
    """Means over 64 x 64 pixels and 16 samples; a shift of 0.03 would be found."""
    ways = paths.EXPERIMENTS[name](np.random.default_rng(100))
    size = 128 if name == "transparency" else 64
    means = {}
    for way, values in ways.items():
        found = []
        for index in range(16):
            path = paths.paths("blue", 3, index, size)
            found.append(np.mean(values(path, index) if values.__code__.co_argcount == 2 else values(path)))
        means[way] = np.mean(found)
    assert max(means.values()) - min(means.values()) < 0.012, means


@pytest.fixture(scope="module")
def tables():
    """{experiment: {way: [error at each count]}} of the report."""
    found = {}
    for name in paths.EXPERIMENTS:
        text = REPORT.split(f"<!-- table: {paths.COMMAND}: {name} -->\n")[1].split("<!-- end")[0]
        rows = re.findall(r"^\| (.*?) \| ([\d.]+) \| ([\d.]+) \| ([\d.]+) \|$", text, re.M)
        found[name] = {way: [float(number) for number in numbers] for way, *numbers in rows}
    return found


def test_what_the_guide_advises_is_best(tables):
    """At 16 samples, against all other ways but those it names as alike."""
    for name, alike in (("lights", ()), ("environment map", ()), ("coin", ()), ("light tree", ()), ("free flight", ()),
                        ("wavelength", ()), ("time and lens", ("time from `next_1d()`",))):
        first, *others = tables[name].items()
        assert all(first[1][2] < numbers[2] for way, numbers in others if not way.endswith(alike)), name
    splitting = list(tables["splitting"].values())
    fixed, running, others = splitting[0][2], splitting[3][2], [row[2] for row in splitting[4:]]
    assert running < 1.15 * fixed and running < min(others) * 2 / 3
