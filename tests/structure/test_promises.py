# SPDX-License-Identifier: Apache-2.0
"""docs/promises.md names the test of every promise; each of them exists and is run."""

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
TEST = re.compile(r"`(tests/[\w/.]+)(?:::(\w+))?`")


def rows(text):
    """(promise, tests) of every row of a table with the heading `promise`."""
    found = []
    for table in re.findall(r"^\| promise \| tests \|\n\|[ -|]+\n((?:\|.*\n)+)", text, re.M):
        for line in table.splitlines():
            promise, tests = line.strip("|").split("|")
            found.append((promise.strip(), TEST.findall(tests)))
    return found


def is_there(path, name):
    """Whether a file has a test: by its name in Python, defined and called in C."""
    text = (ROOT / path).read_text(encoding="utf-8") if (ROOT / path).is_file() else ""
    if path.endswith(".py"):
        return re.search(rf"^def {name or 'test_'}", text, re.M) is not None
    return text != "" and (not name or len(re.findall(rf"\b{name}\(", text)) > 1)


def test_every_promise_has_tests_that_exist():
    found = rows((ROOT / "docs" / "promises.md").read_text(encoding="utf-8"))
    assert len(found) > 25
    assert [promise for promise, tests in found if not tests] == []
    assert [test for _, tests in found for test in tests if not is_there(*test)] == []
