# SPDX-License-Identifier: Apache-2.0
"""Samplers after denoising: the logic, with a blur as the denoiser, and one real run if pyoidn is installed."""

import re
import sys
import types

import numpy as np
import pytest
from scipy import ndimage

pytest.importorskip("flip_evaluator")

from report.measure.image_error import trimmed_relative_rmse
from report.renders import denoise, denoise_report, denoiser, judge, views

SIZE = 17, 16


@pytest.fixture(autouse=True)
def own_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))


def blur(colour, albedo, normal, clean):
    """A simple denoiser whose output depends on all of its inputs."""
    assert colour.shape == albedo.shape == normal.shape and np.all(np.abs(normal) < 1.001) and albedo.max() <= 1
    return ndimage.gaussian_filter(colour, (0.5 if clean else 1, 0.5 if clean else 1, 0)).astype(np.float32)


@pytest.fixture
def fake(monkeypatch):
    monkeypatch.setattr(denoiser, "load", lambda: (blur, "a blur"))


def arguments(pathtracer, out, *more):
    return ["--quick", "--size", "x".join(map(str, SIZE)), "--scenes", "cornell", "--spp", "2", "--seeds", "2",
            "--reference-spp", "64", "--jobs", "2", "--out", str(out), "--pathtracer", str(pathtracer), *more]


def test_interrupted_run_goes_on_and_writes_the_whole_report(pathtracer, tmp_path, monkeypatch, fake, capsys):
    out, made = tmp_path / "report", []
    real = denoiser.DenoisedRun.measure

    def counted(self, task, reference):
        if len(made) == 5:
            raise KeyboardInterrupt
        made.append(task)
        return real(self, task, reference)

    monkeypatch.setattr(denoiser.DenoisedRun, "measure", counted)
    with pytest.raises(SystemExit, match="run the command again"):
        denoise.main(arguments(pathtracer, out))
    assert not out.exists()

    first, made[:] = list(made), []
    monkeypatch.setattr(denoiser.DenoisedRun, "measure", lambda *a: (made.append(a[1]), real(*a))[1])
    denoise.main(arguments(pathtracer, out))
    # Two views, three samplers, two seeds.
    assert not set(first) & set(made) and len(first) + len(made) == 12
    text = (out / "denoise.md").read_text(encoding="utf-8")
    assert text.rstrip("\n") in capsys.readouterr().out
    assert "`scripts/bench denoise --quick --size 17x16" in text and str(tmp_path) not in text and "a blur" in text
    for name in re.findall(r"\((denoise[^)]*)\)", text):
        assert (out / name).is_file(), name

    made.clear()
    denoise.main(arguments(pathtracer, out))
    assert made == [] and (out / "denoise.md").read_text(encoding="utf-8") == text


def layers(pathtracer, scene, sampler, seed=0, spp=2):
    view = views.chosen("core", (scene,), (40, 36))[0]
    return view, denoiser.layers_of(pathtracer, view, sampler, seed, (1, spp))[spp]


def test_layers_and_lamps(pathtracer):
    view, picture = layers(pathtracer, "cornell", "blue")
    assert picture.colour.shape == picture.normal.shape == (36, 40, 3) and 0 <= picture.albedo.min() <= picture.albedo.max() <= 1
    # Light seen directly is a part of the colour to the bit, as both take the same samples, and most of it is dark.
    assert np.all(picture.colour >= picture.lamps * (1 - 1e-6)) and 0 < (picture.lamps > 0).mean() < 0.1
    assert picture.lamps.max() > 5 and picture.rays > 2


def test_without_a_denoiser_every_way_is_the_picture(pathtracer):
    def nothing(colour, albedo, normal, clean):
        return colour

    view, picture = layers(pathtracer, "cornell", "sobol")
    rays = denoiser.primary_rays(pathtracer, view, 0)
    for way in ("plain", "primary"):
        assert np.array_equal(denoiser.denoised(nothing, way, picture, rays), picture.colour)
    apart = denoiser.denoised(nothing, "apart", picture, rays)
    np.testing.assert_allclose(apart - rays.lamps, picture.colour - picture.lamps, atol=1e-5)


def test_measures_of_pictures_made_up():
    reference = np.full((40, 50, 3), 2.0)
    image = reference.copy()
    image[3, 4] += 11
    # An error of 11 over 2 + 0.2, in one of 2000 pixels.
    assert denoiser.relative_rmse(image, reference) == pytest.approx(5 / np.sqrt(2000))
    assert denoiser.worst_share(image, reference) == pytest.approx(1)
    found = denoiser.errors(image, reference, 0.0)
    assert found["trimmed"] == trimmed_relative_rmse(image, reference) == 0 and found["displayed"] == 0
    assert set(found) == set(denoiser.MEASURES)


def report_of(blue):
    """sobol has an error of 1, blue the given one, and "apart" half of that, with 1 % noise."""
    rng, view = np.random.default_rng(2), views.chosen("core", ("cornell",))
    results = {}
    for label, error in (("white", 1.2), ("sobol", 1.0), ("blue", blue)):
        for own in view:
            for seed in range(6):
                results[judge.Task(own, label, seed, (1, 2))] = [
                    {"spp": spp, "rays": 6.0, **{f"{way}:{name}": error * share * np.exp(0.01 * rng.standard_normal())
                                                 for way, share in (("plain", 1), ("primary", 0.8), ("apart", 0.5))
                                                 for name in (*denoiser.MEASURES, "worst")}} for spp in (1, 2)], {}
    options = types.SimpleNamespace(labels=denoise.LABELS, counts=(1, 2), seeds=6, views="core", reference_spp=64,
                                    command="scripts/bench denoise")
    references = {own: judge.Reference("", np.ones((2, 2, 3)), {}, 0.0, 0.0, 64, 1.0) for own in view}
    return denoise_report.Report(options, judge.Cells(results), references, {}, "0")


def test_what_hurts_is_said():
    report = report_of(1.25)
    assert report.gain("plain", 1, "relative").value == pytest.approx(0.8, rel=0.02)
    assert report.of_way("apart", 2, "relative").value == pytest.approx(2, rel=0.02)
    better, worse = report.cells_apart_from_one("plain", "relative")
    assert better == [] and [(scene, spp) for scene, spp, _ in worse] == [("cornell", 1), ("cornell", 2)]
    assert "worse in 2: cornell at 1 (0.8" in report.verdicts()
    assert "2.7" in report.text()  # 16 primary rays over 6 of a path


def test_what_helps_is_said():
    report = report_of(0.8)
    assert "Out of 2 combinations of scene and sample count, blue is better in 2" in report.verdicts() and "worse in 0." in report.verdicts()


def test_missing_package(monkeypatch, pathtracer):
    monkeypatch.setitem(sys.modules, "pyoidn", None)
    with pytest.raises(SystemExit, match="pip install pyoidn"):
        denoise.main(["--pathtracer", str(pathtracer)])


def test_the_denoiser_itself():
    pytest.importorskip("pyoidn")
    run, version = denoiser.load()
    rng = np.random.default_rng(1)
    guide = np.full((64, 64, 3), 0.5, np.float32)
    noisy = (0.5 * rng.exponential(size=(64, 64, 3))).astype(np.float32)
    before = noisy.copy()
    found = run(noisy, guide, np.broadcast_to(np.float32([0, 0, 1]), noisy.shape), False)
    assert version and np.array_equal(noisy, before) and found.std() < 0.3 * noisy.std()
    assert found.mean() == pytest.approx(0.5, rel=0.15)
