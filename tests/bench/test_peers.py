# SPDX-License-Identifier: Apache-2.0
"""Samplers of other libraries: listed by the path tracer, requested with --openqmc."""

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
