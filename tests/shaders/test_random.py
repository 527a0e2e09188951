# SPDX-License-Identifier: Apache-2.0
"""Tests the module of examples/web/package in Node.js. test_browser.py runs its shaders."""

import json
import re
import shutil

import pytest
from conftest import GLSLANG, PACKAGE, ROOT, need, run
from test_browser import GLSL, SEED

NODE = shutil.which("node") or shutil.which("nodejs")


def node(*arguments):
    return run(NODE, *arguments) if NODE else pytest.skip("Node.js is not installed")


def in_node(expression):
    """Evaluates an expression that uses the `bn` module. Its value is returned through JSON."""
    code = f'import * as bn from {json.dumps((PACKAGE / "index.js").as_uri())}; console.log(JSON.stringify({expression}));'
    return json.loads(node("--input-type=module", "-e", code))


def test_exports_match_the_type_declarations():
    declared = re.findall(r"^export (?:function|const) (\w+)", (PACKAGE / "index.d.ts").read_text(), re.M)
    assert in_node("Object.keys(bn)") == sorted(declared)
    effects = (PACKAGE / "index.d.ts").read_text().split("export interface Effects")[1].split("}")[0]
    roles = re.findall(r"^  (\w+)\?: number;", effects, re.M)
    for role in roles:
        assert f"BN_EFFECT_{role.upper()} 9u\n" in in_node(f"bn.glsl({{effects: {{light: 1, {role}: 9}}}})")


def test_package_can_be_imported_by_name(tmp_path):
    description = json.loads((PACKAGE / "package.json").read_text())
    shutil.copytree(PACKAGE, tmp_path / "node_modules" / description["name"])
    (tmp_path / "a.mjs").write_text(f'import {{TABLE_WIDTH}} from "{description["name"]}"; console.log(TABLE_WIDTH);\n')
    assert node(tmp_path / "a.mjs") == "64\n"
    files = [*description["files"], description["types"], description["exports"]["."]["default"]]
    assert all((PACKAGE / name).is_file() for name in files) and description["private"] is True
    header = (ROOT / "libbn" / "include" / "bn" / "bn.h").read_text()
    assert description["version"].split(".") == re.findall(r"^#define BN_VERSION_(?:MAJOR|MINOR|PATCH) (\d+)$", header, re.M)


def test_table_and_seeds_match_the_library(cases):
    words, last = cases.words.tolist(), cases.asked[-1, 0, 10:12].tolist()
    assert in_node("[...bn.tableWords()]") == words
    texels = in_node("[...bn.tableTexels()]")
    assert texels[:len(words)] == words and set(texels[len(words):]) <= {0}
    assert len(texels) == in_node("bn.TABLE_WIDTH * bn.TABLE_HEIGHT") and len(texels) % 64 == 0
    for seed in (f"{SEED}n", "-1", "-1n"):
        assert in_node(f"[...bn.seedWords({seed})]") == last


@pytest.mark.parametrize("language", ["glsl", "wgsl"])
def test_default_seed_is_0(language):
    words = ", ".join(f"0x{word:08x}u" for word in in_node("[...bn.seedWords()]"))
    assert f"({words}); /* seed 0 */" in in_node(f"bn.{language}()")


@pytest.mark.parametrize("call, message", [
    ("bn.glsl({effects: {lense: 1}})", 'effects: no role "lense"; there are pixel, lens,'),
    ("bn.glsl({effects: {lens: 1.5}})", "effects.lens is 1.5, not an integer from 0 to 2^32 - 2"),
    ("bn.wgsl({effects: {lens: 2 ** 32 - 1}})", "effects.lens is 4294967295, not an integer"),
    ("bn.wgsl({effects: {lens: 1, light: 1}})", "two roles have the same number"),
    ("bn.wgsl({effects: {choice: 1}})", "effects.choice needs effects.light"),
    ("bn.wgsl({table: 'sampler'})", 'table is "sampler", not "buffer" or "texture"'),
    ("bn.wgsl({binding: -1})", "binding is -1, not an integer from 0"),
    ("bn.glsl({table: 'texture'})", 'no option "table"; there are effects')])
def test_error_messages(call, message):
    assert message in in_node(f"(() => {{ try {{ {call}; }} catch (error) {{ return error.message; }} }})()")


@pytest.mark.parametrize("version", ["300 es", "330"])
def test_glsl_is_valid(version, tmp_path):
    need(GLSLANG, "glslangValidator")
    (tmp_path / "a.frag").write_text(f"#version {version}\n{in_node('bn.glsl()')}{GLSL}")
    run(GLSLANG, tmp_path / "a.frag")


def test_readme_examples(tmp_path):
    page = (PACKAGE / "README.md").read_text(encoding="utf-8")
    shutil.copytree(PACKAGE, tmp_path / "node_modules" / "libbn")
    for name in ("glsl", "wgsl"):
        (text,) = re.findall(rf"^<!-- listing: {name} -->\n```js\n(.*?)^```", page, re.M | re.S)
        (tmp_path / f"{name}.mjs").write_text(text + "process.stdout.write(shader);\n")
    assert "fn rngInit(" in node(tmp_path / "wgsl.mjs")
    (tmp_path / "a.frag").write_text(node(tmp_path / "glsl.mjs"))
    need(GLSLANG, "glslangValidator")
    run(GLSLANG, tmp_path / "a.frag")
