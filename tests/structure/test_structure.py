# SPDX-License-Identifier: Apache-2.0
"""The sources keep to policy.toml: no circles of includes, and nobody sees what is not theirs to see."""

import re
import tomllib
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
SOURCE = ROOT / "libbn" / "src"
POLICY = tomllib.loads(Path(__file__).with_name("policy.toml").read_text(encoding="utf-8"))


def code_files(folder):
    return sorted(path for path in folder.rglob("*") if path.suffix in (".c", ".h", ".cpp", ".hpp"))


def code(path):
    return re.sub(r"/\*.*?\*/|//[^\n]*", " ", path.read_text(encoding="utf-8"), flags=re.DOTALL)


def included(path):
    """(quoted, name) of each #include of a file."""
    found = re.findall(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]', code(path), re.MULTILINE)
    return [(mark == '"', name) for mark, name in found]


def require_no_circle(graph):
    """Raises CycleError, which names the circle; a graph without an edge is a mistake of the test."""
    assert sum(map(len, graph.values())) > 0
    tuple(TopologicalSorter(graph).static_order())


@pytest.mark.parametrize("folder, root", [("libbn/include", "libbn/include"), ("libbn/src", "libbn/src"), ("libbn/tools", "."),
                                          ("bindings/src", "."), ("examples/pathtracer", "."), ("tests", ".")])
def test_includes_have_no_cycles(folder, root):
    files = set(code_files(ROOT / folder))
    candidates = {path: [(base / name).resolve() for _, name in included(path) for base in (path.parent, ROOT / root)] for path in files}
    require_no_circle({path: files & set(others) for path, others in candidates.items()})


def test_source_folders_include_allowed_folders_only():
    sees = POLICY["source"]
    assert set(sees) == {path.name for path in SOURCE.iterdir()}
    require_no_circle({folder: set(others) for folder, others in sees.items()})
    for path in code_files(SOURCE):
        folder = path.relative_to(SOURCE).parts[0]
        names = {name.split("/")[0] for quoted, name in included(path) if quoted}
        assert names <= {folder, *sees[folder]}, path


@pytest.mark.parametrize("keeper", POLICY["keepers"])
def test_system_calls_stay_in_one_file(keeper):
    found = [path.relative_to(SOURCE).as_posix() for path in code_files(SOURCE) if re.search(POLICY["keepers"][keeper], code(path))]
    assert found == [keeper]


def test_only_the_library_includes_internal_headers():
    found = set()
    for path in (path for folder in ("bindings", "examples", "libbn/tools", "tests") for path in code_files(ROOT / folder)):
        for _, name in included(path):
            beside, below = (path.parent / name).resolve(), (SOURCE / name).resolve()
            if SOURCE in beside.parents or (not beside.exists() and SOURCE in below.parents and below.exists()):
                found.add(path.relative_to(ROOT).as_posix())
    assert found == set(POLICY["insiders"]["files"])


@pytest.mark.parametrize("package", POLICY["packages"])
def test_packages_import_allowed_packages_only(package):
    folder, *others = POLICY["packages"][package]
    forbidden = re.compile(rf"^\s*(?:import|from) (?:{'|'.join(others)})\b", re.M)
    assert [path for path in (ROOT / folder).rglob("*.py*") if path.suffix in (".py", ".pyi")
            and forbidden.search(path.read_text(encoding="utf-8"))] == []
