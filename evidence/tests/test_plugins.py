# SPDX-License-Identifier: Apache-2.0
"""Plug-in samplers: the samples in docs/bench.md, what the path tracer refuses, and whether their numbers are those in the tables."""

import re
import shutil
import subprocess

import numpy as np
import pytest
from conftest import ROOT

import bluenoise
from evidence.base.command import CommandError
from evidence.base.files import read_numbers
from evidence.realtime import realtime
from evidence.samplers import integrands, plugins, samplers

HEADER = ROOT / "examples" / "sampler_plugin"


def code(language):
    """The sample in docs/bench.md."""
    (found,) = re.findall(rf"```{language}\n(.*?)```", (ROOT / "docs" / "bench.md").read_text(encoding="utf-8"), re.DOTALL)
    return found


def library(folder, source, name="mine"):
    """Compiles C to a plug-in, as docs/bench.md says."""
    (folder / f"{name}.c").write_text(source)
    subprocess.run(["cc", "-O2", "-shared", "-fPIC", "-Wall", "-Wextra", "-Wno-unused-parameter", "-Werror", "-I", HEADER, f"{name}.c", "-o", f"{name}.so"],
                   cwd=folder, check=True)
    return folder / f"{name}.so"


@pytest.fixture(autouse=True)
def program(pathtracer):
    if not plugins.PROGRAM.is_file():
        pytest.skip(f"{plugins.PROGRAM} is not built; run scripts/setup")
    return pathtracer


@pytest.fixture
def python(tmp_path):
    (tmp_path / "mine.py").write_text(code("python"))
    return plugins.load(f"{tmp_path}/mine.py:draw")


def test_samples_in_three_languages_draw_the_same_numbers(tmp_path, python):
    files = [library(tmp_path, code("c"))]
    if shutil.which("rustc"):
        (tmp_path / "mine.rs").write_text(code("rust"))
        subprocess.run(["rustc", "-O", "--crate-type", "cdylib", "mine.rs", "-o", "rust.so"], cwd=tmp_path, check=True)
        files.append(tmp_path / "rust.so")
    numbers = python.numbers(2**31, 24, 5, 8, 14, 4)
    assert 0 <= numbers.min() and numbers.max() < 1 and abs(numbers.mean() - 0.5) < 0.01
    for file in files:
        np.testing.assert_array_equal(plugins.load(file).numbers(2**31, 24, 5, 8, 14, 4), numbers)


@pytest.mark.parametrize("compiler", [("cc", "-std=c99", "-xc"), ("c++", "-std=c++11", "-xc++")])
def test_header_is_plain_c_and_cpp(compiler):
    subprocess.run([*compiler, "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-fsyntax-only", HEADER / "sampler_plugin.h"], check=True)


def test_numbers_reach_the_tables_of_integrands(tmp_path, python):
    """A plug-in that draws the numbers of `blue` has its errors; a library and a Python function with the same numbers have the same errors."""
    def draw(seed, x, y, index, decision, dimensions):
        member = (0, 4, 8, 16).index(decision)  # rays 0 to 3
        return bluenoise.Sampler("blue", seed=seed).sample(x, y, index, bluenoise.domain(seed, 4 * seed + member), dimensions)

    ways = {"sobol": integrands.of_library("sobol"), "blue": integrands.of_library("blue"), "copy": plugins.Plugin("copy", draw, False).way(64),
            "python": python.way(64), "library": plugins.load(library(tmp_path, code("c"))).way(64)}
    rows = {}
    for row in samplers.measure_all(ways, 1, (1, 4)):
        rows.setdefault(row["sampler"], []).append((row["row"], row["spp"], row["value"]))
    assert rows["copy"] == rows["blue"] and rows["python"] == rows["library"] != rows["blue"]


def test_numbers_reach_the_tables_of_frames(python):
    half = plugins.Plugin("half", lambda seed, x, y, index, *_: np.full((*np.broadcast(x, y, index).shape, 2), 0.5), False)
    found = realtime.measure({"white": realtime.Draws("white"), "mine": python, "half": half}, 1, 2, ("half-plane",), 16)
    white, mine, constant = (found["half-plane", way][0][realtime.OUTCOMES.index("mean of 32")] for way in ("white", "mine", "half"))
    assert np.all(mine < white) and np.all(constant > 3 * white)


def test_numbers_reach_the_tables_of_renders(bench, tmp_path, capsys):
    """Compares the sample with a copy, and with one that draws no numbers but 0.5."""
    names = {"mine": library(tmp_path, code("c")), "copy": library(tmp_path, code("c"), "copy"),
             "half": library(tmp_path, code("c").replace("out[d] = ", "out[d] = 0.5f + 0 * "), "half")}
    bench("renders", "--samplers", "blue", *(word for name, file in names.items() for word in ("--sampler", f"{name}={file}")))
    rows = {}
    for row in read_numbers(tmp_path / "out" / "renders.csv"):
        rows.setdefault(row["sampler"], {})[row["measure"], row["scene"], row["spp"]] = row["error"]
    assert rows["mine"] == rows["copy"] != rows["blue"] and set(rows["mine"]) == set(rows["blue"])
    assert rows["half"]["rmse_2.1", "", 4] > 2 * rows["mine"]["rmse_2.1", "", 4]
    text = capsys.readouterr().out
    assert "| mine |" in text and "--sampler mine=FILE" in text and str(tmp_path) not in text


TUNED = "uint32_t sampler_plugin_is_tuned(void) { return 1; }\nvoid *sampler_plugin_create(uint64_t seed, uint32_t samples, const char *a) { return (void *)(uintptr_t)%s; }\n"


def test_state_samples_and_argument_are_passed(tmp_path):
    source = code("c").replace("out[d] = ", "out[d] = (float)(uintptr_t)state / 256 + 0 * ")
    counted = plugins.load(library(tmp_path, source + TUNED % "samples"))
    assert counted.tuned and np.all(counted.numbers(1, 2, 0, 1, 0, 2, 64) == 0.25)
    argued = plugins.load(f"{library(tmp_path, source + TUNED % 'a[1]', 'argued')}:x@")
    assert np.all(argued.numbers(1, 2, 0, 1, 0, 2) == 0.25)


@pytest.mark.parametrize(("change", "said"), [
    (("SAMPLER_PLUGIN_VERSION;", "7;"), "version 7 of sampler_plugin.h, not 1"), (("sampler_plugin_draw(const void *", "other(const void *"), "does not export sampler_plugin_draw()"),
    (("sampler_plugin_version(void)", "other(void)"), "does not export sampler_plugin_version()"), (("out[d] = ", "out[d] = 1 + 0 * "), "draws 1, which is not in [0, 1)"),
    (("out[d] = ", "out[d] = __builtin_nanf(\"\") * "), "draws nan, which is not in [0, 1)"), (("out[d] = ", "out[d] = -"), "draws -0."),
    (None, "there is no such file"), ("text", "cannot load the sampler")])
def test_path_tracer_refuses_broken_libraries(program, tmp_path, change, said):
    if change == "text":
        (tmp_path / "mine.so").write_text("no library")
    elif change:
        library(tmp_path, f"extern void other();\n{code('c').replace(*change)}" if "other" not in change[1] else code("c").replace(*change).replace(
            '#include "sampler_plugin.h"', '#include "sampler_plugin.h"\n' + ("uint32_t other(void);" if "version" in change[0] else "")))
    done = subprocess.run([program, "--sampler", "./mine.so", "--size", "16x12", "--spp", "1", "-o", "a.exr"], cwd=tmp_path, check=False, capture_output=True, text=True)
    assert done.returncode == 1 and done.stderr.count("\n") == 1 and done.stderr.startswith("pathtracer: ") and said in done.stderr, done.stderr
    assert not (tmp_path / "a.exr").exists()


def test_resumed_images_do_not_load_libraries_by_themselves(program, tmp_path):
    library(tmp_path, code("c"))

    def run(*words):
        return subprocess.run([program, *words, "--quiet", "-o", "a.exr"], cwd=tmp_path, check=False, capture_output=True, text=True)

    assert run("--sampler", "./mine.so", "--size", "16x12", "--spp", "1").returncode == 0
    assert "must be named again: --sampler ./mine.so" in run("--resume", "a.exr", "--spp", "2").stderr
    assert run("--resume", "a.exr", "--spp", "2", "--sampler", "./mine.so").returncode == 0


@pytest.mark.parametrize(("file", "said"), [("nowhere.so", "cannot load the sampler: .*nowhere.so"), ("mine.py:other", "has no function 'other'"), ("text.so", "cannot load the sampler")])
def test_bench_refuses_what_is_no_sampler(python, tmp_path, monkeypatch, file, said):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "text.so").write_text("no library")
    with pytest.raises(CommandError, match=said):
        plugins.load(file)
    with pytest.raises(CommandError, match=r"shape must be \(4, 4, 1, 2\)"):
        plugins.Plugin("one", lambda *_: np.ones((4, 4, 1, 2)), False).numbers(0, 4, 0, 1, 0, 2)


@pytest.mark.parametrize(("name", "side"), [("multijitter", 4), ("orthogonal", 2)])
def test_mitsubas_points_are_stratified(name, side):
    pytest.importorskip("mitsuba")
    found, count = plugins.load(f"{ROOT}/evidence/plugins/mitsuba_samplers.py:{name}"), side**2
    u = found.numbers(1, 3, 0, count, 4, 4, count)
    for pair in (u[..., :2], u[..., 2:]):
        cells = (side * pair).astype(int)
        assert all(len(set(pixel)) == count for pixel in (side * cells[..., 0] + cells[..., 1]).reshape(9, count).tolist())
        assert all(len(set(line)) == count for line in np.moveaxis((count * pair).astype(int), -1, 2).reshape(-1, count).tolist())
    assert found.tuned and len({pixel.tobytes() for pixel in u.reshape(9, -1)}) == 9 and found.counts == ((4, 9, 25, 49) if name == "orthogonal" else ())
    assert not np.array_equal(found.numbers(1, 3, 0, count, 0, 4, count), u) and np.array_equal(found.numbers(1, 3, 2, 2, 4, 2, count), u[:, :, 2:4, :2])


@pytest.mark.parametrize(("words", "said"), [
    (["--sampler", "mine.so"], "must be NAME=FILE, such as mine=./mine.so"), (["--sampler", "mine=nowhere.so"], "there is no file {}/nowhere.so"),
    (["--sampler"], "--sampler needs a path"), (["--openqmc"], "needs a path"), (["--openqmc", "nowhere"], "nowhere/include/oqmc/oqmc.h does not exist")])
def test_bench_rejects_invalid_options_before_it_builds(tmp_path, words, said):
    done = subprocess.run([ROOT / "scripts" / "bench", "renders", *words], cwd=tmp_path, check=False, capture_output=True, text=True)
    assert done.returncode != 0 and done.stdout == "" and said.format(tmp_path) in done.stderr and "building" not in done.stderr, done.stderr
