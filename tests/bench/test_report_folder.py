# SPDX-License-Identifier: Apache-2.0
"""docs/report holds the tables and small plots that the documents show; everything large belongs in out/."""

import re
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
MOST_BYTES, MOST_ROWS = 10**6, 1000


def tracked(folder):
    listed = subprocess.run(["git", "-C", ROOT, "ls-files", "-z", folder], capture_output=True, text=True, check=False)
    if listed.returncode != 0:
        pytest.skip("not a git checkout")
    return [ROOT / name for name in listed.stdout.split("\0") if name and (ROOT / name).is_file()]


def problems(files):
    found = []
    total = sum(path.stat().st_size for path in files)
    if total > MOST_BYTES:
        found.append(f"{total} bytes, more than {MOST_BYTES}")
    for path in files:
        if path.suffix.lower() in (".html", ".htm"):
            found.append(f"{path.name} is HTML")
        if path.suffix == ".csv" and path.read_text(encoding="utf-8").count("\n") > MOST_ROWS:
            found.append(f"{path.name} has more than {MOST_ROWS} rows")
    return found


def test_the_report_is_small_and_without_pages():
    assert problems(tracked("docs/report")) == []


def test_every_plot_is_shown():
    texts = "".join(path.read_text(encoding="utf-8") for path in tracked("docs") + [ROOT / "README.md"]
                    if path.suffix == ".md")
    shown = {Path(target).name for target in re.findall(r"!\[[^]]*\]\(([^)]+)\)", texts)}
    assert {path.name for path in tracked("docs/report") if path.suffix == ".png"} <= shown


def test_large_files_and_pages_are_noticed(tmp_path):
    (tmp_path / "page.html").write_text("<p>")
    (tmp_path / "rows.csv").write_text("1\n" * (MOST_ROWS + 1))
    (tmp_path / "big.png").write_bytes(bytes(MOST_BYTES))
    assert len(problems(sorted(tmp_path.iterdir()))) == 3


def test_out_is_not_tracked():
    ignored = subprocess.run(["git", "-C", ROOT, "check-ignore", "-q", "out/report.html"], check=False)
    if ignored.returncode == 128:
        pytest.skip("not a git checkout")
    assert ignored.returncode == 0
