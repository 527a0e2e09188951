# SPDX-License-Identifier: Apache-2.0
"""scripts/bench stop: a tiny run, whose figures match a separate render, and the unit of visible noise."""

import csv
import dataclasses

import numpy as np
import pytest

from evidence.base.files import read_exr
from evidence.measure.image_error import visible_error
from evidence.renders import judge, stop, views
from evidence.renders.renderer import run_pathtracer


def test_tiny_run(bench, pathtracer, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(stop, "CAP", 16)
    monkeypatch.setattr(stop, "RULES", {"--visible-noise": (1.0, 2.0), "--noise": (0.1,)})
    monkeypatch.setattr(stop, "LEVELS", (0.1,))
    bench("stop", "--crop", "20x30", "--samplers", "blue", "--spp", 8, "--seeds", 1)
    out = tmp_path / "out"
    text = capsys.readouterr().out
    assert (out / "stop.md").read_text(encoding="utf-8").strip() == text.strip() and "scripts/bench stop" in text and (out / "stop.png").is_file()
    with open(out / "stop.csv", newline="", encoding="utf-8") as file:
        rows = {(row["what"], row["sampler"], float(row["at"])): row for row in csv.DictReader(file)}
    assert 0.3 < float(rows["estimate", "white", 8]["estimate"]) / float(rows["estimate", "white", 8]["noise"]) < 3
    one, two = (float(rows["--visible-noise", "white", steps]["samples"]) for steps in (1, 2))
    assert 4 <= two <= one <= 16 and float(rows["--visible-noise", "white", 2]["noise_95"]) > 0
    assert {row["sampler"] for row in rows.values() if row["what"] == "--noise"} == {"sobol", "blue"}

    # One row against a render of its own.
    view = stop.aligned(views.crops("held-out", ("penumbra",), (64, 64), (20, 30))[0])
    assert view.size == (32, 32) and all(start % 16 == 0 for start in view.crop)
    reference = judge.render_reference(pathtracer, view, 64)
    run_pathtracer(pathtracer, [*dataclasses.replace(view.request("white", 8)).arguments(), "--quiet", "-o", tmp_path / "one.exr"])
    noise = visible_error(read_exr(tmp_path / "one.exr")[0], reference.picture)
    (row, *_) = [row for row in stop.Stops(pathtracer, "stop", 1).estimated(judge.Task(view, "white", 0, (2, 4, 8)), reference) if row["spp"] == 8]
    assert row["noise"] == pytest.approx(np.sqrt(np.mean(noise**2)), rel=1e-4)
    blocks = stop.block_noise(read_exr(tmp_path / "one.exr")[0], reference.picture, 0.0)
    assert len(blocks) == 4 and stop.rms(blocks) == pytest.approx(row["noise"], rel=1e-4)


def test_steps_are_those_of_an_8_bit_display():
    """A display's neighbouring values differ by one step, everywhere on the curve."""
    codes = np.arange(256) / 255
    light = np.where(codes <= 0.04045, codes / 12.92, ((codes + 0.055) / 1.055) ** 2.4)
    flat = [np.full((8, 8, 1), value) for value in light]
    steps = [visible_error(one, other).mean() for one, other in zip(flat[1:], flat)]
    np.testing.assert_allclose(steps, 1, atol=1e-3)
    assert visible_error(flat[255] * 3, flat[255]).max() == 0  # both are white
