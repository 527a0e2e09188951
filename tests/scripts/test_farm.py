# SPDX-License-Identifier: Apache-2.0
"""Tests scripts/farm: parts cover an image exactly once, and a cluster renders the same image as one machine, even if workers die.

The cluster tests need Dask, which scripts/farm installs."""

import contextlib
import importlib.util
import json
import os
import shutil
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from conftest import ROOT
from pathtracer_driver import assert_same, read_layers
from render_farm import cluster, worker
from render_farm.__main__ import parse
from render_farm.parts import FarmError, PartsFolder, names_of, split
from scene_files import write_environment

needs_dask = pytest.mark.skipif(not importlib.util.find_spec("distributed"), reason="scripts/farm has not installed Dask")


def start(pathtracer, *arguments):
    return subprocess.Popen([sys.executable, "-m", "render_farm", "--pathtracer", pathtracer.binary, *map(str, arguments)],
                            cwd=pathtracer.folder, env={**os.environ, "PYTHONPATH": f"{ROOT}:{ROOT / 'scripts'}"}, text=True,
                            stdout=subprocess.PIPE, stderr=subprocess.PIPE)


def ended(process, code):
    """Waits for a process to end with an exit status. Returns its standard output and standard error."""
    out, message = process.communicate(timeout=120)
    assert process.returncode == code, message
    return out, message


def refused(pathtracer, *arguments):
    """Runs a command that must fail before it creates a parts folder. Returns the error line."""
    out, message = ended(start(pathtracer, "-o", "a.exr", *arguments), 1)
    assert out == "" and message.startswith("farm: ") and message.count("\n") == 1, message
    assert list(pathtracer.folder.glob("*.parts")) == []
    return message


def wait_for(condition):
    end = time.monotonic() + 120
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
    inside = counts[crop[1]:crop[3], crop[0]:crop[2]]
    assert (inside == 1).all() and counts.sum() == inside.size
    assert len({part.file_name for part in parts}) == len(parts)


def test_a_parts_folder_belongs_to_one_image(tmp_path):
    first, second = parts = split((0, 0, 8, 4), 0, 2, (4, 4))
    folder_of = lambda name, seed="1": PartsFolder(tmp_path / f"{name}.exr", {"seed": seed})
    folder = folder_of("a")
    folder.add(first, b"data")
    again = folder_of("a")
    assert again.has(first) and not again.has(second) and (again.path / first.file_name).read_bytes() == b"data"
    with pytest.raises(FarmError, match="other settings, files or programs"):
        folder_of("a", "2")
    (folder.path / "mine.txt").write_text("x")
    (folder.path / "1,2,3,4,5,6.exr").write_text("another picture's")
    folder.remove(parts)
    assert sorted(path.name for path in folder.path.iterdir()) == ["1,2,3,4,5,6.exr", "mine.txt"]
    (tmp_path / "damaged.exr.parts").mkdir()
    (tmp_path / "damaged.exr.parts" / "picture.json").write_bytes(b"\xff\x00")
    (tmp_path / "link.exr.parts").symlink_to("a.exr.parts")
    for name, message in (("a", "remove it"), ("damaged", "remove it"), ("link", "symbolic link")):
        with pytest.raises(FarmError, match=message):
            folder_of(name)


def test_names_of_inputs(pathtracer):
    """Names are read back unchanged, whatever characters they contain."""
    for name in ["a b.exr", "back\\slash.exr", "\u00e9.exr", "  "]:
        shutil.copy(write_environment(pathtracer.folder / "sky.exr", 1.0), pathtracer.folder / name)
        assert names_of(pathtracer.success("--env", name, "--list-inputs").stdout) == [name]


def test_options_are_divided_between_parts_and_merging(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "sky.exr").write_bytes(b"")
    options = parse(["--env", "sky.exr", "--exposure", "-1", "--photometric", "-o", "a.exr"])
    assert options.shared == ["--env", str(tmp_path / "sky.exr"), "--photometric", "--size", "512x512"]
    assert options.merging == ["--exposure", "-1"]


def test_workers_notice_a_different_program_or_file(tmp_path, monkeypatch):
    program, scene, other = (tmp_path / name for name in ("program", "scene.glb", "other"))
    for path in (program, scene, other):
        path.write_text(path.name)
    wanted = worker.fingerprint(str(program), [str(scene)])
    complaint = lambda: worker.complaint(str(program), wanted, [str(scene)])
    assert complaint() == ""
    scene.write_text("scenes")
    assert "scene.glb is another file" in complaint()
    scene.unlink()
    assert "cannot read" in complaint()
    monkeypatch.setenv("BN_PATHTRACER", str(other))
    assert "another build" in worker.complaint(str(program), {"the path tracer": wanted["the path tracer"]}, [])


@pytest.mark.slow
def test_bad_arguments_give_one_line_before_a_cluster_starts(pathtracer, even_sky):
    name = "a\x1b[31m\nb.exr"
    (pathtracer.folder / name).mkdir()
    for arguments, message in [
        (["-o", name], "a?[31m?b.exr is a folder"), (["--env", even_sky.name, "-o", even_sky.name], "is also an input"),
        (["-o", "a.png"], "something.exr"), (["--spp", "0"], "--spp"), (["--resume", "a.exr"], "--resume"),
        (["--noise", "0.1"], "--noise does not work in parts"), (["--scene", "--size", "512x512"], "--scene: expected one argument"),
        (["--tile", "8"], "WIDTHxHEIGHT"), (["--size", "9x9", "--crop", "0,0,10,3"], "--crop"),
        (["--size", "1000x1000", "--tile", "1x1"], "--tile"), (["--workers", "2", "--scheduler", "tcp://127.0.0.1:1"], "--workers"),
        # Reported by the path tracer
        (["--sampler", "none"], "none"), (["--first-sample", "4294967290"], "--first-sample"),
    ]:
        assert message in refused(pathtracer, *arguments)


# ---- With a cluster on this machine


@needs_dask
@pytest.mark.slow
def test_a_cluster_renders_the_same_image_as_one_machine(pathtracer):
    """A worker is killed during its task, and the command is interrupted and restarted."""
    import psutil

    # Each part takes long enough to be interrupted. A larger image would only take longer.
    picture = ["--size", "70x50", "--spp", "1000", "--seed", "5"]
    command = [*picture, "--tile", "16x16", "--workers", 2, "-o", "out.exr"]
    parts = lambda: list((pathtracer.folder / "out.exr.parts").glob("*.exr"))

    def at_work(farm):
        """Returns the busy workers, which are the parents of path tracer processes."""
        found = set()
        for process in psutil.Process(farm.pid).children(recursive=True):
            try:
                if process.name() == "pathtracer":
                    found.add(process.parent())
            except psutil.NoSuchProcess:
                pass
        return found - {None, psutil.Process(farm.pid)}

    farm = start(pathtracer, *command)
    wait_for(lambda: parts() and at_work(farm)).pop().kill()
    os.set_blocking(farm.stderr.fileno(), False)
    died = wait_for(lambda: farm.stderr.readline())
    assert died.startswith("farm: worker ") and died.endswith("rendered elsewhere\n")
    os.set_blocking(farm.stderr.fileno(), True)
    wait_for(lambda: farm.poll() is not None or len(parts()) >= 5)
    farm.send_signal(signal.SIGINT)
    out, message = ended(farm, 130)
    assert out == "" and message.count("\n") == 1 and "same command" in message, message
    assert not (pathtracer.folder / "out.exr").exists()
    kept = {path: path.stat().st_mtime_ns for path in parts()}
    assert 5 <= len(kept) < 20 and not list(pathtracer.folder.glob("*.parts/.libbn-*"))
    for change in (["--seed", 6], ["--spp", 10], ["--crop", "0,0,60,50"], ["--tile", "8x16"], ["--first-sample", 1]):
        assert "other settings" in ended(start(pathtracer, *command, *change), 1)[1]
    assert {path: path.stat().st_mtime_ns for path in parts()} == kept

    damaged = min(kept)
    damaged.write_bytes(damaged.read_bytes()[:-100])
    out, message = ended(start(pathtracer, *command), 1)
    assert message.count("\n") == 1 and damaged.name in message and f"{damaged.parent}; if one is damaged, remove it" in message, message
    damaged.unlink()
    out, message = ended(start(pathtracer, *command), 0)
    assert message == "" and "19 of 20 parts are in" in out and "20 images merged" in out
    assert sorted(path.name for path in pathtracer.folder.iterdir()) == ["out.exr", "out.png"]
    # Files store variances in single precision.
    assert_same(read_layers(pathtracer.folder / "out.exr"), pathtracer.layers(*picture), variance=1e-6)


@needs_dask
@pytest.mark.slow
def test_workers_with_a_different_program_are_refused(pathtracer):
    """The scheduler and the worker are started by Dask's commands and cannot import this repository."""
    there = pathtracer.folder / "there"
    there.mkdir()
    program, address = there / "copy", there / "scheduler.json"
    shutil.copy(pathtracer.binary, program)
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"} | {"BN_PATHTRACER": str(program)}
    common = ["--scheduler-file", address, "--no-dashboard", "--host", "127.0.0.1"]
    with contextlib.ExitStack() as stack:
        for command in (["scheduler", "--port", "0"], ["worker", "--nworkers", "1", "--nthreads", "1"]):
            process = stack.enter_context(subprocess.Popen(
                [sys.executable, "-m", "dask", *command, *common], cwd=there, env=environment,
                stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL))
            stack.callback(process.terminate)
            wait_for(address.exists)
        scheduler = json.loads(address.read_text())["address"]
        picture = ["--scene", "penumbra", "--size", "40x30", "--spp", 2]
        assert ended(start(pathtracer, *picture, "--tile", "32x32", "--scheduler", scheduler, "-o", "out.exr"), 0)[1] == ""
        merged, whole = read_layers(pathtracer.folder / "out.exr"), pathtracer.layers(*picture)
        assert all(np.array_equal(merged[name], whole[name]) for name in "RGB")

        with program.open("ab") as file:
            file.write(b" ")
        message = refused(pathtracer, *picture, "--scheduler", scheduler)
        assert scheduler.partition("://")[0] in message and "another build of the path tracer" in message
        # A worker may join after the other workers were checked.
        with cluster.connect(scheduler, 1) as client:
            part, = split((0, 0, 4, 4), 0, 1, (4, 4))
            good = worker.fingerprint(pathtracer.binary, [])
            with pytest.raises(FarmError, match="failed on a worker: another build"):
                list(cluster.render(client, pathtracer.binary, good, [], {part: []}))
