# SPDX-License-Identifier: Apache-2.0
"""The sources keep to the rules of CONTRIBUTING.md: no circles, and nobody sees what is not theirs to see."""

import re
from pathlib import Path

import pytest
import structure

ROOT = Path(__file__).resolve().parents[2]
SOURCE = ROOT / "libbn" / "src"
FOLDERS = structure.folders_of((ROOT / "CONTRIBUTING.md").read_text())
PACKAGES = {"bluenoise": ROOT / "bindings" / "bluenoise", "bn_trainer": ROOT / "trainer" / "bn_trainer",
            "report": ROOT / "scripts" / "report", "render_farm": ROOT / "scripts" / "render_farm"}

# What one file of libbn/src does for all of it.
KEEPERS = {
    r"\b(?:malloc|calloc|realloc|aligned_alloc|free)\s*\(": "base/memory.c",
    r"\bpthread_\w+|<threads\.h>|\bCreateThread\b|\bSRWLOCK\b": "base/threads.c",
    r"\bdlopen\b|\bsetenv\b": "neural/onnxruntime.c",
    r"<stdio\.h>": "neural/files.c",
}
# Tests of parts that have no public interface; CONTRIBUTING.md names them.
INSIDERS = {"tests/c/fake_onnxruntime.c", "tests/c/test_onnxruntime_api.c", "tests/fuzz/fuzz_onnx_model.c",
            "tests/simd/processor.c"}


def relative(paths):
    return [path.relative_to(ROOT).as_posix() for path in paths]


@pytest.mark.parametrize("folder, roots", [("libbn/include", ("libbn/include",)), ("libbn/src", ("libbn/src",)),
                                           ("libbn/tools", ()), ("bindings/src", ()), ("examples/pathtracer", ()),
                                           ("tests", ())])
def test_no_two_files_include_each_other(folder, roots):
    graph = structure.include_graph(ROOT / folder, tuple(ROOT / root for root in roots))
    assert sum(map(len, graph.values())) > 0
    assert relative(structure.circle(graph)) == []


def test_no_two_files_call_each_other():
    graph = structure.call_graph(SOURCE)
    assert SOURCE / "masks" / "eliminate_ends.c" in graph[SOURCE / "masks" / "relax.c"]
    assert relative(structure.circle(graph)) == []


def test_folders():
    assert set(FOLDERS) == {path.name for path in SOURCE.iterdir()}
    assert structure.circle({folder: sees - {folder} for folder, sees in FOLDERS.items()}) == []
    assert structure.folder_violations(SOURCE, FOLDERS) == []


def test_one_file_knows_memory_threads_libraries_and_files():
    assert structure.keepers_violations(SOURCE, KEEPERS) == []


def test_only_the_library_sees_its_insides():
    assert structure.insiders(ROOT, ("bindings", "examples", "libbn/tools", "tests")) == INSIDERS


@pytest.mark.parametrize("name", PACKAGES)
def test_no_python_module_imports_in_a_circle(name):
    graph = structure.import_graph(structure.modules_of(PACKAGES[name], name))
    assert sum(map(len, graph.values())) > 0
    assert structure.circle(graph) == []


@pytest.mark.parametrize("name, others", [("bluenoise", {"bn_trainer", "report", "torch", "onnx"}),
                                          ("report", {"bn_trainer", "render_farm"}), ("bn_trainer", {"report", "render_farm"}),
                                          ("render_farm", {"bluenoise", "bn_trainer"})])
def test_packages_do_not_import(name, others):
    for module, path in structure.modules_of(PACKAGES[name], name).items():
        assert {target.split(".")[0] for target in structure.imports(module, path)} & others == set(), path


# A kind of sampler wherever code names it, by the example of one that nothing but its own file draws.
KIND = re.compile(r'BN_SAMPLER_ZORDER|bn_draw_zorder|sampler/zorder\.c|\[[^]\n]*"zorder"[^]\n]*\]')


def test_a_kind_of_sampler_has_the_places_that_contributing_names():
    listed = re.search(r"^A kind of sampler is one file .*?counts them", (ROOT / "CONTRIBUTING.md").read_text(), re.M | re.S)
    named = {name for name in re.findall(r"`([\w./-]+/[\w.-]+\.\w+)`", listed[0])}
    files = [path for folder in ("libbn/include", "libbn/src", "bindings", "examples") for path in (ROOT / folder).rglob("*")
             if path.suffix in (".c", ".h", ".hpp", ".cpp", ".py", ".rs") and not {"target", "tests", "vendor"} & set(path.parts)]
    files += [ROOT / "libbn" / "CMakeLists.txt"]
    found = {path.relative_to(ROOT).as_posix() for path in files
             if path.name != "zorder.c" and KIND.search(structure.without_comments(path.read_text(encoding="utf-8")))}
    assert found == named and len(named) == 10


# ---- The checks themselves, on small trees that break each rule


def write(folder, **files):
    for name, text in files.items():
        path = folder / name.replace("__", "/").replace("_dot_", ".")
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)


def test_notices_circles_of_includes(tmp_path):
    write(tmp_path, base__a_dot_h='#include "base/b.h"\n', base__b_dot_h='/* #include "base/a.h" */\n')
    assert structure.circle(structure.include_graph(tmp_path, (tmp_path,))) == []
    write(tmp_path, base__b_dot_h='# include "a.h"\n')
    assert len(structure.circle(structure.include_graph(tmp_path, (tmp_path,)))) >= 2


def test_notices_circles_of_calls(tmp_path):
    write(tmp_path, a_dot_c="int bn_a(int x) {\n    return bn_b(x);\n}\n", b_dot_c="const int *bn_b(int x) {\n}\n")
    graph = structure.call_graph(tmp_path)
    assert graph[tmp_path / "a.c"] == {tmp_path / "b.c"} and structure.circle(graph) == []
    write(tmp_path, b_dot_c="int bn_b(int x,\n         int y) {\n    return bn_a(x);\n}\n")
    assert len(structure.circle(structure.call_graph(tmp_path))) >= 2


def test_notices_a_look_into_the_wrong_folder(tmp_path):
    folders = structure.folders_of("| source folder | what | sees |\n| --- | --- | --- |\n| `base` | x | |\n| `masks` | y | `base` |\n")
    write(tmp_path, base__a_dot_c='#include "base/a.h"\n', masks__b_dot_c='#include "base/a.h"\n')
    assert structure.folder_violations(tmp_path, folders) == []
    write(tmp_path, base__a_dot_c='#include "masks/b.h"\n', attic__c_dot_c="")
    assert len(structure.folder_violations(tmp_path, folders)) == 2


def test_notices_a_second_keeper_and_an_insider(tmp_path):
    source = tmp_path / "libbn" / "src"
    write(source, base__memory_dot_c="void *p = malloc(1);", masks__m_dot_c="bn_free(p); /* malloc(1) */", base__a_dot_h="")
    assert structure.keepers_violations(source, KEEPERS) == []
    write(source, masks__m_dot_c="void *p = calloc(1, 1);")
    assert len(structure.keepers_violations(source, KEEPERS)) == 1
    write(tmp_path, tests__a_dot_c='#include "a.h"\n', tests__b_dot_c='#include "../libbn/src/base/a.h"\n',
          tests__c_dot_c='#include "base/a.h"\n')
    assert structure.insiders(tmp_path, ("tests",)) == {"tests/b.c", "tests/c.c"}


@pytest.mark.parametrize("text", ["from . import a\n", "from .a import x\n", "def f():\n    from p.a import x\n",
                                  "import p.a\n"])
def test_notices_circles_of_imports(tmp_path, text):
    write(tmp_path, __init___dot_py="")
    (tmp_path / "__init__.py").write_text("from .a import x\n")
    write(tmp_path, a_dot_py="import os\nfrom . import b\nx = 1\n",
          b_dot_py="from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from . import a\n")
    assert structure.circle(structure.import_graph(structure.modules_of(tmp_path, "p"))) == []
    write(tmp_path, b_dot_py=text)
    assert len(structure.circle(structure.import_graph(structure.modules_of(tmp_path, "p")))) >= 2
