# SPDX-License-Identifier: Apache-2.0
"""Processor time to an error, on errors and costs made up, and the cost of a sample in the path tracer."""

import types

import pytest

from evidence.measure import equal_quality, gains
from evidence.renders import judge, views

COUNTS = (1, 4, 16, 64)
FACTORS = {"white": 1.0, "sobol": 0.5, "blue": 0.25, "mask": 2.0}
COST = {(scene, label): cost for scene in ("lens", "glossy") for label, cost in
        {"white": 0.5, "sobol": 1.0, "blue": 0.5, "mask": 0.5}.items()}


def made_up(own=0.0):
    """Errors fall with the root of the count, from the factor of the sampler."""
    chosen = [view for scene in ("lens", "glossy") for view in views.crops("core", (scene,), (64, 48), (8, 8))]
    cells = types.SimpleNamespace(get=lambda view, label, spp, measure: [FACTORS[label] * spp**-0.5] * 3)
    references = {view: types.SimpleNamespace(own={equal_quality.MEASURE: own}) for view in chosen}
    return gains.Gains(cells, references, tuple(FACTORS))


def gain(label, at=16, own=0.0):
    return equal_quality.time_gain(made_up(own), COST, COUNTS, label, equal_quality.MEASURE, at)


def test_time_is_that_of_the_samples_it_takes():
    # A quarter of the samples at twice the cost; a sixteenth at the same.
    assert gain("sobol").value == pytest.approx(2) and gain("blue").value == pytest.approx(16)
    assert (gain("blue").scenes, gain("blue").views, gain("blue").left_out) == (2, 8, 0)
    found = equal_quality.seconds_of(made_up(), COST, COUNTS, "blue", equal_quality.MEASURE, 64)
    assert list(found.values()) == [(pytest.approx(4 * 0.5), 64 * 0.5)] * 8


def test_what_is_not_reached_is_no_figure():
    assert gain("mask").value == pytest.approx(0.25) and gain("mask", 64) is None and gain("blue", own=1.0) is None
    _, rows = equal_quality.table_rows(made_up(), COST, COUNTS)
    assert {row[0]: row[4] for row in rows} == {"white": "32", "sobol": "16", "blue": "2", "mask": "not reached"}
    assert {row[0]: row[3] for row in rows}["blue"] == "16.00 (16.00 to 16.00)"


def test_costs_are_measured_once(pathtracer, tmp_path, monkeypatch):
    monkeypatch.setattr(equal_quality, "ROUNDS", 1)
    monkeypatch.setattr(equal_quality, "COST_SPP", 8)
    own = [views.crops("core", ("cornell",), (256, 256), (128, 128))[0]]
    store, chosen = judge.Store(tmp_path), ("white", "zorder")
    builds = judge.Builds(pathtracer, 1, store)
    found = equal_quality.costs(pathtracer, store, own, chosen, "a machine", builds)
    assert set(found) == {("cornell", "white"), ("cornell", "zorder")} and all(0.01 < cost < 1000 for cost in found.values())
    monkeypatch.setattr(equal_quality, "processor_seconds", None)
    assert equal_quality.costs(pathtracer, store, own, chosen, "a machine", builds) == found
