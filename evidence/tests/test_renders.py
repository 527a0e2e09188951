# SPDX-License-Identifier: Apache-2.0
"""scripts/bench renders: a tiny run, which is interrupted and resumed, and the report's parts on synthetic data."""

import re
import struct
import subprocess
import types
from pathlib import Path

import numpy as np
import pytest
from own_scene import to_gltf

from evidence.__main__ import main
from evidence.base import page
from evidence.base.files import read_exr, read_numbers
from evidence.measure.image_error import MEASURES, displayed_rmse
from evidence.measure.statistics import Estimate
from evidence.renders import judge, models, renders, views
from evidence.renders.renderer import run_pathtracer
from evidence.samplers import heitz
from evidence.summary import summary

CORNELL = [(516, 560), (754, 107), (221, 981), (1051, 730)]


def test_interrupted_run_resumes_and_writes_the_whole_report(bench, cache, tmp_path, monkeypatch, capsys):
    out, made = tmp_path / "out", []
    real = judge.measure

    def counted(program, task, *more):
        if len(made) == 7:
            raise KeyboardInterrupt
        made.append(task)
        return real(program, task, *more)

    monkeypatch.setattr(judge, "measure", counted)
    with pytest.raises(SystemExit, match="run the command again"):
        bench("renders", "--samplers", "zorder,blue", "--jobs", 2)
    assert not out.exists() and 0 < len(made) < 32

    # The total is 32: four crops, four samplers and two seeds.
    first, made[:] = list(made), []
    monkeypatch.setattr(judge, "measure", lambda *a: (made.append(a[1]), real(*a))[1])
    bench("renders", "--samplers", "zorder,blue", "--jobs", 2)
    assert not set(first) & set(made) and len(first) + len(made) == 32
    text = (out / "renders.md").read_text(encoding="utf-8")
    assert text.rstrip("\n") in capsys.readouterr().out
    assert "scripts/bench renders --scenes penumbra --size 64x64 --crop 17x16" in text and "4 crops of 17x16 pixels" in text and str(tmp_path) not in text

    found = summary.read(out / "renders.csv")["displayed_2.1", "", "white", 4]
    assert 1 < found.low < found.value < found.high and found.crops + found.left_out == 4 and found.text() in text
    for name in re.findall(r"\((renders[^)]*)\)", text):
        assert (out / name).is_file(), name

    # All results are now cached, and only the text is compared.
    made.clear()
    monkeypatch.setattr(renders.Report, "plot", lambda *_: None)
    bench("renders", "--samplers", "zorder,blue", "--jobs", 2)
    assert made == [] and (out / "renders.md").read_text(encoding="utf-8") == text
    assert sorted(path.name for path in cache.iterdir()) == ["references", "renders"]


def test_figures_match_single_renders(pathtracer, tmp_path):
    view = views.crops("development", ("cornell",), (64, 48), (16, 17))[0]
    reference = judge.render_reference(pathtracer, view, 64)
    for label in ("blue", "zorder"):
        task = judge.Task(view, label, 1, (2, 4))
        rows = judge.measure(pathtracer, task, reference)
        run_pathtracer(pathtracer, [*view.request(label, 4, 1).arguments(), "--quiet", "-o", tmp_path / "one.exr"])
        whole = read_exr(tmp_path / "one.exr")[0]
        assert rows[1]["rmse"] == pytest.approx(np.sqrt(np.mean((whole - reference.picture) ** 2)), rel=1e-4)
        assert rows[1]["displayed_2.1"] == pytest.approx(displayed_rmse(whole, reference.picture, 1.0, 2.1), rel=1e-4)


def made_up(blue, seeds=8):
    """A report on four crops of one scene. The errors are 1 (white), 1/2 (sobol) and `blue` (blue), each with 1% noise."""
    rng, chosen = np.random.default_rng(11), views.crops("development", ("cornell",), (64, 64), (16, 16))
    labels = ("white", "sobol", "blue")
    options = types.SimpleNamespace(labels=labels, counts=(1, 16), seeds=seeds, size=(64, 64), views="development", out=Path("o"),
                                    reference_spp=64, command="scripts/bench renders")
    references = {view: judge.Reference(np.ones((16, 16, 3), np.float32), dict.fromkeys(MEASURES, 1e-5), 64, 1.0, mean_error=1e-5)
                  for view in chosen}
    results = {}
    for view in chosen:
        for label, error in zip(labels, (1.0, 0.5, blue)):
            for seed in range(seeds):
                noise = np.exp(0.01 * rng.standard_normal())
                mean = 1 + 0.001 * rng.standard_normal()
                results[judge.Task(view, label, seed, (1, 16))] = [
                    {"spp": spp, **dict.fromkeys(MEASURES, error * noise), "mean": mean}
                    for spp in (1, 16)], {}
    return renders.Report(options, judge.Cells(results), references)


def text_of(report):
    return page.render(vars(renders), "renders.md.in", report=report, options=report.options, crop=(16, 16), has_peers=False).split("\n")[4]


def test_summary_comes_first_and_states_losses_and_biases():
    assert "relative to padded Sobol' is 0.50 at 1 and 0.50 at 16 samples. At 16 samples, the gain is largest in `cornell` (0.50)" in text_of(made_up(0.25))
    assert "higher error than padded Sobol' in 0 of 6 comparisons" in text_of(made_up(0.25)) and "3 tests for bias (one per scene and sampler) found none. Both" in text_of(made_up(0.25))
    report = made_up(0.6)
    for cell in [cell for at, cell in report.cells.values.items() if at[1] == "sobol"]:
        cell["mean"] = [mean + 0.01 for mean in cell["mean"]]
    assert "in 6 of 6 comparisons (one per scene, sample count and blur), 2 of them without a blur (6 in `cornell`). The" in text_of(report)
    assert "3 tests for bias (one per scene and sampler) found 1: sobol in cornell." in text_of(report)


def test_readme_tables():
    found = {(summary.TO_WHITE, "", "blue", 16): Estimate(0.3, 0.2, 0.4), (summary.HEADLINE, "", "blue", 4): Estimate(0.7, 0.6, 0.8)}
    assert summary.short_table(found).splitlines()[2:] == ["| **`blue`** | **4.8** | no | no |"] and "| **0.70** |" in summary.table(found)


def test_answers_for_other_renderers_use_the_headline_measure():
    def rows(scenes, label, counts):
        return {(measure, scene, label, spp): Estimate(value, 0.9 * value, 1.1 * value) for measure, value in ((summary.HEADLINE, 1.5), ("rmse", 7))
                for scene in scenes for spp in counts}

    text = summary.answers(Path("none"), pbrt=rows(("Fixed wavelengths", "Four random wavelengths"), "zsobol", (2, 4, 16)),
                           cycles={**rows(("Scenes",), "tabulated_sobol", (4, 16, 64)), **rows(("Scenes",), "blue_noise_pure", (4, 16, 64))})
    assert "1.50 (95% interval 1.35 to 1.65)" in text and text.count("of which 1.50, 1.50 and 1.50 significantly") == 2 and "7.00" not in text
    assert summary.compared([Estimate(0.99, 0.9, 1.1)]) == "0.99, none of them significantly different from 1"


def test_seeds_with_higher_error_are_counted():
    rows = [{"seed": seed, "sobol": sobol, "blue": blue} for seed, (sobol, blue) in enumerate([(1, 0.5), (2, 3), (4, 0.25)])]
    text = summary.answers(Path("none"), worst=rows)
    assert "than padded Sobol' for 1 of 3 seeds" in text and "`blue` has 1.50 times the median error" in text and "own worst seed, padded Sobol' has 2.00 times" in text


# ---- Views

@pytest.mark.parametrize("scene", views.BUILT_IN)
def test_cameras_match_the_scenes(pathtracer, scene):
    listed = subprocess.run([pathtracer, "--scene", scene, "--list-cameras"], check=True, capture_output=True, text=True).stdout
    words = listed.split()
    for name, own in zip(("--eye", "--target", "--fov"), views.CAMERAS[scene]):
        numbers = [float(number) for number in words[words.index(name) + 1].split(",")]
        assert numbers == pytest.approx(list(own) if isinstance(own, tuple) else [own], abs=2e-5)


def test_sets_share_no_camera():
    cameras = [{view.camera for view in views.crops(name, views.BUILT_IN)} for name in views.SETS]
    assert all(len(own) == len(views.BUILT_IN) for own in cameras) and len(set().union(*cameras)) == len(views.SETS) * len(views.BUILT_IN)


def test_each_quarter_contains_one_full_size_crop():
    for name in views.SETS:
        for scene in views.BUILT_IN:
            own = views.crops(name, (scene,))
            assert len(own) == 4 and len({view.picture for view in own}) == 1
            assert own[0].width >= 1280 and own[0].height >= 960
            for i, view in enumerate(own):
                (x0, y0, x1, y1), (wide, high) = view.crop, (view.width // 2, view.height // 2)
                assert view.size == (x1 - x0, y1 - y0) == views.CROP and view.pixels == views.CROP[0] * views.CROP[1]
                assert i % 2 * wide <= x0 < x1 <= (i % 2 + 1) * wide and i // 2 * high <= y0 < y1 <= (i // 2 + 1) * high
    # Crop positions depend on names and cameras. They must not change, or results would not be comparable between versions.
    assert [view.crop[:2] for view in views.crops("held-out", ("cornell",))] == CORNELL


def test_models_stand_on_a_lit_floor(pathtracer, tmp_path):
    data = np.array([[0, 5, 0], [0, 5, 20], [40, 5, 0]], "<f4").tobytes()
    tree = {"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
            "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
            "bufferViews": [{"buffer": 0, "byteLength": 36}], "buffers": [{"byteLength": 36}]}
    model = to_gltf.glb_of(tree, struct.pack("<I4s", 36, b"BIN\0") + data)
    for in_room, light, dark in ((True, "none", "none"), (False, "sky", "none")):
        (tmp_path / "s.glb").write_bytes(models.stage(model, [(0, 5, 0), (40, 5, 20)], in_room))
        means = []
        for sky in (light, dark):
            view = views.View(str(tmp_path / "s.glb"), "", 32, 24, ("--eye", "0,1.5,0.01", "--target", "0,0,0", "--fov", "60", "--env", sky))
            means.append(np.mean(judge.render_reference(pathtracer, view, 32).picture))
        assert means[0] > 0.05 and (means[1] == 0 or in_room)


def test_trials_write_only_to_out(pathtracer, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    main(["renders", "--quick", "--scenes", "penumbra", "--size", "64x48", "--crop", "16x12", "--seeds", "1", "--spp", "4", "--reference-spp", "32",
          "--samplers", "blue", "--pathtracer", str(pathtracer)])
    assert {path.relative_to(tmp_path) for path in tmp_path.glob("[eo]*/**/*") if path.is_file()} == {Path(f"out/renders/renders.{kind}") for kind in ("md", "csv", "png")}


def test_filters_are_compared_for_all_samplers_with_tables_for_each_count(bench, tmp_path, capsys):
    random, tables = np.random.default_rng(1), tmp_path / "tables"
    tables.mkdir()
    for spp in (1, 2):
        (tables / f"spp{spp}.rs").write_text("".join(f"{kind.upper()}: &[\n{','.join(map(str, random.integers(0, 256, size)))}];\n" for kind, size in heitz.SIZES.items()))
    bench("filters", "--samplers", "blue", "--spp", 2, "--heitz", tables)
    rows, text = read_numbers(tmp_path / "out" / "filters.csv"), capsys.readouterr().out
    assert {(row["filter"], row["sampler"]) for row in rows} == {(name, label) for name in ("box", "gaussian") for label in ("white", "blue", "heitz")}
    errors = {(row["filter"], row["sampler"], row["spp"]): row["error"] for row in rows if row["measure"] == "displayed"}
    assert errors["box", "blue", 2] != errors["gaussian", "blue", 2]
    assert "| `blue`, gaussian |" in text and "--heitz DIR" in text and str(tmp_path) not in text
