# SPDX-License-Identifier: Apache-2.0
"""scripts/demo: a tiny run with its page, and error messages."""

import csv
import json
import re

import pytest
from own_scene import convergence

from evidence.base.command import run_or_say_why
from evidence.base.files import read_exr
from evidence.measure.image_error import rmse
from evidence.renders import judge
from evidence.renders.views import View

TRIANGLE = "v -1 0 -1\nv 1 0 -1\nv 0 0 1\nv -1 0.5 0\nv 1 0.5 0\nv 0 1.5 0\nf 1 2 3\nf 4 5 6\n"


def run(pathtracer, folder, *arguments):
    run_or_say_why(convergence.run, [*map(str, arguments), "--size", "16x16", "--spp", "4", "--reference-spp", "32", "--seeds", "1",
           "--out", str(folder), "--pathtracer", str(pathtracer.binary)], "demo")
    with open(folder / "convergence.csv", newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_report_of_a_tiny_run(pathtracer, tmp_path, capsys):
    out = tmp_path / "out"
    rows = run(pathtracer, out, "cornell")
    assert [(row["sampler"], int(row["spp"])) for row in rows] == [
        (sampler, spp) for sampler in ("white", "sobol", "blue") for spp in (1, 2, 3, 4)]
    reference = judge.render_reference(pathtracer.binary, View("cornell", "", 16, 16), 32).picture
    for row in rows:
        assert float(row["seconds"]) > 0
        image, _ = read_exr(out / f"{row['sampler']}_{row['spp']}.exr")
        assert float(row["rmse_2.1"]) == pytest.approx(rmse(image, reference, 2.1), rel=1e-4)
    text = (out / "report.html").read_text(encoding="utf-8")
    assert re.findall(r'(?:src|href)="(?!data:|#)[^"]+"', text) == [] and "@import" not in text
    data = json.loads(re.search(r"id=\"data\">(.*?)</script>", text, re.S)[1])
    assert data["counts"] == [1, 2, 3, 4] and [len(data[name]["blue"]) for name in ("pictures", "errors")] == [4, 4]
    assert "needs at least 3 seeds" in data["notes"][3]["white|blue"]
    assert str(out) in capsys.readouterr().out and not list(out.glob(".*"))


def test_a_scene_that_was_changed_is_rendered_again(pathtracer, tmp_path):
    scene = tmp_path / "scene" / "my scene.obj"
    scene.parent.mkdir()
    found = []
    for height in ("0.5", "0.8"):
        scene.write_text(TRIANGLE.replace("0.5", height))
        found.append(run(pathtracer, tmp_path / "out", scene, "--samplers", "white")[0]["rmse"])
    assert found[0] != found[1]


@pytest.mark.parametrize("arguments, said", [
    (["no-such-scene"], "no-such-scene"), (["cornell", "--samplers", "white,no-such"], "no-such"),
    (["cornell", "--", "--no-such-option"], "no-such-option"), (["missing.gltf"], "missing.gltf does not exist"),
    (["cornell", "--size", "0x9"], "WIDTHxHEIGHT"), (["cornell", "--reference-spp", "33"], "multiple of 32"),
], ids=str)
def test_bad_arguments_are_one_line(pathtracer, tmp_path, monkeypatch, capsys, arguments, said):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as stopped:
        run_or_say_why(convergence.run, [arguments[0], "--out", "out", "--pathtracer", str(pathtracer.binary), *arguments[1:]], "demo")
    message = str(stopped.value.code) if isinstance(stopped.value.code, str) else capsys.readouterr().err
    assert stopped.value.code != 0 and said in message and "Traceback" not in message
    assert "\n" not in message.split("usage:")[0].strip() and not (tmp_path / "out/report.html").exists()


def test_ratios_need_seeds_and_a_good_reference():
    def said(white, blue, own_error=0.0):
        return convergence.note("white", "blue", {"white": white, "blue": blue}, own_error)

    assert "blue is 2.00 times smaller" in said([2.0, 2.1, 1.9], [1.0, 1.0, 1.0])
    assert "No significant difference" in said([1.0, 1.1, 0.9], [1.0, 1.0, 1.0])
    assert "at least 3 seeds" in said([2.0], [1.0]) and "own error" in said([2.0, 2.1, 1.9], [1.0, 1.0, 1.0], 0.9)
