# SPDX-License-Identifier: Apache-2.0
"""Tests scripts/demo: the report of a tiny run, and error messages."""

import csv
import json
import re

import numpy as np
import pytest
from own_scene import convergence
from scene_files import QUAD, floor

import bluenoise
from evidence.base.command import run_or_say_why
from evidence.base.files import read_exr
from evidence.measure.image_error import rmse
from evidence.renders import judge
from evidence.renders.views import View

TINY = ("--size", "16x16", "--spp", "4", "--reference-spp", "32", "--seeds", "1")


def demo(pathtracer, *arguments):
    out = ["--out", str(pathtracer.folder / "out"), "--pathtracer", pathtracer.binary]
    run_or_say_why(convergence.run, [str(arguments[0]), *out, *arguments[1:]], "demo")


def rows_of(pathtracer):
    with open(pathtracer.folder / "out/convergence.csv", newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


@pytest.mark.slow
def test_report_of_a_tiny_run(pathtracer, capsys):
    demo(pathtracer, "cornell", *TINY)
    rows, out = rows_of(pathtracer), pathtracer.folder / "out"
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
    said = capsys.readouterr().out
    assert str(out) in said and not list(out.glob(".*"))
    first, mean = (read_exr(out / f"blue_{n}.exr")[0] for n in (2, 4))
    noise = np.percentile(bluenoise.visible_noise(first, 2 * mean - first), 95)
    assert "at 4 samples, in steps of an 8-bit display; 95% of the image is below: " in said and f"blue {noise:.2f}" in said
    assert f"blue {noise:.2f}" in text and "maps of visible noise" in text


@pytest.mark.slow
def test_a_changed_scene_is_rendered_again(pathtracer, capsys):
    """What the image lacks is said on the terminal and on the page."""
    scene = pathtracer.folder / "my scene.glb"
    found = set()
    for height in (0.5, 0.8):
        g = floor()
        g.quads([0.5 * QUAD + np.float32([0, height, 0])], g.material(extensions={"KHR_materials_unlit": {}}))
        g.save(scene)
        demo(pathtracer, scene, *TINY, "--samplers", "white")
        found.add(rows_of(pathtracer)[0]["rmse"])
    assert len(found) == 2
    for text in (capsys.readouterr().out, (pathtracer.folder / "out/report.html").read_text(encoding="utf-8")):
        assert "ignores the extension KHR_materials_unlit" in text


@pytest.mark.slow
def test_options_that_a_converted_scene_needs(pathtracer, monkeypatch, capsys):
    """The user's own options replace them."""
    scene = floor().save(pathtracer.folder / "a.glb")
    monkeypatch.setattr(convergence, "scene_for", lambda path, folder, program: (
        str(scene), ["--env", "none", "--lens", "0.1"], ["a.glb is a.blend as glTF", "a.blend: conversion to glTF loses hair"]))
    demo(pathtracer, scene, *TINY, "--spp", "1", "--samplers", "white", "--", "--env", "sky")
    assert (out := capsys.readouterr().out).startswith("demo: a.glb is a.blend as glTF\ndemo: a.blend: conversion to glTF loses hair\n")
    header = read_exr(pathtracer.folder / "out/white_1.exr")[0]
    assert header.max() > 0 and "Written" in out and "loses hair" in (pathtracer.folder / "out/report.html").read_text(encoding="utf-8")


@pytest.mark.parametrize(("arguments", "said"), [
    (["no-such-scene"], "no-such-scene"), (["cornell", "--samplers", "white,no-such"], "no-such"),
    (["cornell", "--", "--no-such-option"], "no-such-option"), (["missing.gltf"], "missing.gltf does not exist"),
    (["cornell", "--size", "0x9"], "WIDTHxHEIGHT"), (["cornell", "--reference-spp", "33"], "multiple of 32")], ids=str)
def test_bad_arguments_give_one_line(pathtracer, capsys, arguments, said):
    with pytest.raises(SystemExit) as stopped:
        demo(pathtracer, *arguments)
    message = str(stopped.value.code) if isinstance(stopped.value.code, str) else capsys.readouterr().err
    assert stopped.value.code != 0 and said in message and "Traceback" not in message
    assert "\n" not in message.split("usage:")[0].strip() and not (pathtracer.folder / "out/report.html").exists()


def test_ratios_need_enough_seeds_and_a_good_reference():
    said = lambda white, blue, own_error=0.0: convergence.note("white", "blue", {"white": white, "blue": blue}, own_error)
    assert "blue is 2.00 times smaller" in said([2.0, 2.1, 1.9], [1.0, 1.0, 1.0])
    assert "No significant difference" in said([1.0, 1.1, 0.9], [1.0, 1.0, 1.0])
    assert "at least 3 seeds" in said([2.0], [1.0]) and "own error" in said([2.0, 2.1, 1.9], [1.0, 1.0, 1.0], 0.9)
