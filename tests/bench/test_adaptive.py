# SPDX-License-Identifier: Apache-2.0
"""Adaptive against plain sampling: its measures, its figures from errors that are known, and a tiny complete run."""

import subprocess

import numpy as np
import pytest
from conftest import ROOT
from report.renders import adaptive
from report.renders.adaptive import Point


def test_errors_are_relative_and_as_displayed():
    reference = np.full((24, 32, 3), 0.2)
    picture = reference.copy()
    picture[::2, ::2] += 0.04  # a quarter of the pixels
    assert adaptive.relative_error(picture, reference, 0.0, 0.0) == pytest.approx(0.04 / 0.22 / 2)
    assert adaptive.relative_error(picture, reference, 1.0, 0.0) == pytest.approx(0.08 / 0.42 / 2)
    assert adaptive.relative_error(picture, reference, 0.0, 2.1) == pytest.approx(0.01 / 0.22, rel=0.01)
    assert adaptive.relative_error(picture, reference, 3.0, 0.0) == 0  # all of it is white
    assert adaptive.relative_error(np.full_like(reference, 0.01), 0 * reference, 0.0, 0.0) == pytest.approx(0.5)


def test_errors_between_counts_lie_on_straight_lines():
    points = [Point(n, {0.0: n**-0.5, 2.1: 1 / n}, 0.0) for n in (16, 64, 256)]
    for n in (16, 20, 100, 256):
        assert adaptive.error_at(points, n, 0.0) == pytest.approx(n**-0.5)
        assert adaptive.error_at(points, n, 2.1) == pytest.approx(1 / n)


def known_result():
    """Errors that fall as 1 / sqrt(n); adaptive ones are 0.8 times those of plain pictures, and blue's half of the others'."""
    result = {}
    for scene in adaptive.SCENES:
        for sampler in ("white", "sobol", "blue"):
            scale = 1.0 if sampler == "blue" else 2.0
            def at(n, factor=1.0, scale=scale):
                light = 0.001 if factor == 1 else 0.002
                return Point(n, {0.0: factor * scale * n**-0.5, 2.1: factor * scale * n**-0.5 / 4}, light)
            result[scene, sampler] = ([at(n) for n in adaptive.COUNTS], [at(n, 0.8) for n in (20, 50, 150)])
    return result


def test_figures_of_known_errors():
    result = known_result()
    for level in adaptive.LEVELS:
        for sampler in ("white", "blue"):
            for sigma in adaptive.SIGMAS:
                assert adaptive.over_plain(result, sampler, level, sigma) == pytest.approx(0.8)
        assert adaptive.over_blue(result, "white", level) == pytest.approx(2)
    text = adaptive.report_text(result, "scripts/bench adaptive", "")
    assert "| sobol (padded) | 20 | 0.80 | 0.80 | 2.00 | 50 | 0.80 | 0.80 | 2.00 | 150 |" in text
    assert "0.80 to 0.80 of the plain one with white" in text and "+0.100 % off" in text


def test_a_tiny_run(tmp_path, monkeypatch, pathtracer, capsys):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    for name, value in {"SCENES": {"penumbra": 0.0}, "WIDTH": 24, "HEIGHT": 16, "LEVELS": (0.3, 0.2), "LEAST": 4, "MOST": 32,
                        "COUNTS": (4, 8, 16, 32), "REFERENCE_SPP": 64}.items():
        monkeypatch.setattr(adaptive, name, value)
    words = ["--pathtracer", str(pathtracer), "--out", str(tmp_path)]
    measured, real = [], adaptive.measure
    monkeypatch.setattr(adaptive, "measure", lambda *given: measured.append(real(*given)) or measured[0])
    adaptive.run(words)
    text = (tmp_path / "adaptive.md").read_text()
    for name in ("white", "sobol (padded)", "zorder (declared 32)", "blue"):
        assert f"| {name} |" in text
    assert len(measured[0]) == 4
    for plain, adapted in measured[0].values():
        assert [point.samples for point in plain] == [4, 8, 16, 32]
        assert 4 <= adapted[0].samples <= adapted[1].samples <= 32 and adapted[0].samples < 32


def test_help_builds_nothing():
    done = subprocess.run([ROOT / "scripts" / "bench", "adaptive", "--help"], check=False, capture_output=True, text=True)
    assert done.returncode == 0 and "docs/report/adaptive.md" in done.stdout
