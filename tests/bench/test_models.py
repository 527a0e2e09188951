# SPDX-License-Identifier: Apache-2.0
"""Samplers on models from files: a tiny complete run, its failures, and its summary."""

import csv
import dataclasses
import re

import pytest
from PIL import Image

pytest.importorskip("flip_evaluator")

from report.base import tables
from report.measure import gains
from report.pages import convergence
from report.renders import judge, models, summary

TENT = """v -1 0 -1
v 1 0 -1
v 1 0 1
v -1 0 1
v 0 {height} 0
f 1 2 3 4
f 1 5 2
f 2 5 3
f 3 5 4
f 4 5 1
"""


@pytest.fixture(autouse=True)
def own_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setattr(convergence, "REFERENCE_PARTS", 4)  # each part is a start of the path tracer


@pytest.fixture
def folder(tmp_path):
    root = tmp_path / "models"
    for name, height in (("a", 1.5), ("b", 0.7)):
        (root / name).mkdir(parents=True)
        (root / name / "tent.obj").write_text(TENT.format(height=height))
    (root / "broken.gltf").write_text("{")
    (root / "notes.txt").write_text("no model")
    return root


def arguments(pathtracer, folder, out, *more):
    return [str(folder), "--size", "72x64", "--crop", "17x15", "--samplers", "blue", "--seeds", "2", "--reference-spp", "256", "--jobs", "2",
            "--out", str(out), "--pages", str(out / "pages"), "--pathtracer", str(pathtracer), "--no-flip", *more]


def test_every_model_has_a_row_and_what_fails_is_listed(pathtracer, folder, tmp_path, monkeypatch, capsys):
    out, made, real = tmp_path / "report", [], judge.measure
    monkeypatch.setattr(judge, "measure", lambda *a: (made.append(a[1]), real(*a))[1])
    monkeypatch.setattr(models, "COUNTS", (1, 4))
    models.main(arguments(pathtracer, folder, out))
    text = (out / "models.md").read_text(encoding="utf-8")
    assert text.rstrip("\n") in capsys.readouterr().out and str(tmp_path) not in text
    assert "scripts/bench models FOLDER --size 72x64" in text and "2 models, each in four crops" in text
    for measure in ("RMSE as displayed after sigma 2.1", "RMSE after sigma 2.1"):
        part = text[text.index("## Every model"):].split(f"### {measure}\n")[1].split("\n### ")[0]
        assert len(re.findall(r"^\| [ab]/tent.obj \|( (\d+\.\d\d|-) / (\d+\.\d\d|-) \|){4}$", part, re.M)) == 2
    assert "in four crops of 17x15 pixels out of a picture of 72x64" in text
    assert re.search(r"^- broken: .*broken", text, re.M)
    Image.open(out / "models.png").verify()
    with open(out / "pages/models.csv", newline="", encoding="utf-8") as file:
        assert len(list(csv.DictReader(file))) == 8 * 3 * 2
    # Four crops of two models, three samplers, two seeds; found again the next time, but for the model that changes.
    assert len(made) == 48
    models.main(arguments(pathtracer, folder, out))
    assert len(made) == 48 and (out / "models.md").read_text(encoding="utf-8") == text
    (folder / "b/tent.obj").write_text(TENT.format(height=2))
    models.main(arguments(pathtracer, folder, out))
    assert len(made) == 72

    pages = [tmp_path / "README.md", out / "README.md"]
    for page in pages:
        page.write_text(f"before\n{tables.begin(summary.COMMAND)}old\n{tables.END}after\n", encoding="utf-8")
    summary.main(["--report", str(out), "--readme", str(pages[0])])
    captured = capsys.readouterr()
    assert "renders_headline.csv is missing; run scripts/bench renders --views held-out" in captured.err
    for page in pages:
        lines = page.read_text(encoding="utf-8").splitlines()
        assert lines[0] == "before" and lines[-1] == "after" and "old" not in lines
    first = gains.read_rows(out / "models_headline.csv")["displayed_2.1", 1, "blue", "white"]
    start = "| third-party models, 2 scenes, "
    assert any(line.startswith(start) and f" crops | as displayed | white | {first.text()} |" in line for line in lines)


def test_models_are_displayed_at_the_exposure_of_the_path_tracer(pathtracer, folder):
    path = str(folder / "a/tent.obj")
    view = judge.View(path, "", 40, 36)
    found = judge.render_reference(pathtracer, view, 32)
    darker = judge.load_reference(found.path, dataclasses.replace(view, exposure=found.exposure - 3))
    assert -10 < found.exposure < 10 and darker.exposure == found.exposure - 3
    assert darker.own["displayed"] < found.own["displayed"] / 4 and darker.own["rmse"] == found.own["rmse"]


def gain(value, scenes, views):
    return gains.Gain(value, value - 0.1, value + 0.1, scenes, views)


def summary_files(folder):
    """Results of both path tracers and of models, as their commands write them."""
    def write(name, thans, counts, what):
        gains.write_rows(folder / name, [gains.row_of(gain(what, 6, 24 if spp < 64 else 22), measure, spp, "blue", than)
                                         for measure in (*summary.MEASURES, "rmse") for spp in counts for than in thans])

    write("held-out/renders_headline.csv", ("white", "sobol", "zorder", gains.BEST_PEER), judge.COUNTS, 2.0)
    times = {"sobol": 2.0, "openqmc-a": 2.5, "openqmc-b": 4.0, "blue": 5.0}
    gains.write_rows(folder / "held-out/denoise.csv", [gains.row_of(gain(what, 6, 24), "seconds:plain:displayed_2.1", 16, label, "white")
                                                       for label, what in times.items()])
    write("pbrt_headline.csv", ("independent", "zsobol", "sobol", "halton", "best of pbrt"), judge.COUNTS, 1.5)
    write("models_headline.csv", ("white",), (4,), 1.2)


def test_summary_of_both_path_tracers_and_models(tmp_path, capsys):
    summary_files(tmp_path)
    summary.main(["--report", str(tmp_path), "--print"])
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "| where | error | times less than | 1 spp | 3 | 4 | 6 | 16 | 64 |"
    assert len(lines) == 2 + 2 * (4 + 5 + 1) and not (tmp_path / "README.md").exists()
    assert lines[2] == "| our path tracer, 6 scenes, 22 to 24 crops | as displayed | white |" + " 2.00 (1.90 to 2.10) |" * 6
    assert sum("| best of pbrt's own | 1.50 (1.40 to 1.60) |" in line for line in lines) == 2
    assert lines[-1] == "| third-party models, 6 scenes, 24 crops | raw | white |  |  | 1.20 (1.10 to 1.30) |  |  |  |"
    # The README has the figures as displayed of both path tracers alone.
    for page in ("README.md", "front.md"):
        (tmp_path / page).write_text(f"{tables.begin(summary.COMMAND)}{tables.END}", encoding="utf-8")
    summary.main(["--report", str(tmp_path), "--readme", str(tmp_path / "front.md")])
    text = (tmp_path / "front.md").read_text(encoding="utf-8")
    rows = [line for line in text.splitlines() if line.startswith("| ")][2:]
    assert len(rows) == 6 and sum("in our path tracer |" in row for row in rows) == 3 and "models" not in text


def test_summary_of_times(tmp_path):
    """White noise's time over a sampler's is printed the other way round, and so is its interval."""
    summary_files(tmp_path)
    assert summary.time_table(tmp_path) is None  # the first column is missing: a run without times
    path = tmp_path / "held-out/renders_headline.csv"
    gains.write_rows(path, [gains.row_of(gain(4.0, 6, 24), "seconds:displayed_2.1", 16, "blue", "white")])
    rows = summary.time_table(tmp_path).splitlines()
    assert rows[-1] == "| `blue` | 0.25 (0.24 to 0.26) |  | 0.20 (0.20 to 0.20) |"
    assert rows[-2] == "| the best of OpenQMC |  |  | 0.25 (0.24 to 0.26) |"


def test_pages_without_marks_are_left_alone(tmp_path):
    summary_files(tmp_path)
    (tmp_path / "README.md").write_text("no marks", encoding="utf-8")
    with pytest.raises(SystemExit, match="must contain the markers"):
        summary.main(["--report", str(tmp_path), "--readme", str(tmp_path / "README.md")])
    assert (tmp_path / "README.md").read_text(encoding="utf-8") == "no marks"
    with pytest.raises(SystemExit, match="run scripts/bench pbrt; .*run scripts/bench models"):
        summary.main(["--report", str(tmp_path / "none")])


def test_names_tell_files_apart(tmp_path):
    paths = [tmp_path / "duck/a/duck.gltf", tmp_path / "duck/b/duck.gltf", tmp_path / "box.glb"]
    assert list(models.names_of(paths).values()) == ["a/duck.gltf", "b/duck.gltf", "box"]


def test_folders_without_models_are_refused(tmp_path, capsys):
    with pytest.raises(SystemExit, match="no .gltf, .glb, .obj file below"):
        models.main([str(tmp_path)])
    with pytest.raises(SystemExit):
        models.main([str(tmp_path / "none")])
    assert "does not exist" in capsys.readouterr().err
