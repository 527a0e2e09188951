# SPDX-License-Identifier: Apache-2.0
"""Tests the scripts in a fresh clone: --help needs no set-up and creates no files, and unusable folders are refused at once."""

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
    """Copies only the scripts. The set-up script only supports --help, and Python has no packages."""
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
    environment["PATH"] = f"{folder / 'bin'}:{environment['PATH']}"  # Python's caches count as files that a script creates
    return subprocess.run([folder / "scripts" / name, *arguments], cwd=folder, env=environment, stdin=subprocess.DEVNULL,
                          capture_output=True, text=True, timeout=60, check=False)


@pytest.fixture(scope="module")
def fresh(tmp_path_factory):
    return clone(tmp_path_factory.mktemp("fresh") / "a clone")


@pytest.mark.parametrize("command", HELP, ids=" ".join)
def test_help_creates_no_files(command, fresh):
    before = sorted(fresh.rglob("*"))
    done = run(fresh, *command)
    assert done.returncode == 0 and done.stderr == "" and "usage" in done.stdout.lower(), done
    assert sorted(fresh.rglob("*")) == before


@pytest.mark.parametrize("options", [[], ["--spp", "4"]], ids=" ".join)
def test_farm_without_an_output_is_refused_before_set_up(options, fresh):
    done = run(fresh, "farm", *options)
    assert (done.returncode, done.stdout) == (1, "") and done.stderr.count("\n") == 1 and "required: -o" in done.stderr
    assert not (fresh / "set-up-was-run").exists()


def test_unusable_folder_names_are_refused_at_once(tmp_path):
    folder = clone(tmp_path / "clone")
    for name in ("a#b", 'a"b', "a;b", "a\\b", "a:b", "a[b]", "a|b", "a<b", "a>b", "$(b)", "a\tb"):
        folder = folder.rename(tmp_path / name)
        for script in ("demo", "real_setup", "farm"):
            done = run(folder, script)
            assert done.returncode == 1 and done.stdout == "" and done.stderr.count("\n") == 1, done
            assert "cannot work in the folder" in done.stderr


@pytest.mark.slow
def test_unknown_bench_options_are_refused_before_set_up(tmp_path):
    """This needs a working earlier set-up. If that is broken, the set-up runs first and repairs it."""
    program = clone(tmp_path / "clone")
    if not (ROOT / ".venv").is_dir():
        pytest.skip("there is no .venv; run scripts/setup")
    (program / ".venv").symlink_to(ROOT / ".venv")
    for part in ("samplers", "denoise"):
        done = run(program, "bench", part, "--nope")
        assert done.returncode == 2 and done.stderr.rstrip().endswith("error: unrecognized arguments: --nope")
        assert "Traceback" not in done.stderr and not (program / "build").exists()
