# SPDX-License-Identifier: Apache-2.0
"""The programs in examples/python do what docs/masks.md shows."""

import importlib.util
import sys
from pathlib import Path

import numpy as np
import pytest

FOLDER = Path(__file__).resolve().parents[2] / "examples" / "python"


def load(name):
    pytest.importorskip("scipy")
    if not FOLDER.exists():
        pytest.skip("the source distribution has no examples")
    spec = importlib.util.spec_from_file_location(name, FOLDER / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def run(module, monkeypatch, *arguments):
    pytest.importorskip("matplotlib")
    monkeypatch.setattr(sys, "argv", [module.__name__, *map(str, arguments)])
    module.main()


# A square of two large triangles beside one of many small ones
def square():
    x, y = np.meshgrid(np.linspace(1, 2, 17), np.linspace(0, 1, 17))
    fine = np.stack([x, y, 0 * x], -1).reshape(-1, 3)
    i = (np.arange(16)[:, None] * 17 + np.arange(16)).reshape(-1) + 4
    triangles = [[0, 1, 2], [0, 2, 3], *np.stack([i, i + 1, i + 18], 1), *np.stack([i, i + 18, i + 17], 1)]
    return np.concatenate([[[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], fine]).astype(float), np.array(triangles)


def test_points_lie_on_the_mesh_as_its_area_demands():
    """5000 white points: six standard deviations, a false alarm in 5e8."""
    module = load("mesh_points")
    points, chosen = module.white_points(*square(), 5000, 1)
    assert (points[:, 2] == 0).all() and ((points[:, :2] >= 0) & (points[:, :2] <= (2, 1))).all()
    assert ((points[:, 0] <= 1) == (chosen < 2)).all()
    assert abs((points[:, 0] < 1).sum() - 2500) < 6 * np.sqrt(1250)
    assert abs((points[:, 0] + points[:, 1] < 1).sum() - 1250) < 6 * np.sqrt(940)


def test_elimination_leaves_points_apart():
    module = load("mesh_points")
    points, chosen = module.blue_points(*square(), 400)
    assert points.shape == (400, 3) and chosen.shape == (400,)
    apart = np.linalg.norm(points[:, None] - points, axis=2) + 9 * np.eye(400)
    # Of the largest possible distance, that of a hexagonal lattice; white noise has 0.03.
    assert apart.min() / np.sqrt(2 * 2 / (np.sqrt(3) * 400)) > 0.5
    # White noise would differ by more than this in half of all cases.
    assert abs((points[:, 0] < 1).sum() - 200) < 8


def test_a_mesh_from_a_file(tmp_path, monkeypatch):
    module = load("mesh_points")
    path = tmp_path / "mesh.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//1 4//1\nf -4 -3 -2\n")
    vertices, triangles = module.read_obj(path)
    assert vertices.shape == (4, 3) and triangles.tolist() == [[0, 1, 2], [0, 2, 3], [0, 1, 2]]
    run(module, monkeypatch, "--obj", path, "--count", 50, "-o", tmp_path / "a.png")
    assert (tmp_path / "a.png").stat().st_size > 1000


def test_a_blue_mask_has_less_noise_at_low_frequencies(tmp_path, monkeypatch, capsys):
    module = load("audio_dither")
    run(module, monkeypatch, "-o", tmp_path / "a.png", "--seconds", 1, "--wav", tmp_path / "wav")
    rows = [line.split("|")[1:4] for line in capsys.readouterr().out.splitlines()[2:]]
    noise = {name.strip(): (float(low), float(total)) for name, low, total in rows}
    assert list(noise) == ["none", "white noise", "blue mask"]
    assert noise["blue mask"][0] < noise["white noise"][0] - 3
    assert noise["blue mask"][1] == pytest.approx(noise["white noise"][1], abs=0.5)
    assert len(list((tmp_path / "wav").glob("*.wav"))) == 3 and (tmp_path / "a.png").exists()
