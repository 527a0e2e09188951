# SPDX-License-Identifier: Apache-2.0
"""The judge of the samplers: a tiny run of the whole, interrupted and finished, and its parts on figures made up."""

import csv
import re
import types

import numpy as np
import pytest
from PIL import Image

pytest.importorskip("flip_evaluator")

from report import comparison, embree_scene, renders, renders_plots, renders_report, speed
from report.files import read_exr
from report.renderer import Request, run_pathtracer


@pytest.fixture(autouse=True)
def own_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))


def arguments(pathtracer, out, *more):
    return ["--size", "16x16", "--scenes", "cornell,lens", "--samplers", "zorder,blue,blue-declared", "--spp", "4",
            "--seeds", "2", "--reference-spp", "64", "--jobs", "2", "--out", str(out), "--pathtracer", str(pathtracer), *more]


def test_interrupted_run_goes_on_and_writes_the_whole_report(pathtracer, tmp_path, monkeypatch, capsys):
    out, made = tmp_path / "report", []
    real = renders.measure

    def counted(program, task, *more):
        if len(made) == 7:
            raise KeyboardInterrupt
        made.append(task)
        return real(program, task, *more)

    monkeypatch.setattr(renders, "measure", counted)
    with pytest.raises(SystemExit, match="run it again"):
        renders.main(arguments(pathtracer, out, "--no-times"))
    assert not out.exists() and 0 < len(made) < 20

    first, made[:] = list(made), []
    monkeypatch.setattr(renders, "measure", lambda *a: (made.append(a[1]), real(*a))[1])
    renders.main(arguments(pathtracer, out, "--no-times"))
    assert not set(first) & set(made) and len(first) + len(made) == 20
    text = (out / "renders.md").read_text(encoding="utf-8")
    assert text.rstrip("\n") in capsys.readouterr().out
    assert "scripts/bench renders --size 16x16" in text and str(tmp_path) not in text

    with open(out / "renders.csv", newline="", encoding="utf-8") as file:
        rows = {(row["scene"], row["sampler"], row["spp"]): row for row in csv.DictReader(file)}
    # Four samplers at 1, 2 and 4, the declared one at 1 and 4.
    assert len(rows) == 2 * (4 * 3 + 2)
    for (scene, sampler, _), row in rows.items():
        assert row["seeds"] == "2" and 0 < float(row["flip"]) < 1 and 0 < float(row["rmse_2.1"]) < float(row["rmse"])
        assert sampler != "white" or float(row["white_over_rmse"]) == 1
    for name in re.findall(r"\((renders[^)]*)\)", text):
        assert (out / name).is_file(), name
    for name in out.glob("*.png"):
        Image.open(name).verify()
    html = (out / "renders.html").read_text(encoding="utf-8")
    assert html.count("data:image/jpeg") == 2 * (1 + 4 * 2 + 2)

    # Found again, all of it: only the text is compared.
    made.clear()
    before = text
    monkeypatch.setattr(renders_plots, "draw_all", lambda report, folder: None)
    renders.main(arguments(pathtracer, out, "--no-times"))
    assert made == [] and (out / "renders.md").read_text(encoding="utf-8") == before
    assert sorted(path.name for path in (tmp_path / "cache/libbn").iterdir()) == ["references", "renders"]


def test_figures_are_those_of_single_renders(pathtracer, tmp_path):
    reference, _ = read_exr(render(pathtracer, tmp_path, Request("sobol", 64, 9, width=16, height=16)))
    for label, declared in (("blue", 0), ("zorder", 4)):
        task = renders.Task("cornell", label, 1, (2, 4))
        rows, pictures = renders.measure(pathtracer, task, (16, 16), reference, False)
        whole, _ = read_exr(render(pathtracer, tmp_path, Request(label, 4, 1, width=16, height=16, declared=declared)))
        assert rows[1]["rmse"][0] == pytest.approx(np.sqrt(np.mean((whole - reference) ** 2)), rel=1e-4)
        assert rows[1]["flip"] is None and pictures == {}


def render(pathtracer, folder, request):
    run_pathtracer(pathtracer, [*request.arguments(), "--quiet", "-o", folder / "one.exr"])
    return folder / "one.exr"


def test_seeds_and_counts_of_the_plan():
    tasks = renders.plan(("cornell",), ("white", "zorder", "blue, declared"), {1: 3, 2: 3, 4: 1}, (1, 2, 4))
    assert {(t.label, t.seed): t.counts for t in tasks} == {
        ("white", 0): (1, 2, 4), ("white", 1): (1, 2), ("white", 2): (1, 2),
        ("zorder", 0): (1, 2, 4), ("zorder", 1): (1, 2), ("zorder", 2): (1, 2),
        ("blue, declared", 0): (1, 4), ("blue, declared", 1): (1,), ("blue, declared", 2): (1,)}
    assert [t.cost for t in tasks if t.seed == 0] == [4, 7, 5]


def made_up(blue, seeds=8, own=0.0):
    """A report on one scene in which white has the error 1, sobol a half, and blue what is given, with 1 % of noise."""
    rng = np.random.default_rng(11)
    options = types.SimpleNamespace(scenes=("cornell",), samplers=("white", "sobol", "blue"), seeds={1: seeds, 16: seeds},
                                    size=(16, 16), quick=False, reference_spp=64, command="scripts/bench renders")
    reference = np.ones((16, 16, 3), np.float32)
    results = {}
    for label, error in (("white", 1.0), ("sobol", 0.5), ("blue", blue)):
        for seed in range(seeds):
            noise = np.exp(0.01 * rng.standard_normal())
            mean = 1 + 0.001 * rng.standard_normal() + (own if label == "blue" else 0)
            results[renders.Task("cornell", label, seed, (1, 16))] = [
                {"spp": spp, "rmse": [error * noise] * 3, "flip": error * noise / 2, "mean": mean, "spectrum": [1.0] * 8}
                for spp in (1, 16)], {}
    return renders_report.Report(options, renders.Cells(results), {"cornell": ("", reference, {"meanError": 1e-5})}, [], None)


def test_ratios_and_aims_of_figures_made_up():
    report = made_up(0.25)
    assert report.ratio("cornell", "blue", 1, 2.1, "white").value == pytest.approx(4, rel=0.02)
    assert report.ratio("cornell", "blue", 1, "flip", "sobol").value == pytest.approx(2, rel=0.02)
    aims = {row[0]: row[3] for row in report.aims()}
    assert aims["white / blue, 1 spp, sigma 2.1"] == aims["sobol / blue, 16 spp, sigma 2.1"] == "met"
    assert aims["cells in which blue is worse than sobol"] == aims["greatest |z| of a mean"] == "met"
    assert "No cell is worse" in report.worse_text()


def test_what_misses_its_aim_is_said():
    report = made_up(0.6, own=0.01)
    aims = {row[0]: row[3] for row in report.aims()}
    assert aims["white / blue, 16 spp, sigma 2.1"] == "missed" and aims["greatest |z| of a mean"] == "missed"
    assert aims["cells in which blue is worse than sobol"] == "missed"
    assert report.worse_text().count("| worse |") == 2 * 3


def test_one_seed_is_no_evidence():
    report = made_up(0.6, seeds=1)
    assert "One seed" in report.worse_text() and "One seed" in report.z_text()
    assert not any("worse" in row[0] or "|z|" in row[0] for row in report.aims())


@pytest.mark.parametrize("words, said", [(["--scenes", "cornell,attic"], "there is no scene 'attic'"),
                                         (["--samplers", "red"], "there is no sampler 'red'"),
                                         (["--reference-spp", "100"], "a multiple of 32"),
                                         (["--seeds", "0"], "a whole number from 1")])
def test_bad_options(words, said, capsys):
    with pytest.raises(SystemExit) as stopped:
        renders.main(words)
    assert stopped.value.code == 2 and said in capsys.readouterr().err


def test_missing_program(tmp_path):
    with pytest.raises(SystemExit, match="scripts/setup"):
        renders.main(arguments(tmp_path / "none", tmp_path / "out"))


def test_results_that_are_not_whole_are_measured_again(tmp_path):
    store = renders.Store(tmp_path, "build")
    store.save({"a": 1}, [{"spp": 1}], {"1": np.ones(3)})
    rows, arrays = store.load({"a": 1})
    assert rows == [{"spp": 1}] and arrays["1"].tolist() == [1, 1, 1]
    assert store.load({"a": 2}) is None
    (path,) = (tmp_path / "build").iterdir()
    path.write_bytes(path.read_bytes()[:-40])
    assert store.load({"a": 1}) is None
    renders.Store(tmp_path, "next")
    assert list(tmp_path.iterdir()) == []


def test_times_of_a_small_run(pathtracer, tmp_path):
    reference = render(pathtracer, tmp_path, Request("sobol", 32, 9, width=16, height=16))
    runs = speed.progressive_runs(pathtracer, "cornell", (16, 16), reference, 4, 2, tmp_path, lambda what: None)
    assert {label: [row["spp"] for row in rows] for label, rows in runs.items()} == {
        "white": [1, 2, 3, 4], "sobol": [1, 2, 3, 4], "blue": [1, 2, 3, 4], "blue, declared": [1, 4]}
    assert all(row["seconds"] > 0 and row["rmse_2.1"] > 0 for rows in runs.values() for row in rows)
    shares = speed.sampling_shares(pathtracer, {"blue": renders.VARIANTS["blue"]}, (16, 16), tmp_path)
    assert 0 < shares["blue"] < 1


def test_embree_is_known_by_what_it_says(tmp_path):
    other = tmp_path / "pathtracer"
    other.write_text("#!/bin/sh\necho another program\n")
    other.chmod(0o755)
    assert speed.find_embree(str(other)) is None and speed.find_embree(str(tmp_path / "none")) is None


def test_embree_that_fails_is_a_row_and_not_an_end(pathtracer, tmp_path):
    broken = tmp_path / "embree"
    broken.write_text("#!/bin/sh\necho no such device >&2\nexit 3\n")
    broken.chmod(0o755)
    assert speed.embree_pairs(pathtracer, broken, (16, 16), 1, tmp_path, lambda what: None) == {"failed": "no such device"}


def test_the_box_for_embree_is_closed_but_for_its_front():
    """Every wall and the floor, the ceiling without the lamp, two blocks with sides."""
    quads = embree_scene.quads()
    assert len(quads) == 8 + 2 * 5
    below = np.array([corners for _, corners in quads[:4]], float)
    area = sum(np.linalg.norm(np.cross(q[1] - q[0], q[3] - q[0])) for q in below)
    x0, x1, z0, z1 = embree_scene.LAMP
    assert area == pytest.approx(556 * embree_scene.BACK - (x1 - x0) * (z1 - z0))
    text = embree_scene.cornell_xml()
    assert text.count("<TriangleMesh>") == 3 and text.count("<PointLight>") == 1


def test_slider_has_its_controls_and_asks_no_network():
    image = Image.new("RGB", (4, 3), (10, 200, 30))
    uri = comparison.data_uri(image)
    text = comparison.widget({"a</script>": {"size": (4, 3), "reference": uri, "counts": {1: {"white": (uri, 0.5)}}}})
    for control in ("scene", "spp", "left", "right", "zoom", "blur", "swap", "divider", "stage", "note"):
        assert f"data-part={control}" in text
    assert text.count("<script") == text.count("</script>") == 2
    assert "http" not in text and "src=" not in text and "pointerdown" in text and "aria-label" in text
