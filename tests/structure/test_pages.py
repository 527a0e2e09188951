# SPDX-License-Identifier: Apache-2.0
"""The pages of the documentation: links lead somewhere, the site has every page, and headers become pages. Needs no MkDocs."""

import ast
import os
import re
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
from pages import headers, links, search_order  # noqa: E402

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


@pytest.mark.parametrize("path", sorted(path for path in INCLUDE.iterdir() if path.suffix in (".h", ".hpp")), ids=lambda path: path.name)
def test_pages_of_headers_have_every_function(path):
    text = path.read_text(encoding="utf-8")
    page = headers.page(path.name, text)
    names = set(re.findall(r"^BN_API [^;]*?\b(bn_\w+)\(", text, re.M)) | set(re.findall(r"^\} (bn_\w+);", text, re.M))
    assert names <= set(headers.names(text)) and len(headers.names(text)) > 2
    assert all(re.search(rf"\b{name}\b", page) for name in names)
    assert "BN_API" not in page and "SPDX" not in page and page.count("```") % 2 == 0


# ---- The checks themselves, on small trees and headers


def test_broken_links_and_missing_pages_are_noticed(tmp_path):
    (tmp_path / "docs").mkdir()
    (tmp_path / "README.md").write_text(
        "# A\n[a](docs/b.md#the-c-in-d) [b](docs/b.md#no) `[c](none.md)` [d](#a) ![p](none.png)\n"
        "```\n[e](none.md)\n# No\n```\n<!-- [f](none.md) -->\n[g](https://host/none) [h](#no)\n")
    (tmp_path / "docs/b.md").write_text("## The `c` in [d](../README.md)\n\n## A\n## A\n[up](../README.md#a) [2](#a-1) [3](#a-2)\n")
    assert broken_links(tmp_path) == ["README.md: docs/b.md#no", "README.md: none.png", "README.md: #no", "docs/b.md: #a-2"]
    assert missing_pages(tmp_path, "nav:\n  - Home: README.md\n  - B: docs/c.md\n") == (["docs/b.md"], ["docs/c.md"])


HEADER = """/* SPDX-License-Identifier: Apache-2.0
 * What it is.
 *
 *     int x = bn_one(1);
 *
 * HOW ONE WORKS
 *
 * Names. `a` and *b of bn_one(). */
#ifndef BN_A_H
#define BN_A_H
#define BN_API

/* ---- Section */

/* About the section. */

typedef struct bn_options {
    int a; /* an a */
} bn_options;

static inline bn_options bn_options_default(void) {
    bn_options options = {1};
    return options;
}

/* Makes one. Errors:
 *
 *   BAD_DATA   a is
 *              bad */
BN_API int bn_one(int a,
                  int b);
BN_API int bn_two(int a);

static int bn_hidden(void) { return 0; }
#endif
"""


def test_a_header_becomes_a_page():
    page = headers.page("a.h", HEADER, {"bn_one": "#bn_one"}.get)
    assert page == """# a.h

What it is.

```c
int x = bn_one(1);
```

## How one works

**Names.** `a` and `*b` of [`bn_one()`](#bn_one).

## Section

About the section.

### `bn_options` { #bn_options }

```c
typedef struct bn_options {
    int a; /* an a */
} bn_options;

static inline bn_options bn_options_default(void);
```

### `bn_one`, `bn_two` { #bn_one }

```c
int bn_one(int a,
           int b);
int bn_two(int a);
```

Makes one.

**Errors:**

- `BAD_DATA`: a is bad
"""


def test_a_class_becomes_what_its_users_see():
    page = headers.page("a.hpp", """// What it is.
namespace bn {

// A thing.
class Thing {
  public:
    explicit Thing(int a) : a_(a), b_{a} { check(a); }
    Thing(const Thing &) = delete;

    // The a.
    int a() const noexcept { return a_; }

  private:
    int a_, b_;
};

} // namespace bn
""", language="cpp")
    assert page == """# a.hpp

What it is.

## `bn::Thing` { #bn-thing }

```cpp
class Thing {
  public:
    explicit Thing(int a);

    // The a.
    int a() const noexcept;
};
```

A thing.
"""


def test_a_shader_becomes_a_page():
    text = "/* SPDX-License-Identifier" ": Apache-2.0\n * What it is:\n *\n *     #define X */\n\nuint x; /* y */\n"
    assert headers.source_page("a.glsl", text) == (
        "# a.glsl\n\nWhat it is:\n\n```glsl\n#define X\n```\n\n## Source\n\n```glsl\nuint x; /* y */\n```\n")


def test_a_function_without_a_comment_is_refused():
    with pytest.raises(ValueError, match="bn_one has no comment"):
        headers.read(HEADER.replace("bad */\n", "bad */\n\n"))
