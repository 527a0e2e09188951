# SPDX-License-Identifier: Apache-2.0
"""The pages of the documentation: links lead somewhere, the site has every page, and every promise has tests. Needs no MkDocs."""

import ast
import os
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
from pages import links  # noqa: E402


def markdown_files():
    found = []
    for folder, folders, files in os.walk(ROOT):
        folders[:] = [name for name in folders if not re.match(r"(?!\.github$)\.|build$|build-|out$|dist$|__pycache__$", name)]
        found += [(Path(folder) / name).relative_to(ROOT).as_posix() for name in files if name.endswith(".md")]
    return sorted(found)


def test_every_link_and_anchor_resolves():
    texts = {path: (ROOT / path).read_text(encoding="utf-8") for path in markdown_files()}
    anchors = {path: links.anchors(text) for path, text in texts.items()}
    found = [(page, target) for page, text in texts.items() for target in links.links(text) if not links.is_external(target)]
    assert len(found) > 50
    for page, target in found:
        path, anchor = links.resolve(page, target)
        assert (ROOT / path).exists() and (not anchor or anchor in anchors.get(path, ())), f"{page}: {target}"


def test_every_page_is_in_the_navigation():
    """NAME.md may be made from NAME."""
    nav = set(re.findall(r"^ +- [^:\n]+: (\S+\.md)$", (ROOT / "mkdocs.yml").read_text(encoding="utf-8"), re.M))
    pages = {path for path in markdown_files() if not path.startswith(".")}
    assert (pages - nav, [path for path in nav - pages if not (ROOT / path[:-3]).exists()]) == (set(), [])


def test_the_python_page_has_every_name_and_says_what_it_is():
    """On a code host, the directives for docstrings are bare lines."""
    tree = ast.parse((ROOT / "bindings/bluenoise/__init__.py").read_text(encoding="utf-8"))
    names = next(set(ast.literal_eval(node.value)) for node in tree.body
                 if isinstance(node, ast.Assign) and node.targets[0].id == "__all__") - {"__version__"}
    text = (ROOT / "bindings/api.md").read_text(encoding="utf-8")
    assert names == set(re.findall(r"^::: bluenoise\.(\w+)$", text, re.M)) - {"mitsuba"}
    rows = [line for line in text.splitlines() if line.startswith("| `")]
    assert names <= {name for row in rows for name in re.findall(r"`(\w+)", row.split(" | ")[0]) if len(row.split(" | ")[1]) > 12}


def is_there(path, name):
    """Whether a file has a test: by its name in Python, defined and called in C."""
    text = (ROOT / path).read_text(encoding="utf-8") if (ROOT / path).is_file() else ""
    if path.endswith(".py"):
        return re.search(rf"^def {name or 'test_'}", text, re.M) is not None
    return text != "" and (not name or len(re.findall(rf"\b{name}\(", text)) > 1)


def test_every_promise_has_tests_that_exist():
    """In the tables with the heading `promise`."""
    text = (ROOT / "docs" / "promises.md").read_text(encoding="utf-8")
    tables = re.findall(r"^\| promise \| tests \|\n\|[ -|]+\n((?:\|.*\n)+)", text, re.M)
    found = [(row, re.findall(r"`(tests/[\w/.]+)(?:::(\w+))?`", row.split("|")[2])) for row in "".join(tables).splitlines()]
    assert len(found) > 25 and [row for row, tests in found if not tests] == []
    assert [test for _, tests in found for test in tests if not is_there(*test)] == []
