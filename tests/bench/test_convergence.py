# SPDX-License-Identifier: Apache-2.0
"""The convergence command: a tiny run with its page, and error messages."""

import csv
import re

import numpy as np
import pytest

pytest.importorskip("flip_evaluator")

from report.base.files import read_exr, write_exr
from report.measure.image_error import rmse
from report.pages import convergence
from report.renders.renderer import Request, progressive, run_pathtracer

TRIANGLE = """v -1 0 -1
v 1 0 -1
v 0 0 1
v -1 0.5 0
v 1 0.5 0
v 0 1.5 0
f 1 2 3
f 4 5 6
"""


@pytest.fixture(autouse=True)
def own_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))


def run(pathtracer, folder, *arguments):
    convergence.main([*map(str, arguments), "--size", "16x16", "--spp", "4", "--reference-spp", "32", "--seeds", "1",
                      "--threads", "1",
                      "--out", str(folder), "--pathtracer", str(pathtracer)])


def test_tiny_run_to_the_page(pathtracer, tmp_path, capsys):
    out = tmp_path / "out"
    run(pathtracer, out, "cornell")
    with open(out / "convergence.csv", newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [(row["sampler"], int(row["spp"])) for row in rows] == [
        (sampler, spp) for sampler in ("white", "sobol", "blue") for spp in (1, 2, 3, 4)]
    reference, _ = read_exr(next((tmp_path / "cache/libbn/references").glob("cornell-16x16-sobol-32.exr")))
    for row in rows:
        assert 0 < float(row["flip"]) < 1 and float(row["seconds"]) > 0 and float(row["relative_rmse"]) > 0
        if int(row["spp"]) in (1, 4):
            image, _ = read_exr(out / f"{row['sampler']}_{row['spp']}.exr")
            assert float(row["rmse"]) == pytest.approx(rmse(image, reference), rel=1e-4)
            assert float(row["rmse_2.1"]) == pytest.approx(rmse(image, reference, 2.1), rel=1e-4)
    text = (out / "report.html").read_text(encoding="utf-8")
    assert re.findall(r'(?:src|href)="(?!data:|#)[^"]+"', text) == [] and "@import" not in text
    assert "1 samples" not in text and "1 sample per pixel" in text
    order = [text.index(mark) for mark in ("id=compare>", "<table class=pictures>", "<svg", "<table><thead>")]
    assert order == sorted(order)
    assert "times smaller" not in text.split("id=compare-data")[1].split("</script>")[0]
    for control in ("spp", "left", "right", "zoom", "blur", "swap", "divider"):
        assert f"data-part={control}" in text
    assert text.count("<svg") == 3 * 3 + 2
    printed = capsys.readouterr().out
    assert "white" in printed and str(out) in printed
    assert not list(out.glob("*progressive*")) and not list(out.glob(".*"))


def test_own_scene_and_own_reference(pathtracer, tmp_path, monkeypatch):
    scene = tmp_path / "my scene.obj"
    scene.write_text(TRIANGLE)
    monkeypatch.chdir(tmp_path)
    run(pathtracer, tmp_path / "a", "my scene.obj", "--samplers", "white,blue")
    (reference,) = (tmp_path / "cache/libbn/references").glob("my_scene-*-sobol-32.exr")
    run(pathtracer, tmp_path / "b", "my scene.obj", "--samplers", "white,blue", "--reference", reference)
    drop_seconds = [[[v for k, v in row.items() if k != "seconds"] for row in
                     csv.DictReader((tmp_path / name / "convergence.csv").open(encoding="utf-8"))] for name in "ab"]
    assert drop_seconds[0] == drop_seconds[1]
    # A scene that was changed is not judged by the reference of the old one.
    before = reference.read_bytes()
    scene.write_text(TRIANGLE.replace("0.5", "0.8"))
    run(pathtracer, tmp_path / "a", "my scene.obj", "--samplers", "white")
    assert reference.read_bytes() != before


@pytest.mark.parametrize("arguments, said", [
    (["no-such-scene"], "no-such-scene"),
    (["cornell", "--samplers", "white,no-such"], "no-such"),
    (["cornell", "--", "--no-such-option"], "no-such-option"),
    (["missing.gltf"], "missing.gltf does not exist"),
    (["cornell", "--size", "0x9"], "WIDTHxHEIGHT"),
    (["cornell", "--reference-spp", "33"], "multiple of 32"),
], ids=str)
def test_bad_arguments_are_one_line(pathtracer, tmp_path, capsys, arguments, said):
    out = tmp_path / "out"
    common = ["--out", str(out), "--pathtracer", str(pathtracer)]
    with pytest.raises(SystemExit) as stopped:
        convergence.main([arguments[0], *common, *arguments[1:]])
    message = str(stopped.value.code) if isinstance(stopped.value.code, str) else capsys.readouterr().err
    assert stopped.value.code != 0 and said in message and "Traceback" not in message
    assert "\n" not in message.split("usage:")[0].strip()
    assert not (out / "report.html").exists()


def test_reference_of_another_size(pathtracer, tmp_path):
    write_exr(tmp_path / "ref.exr", np.ones((8, 9, 3), np.float32), {})
    with pytest.raises(SystemExit, match=r"9x8 pixels, the pictures 16x16; set --size"):
        run(pathtracer, tmp_path / "out", "cornell", "--reference", tmp_path / "ref.exr")
    (tmp_path / "text.exr").write_text("no picture")
    with pytest.raises(SystemExit, match="text.exr is not an EXR"):
        run(pathtracer, tmp_path / "out", "cornell", "--reference", tmp_path / "text.exr")


def test_missing_program_says_how_to_build_it(tmp_path):
    with pytest.raises(SystemExit, match="scripts/setup"):
        run(tmp_path / "no-pathtracer", tmp_path / "out", "cornell")


def test_errors_over_seeds_are_medians():
    row = {"spp": 2, "seconds": 1.0, "rmse": 3.0, "relative_rmse": 1.0, "rmse_1.0": 0.0, "rmse_2.1": 2.0}
    (mean,) = convergence.over_seeds([[row], [{**row, "seconds": 2.0, "rmse": 4.0}], [{**row, "seconds": 9.0, "rmse": 0.0}]])
    assert {name: mean[name] for name in row} == {**row, "seconds": 2.0, "rmse": 3.0}
    assert mean["each"]["rmse"] == [3.0, 4.0, 0.0]


def test_headlines_say_only_what_seeds_and_reference_allow():
    def rows(white, blue):
        return [{"sampler": name, "spp": 1, "each": {"rmse_2.1": errors}}
                for name, errors in (("white", white), ("blue", blue))]

    samplers = ("white", "blue")
    (fact,) = convergence.headlines(rows([2.0, 2.1, 1.9], [1.0, 1.0, 1.0]), samplers, (1,), 0.0)
    assert fact[0].startswith("2.00") and "white at 1 sample per pixel" in fact[1]
    (even,) = convergence.headlines(rows([1.0, 1.1, 0.9], [1.0, 1.0, 1.0]), samplers, (1,), 0.0)
    assert even[0] == "even"
    assert convergence.headlines(rows([2.0], [1.0]), samplers, (1,), 0.0) == []
    assert convergence.headlines(rows([2.0, 2.1, 1.9], [1.0, 1.0, 1.0]), samplers, (1,), 0.9) == []


def test_several_seeds_are_the_default():
    assert convergence.parse_options(["cornell"]).seeds >= 3


def test_progressive_parts_are_the_picture_at_each_count(pathtracer, tmp_path):
    request = Request("blue", 1, seed=3, width=16, height=12)
    for spp, picture, attributes in progressive(pathtracer, request, (1, 3, 4), 1):
        run_pathtracer(pathtracer, [*Request("blue", spp, seed=3, width=16, height=12).arguments(), "--quiet",
                                    "-o", tmp_path / "whole.exr"])
        whole, other = read_exr(tmp_path / "whole.exr")
        np.testing.assert_allclose(picture, whole, rtol=1e-5, atol=1e-6)
        assert attributes["rays"] == int(other["rays"]) and attributes["spp"] == spp


def test_part_worth_showing_is_where_noise_and_things_are():
    rng = np.random.default_rng(2)
    reference = np.full((40, 60, 3), 0.5)
    reference[20:30, 40:50] = 0.8
    noise = 0.01 * rng.standard_normal(reference.shape)
    noise[18:32, 38:52] *= 10
    left, top, width, height = convergence.part_worth_showing(reference, reference + noise)
    assert (width, height) == (10, 10) and 35 <= left <= 50 and 15 <= top <= 30
