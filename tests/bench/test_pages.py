# SPDX-License-Identifier: Apache-2.0
"""scripts/convergence and scripts/demo: a tiny run with its page, and error messages."""

import csv
import json
import re

import numpy as np
import pytest

pytest.importorskip("flip_evaluator")

from report.__main__ import main as bench
from report.base.files import read_exr, write_exr
from report.measure.image_error import rmse
from report.pages import convergence, slider

TRIANGLE = "v -1 0 -1\nv 1 0 -1\nv 0 0 1\nv -1 0.5 0\nv 1 0.5 0\nv 0 1.5 0\nf 1 2 3\nf 4 5 6\n"


@pytest.fixture(autouse=True)
def own_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))


def run(pathtracer, folder, *arguments):
    bench(["convergence", *map(str, arguments), "--size", "16x16", "--spp", "4", "--reference-spp", "32", "--seeds", "1",
                      "--threads", "1", "--out", str(folder), "--pathtracer", str(pathtracer)])


def rows_of(folder):
    with open(folder / "convergence.csv", newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_tiny_run_to_the_page(pathtracer, tmp_path, monkeypatch, capsys):
    out, early, real = tmp_path / "out", [], convergence.make_reference
    monkeypatch.setattr(convergence, "make_reference", lambda *a: early.append((out / "report.html").read_text()) or real(*a))
    run(pathtracer, out, "cornell")
    # Before the reference, the page shows the pictures, loads itself again, and promises no figure.
    assert "location.reload()" in early[0] and "Still to come" in early[0] and "<table><thead>" not in early[0]
    assert [(row["sampler"], int(row["spp"])) for row in rows_of(out)] == [
        (sampler, spp) for sampler in ("white", "sobol", "blue") for spp in (1, 2, 3, 4)]
    reference, _ = read_exr(next((tmp_path / "cache/libbn/references").glob("cornell-16x16-sobol-32.exr")))
    for row in rows_of(out):
        assert 0 < float(row["flip"]) < 1 and float(row["seconds"]) > 0 and float(row["relative_rmse"]) > 0
        image, _ = read_exr(out / f"{row['sampler']}_{row['spp']}.exr")
        assert float(row["rmse_2.1"]) == pytest.approx(rmse(image, reference, 2.1), rel=1e-4)
    text = (out / "report.html").read_text(encoding="utf-8")
    assert re.findall(r'(?:src|href)="(?!data:|#)[^"]+"', text) == [] and "@import" not in text and "http-equiv" not in text
    assert "1 samples" not in text and "1 sample per pixel" in text
    order = [text.index(mark) for mark in ("id=compare>", "id=steps>", "<table class=pictures>", "<table><thead>")]
    assert order == sorted(order)
    steps, compare = (json.loads(re.search(rf"id={name}-data>(.*?)</script>", text, re.S)[1]) for name in ("steps", "compare"))
    assert steps["counts"] == [1, 4] and list(compare["counts"]) == ["1", "4"] and len(steps["errors"]["blue"]) == 2
    assert "needs at least 3 seeds" in compare["counts"]["4"]["notes"]["white|blue"]
    assert str(out) in capsys.readouterr().out and not list(out.glob(".*"))


def test_own_scene_and_own_reference(pathtracer, tmp_path, monkeypatch):
    scene = tmp_path / "my scene.obj"
    scene.write_text(TRIANGLE)
    monkeypatch.chdir(tmp_path)
    run(pathtracer, "out/a", "my scene.obj", "--samplers", "white,blue")
    (reference,) = (tmp_path / "cache/libbn/references").glob("my_scene-*-sobol-32.exr")
    run(pathtracer, "out/b", "my scene.obj", "--samplers", "white,blue", "--reference", reference)
    first, second = ([row["rmse"] for row in rows_of(tmp_path / "out" / name)] for name in "ab")
    assert first == second
    # A scene that was changed is rendered again, and not judged by the reference of the old one.
    before = reference.read_bytes()
    scene.write_text(TRIANGLE.replace("0.5", "0.8"))
    run(pathtracer, "out/a", "my scene.obj", "--samplers", "white")
    assert reference.read_bytes() != before and rows_of(tmp_path / "out/a")[0]["rmse"] != first[0]


@pytest.mark.parametrize("arguments, said", [
    (["no-such-scene"], "no-such-scene"), (["cornell", "--samplers", "white,no-such"], "no-such"),
    (["cornell", "--", "--no-such-option"], "no-such-option"), (["missing.gltf"], "missing.gltf does not exist"),
    (["cornell", "--size", "0x9"], "WIDTHxHEIGHT"), (["cornell", "--reference-spp", "33"], "multiple of 32"),
    (["cornell", "--reference", "ref.exr", "--size", "16x16"], "9x8 pixels, the pictures 16x16; set --size"),
    (["cornell", "--reference", "text.exr"], "text.exr is not an EXR"),
], ids=str)
def test_bad_arguments_are_one_line(pathtracer, tmp_path, monkeypatch, capsys, arguments, said):
    monkeypatch.chdir(tmp_path)
    write_exr(tmp_path / "ref.exr", np.ones((8, 9, 3), np.float32), {})
    (tmp_path / "text.exr").write_text("no picture")
    with pytest.raises(SystemExit) as stopped:
        bench(["convergence", arguments[0], "--out", "out", "--pathtracer", str(pathtracer), *arguments[1:]])
    message = str(stopped.value.code) if isinstance(stopped.value.code, str) else capsys.readouterr().err
    assert stopped.value.code != 0 and said in message and "Traceback" not in message
    assert "\n" not in message.split("usage:")[0].strip() and not (tmp_path / "out/report.html").exists()


def test_headlines_say_only_what_seeds_and_reference_allow():
    def found(white, blue, own_error=0.0):
        rows = [{"sampler": name, "spp": 1, "each": {"rmse_2.1": errors}} for name, errors in (("white", white), ("blue", blue))]
        return convergence.headlines(rows, ("white", "blue"), (1,), own_error)

    ((fact, caption),) = found([2.0, 2.1, 1.9], [1.0, 1.0, 1.0])
    assert fact.startswith("2.00") and "white at 1 sample per pixel" in caption
    assert found([1.0, 1.1, 0.9], [1.0, 1.0, 1.0])[0][0] == "even"
    assert found([2.0], [1.0]) == found([2.0, 2.1, 1.9], [1.0, 1.0, 1.0], 0.9) == []
    assert slider.evenly([0.09996, 1.0]) == ["0.100", "1.000"] and slider.evenly([0.0123456, 0.2]) == ["0.0123", "0.2000"]
