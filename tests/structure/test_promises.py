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


def problem(path, name):
    """Why there is no such test, or None."""
    file = ROOT / path
    if not file.is_file():
        return f"{path} does not exist"
    text = file.read_text(encoding="utf-8")
    if path.endswith(".py"):
        if not file.name.startswith("test_"):
            return f"{path} is not collected by pytest"
        if not re.search(rf"^def {name or 'test_'}", text, re.M) or name and not re.search(rf"^def {name}\(", text, re.M):
            return f"{path} has no test {name or ''}"
        return None
    cmake = "".join(part.read_text(encoding="utf-8") for part in sorted(file.parent.glob("*.cmake")))
    cmake += (file.parent / "CMakeLists.txt").read_text(encoding="utf-8")
    if not re.search(rf"\b{file.stem}\b", cmake):
        return f"{path} is not built"
    if name and len(re.findall(rf"\b{name}\(", text)) < 2:
        return f"{path} does not define and call {name}"
    return None


def test_every_promise_has_tests_that_exist():
    found = rows((ROOT / "docs" / "promises.md").read_text(encoding="utf-8"))
    assert len(found) > 25
    assert [promise for promise, tests in found if not tests] == []
    assert [text for _, tests in found for path, name in tests if (text := problem(path, name))] == []
