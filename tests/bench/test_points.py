# SPDX-License-Identifier: Apache-2.0
"""scripts/bench points: its measures on sets whose spectrum and error are known, and the report it writes."""

import sys

import numpy as np
import pytest

pytest.importorskip("bluenoise")
from report.masks import points  # noqa: E402


def test_integrals_are_right():
    u = (np.arange(1000) + 0.5) / 1000
    square = np.stack(np.meshgrid(u, u), -1)
    for name, (function, integral) in points.FUNCTIONS.items():
        assert function(square).mean() == pytest.approx(integral, rel=1e-3), name


def test_white_noise_has_the_variance_of_the_function():
    """2000 sets give the variance to 3 % (one standard deviation)."""
    rng = np.random.default_rng(0)
    function, integral = points.FUNCTIONS["disc (a step)"]
    found = points.variance(rng.random((2000, 8, 2)), function, integral, np.zeros((2000, 1, 2)))
    assert found == pytest.approx(integral * (1 - integral) / 8, rel=0.15)


def test_rate():
    counts = (16, 64, 256, 1024)
    assert points.rate(counts, [5 * n**-1.5 for n in counts]) == pytest.approx(1.5)


def test_spectra_of_a_lattice_and_of_white_noise():
    lattice = np.stack(np.meshgrid(np.arange(8) / 8, np.arange(8) / 8), -1).reshape(-1, 2)
    power = points.periodogram(lattice, 12)
    assert np.isnan(power[12, 0])
    peaks = {(v - 12, u) for v, u in zip(*np.nonzero(np.nan_to_num(power) > 1e-9))}
    assert peaks == {(v, u) for v in (-8, 0, 8) for u in (0, 8)} - {(0, 0)}
    assert power[12 + 8, 0] == pytest.approx(64)
    rng = np.random.default_rng(0)
    mean = np.mean([points.periodogram(rng.random((64, 2)), 12) for _ in range(300)], axis=0)
    frequency, ring = points.radial(mean, 3.0)
    assert len(ring) == 5 and np.allclose(frequency, [1.5, 4.5, 7.5, 10.5, 13.5][: len(ring)])
    np.testing.assert_allclose(ring, 1, atol=0.15)


def test_the_report(tmp_path, monkeypatch, capsys):
    pytest.importorskip("scipy")
    monkeypatch.setattr(points, "SPECTRUM_COUNT", 64)
    monkeypatch.setattr(sys, "argv", ["points", "--sets", "2", "--offsets", "3", "--most", "64", "--out", str(tmp_path)])
    points.main()
    text = (tmp_path / "points.md").read_text()
    assert text == capsys.readouterr().out[:-1]
    assert "`scripts/bench points --sets 2 --offsets 3 --most 64`" in text
    assert all(f"| {name} | " in text for name in points.SETS)
    assert (tmp_path / "points.png").stat().st_size < 60000
