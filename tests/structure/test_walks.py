# SPDX-License-Identifier: Apache-2.0
"""The lists of CONTRIBUTING.md for what is often added are complete: each thing that there is stands in every place of its list in
policy.toml, and the list in CONTRIBUTING.md names that place."""

import re
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
WALKS = tomllib.loads(Path(__file__).with_name("policy.toml").read_text(encoding="utf-8"))["walks"]
# Where the things of a walk are declared.
DECLARED = {"sampler": ("libbn/include/bn/bn.h", r"^    BN_SAMPLER_(\w+) = \d"),
            "mask": ("libbn/include/bn/bn.h", r"^BN_API bn_result bn_(\w+)\(const bn_\1_options \*options, uint32_t width"),
            "scene": ("examples/pathtracer/scene_builder.h", r"^Scene scene_(\w+)\(\);"),
            "bench": ("scripts/report/__main__.py", r'(?<=[( ])"(?!convergence)(\w+)"(?=[,)][^\n]*,$)')}


def text_of(path):
    return (ROOT / path).read_text(encoding="utf-8")


@pytest.mark.parametrize("walk", WALKS)
def test_everything_stands_in_every_place(walk):
    path, pattern = DECLARED[walk]
    found = re.findall(pattern, text_of(path), re.M)
    assert len(found) >= 3
    for name in found:
        names = {"name": name.lower().replace("_", "-"), "snake": name.lower(), "NAME": name.upper(), "count": str(len(found)),
                 "LAST": found[-1]}
        for place, form in WALKS[walk].items():
            for key, value in names.items():
                form = form.replace(f"{{{key}}}", value)
            assert form in text_of(place), f"{place} lacks {form}"


@pytest.mark.parametrize("walk", WALKS)
def test_the_list_names_every_place(walk):
    section = re.search(rf"^### Add a {walk}\b.*?(?=^##)", text_of("CONTRIBUTING.md"), re.M | re.S)[0]
    assert [place for place in WALKS[walk] if f"`{place}`" not in section] == []


def test_code_names_a_kind_of_sampler_nowhere_else():
    """By the example of one that nothing but its own file draws."""
    kind = re.compile(r'BN_SAMPLER_ZORDER|bn_draw_zorder|sampler/zorder\.c|\[[^]\n]*"zorder"[^]\n]*\]')
    files = [path for folder in ("libbn/include", "libbn/src", "bindings", "examples") for path in (ROOT / folder).rglob("*")
             if path.suffix in (".c", ".h", ".hpp", ".cpp", ".py", ".rs") and not {"target", "vendor"} & set(path.parts)]
    found = {path.relative_to(ROOT).as_posix() for path in [*files, ROOT / "libbn/CMakeLists.txt"]
             if path.name != "zorder.c" and kind.search(re.sub(r"/\*.*?\*/|//[^\n]*", " ", text_of(path), flags=re.S))}
    section = re.search(r"^### Add a sampler\b.*?(?=^##)", text_of("CONTRIBUTING.md"), re.M | re.S)[0]
    assert [path for path in found if f"`{path}`" not in section] == []
