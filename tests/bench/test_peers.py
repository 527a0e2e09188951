# SPDX-License-Identifier: Apache-2.0
"""Samplers of other libraries: listed by the path tracer, requested with --openqmc."""

import argparse
import re
import subprocess
import sys

import pytest
from conftest import ROOT
from report.base import peers


def program_that_lists(folder, *names):
    program = folder / "pathtracer"
    lines = "".join(f"  {name} what it is\\n" for name in names)
    program.write_text(f"#!{sys.executable}\nprint('scenes:\\n  cornell a box\\nsamplers:\\n{lines}', end='')\n")
    program.chmod(0o755)
    return program


def test_listed_are_those_of_the_program(tmp_path):
    assert peers.listed(program_that_lists(tmp_path, "blue", "openqmc-latticebn", "openqmc-pmjbn")) == (
        "openqmc-pmjbn", "openqmc-latticebn")
    assert peers.listed(program_that_lists(tmp_path, "blue", "white")) == ()
    assert peers.listed(tmp_path / "nothing") == ()


def test_peers_stand_in_a_table_only_when_asked_for(tmp_path):
    parser = argparse.ArgumentParser()
    peers.add_option(parser)
    program = program_that_lists(tmp_path, "blue", *peers.PEERS)
    assert peers.chosen(parser.parse_args([]).openqmc, program) == ()
    assert peers.chosen(parser.parse_args(["--openqmc", "there"]).openqmc, program) == peers.PEERS


def test_a_build_without_them_is_refused_in_one_line(tmp_path):
    with pytest.raises(SystemExit) as ended:
        peers.chosen("there", program_that_lists(tmp_path, "blue"))
    assert "scripts/setup -DBN_OPENQMC=there" in str(ended.value) and "\n" not in str(ended.value)


@pytest.mark.parametrize(("words", "said"), [(["--openqmc"], "needs the folder"),
                                             (["--openqmc", "nowhere"], "nowhere/include/oqmc/oqmc.h does not exist")])
def test_bench_refuses_what_is_no_checkout(tmp_path, words, said):
    done = subprocess.run([ROOT / "scripts" / "bench", "samplers", *words], cwd=tmp_path, check=False,
                          capture_output=True, text=True)
    assert done.returncode == 1 and done.stdout == ""
    assert said in done.stderr and done.stderr.count("\n") == 1


def test_a_report_names_the_commit_of_a_checkout(tmp_path):
    assert peers.commit(tmp_path / "nowhere") == "unknown"
    git = ["git", "-C", tmp_path, "-c", "user.name=a", "-c", "user.email=a@example.org"]
    subprocess.run([*git, "init", "-q"], check=True)
    subprocess.run([*git, "commit", "-q", "--allow-empty", "--no-verify", "-m", "a"], check=True)
    assert re.fullmatch(r"[0-9a-f]{7,} of \d{4}-\d\d-\d\d", peers.commit(tmp_path))
