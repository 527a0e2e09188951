# SPDX-License-Identifier: Apache-2.0
"""The comparison in Cycles: scenes, what adaptive sampling adds, and the report. With BN_CYCLES=DIR, a checkout of Cycles, pictures too:
threads and seeds. That builds Cycles, which takes a quarter of an hour the first time."""

import math
import os
import subprocess
from types import SimpleNamespace

import numpy as np
import pytest
from report.base.files import read_exr, write_exr
from report.others import cycles, cycles_build, cycles_report, cycles_scenes, other_renderer
from report.renders.renderer import RenderError


@pytest.fixture
def checkout(tmp_path):
    """A folder that looks like Cycles."""
    folder = tmp_path / "cycles"
    for name in ("src/kernel/sample", "src/app", "src/session", "lib/linux_x64", "examples"):
        (folder / name).mkdir(parents=True)
    (folder / "src/kernel/sample/pattern.h").write_text("first\n")
    for path, before, _ in cycles_build.CHANGES:
        (folder / path).write_text(f"before {before} after\n")
    (folder / "examples/scene_monkey.xml").write_text(
        '<cycles>\n<camera type="perspective" fov="0.5"/>\n<include src="./objects/suzanne.xml" />\n</cycles>\n')
    git = ("git", "-C", folder, "-c", "user.name=a", "-c", "user.email=a@example.org")
    for command in (("init", "-q"), ("add", "."), ("commit", "-q", "-m", "first")):
        subprocess.run([*git, *command], check=True)
    return folder


def test_a_copy_is_patched_and_what_is_the_same_stays(checkout, tmp_path, monkeypatch):
    patch = tmp_path / "a.patch"
    patch.write_text("--- a/src/kernel/sample/pattern.h\n+++ b/src/kernel/sample/pattern.h\n@@ -1 +1,2 @@\n first\n+second\n")
    monkeypatch.setattr(cycles_build, "PATCH", patch)
    folder = tmp_path / "cache"
    folder.mkdir()
    cycles_build.prepare(checkout, folder)
    copy = folder / "src"
    assert (copy / "src/kernel/sample/pattern.h").read_text() == "first\nsecond\n"
    for path, _, after in cycles_build.CHANGES:
        assert (copy / path).read_text() == f"before {after} after\n"
    assert (copy / "src/kernel/sample/blue.h").read_text() == (cycles_build.OWN / "blue.h").read_text()
    assert not (copy / "lib").exists() and (checkout / "lib").exists()
    assert (checkout / "src/kernel/sample/pattern.h").read_text() == "first\n"
    before = (copy / "src/kernel/sample/blue.h").stat().st_mtime_ns
    cycles_build.prepare(checkout, folder)
    assert (copy / "src/kernel/sample/blue.h").stat().st_mtime_ns == before
    with pytest.raises(RenderError, match=f"checkout {cycles_build.TAG}"):
        cycles_build.check(checkout)
    with pytest.raises(RenderError, match="is no checkout of Cycles"):
        cycles_build.check(tmp_path)


class Made:
    """Cells: Tabulated Sobol has 1.5 times the error of blue and half its time, blue noise 1.2 times."""

    def get(self, view, label, spp, measure):
        name, _, threshold = label.partition(" ")
        factor = {"blue": 1, "tabulated_sobol": 1.5}.get(name, 1.2)
        if measure == "samples":
            return [20 * factor] * 4 if threshold else None
        if measure == "seconds":
            return [0.1 + 1e-3 * spp * (2 if name == "blue" else 1)] * 4
        return [factor / math.sqrt(spp)] * 4


def report(names=("penumbra", "monkey")):
    views = [cycles_scenes.View(name) for name in names]
    references = {view: other_renderer.Reference(np.zeros((2, 2, 3)), dict.fromkeys(cycles.MEASURES, 0.001), 4096, 1.0) for view in views}
    options = SimpleNamespace(seeds=4, command="scripts/bench cycles --cycles DIR")
    return cycles_report.Report(options, Made(), references, cycles.SAMPLERS, cycles.COUNTS)


def test_the_report_says_what_was_measured():
    text = report().text()
    assert ("program, has 1.50, 1.50, 1.50, 1.50 times the error of `blue` as displayed" in text
            and "has 1.20, 1.20, 1.20, 1.20 times with *pure* (raw" in text and "takes 2.00 times as long" in text)
    assert "Told 64 and stopped at 1, 4, 16, as in a preview, *pure* has 1.20, 1.20, 1.20 times and" in text
    assert "takes 1.50 (1.50 to 1.50) times the samples of `blue` and ends with 1.50 (1.50 to 1.50) times its error" in text
    assert text.count("1.50 (1.50 to 1.50)") == 2 * 9 + 3 * len(cycles_report.ADAPTIVE) + 2
    assert "| Tabulated Sobol | 1.50 (1.50) |" in report().summary()
    assert max(map(len, text.split("## Other")[0].replace("|", "\n").splitlines())) < 800


def test_the_whole_command_with_a_stand_in(tmp_path, checkout, monkeypatch):
    """A program whose pictures are noise that depends on the scene file alone."""
    for number in range(10):
        noise = np.random.default_rng(number).random((cycles_scenes.SIZE[1], cycles_scenes.SIZE[0], 3))
        write_exr(tmp_path / f"{number}.exr", noise.astype(np.float32), {})
    program = tmp_path / "program"
    program.write_text("#!/bin/sh\nfor last; do :; done\nwhile [ $1 != --output ]; do shift; done\n"
                       f"sum=$(cksum < $last)\ncp {tmp_path}/$((${{sum%% *}} % 10)).exr $2\n")
    program.chmod(0o755)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    (tmp_path / "docs/report").mkdir(parents=True)
    guide = tmp_path / "guide.md"
    guide.write_text("<!-- table: scripts/bench cycles -->\n<!-- end of the table -->\n")
    monkeypatch.chdir(tmp_path)
    cycles.run(["--cycles", str(checkout), "--program", str(program), "--scenes", "monkey", "--spp", "4", "--seeds", "2", "--jobs", "2",
                "--out", "docs/report", "--guide", str(guide)])
    text = (tmp_path / "docs/report/cycles.md").read_text()
    assert "## Stopped early" in text and "## Adaptive sampling" in text and "`monkey`: Cycles'" in text
    assert "| Tabulated Sobol |" in guide.read_text() and (tmp_path / "out/cycles/cycles.csv").is_file()
    assert (tmp_path / "docs/cycles.jpg").is_file()


# ---- With Cycles

@pytest.fixture(scope="session")
def program():
    if not os.environ.get("BN_CYCLES"):
        pytest.skip("BN_CYCLES is not set to a checkout of Cycles")
    return cycles_build.build(os.environ["BN_CYCLES"], os.cpu_count() or 1)


def picture(program, folder, settings, spp):
    out = folder / "out.exr"
    cycles.render(program, os.environ["BN_CYCLES"], "penumbra", settings, out, spp)
    return read_exr(out)[0]


def test_pictures_differ_by_their_seeds_alone(program, tmp_path):
    first, again, other = (picture(program, tmp_path, cycles.integrator("blue", 2, seed), 2) for seed in (1, 1, 2))
    assert np.array_equal(first, again) and np.mean(first != other) > 0.5 and abs(first.mean() / other.mean() - 1) < 0.02


@pytest.mark.parametrize("sampler", cycles.SAMPLERS)
def test_what_patterns_are_told(program, tmp_path, sampler):
    """Blue noise of Cycles depends on it, as the table of pictures that stop early needs; `blue` does not."""
    told_four, told_more = (picture(program, tmp_path, cycles.integrator(sampler, told, 1), 4) for told in (4, 64))
    assert np.array_equal(told_four, told_more) == (sampler not in cycles_report.PREVIEW)
