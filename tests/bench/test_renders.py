# SPDX-License-Identifier: Apache-2.0
"""scripts/bench renders: a tiny complete run, interrupted and resumed, and its parts on synthetic data."""

import csv
import os
import re
import time
import types
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

pytest.importorskip("flip_evaluator")

from report.base.files import read_exr
from report.measure import gains
from report.measure.image_error import MEASURES, displayed_rmse
from report.pages import comparison, convergence
from report.renders import embree_scene, judge, renders, renders_plots, renders_report, speed, variants, views
from report.renders.renderer import run_pathtracer


@pytest.fixture(autouse=True)
def own_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setattr(convergence, "REFERENCE_PARTS", 4)  # each part is a start of the path tracer


def arguments(pathtracer, out, *more):
    return ["--size", "36x34", "--crop", "17x16", "--scenes", "penumbra", "--samplers", "zorder,blue", "--spp", "4",
            "--seeds", "2", "--reference-spp", "64", "--jobs", "2", "--out", str(out), "--pages", str(out / "pages"),
            "--pathtracer", str(pathtracer), "--no-times", *more]


def test_interrupted_run_goes_on_and_writes_the_whole_report(pathtracer, tmp_path, monkeypatch, capsys):
    out, made = tmp_path / "report", []
    real = judge.measure

    def counted(program, task, *more):
        if len(made) == 7:
            raise KeyboardInterrupt
        made.append(task)
        return real(program, task, *more)

    monkeypatch.setattr(judge, "measure", counted)
    with pytest.raises(SystemExit, match="run the command again"):
        renders.main(arguments(pathtracer, out))
    assert not out.exists() and 0 < len(made) < 32

    # Four crops, four samplers, two seeds.
    first, made[:] = list(made), []
    monkeypatch.setattr(judge, "measure", lambda *a: (made.append(a[1]), real(*a))[1])
    renders.main(arguments(pathtracer, out))
    assert not set(first) & set(made) and len(first) + len(made) == 32
    text = (out / "renders.md").read_text(encoding="utf-8")
    assert text.rstrip("\n") in capsys.readouterr().out
    assert "scripts/bench renders --size 36x34 --crop 17x16" in text and "4 crops of 17x16 pixels, out of pictures of 36x34" in text and str(tmp_path) not in text

    with open(out / "pages/renders.csv", newline="", encoding="utf-8") as file:
        rows = {(row["scene"], row["view"], row["sampler"], row["spp"]): row for row in csv.DictReader(file)}
    # At 1, 2, 3 and 4.
    assert len(rows) == 4 * 4 * 4
    for (*_, spp), row in rows.items():
        assert row["seeds"] == "2" and all(float(row[name]) > 0 for name in MEASURES)
        assert float(row["rmse_2.1"]) < float(row["rmse"]) and (row["flip"] == "") == (spp in "23")
    headline = gains.read_rows(out / "renders_headline.csv")
    gain = headline["displayed_2.1", 4, "blue", "white"]
    assert gain.low < gain.value < gain.high and gain.views + gain.left_out == 4
    assert gain.text() in text
    for name in re.findall(r"\((renders[^)]*)\)", text):
        assert (out / name).is_file(), name
    for name in (*out.glob("*.png"), *out.glob("pages/*.png")):
        Image.open(name).verify()

    # Found again, all of it: only the text is compared.
    made.clear()
    monkeypatch.setattr(renders_plots, "draw_all", lambda *_: None)
    renders.main(arguments(pathtracer, out))
    assert made == [] and (out / "renders.md").read_text(encoding="utf-8") == text
    assert sorted(path.name for path in (tmp_path / "cache/libbn").iterdir()) == ["references", "renders"]


def test_a_change_of_one_sampler_renders_that_sampler_again(pathtracer, tmp_path, monkeypatch):
    """A path tracer with another seed for blue simulates one with another table."""
    program, made, real = tmp_path / "pathtracer", [], judge.measure
    monkeypatch.setattr(judge, "measure", lambda *a: (made.append(a[1]), real(*a))[1])
    view = views.chosen("core", ("lens",), (16, 17))[0]
    tasks = judge.plan((view,), ("white", "sobol", "zorder", "blue"), {1: 1, 4: 1})
    for other in ("", "--seed 77"):
        program.write_text(f"""#!/bin/sh
case "$*" in *"--sampler blue"*) exec '{pathtracer}' "$@" {other} ;; *) exec '{pathtracer}' "$@" ;; esac
""")
        program.chmod(0o755)
        reference = judge.render_reference(program, view, 32)
        judge.Run(program, "renders", 4, 2, flip=False).results({view: reference}, tasks)
    assert sorted(task.label for task in made[:4]) == ["blue", "sobol", "white", "zorder"]
    assert [task.label for task in made[4:]] == ["blue"]


def test_figures_are_those_of_single_renders(pathtracer, tmp_path):
    view = views.chosen("core", ("cornell",), (16, 17))[0]
    reference = judge.render_reference(pathtracer, view, 64)
    for label, declared in (("blue", 0), ("zorder", 4)):
        task = judge.Task(view, label, 1, (2, 4))
        rows, pictures = judge.measure(pathtracer, task, reference, flip=False)
        whole = render(pathtracer, tmp_path, view.request(label, 4, 1, declared=declared))
        assert rows[1]["rmse"] == pytest.approx(np.sqrt(np.mean((whole - reference.picture) ** 2)), rel=1e-4)
        assert rows[1]["displayed_2.1"] == pytest.approx(displayed_rmse(whole, reference.picture, 1.0, 2.1), rel=1e-4)
        assert "flip" not in rows[1] and pictures == {}


def test_a_reference_knows_its_own_error(pathtracer):
    """The estimate of a reference's own error is right within a factor of 1.5: 64 samples of sobol against 2048."""
    view = views.chosen("core", ("penumbra",), (31, 32))[0]
    coarse, fine = (judge.render_reference(pathtracer, view, spp) for spp in (64, 2048))
    assert fine.own["rmse"] < coarse.own["rmse"] / 3
    error = float(np.sqrt(np.mean((coarse.picture - fine.picture) ** 2)))
    assert coarse.own["rmse"] / 1.5 < error < 1.5 * coarse.own["rmse"]


def render(pathtracer, folder, request):
    run_pathtracer(pathtracer, [*request.arguments(), "--quiet", "-o", folder / "one.exr"])
    return read_exr(folder / "one.exr")[0]


def test_seeds_and_counts_of_the_plan():
    view = views.chosen("core", ("cornell",), (10, 10))[0]
    tasks = judge.plan((view,), ("white", "zorder", "mask, neural"), {1: 6, 2: 6, 4: 1})
    counts = {(t.label, t.seed): t.counts for t in tasks}
    assert [counts["white", seed] for seed in range(6)] == [counts["zorder", seed] for seed in range(6)] == [(1, 2, 4), *[(1, 2)] * 5]
    assert counts["mask, neural", 0] == (1, 2, 4) and ("mask, neural", variants.SIDE_SEEDS) not in counts
    assert judge.seeds_up_to(6) == dict.fromkeys((1, 2, 3, 4, 6), judge.SEEDS) and judge.SEEDS >= 12
    assert [t.cost for t in tasks if t.seed == 0] == [400, 700, 400]


def made_up(blue, seeds=8):
    """A report on four crops of one scene: white has an error of 1, sobol 1/2, and blue the given one, with 1 % noise."""
    rng, chosen = np.random.default_rng(11), views.crops("core", ("cornell",), (64, 64), (16, 16))
    labels = ("white", "sobol", "blue")
    options = types.SimpleNamespace(labels=labels, seeds={1: seeds, 16: seeds}, size=(64, 64), views="core", out=Path("o"), plots=Path("o"),
                                    reference_spp=64, command="scripts/bench renders")
    references = {view: judge.Reference(Path(), np.ones((16, 16, 3), np.float32), dict.fromkeys(MEASURES, 1e-5), 1e-5, 0.0, 64, 1.0)
                  for view in chosen}
    results = {}
    for view in chosen:
        for label, error in zip(labels, (1.0, 0.5, blue)):
            for seed in range(seeds):
                noise = np.exp(0.01 * rng.standard_normal())
                mean = 1 + 0.001 * rng.standard_normal()
                results[judge.Task(view, label, seed, (1, 16))] = [
                    {"spp": spp, **dict.fromkeys(MEASURES, error * noise), "flip": error * noise / 2, "mean": mean}
                    for spp in (1, 16)], {}
    return renders_report.Report(options, judge.Cells(results), references, [], None)


def test_the_answer_comes_first():
    report = made_up(0.25)
    first = report.text().split("\n")[4]
    assert first == report.short()
    assert "3.9" in first or "4.0" in first
    assert "none found one" in first and "none did" in first
    assert "No cell is worse" in report.worse_text() and "No cell is biased" in report.bias_text()
    assert "| 4.0" in report.text() and "| 2.0" in report.text()


def test_losses_and_biases_are_said():
    report = made_up(0.6)
    for cell in [cell for at, cell in report.cells.values.items() if at[1] == "sobol"]:
        cell["mean"] = [mean + 0.01 for mean in cell["mean"]]
    assert report.worse_text().count("| worse |") == 2 * 3 and "Biased: sobol in cornell." in report.bias_text()
    certain = sum(ratio.high < 1 for ratio in report.losses.values())
    assert f"Of {len(report.losses)} tests for a loss to `sobol` {certain} found one, 2 of them in single pixels, without a blur; of {len(report.biases)} for a bias 1 did." in report.short()


def test_plots_that_lie_elsewhere_are_not_shown():
    report = made_up(0.25)
    assert report.text().count("![") >= 2
    report.options.plots = "elsewhere"
    assert "![" not in report.text()


def test_times_are_said_with_those_after_the_denoiser(tmp_path):
    """blue has a quarter of white's error at every count, made up without convergence: one sample does for white's 16."""
    report = made_up(0.25)
    report.costs = {("cornell", "white"): 1.0, ("cornell", "sobol"): 2.0, ("cornell", "blue"): 1.0}
    report.times = {"machine": "a machine", "big": (8, 8), "shares": {"blue": 0.1}, "threads": [(2.0, 1.0)], "embree": None}
    report.options.out = tmp_path
    assert "| blue | 1 | 1 | 16.00 (16.00 to 16.00) |\n" in report.text() and "| sobol | 2 | 2 | 8.00 (8.00 to 8.00) |\n" in report.text()
    gains.write_rows(tmp_path / "denoise.csv", [gains.row_of(gains.Gain(5.0, 4.0, 6.0), "seconds:plain:displayed_2.1", 16, "blue", "white")])
    assert "| blue | 1 | 1 | 16.00 (16.00 to 16.00) | 5.00 (4.00 to 6.00) |\n" in report.text() and "| after denoising, at 16 |" in report.text()
    assert {row["gain"] for row in report.headline_rows() if row["measure"] == "seconds:displayed_2.1"} == {"8.000000", "16.000000"}


def test_one_seed_is_no_evidence():
    report = made_up(0.6, seeds=1)
    assert "more than one seed" in report.worse_text() and "more than one seed" in report.bias_text()
    assert "tests for a loss" not in report.short()


@pytest.mark.parametrize("words, said", [(["--scenes", "cornell,attic"], "unknown scene 'attic'"),
                                         (["--samplers", "red"], "unknown sampler 'red'"),
                                         (["--reference-spp", "100"], "a multiple of 32"),
                                         (["--views", "none"], "invalid choice"),
                                         (["--seeds", "0"], "a positive integer"),
                                         (["--size", "100x100"], "crops of 96x72 pixels do not fit")])
def test_bad_options(words, said, capsys):
    with pytest.raises(SystemExit) as stopped:
        renders.main(words)
    assert stopped.value.code == 2 and said in capsys.readouterr().err


def test_sets_of_views_have_folders_of_their_own():
    def places(*words):
        options = renders.parse_options(words)
        return [path.as_posix() for path in (options.out, options.plots, options.pages)]

    assert places() == ["docs/report", "docs/report", "out/renders"]
    assert places("--views", "held-out") == ["docs/report/held-out", "out/renders/held-out", "out/renders/held-out"]
    assert places("--views", "held-out", "--out", "a", "--pages", "b") == ["a", "b", "b"]
    assert places("--quick") == ["out/renders/quick"] * 3
    assert places("--quick", "--views", "tuning") == ["out/renders/quick/tuning"] * 3


def test_missing_program(tmp_path):
    with pytest.raises(SystemExit, match="scripts/setup"):
        renders.main(arguments(tmp_path / "none", tmp_path / "out"))


def test_results_that_are_not_whole_are_measured_again(tmp_path):
    store = judge.Store(tmp_path)
    store.save({"a": 1}, [{"spp": 1}], {"1": np.ones(3)})
    rows, arrays = store.load({"a": 1})
    assert rows == [{"spp": 1}] and arrays["1"].tolist() == [1, 1, 1]
    assert store.load({"a": 2}) is None
    (path,) = tmp_path.iterdir()
    path.write_bytes(path.read_bytes()[:-40])
    assert store.load({"a": 1}) is None


def test_what_nothing_asks_for_goes(tmp_path):
    store = judge.Store(tmp_path)
    for key in (1, 2):
        store.save(key, [], {})
    for path in tmp_path.iterdir():
        os.utime(path, (0, time.time() - 86400 * (judge.KEPT_DAYS + 1)))
    assert store.load(2) is not None
    store = judge.Store(tmp_path)
    assert store.load(1) is None and store.load(2) is not None


def test_everything_but_blue_is_prepared(pathtracer, tmp_path, monkeypatch, capsys):
    made, real = [], judge.measure
    monkeypatch.setattr(judge, "measure", lambda *a: (made.append(a[1].label), real(*a))[1])
    few = "--spp", "1", "--seeds", "1", "--no-flip"
    renders.main(arguments(pathtracer, tmp_path / "out", *few, "--prepare"))
    assert sorted(made) == ["sobol"] * 4 + ["white"] * 4 + ["zorder"] * 4 and not (tmp_path / "out").exists()
    assert "12 runs are in the cache; 4 of blue are left" in capsys.readouterr().out
    made.clear()
    monkeypatch.setattr(renders_plots, "draw_all", lambda *_: None)
    renders.main(arguments(pathtracer, tmp_path / "out", *few))
    assert made == ["blue"] * 4


def test_times_of_a_small_run(pathtracer, tmp_path):
    shares = speed.sampling_shares(pathtracer, {"blue": judge.VARIANTS["blue"]}, (16, 16), tmp_path)
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
    """All walls and the floor, the ceiling without the lamp, and two blocks."""
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
    text = comparison.widget("a</script>", (4, 3), uri, {1: {"white": (uri, 0.5)}})
    for control in ("spp", "left", "right", "zoom", "blur", "swap", "divider", "stage", "note"):
        assert f"data-part={control}" in text
    assert text.count("<script") == text.count("</script>") == 2
    assert "http" not in text and "src=" not in text and "pointerdown" in text and "aria-label" in text
