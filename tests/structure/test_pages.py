# SPDX-License-Identifier: Apache-2.0
"""The pages of the documentation: links lead somewhere, and the site has every page. Needs no MkDocs."""

import ast
import os
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
from pages import links, search_order  # noqa: E402

INCLUDE = ROOT / "libbn" / "include" / "bn"


def markdown_files(root):
    found = []
    for folder, folders, files in os.walk(root):
        folders[:] = [name for name in folders if not re.match(r"(?!\.github$)\.|build$|build-|out$|dist$|__pycache__$", name)]
        found += [(Path(folder) / name).relative_to(root).as_posix() for name in files if name.endswith(".md")]
    return sorted(found)


def broken_links(root):
    texts = {path: (root / path).read_text(encoding="utf-8") for path in markdown_files(root)}
    anchors = {path: links.anchors(text) for path, text in texts.items()}
    found = []
    for page, text in texts.items():
        for _, _, target in links.links(text):
            if links.is_external(target):
                continue
            path, anchor = links.resolve(page, target)
            if not (root / path).exists() or anchor and anchor not in anchors.get(path, ()):
                found.append(f"{page}: {target}")
    return found


def missing_pages(root, config):
    """Pages that the navigation lacks, and entries of it without a file; NAME.md may be made from NAME."""
    nav = set(re.findall(r"^ +- [^:\n]+: (\S+\.md)$", config, re.M))
    pages = {path for path in markdown_files(root) if not path.startswith(".")}
    return sorted(pages - nav), sorted(path for path in nav - pages if not (root / path[:-3]).exists())


def test_every_link_and_anchor_resolves():
    assert sum(len(links.links((ROOT / path).read_text(encoding="utf-8"))) for path in markdown_files(ROOT)) > 50
    assert broken_links(ROOT) == []


def test_every_page_is_in_the_navigation():
    assert missing_pages(ROOT, (ROOT / "mkdocs.yml").read_text(encoding="utf-8")) == ([], [])


def test_a_search_shows_guides_and_interfaces_before_reports():
    titles = re.findall(r"^  - ([^:\n]+):$", (ROOT / "mkdocs.yml").read_text(encoding="utf-8").split("\nhooks:")[0], re.M)
    assert titles == list(dict.fromkeys(titles)) and set(titles) == set(search_order.SECTIONS)
    nav = [{"Home": "README.md"}, {"Guides": [{"a": "a.md"}]}, {"Python": [{"b": "b.md"}]}, {"Reports": [{"c": ["c.md", {"d": "d.md"}]}]}]
    boosts = [search_order.boost(path, nav) for path in ("a.md", "b.md", "README.md", "c.md", "d.md", "other.md")]
    assert boosts[0] > boosts[2] > 10 * boosts[3] and boosts[1] > boosts[2] and boosts[3] == boosts[4] > boosts[5]


def test_every_header_is_in_the_navigation():
    config = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    assert [path.name for path in INCLUDE.iterdir() if f"libbn/include/bn/{path.name}.md" not in config] == []


def test_the_python_page_has_every_name():
    tree = ast.parse((ROOT / "bindings/bluenoise/__init__.py").read_text(encoding="utf-8"))
    names = next(ast.literal_eval(node.value) for node in tree.body
                 if isinstance(node, ast.Assign) and node.targets[0].id == "__all__")
    page = re.findall(r"^::: bluenoise\.(\w+)$", (ROOT / "bindings/api.md").read_text(encoding="utf-8"), re.M)
    assert set(names) - {"__version__"} == set(page) - {"mitsuba"}


def test_the_python_page_says_what_each_name_is_without_the_site():
    """On a code host, the directives for docstrings are bare lines."""
    tree = ast.parse((ROOT / "bindings/bluenoise/__init__.py").read_text(encoding="utf-8"))
    names = next(ast.literal_eval(node.value) for node in tree.body
                 if isinstance(node, ast.Assign) and node.targets[0].id == "__all__")
    rows = [line for line in (ROOT / "bindings/api.md").read_text(encoding="utf-8").splitlines() if line.startswith("| `")]
    described = {name for row in rows for name in re.findall(r"`(\w+)", row.split(" | ")[0]) if len(row.split(" | ")[1]) > 12}
    assert set(names) - {"__version__"} <= described


# ---- The checks themselves, on small trees


def test_broken_links_and_missing_pages_are_noticed(tmp_path):
    (tmp_path / "docs").mkdir()
    (tmp_path / "README.md").write_text(
        "# A\n[a](docs/b.md#the-c-in-d) [b](docs/b.md#no) `[c](none.md)` [d](#a) ![p](none.png)\n"
        "```\n[e](none.md)\n# No\n```\n<!-- [f](none.md) -->\n[g](https://host/none) [h](#no)\n")
    (tmp_path / "docs/b.md").write_text("## The `c` in [d](../README.md)\n\n## A\n## A\n[up](../README.md#a) [2](#a-1) [3](#a-2)\n")
    assert broken_links(tmp_path) == ["README.md: docs/b.md#no", "README.md: none.png", "README.md: #no", "docs/b.md: #a-2"]
    assert missing_pages(tmp_path, "nav:\n  - Home: README.md\n  - B: docs/c.md\n") == (["docs/b.md"], ["docs/c.md"])
