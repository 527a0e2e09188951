# SPDX-License-Identifier: Apache-2.0
"""scripts/farm: parts cover an image once, and a cluster's image is that of one machine, even if workers die.

The tests of the cluster need Dask, which scripts/farm installs."""

import contextlib
import json
import os
import shutil
import signal
import subprocess
import sys
import time

import numpy as np
import OpenEXR
import pytest
from conftest import ROOT
from pathtracer_driver import assert_same, read_layers
from render_farm import cluster, worker
from render_farm.__main__ import parse
from render_farm.parts import FarmError, PartsFolder, names_of, split
from scene_files import write_environment

# A larger picture would only take longer; each part takes long enough to be interrupted.
PICTURE = ["--size", "70x50", "--spp", "1000", "--seed", "5"]


def start(pathtracer, *arguments):
    return subprocess.Popen([sys.executable, "-m", "render_farm", "--pathtracer", pathtracer.binary, *map(str, arguments)],
                            cwd=pathtracer.folder, env={**os.environ, "PYTHONPATH": f"{ROOT}:{ROOT / 'scripts'}"}, text=True,
                            stdout=subprocess.PIPE, stderr=subprocess.PIPE)


def ended(process):
    """Its exit status, and what it printed."""
    out, message = process.communicate(timeout=120)
    return process.returncode, out, message


def refused(pathtracer, *arguments):
    code, out, message = ended(start(pathtracer, *arguments))
    assert code == 1 and out == "" and message.startswith("farm: ") and message.count("\n") == 1, message
    assert list(pathtracer.folder.glob("*.parts")) == []
    return message


def wait_for(condition, seconds=120):
    end = time.monotonic() + seconds
    while not (found := condition()):
        assert time.monotonic() < end
        time.sleep(0.02)
    return found


# ---- Splitting, without a cluster


@pytest.mark.parametrize("crop", [(0, 0, 20, 9), (3, 2, 17, 9)])
@pytest.mark.parametrize("tile", [(5, 4), (7, 100), (1, 3)])
def test_parts_cover_each_sample_once(crop, tile):
    counts = np.zeros((9, 20), int)
    parts = split(crop, 3, 10, tile)
    for x0, y0, x1, y1, first, count in parts:
        assert 0 < x1 - x0 <= tile[0] and 0 < y1 - y0 <= tile[1] and (first, count) == (3, 10)
        counts[y0:y1, x0:x1] += 1
    expected = np.zeros_like(counts)
    expected[crop[1]:crop[3], crop[0]:crop[2]] = 1
    assert np.array_equal(counts, expected)
    assert len({part.file_name for part in parts}) == len(parts)


def test_parts_folder(pathtracer, tmp_path):
    first, second = parts = split((0, 0, 8, 4), 0, 2, (4, 4))
    folder = PartsFolder(tmp_path / "a.exr", {"seed": "1"}, "")
    data = pathtracer.render("--size", "8x4", *first.arguments()).read_bytes()
    folder.add(first, data)
    again = PartsFolder(tmp_path / "a.exr", {"seed": "1"}, "")
    assert again.has(first) and not again.has(second) and (again.path / first.file_name).read_bytes() == data
    for seed, inputs in (("2", ""), ("1", "another file")):
        with pytest.raises(FarmError, match="other settings, files or programs"):
            PartsFolder(tmp_path / "a.exr", {"seed": seed}, inputs)
    (folder.path / "mine.txt").write_text("x")
    (folder.path / "1,2,3,4,5,6.exr").write_text("another picture's")
    folder.remove(parts)
    assert sorted(path.name for path in folder.path.iterdir()) == ["1,2,3,4,5,6.exr", "mine.txt"]
    (tmp_path / "damaged.exr.parts").mkdir()
    (tmp_path / "damaged.exr.parts" / "picture.json").write_bytes(b"\xff\x00")
    (tmp_path / "link.exr.parts").symlink_to("a.exr.parts")
    for name, message in (("a", "remove it"), ("damaged", "remove it"), ("link", "symbolic link")):
        with pytest.raises(FarmError, match=message):
            PartsFolder(tmp_path / f"{name}.exr", {"seed": "1"}, "")


def test_wrong_and_damaged_parts_are_refused(pathtracer, even_sky, tmp_path):
    part, = split((0, 0, 8, 4), 3, 2, (8, 4))
    folder = PartsFolder(tmp_path / "a.exr", {}, "")
    rendered = lambda *more, **change: pathtracer.render("--size", "8x8", *part._replace(**change).arguments(), *more).read_bytes()
    whole = rendered()
    folder.add(part, whole)
    assert folder.remove_damaged([part]) == [] and folder.has(part)
    with OpenEXR.File(str(folder.path / part.file_name), separate_channels=True) as file:
        file.channels()["count"].pixels[3, 7] -= 1
        file.write(str(tmp_path / "stopped.exr"))
    for wrong, message in [
        (rendered(y1=3), "shows the pixels 0,0,8,3"), (rendered(count=1), "has other samples"), (rendered(first=2), "has other samples"),
        ((tmp_path / "stopped.exr").read_bytes(), "has other samples"),
        (rendered("--env", even_sky), "was rendered from other files"), (whole[:-100], "is damaged"), (b"", "is damaged"),
    ]:
        with pytest.raises(FarmError, match=message):
            folder.add(part, wrong)
        assert (folder.path / part.file_name).read_bytes() == whole
        (folder.path / part.file_name).write_bytes(wrong)
        (path, said), = folder.remove_damaged([part])
        assert path.name == part.file_name and message in said and not folder.has(part)
        folder.add(part, whole)


def test_names_of_inputs(pathtracer):
    """Names come back whole, whatever is in them."""
    for name in ["a b.exr", "back\\slash.exr", "\u00e9.exr", "  "]:
        shutil.copy(write_environment(pathtracer.folder / "sky.exr", 1.0), pathtracer.folder / name)
        assert names_of(pathtracer.success("--env", name, "--list-inputs").stdout) == [name]


def test_options_for_parts_and_for_merging(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "sky.exr").write_bytes(b"")
    options = parse(["--env", "sky.exr", "--exposure", "-1", "--photometric", "-o", "a.exr"])
    assert options.shared == ["--env", str(tmp_path / "sky.exr"), "--photometric", "--size", "512x512"]
    assert options.merging == ["--exposure", "-1"]


def test_workers_notice_another_program_or_file(tmp_path, monkeypatch):
    program, scene = tmp_path / "program", tmp_path / "scene.glb"
    program.write_bytes(b"1")
    scene.write_bytes(b"2")
    wanted = worker.fingerprint(str(program), [str(scene)])
    assert worker.complaint(str(program), wanted, [str(scene)]) == ""
    scene.write_bytes(b"two")
    assert "scene.glb is another file" in worker.complaint(str(program), wanted, [str(scene)])
    scene.unlink()
    assert "cannot read" in worker.complaint(str(program), wanted, [str(scene)])
    other = tmp_path / "other"
    other.write_bytes(b"one")
    monkeypatch.setenv("BN_PATHTRACER", str(other))
    assert "another build" in worker.complaint(str(program), {"the path tracer": wanted["the path tracer"]}, [])


def test_mistakes_are_one_line_before_a_cluster_starts(pathtracer, even_sky):
    name = "a\x1b[31m\nb.exr"
    (pathtracer.folder / name).mkdir()
    for arguments, message in [
        (["-o", name], "a?[31m?b.exr is a folder"),
        (["--env", even_sky.name, "-o", even_sky.name], "is also an input"),
        (["-o", "a.png"], "something.exr"),
        (["--spp", "0", "-o", "a.exr"], "--spp"),
        (["--resume", "a.exr", "-o", "a.exr"], "--resume"),
        (["--noise", "0.1", "-o", "a.exr"], "--noise does not work in parts"),
        (["--scene", "--size", "512x512", "-o", "a.exr"], "--scene: expected one argument"),
        (["--tile", "8", "-o", "a.exr"], "WIDTHxHEIGHT"),
        (["--size", "9x9", "--crop", "0,0,10,3", "-o", "a.exr"], "--crop"),
        (["--size", "1000x1000", "--tile", "1x1", "-o", "a.exr"], "--tile"),
        (["--workers", "2", "--scheduler", "tcp://127.0.0.1:1", "-o", "a.exr"], "--workers"),
        # These the path tracer says.
        (["--sampler", "none", "-o", "a.exr"], "none"),
        (["--first-sample", "4294967290", "-o", "a.exr"], "--first-sample"),
    ]:
        assert message in refused(pathtracer, *arguments)


# ---- With a cluster on this machine


def test_the_image_is_that_of_one_machine(pathtracer):
    """A worker is killed with its task, the command interrupted, and started again."""
    psutil = pytest.importorskip("psutil", reason="scripts/farm has not installed Dask")
    pytest.importorskip("distributed", reason="scripts/farm has not installed Dask")
    command = [*PICTURE, "--tile", "16x16", "--workers", 2, "-o", "out.exr"]
    parts = pathtracer.folder / "out.exr.parts"

    def at_work(farm):
        """Workers, as parents of path tracers."""
        found = set()
        for process in psutil.Process(farm.pid).children(recursive=True):
            try:
                if process.name() == "pathtracer":
                    found.add(process.parent())
            except psutil.NoSuchProcess:
                pass
        return found - {None, psutil.Process(farm.pid)}

    farm = start(pathtracer, *command)
    victim = wait_for(lambda: len(list(parts.glob("*.exr"))) >= 1 and at_work(farm)).pop()
    victim.kill()
    os.set_blocking(farm.stderr.fileno(), False)
    died = wait_for(lambda: farm.stderr.readline())
    assert died.startswith("farm: worker ") and died.endswith("rendered elsewhere\n")
    os.set_blocking(farm.stderr.fileno(), True)
    wait_for(lambda: farm.poll() is not None or len(list(parts.glob("*.exr"))) >= 5)
    farm.send_signal(signal.SIGINT)
    code, out, message = ended(farm)
    assert code == 130 and out == "" and message.count("\n") == 1 and "same command" in message, message
    assert not (pathtracer.folder / "out.exr").exists()
    kept = {path: path.stat().st_mtime_ns for path in parts.glob("*.exr")}
    assert 5 <= len(kept) < 20 and not list(parts.glob(".libbn-*"))
    for change in (["--seed", 6], ["--spp", 10], ["--crop", "0,0,60,50"], ["--tile", "8x16"], ["--first-sample", 1]):
        code, _, message = ended(start(pathtracer, *command, *change))
        assert code == 1 and "other settings" in message
    assert {path: path.stat().st_mtime_ns for path in parts.glob("*.exr")} == kept

    damaged = sorted(kept)[0]
    damaged.write_bytes(damaged.read_bytes()[:-100])
    code, out, message = ended(start(pathtracer, *command))
    assert code == 0 and message.count("\n") == 1 and f"{damaged} is damaged" in message, message
    assert f"{len(kept) - 1} of 20 parts are in" in out and "20 images merged" in out
    assert sorted(path.name for path in pathtracer.folder.iterdir()) == ["out.exr", "out.png"]
    merged, whole = read_layers(pathtracer.folder / "out.exr"), read_layers(pathtracer.render(*PICTURE))
    assert_same(merged, whole, variance=1e-6)  # through single precision and back


def test_workers_with_another_program_are_refused(pathtracer):
    """A scheduler and a worker started by their commands: they know nothing of this repository."""
    pytest.importorskip("distributed", reason="scripts/farm has not installed Dask")
    folder = pathtracer.folder
    (folder / "there").mkdir()
    program = folder / "there" / "copy"
    shutil.copy(pathtracer.binary, program)
    environment = {**os.environ, "BN_PATHTRACER": str(program)}
    environment.pop("PYTHONPATH", None)
    address = folder / "there" / "scheduler.json"
    common = ["--scheduler-file", address, "--no-dashboard", "--host", "127.0.0.1"]
    with contextlib.ExitStack() as stack:
        for command in (["scheduler", "--port", "0"], ["worker", "--nworkers", "1", "--nthreads", "1"]):
            process = stack.enter_context(subprocess.Popen(
                [sys.executable, "-m", "dask", *command, *common], cwd=folder / "there", env=environment,
                stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL))
            stack.callback(process.terminate)
            wait_for(address.exists)
        scheduler = json.loads(address.read_text())["address"]
        picture = ["--scene", "penumbra", "--size", "40x30", "--spp", 2]
        code, _, message = ended(start(pathtracer, *picture, "--tile", "32x32", "--scheduler", scheduler, "-o", "out.exr"))
        assert code == 0 and message == "", message
        merged, whole = read_layers(folder / "out.exr"), read_layers(pathtracer.render(*picture))
        assert all(np.array_equal(merged[name], whole[name]) for name in "RGB")

        with program.open("ab") as file:
            file.write(b" ")
        message = refused(pathtracer, *picture, "--scheduler", scheduler, "-o", "out2.exr")
        assert scheduler.partition("://")[0] in message and "another build of the path tracer" in message
        # A worker may join after the others were checked.
        with cluster.connect(scheduler, 1) as client:
            part, = split((0, 0, 4, 4), 0, 1, (4, 4))
            good = worker.fingerprint(pathtracer.binary, [])
            with pytest.raises(FarmError, match="failed on a worker: another build"):
                list(cluster.render(client, pathtracer.binary, good, [], {part: []}))
