# SPDX-License-Identifier: Apache-2.0
"""docs/report holds the tables and small plots that the documents show; everything large belongs in out/."""

import re
import subprocess
from pathlib import Path

import pytest
from conftest import ROOT


def tracked(folder):
    listed = subprocess.run(["git", "-C", ROOT, "ls-files", "-z", folder], capture_output=True, text=True, check=False)
    if listed.returncode != 0:
        pytest.skip("not a git checkout")
    return [ROOT / name for name in listed.stdout.split("\0") if name and (ROOT / name).is_file()]


def test_the_report_is_small_and_every_plot_is_shown():
    files = tracked("docs/report")
    assert sum(path.stat().st_size for path in files) < 10**6 and not any(path.suffix == ".html" for path in files)
    texts = "".join(path.read_text(encoding="utf-8") for path in [*tracked("docs"), ROOT / "README.md"] if path.suffix == ".md")
    shown = {Path(target).name for target in re.findall(r"!\[[^]]*\]\(([^)]+)\)", texts)}
    assert {path.name for path in files if path.suffix == ".png"} <= shown
