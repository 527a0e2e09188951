# SPDX-License-Identifier: Apache-2.0
"""The comparison with Mitsuba: its statistics on synthetic data, its scenes, and a small run if Mitsuba is installed."""

import sys

import numpy as np
import pytest
from report.others import correctness
from report.others.correctness_scenes import SCENES, ball, box, write_obj


def pictures(rng, seeds=8, mean=1.0, size=(48, 64)):
    """Noisy pictures; the exponential distribution has a tail like rendered noise."""
    return [mean * rng.exponential(size=(*size, 3)) for _ in range(seeds)]


def test_equal_renderers_agree():
    """180 comparisons of 48 blocks in three channels at a false-alarm rate of 1 %: more than 8 alarms in less than one run in 1000."""
    rng = np.random.default_rng(3)
    alarms = sum(not correctness.compare(pictures(rng), pictures(rng), 0.0).agrees for _ in range(180))
    assert alarms <= 8
    assert correctness.compare(pictures(rng), pictures(rng), 0.0).scatter == pytest.approx(1, abs=0.2)


def test_a_block_that_differs_is_found():
    rng = np.random.default_rng(4)
    ours, theirs = pictures(rng, 16), pictures(rng, 16)
    for picture in ours:
        picture[8:16, 16:24, 1] *= 1.5
    found = correctness.compare(ours, theirs)
    assert found.outside == 1 and found.worst > found.limit and found.block_count == 48


def test_a_difference_within_the_tolerance_is_none():
    rng = np.random.default_rng(5)
    ours, theirs = (pictures(rng, 32, mean) for mean in (1.1, 1.0))
    assert not correctness.compare(ours, theirs, 0.0).agrees and correctness.compare(ours, theirs, 0.1).agrees
    found = correctness.compare(ours, theirs)
    assert np.all(np.abs(found.ratio - 1.1) < 4 * found.error) and np.all(found.error < 0.01)


def test_blocks_are_whole():
    picture = np.arange(10 * 17 * 3, dtype=float).reshape(10, 17, 3)
    means = correctness.block_means(picture)
    assert means.shape == (1, 2, 3) and means[0, 1, 2] == picture[:8, 8:16, 2].mean()


@pytest.mark.parametrize("faces, area", [(box((0.2, 0.5, -0.1), (0.3, 0.5, 0.2), 18), 2 * (0.6 + 0.4 + 0.24)),
                                         (ball((0, 1, 0), 0.5), 3.1)])
def test_solids_are_closed_and_face_outward(faces, area):
    middle = np.mean([corner for face in faces for corner in face], axis=0)
    normals, edges = [], {}
    for face in faces:
        points = np.array(face)
        normal = sum(np.cross(points[i] - points[0], points[i + 1] - points[0]) for i in range(1, len(points) - 1)) / 2
        assert np.dot(normal, points.mean(0) - middle) > 0
        normals.append(np.linalg.norm(normal))
        for a, b in zip(face, face[1:] + face[:1]):
            key = tuple(np.round(a, 9)), tuple(np.round(b, 9))
            edges[key] = edges.get(key, 0) + 1
    assert sum(normals) == pytest.approx(area, rel=0.02)
    assert all(count == 1 and edges.get(key[::-1]) == 1 for key, count in edges.items())


@pytest.mark.parametrize("scene", SCENES, ids=lambda scene: scene.name)
def test_the_path_tracer_reads_every_scene(scene, pathtracer, tmp_path):
    picture, = correctness.our_pictures(pathtracer, scene, tmp_path, (16, 16), 16, "sobol", 1)
    assert picture.mean() > 0.02 and (picture > 0).mean() > 0.9
    if scene.name != "fog":  # a scene of the path tracer's own
        assert (tmp_path / "scene.mtl").read_text().count("newmtl") == len(scene.parts)


def test_parts_have_no_materials(tmp_path):
    path = write_obj(SCENES[0], tmp_path, "part", with_materials=False)
    text = path.read_text()
    assert "mtl" not in text and text.count("\nf ") == 2 * sum(len(part.faces) for part in SCENES[0].parts)


def test_missing_package(monkeypatch):
    monkeypatch.setitem(sys.modules, "mitsuba", None)
    with pytest.raises(SystemExit, match="pip install mitsuba"):
        correctness.main([])


@pytest.mark.parametrize("words, said", [(["--scenes", "attic"], "unknown scene 'attic'"), (["--seeds", "2"], "at least 3"),
                                         (["--size", "4x64"], "at least 8x8")])
def test_bad_options(words, said, capsys):
    with pytest.raises(SystemExit) as stopped:
        correctness.main(words)
    assert stopped.value.code == 2 and said in capsys.readouterr().err


def test_small_run(pathtracer, tmp_path, capsys):
    pytest.importorskip("mitsuba")
    correctness.main(["--scenes", "box,glass", "--size", "24x16", "--seeds", "4", "--spp", "16", "--out", str(tmp_path),
                      "--pathtracer", str(pathtracer)])
    text = (tmp_path / "correctness.md").read_text()
    assert text.count("| agrees |") == 2 and "`scripts/bench correctness --scenes box,glass" in text
    assert str(tmp_path) not in text and (tmp_path / "correctness.png").is_file() and "agrees" in capsys.readouterr().out
