# SPDX-License-Identifier: Apache-2.0
"""Figures in the prose of pages are those of the tables they come from, and the first tables those of the committed results."""

import re
from pathlib import Path

import pytest

from evidence.renders import summary

ROOT = Path(__file__).resolve().parents[2]
FIGURE = r"(?<![\d.])\d*\.\d\d(?!\d)"
# Page, how its paragraph begins, and the page of the tables.
CLAIMS = [("docs/mitsuba.md", "*A part of the Cornell box", "docs/mitsuba.md"), ("docs/mitsuba.md", "Figures are root mean", "docs/mitsuba.md"),
          ("evidence/results/realtime.md", "- **Masks win**", "evidence/results/realtime.md"), ("evidence/results/realtime.md", "- **`blue` wins**", "evidence/results/realtime.md"),
          ("examples/cycles/README.md", "As displayed, Tabulated", "evidence/results/cycles.md"),
          ("examples/pbrt/README.md", "As displayed after", "evidence/results/pbrt.md"), ("examples/pbrt/README.md", "A sample with", "evidence/results/pbrt.md"),
          ("evidence/results/samplers.md", "After a blur of", "evidence/results/samplers.md")]


def test_the_first_tables_are_those_of_the_results():
    parts, _ = summary.read_parts(ROOT / "evidence/results")
    for page, table in (("evidence/README.md", summary.table(parts)), ("README.md", summary.short_table(parts))):
        assert table in (ROOT / page).read_text(encoding="utf-8"), f"{page}: run scripts/bench summary"


def figures(text):
    return {float(word) for word in re.findall(FIGURE, text)}


def paragraph(page, start):
    (found,) = [part for part in re.split(r"\n\n|\n(?=- )", (ROOT / page).read_text(encoding="utf-8")) if part.startswith(start)]
    return found


@pytest.mark.parametrize("page, start, source", CLAIMS)
def test_figures_of_prose_are_in_the_tables(page, start, source):
    tables = "\n".join(line for line in (ROOT / source).read_text(encoding="utf-8").splitlines() if line.startswith("|"))
    claimed = figures(paragraph(page, start))
    assert claimed and claimed - figures(tables) == set()
