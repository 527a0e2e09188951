# SPDX-License-Identifier: Apache-2.0
"""Scripts in a fresh clone: help needs nothing and makes nothing, and a folder that cannot work is refused at once."""

import os
import shutil
import subprocess
import sys

import pytest
from conftest import ROOT

SCRIPTS = sorted(path.name for path in (ROOT / "scripts").iterdir() if path.is_file() and os.access(path, os.X_OK))
HELP = [*([name, "--help"] for name in SCRIPTS), ["bench", "samplers", "--help"], ["demo", "cornell", "--help"],
        ["demo", "--out", "--help"], ["farm", "--spp", "4", "-h"]]


def clone(folder):
    """The scripts alone; only `setup --help` is left of set-up. Python has no packages."""
    for name in ("scripts", "evidence"):
        shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__", "results"))
    setup = folder / "scripts" / "setup"
    setup.rename(folder / "scripts" / "real_setup")
    setup.write_text('#!/bin/sh\n[ "$*" = --help ] && exec "$(dirname "$0")/real_setup" --help\ntouch set-up-was-run\nexit 1\n')
    python = folder / "bin" / "python3"
    python.parent.mkdir()
    python.write_text(f'#!/bin/sh\nexec "{os.path.realpath(sys.executable)}" -S "$@"\n')
    for script in (setup, python):
        script.chmod(0o755)
    return folder


def run(folder, name, *arguments):
    environment = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    environment["PATH"] = f"{folder / 'bin'}:{environment['PATH']}"  # caches of Python are files that a script makes, too
    return subprocess.run([folder / "scripts" / name, *arguments], cwd=folder, env=environment, stdin=subprocess.DEVNULL,
                          capture_output=True, text=True, timeout=60, check=False)


@pytest.mark.parametrize("command", HELP, ids=" ".join)
def test_help_makes_nothing(command, tmp_path):
    folder = clone(tmp_path / "a clone")
    before = sorted(folder.rglob("*"))
    done = run(folder, *command)
    assert done.returncode == 0 and done.stderr == "" and "usage" in done.stdout.lower(), done
    assert sorted(folder.rglob("*")) == before


@pytest.mark.parametrize("options", [[], ["--spp", "4"]], ids=" ".join)
def test_a_farm_without_an_output_is_refused_before_set_up(options, tmp_path):
    folder = clone(tmp_path / "clone")
    done = run(folder, "farm", *options)
    assert (done.returncode, done.stdout) == (1, "") and done.stderr.count("\n") == 1 and "required: -o" in done.stderr
    assert not (folder / "set-up-was-run").exists()


@pytest.mark.parametrize("name", ["a#b", 'a"b', "a;b", "a\\b", "a:b", "a[b]", "a|b", "a<b", "a>b", "$(b)", "a\tb"])
def test_folders_that_cannot_work_are_refused_at_once(name, tmp_path):
    folder = clone(tmp_path / name)
    for script in ("demo", "real_setup", "farm"):
        done = run(folder, script)
        assert done.returncode == 1 and done.stdout == "" and done.stderr.count("\n") == 1, done
        assert "cannot work in the folder" in done.stderr


@pytest.mark.slow
def test_wrong_options_of_a_part_are_refused_before_set_up(tmp_path):
    """Where an earlier set-up can tell; a broken one cannot, and set-up mends it."""
    program = clone(tmp_path / "clone")
    if not (ROOT / ".venv").is_dir():
        pytest.skip("no .venv; scripts/setup makes it")
    (program / ".venv").symlink_to(ROOT / ".venv")
    for part in ("summary", "samplers", "denoise"):
        done = run(program, "bench", part, "--nope")
        assert done.returncode == 2 and done.stderr.rstrip().endswith("error: unrecognized arguments: --nope")
        assert "Traceback" not in done.stderr and not (program / "build").exists()
