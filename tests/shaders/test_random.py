# SPDX-License-Identifier: Apache-2.0
"""The package of examples/web/package: its module in Node.js, and its texts run by WebGPU and OpenGL drivers, with the cases of
shader_cases.c."""

import json
import re
import shutil
import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest
from conftest import GLSLANG, HERE, ROOT, need, run
from test_browser import posted_by

PACKAGE = ROOT / "examples" / "web" / "package"
NODE = shutil.which("node") or shutil.which("nodejs")
SEED = 2**64 - 1  # of the cases
EFFECTS = [{"pixel": 0, "direction": 3, "light": 5}, {"pixel": 0, "lens": 4, "direction": 3, "light": 5, "choice": 6, "environment": 7}]

needs_node = pytest.mark.skipif(NODE is None, reason="no Node.js")


def in_node(expression):
    """What an expression over the module `bn` is, through JSON."""
    code = f'import * as bn from {json.dumps((PACKAGE / "index.js").as_uri())}; console.log(JSON.stringify({expression}));'
    return json.loads(run(NODE, "--input-type=module", "-e", code))


@pytest.fixture(scope="module", params=[0, 1], ids=["no lens", "lens"])
def random(request, cases):
    """For a renderer without a lens or with one."""
    asked, expected = (np.fromfile(cases.folder / name, "<u4") for name in ("asked.bin", f"random{request.param}.bin"))
    return SimpleNamespace(words=cases.words, asked=asked, expected=expected.reshape(-1, 16), effects=EFFECTS[request.param])


@pytest.fixture(scope="module")
def posted(random, tmp_path_factory):
    """What random.html posts in Chromium, {path: bytes}."""
    served = {"/": (HERE / "random.html").read_bytes(), "/harness.js": (HERE / "harness.js").read_bytes(),
              "/asked": random.asked.tobytes(), "/main.wgsl": WGSL.encode(),
              "/main.glsl": GLSL.encode(), "/effects": json.dumps(random.effects).encode()}
    served |= {f"/{name}": (PACKAGE / name).read_bytes() for name in ("index.js", "texts.js")}
    return posted_by(served, tmp_path_factory.mktemp("profile"))


# ---- The module


def test_the_texts_are_up_to_date():
    pytest.importorskip("bluenoise")
    run(sys.executable, PACKAGE / "make_texts.py", "--check")


@needs_node
def test_the_names_are_those_of_the_types():
    declared = re.findall(r"^export (?:function|const) (\w+)", (PACKAGE / "index.d.ts").read_text(), re.M)
    assert in_node("Object.keys(bn)") == sorted(declared)
    effects = (PACKAGE / "index.d.ts").read_text().split("export interface Effects")[1].split("}")[0]
    roles = re.findall(r"^  (\w+)\?: number;", effects, re.M)
    for role in roles:
        assert f"BN_EFFECT_{role.upper()} 9u\n" in in_node(f"bn.glsl({{effects: {{light: 1, {role}: 9}}}})")


@needs_node
def test_the_package_is_found_by_its_name(tmp_path):
    description = json.loads((PACKAGE / "package.json").read_text())
    shutil.copytree(PACKAGE, tmp_path / "node_modules" / description["name"])
    (tmp_path / "a.mjs").write_text(f'import {{TABLE_WIDTH}} from "{description["name"]}"; console.log(TABLE_WIDTH);\n')
    assert run(NODE, tmp_path / "a.mjs") == "64\n"
    files = [*description["files"], description["types"], description["exports"]["."]["default"]]
    assert all((PACKAGE / name).is_file() for name in files) and description["private"] is True
    header = (ROOT / "libbn" / "include" / "bn" / "bn.h").read_text()
    assert description["version"].split(".") == re.findall(r"^#define BN_VERSION_(?:MAJOR|MINOR|PATCH) (\d+)$", header, re.M)


@needs_node
def test_the_table_and_seeds_are_the_librarys(random):
    assert in_node("[...bn.tableWords()]") == random.words.tolist()
    texels = in_node("[...bn.tableTexels()]")
    assert texels[:len(random.words)] == random.words.tolist() and set(texels[len(random.words):]) <= {0}
    assert len(texels) == in_node("bn.TABLE_WIDTH * bn.TABLE_HEIGHT") and len(texels) % 64 == 0
    for seed in (f"{SEED}n", "-1", "-1n"):
        assert in_node(f"[...bn.seedWords({seed})]") == random.asked.reshape(-1, 8)[0, 5:7].tolist()


@needs_node
@pytest.mark.parametrize("language", ["glsl", "wgsl"])
def test_the_seed_is_0_until_it_is_set(language):
    words = ", ".join(f"0x{word:08x}u" for word in in_node("[...bn.seedWords()]"))
    assert f"({words}); /* seed 0 */" in in_node(f"bn.{language}()")


@needs_node
@pytest.mark.parametrize("call, message", [
    ("bn.glsl({effects: {lense: 1}})", 'effects: no role "lense"; there are pixel, lens,'),
    ("bn.glsl({effects: {lens: 1.5}})", "effects.lens is 1.5, not an integer from 0 to 2^32 - 2"),
    ("bn.wgsl({effects: {lens: 2 ** 32 - 1}})", "effects.lens is 4294967295, not an integer"),
    ("bn.wgsl({effects: {lens: 1, light: 1}})", "two roles have the same number"),
    ("bn.wgsl({effects: {choice: 1}})", "effects.choice needs effects.light"),
    ("bn.wgsl({table: 'sampler'})", 'table is "sampler", not "buffer" or "texture"'),
    ("bn.wgsl({binding: -1})", "binding is -1, not an integer from 0"),
    ("bn.glsl({table: 'texture'})", 'no option "table"; there are effects')])
def test_mistakes_are_one_clear_line(call, message):
    assert message in in_node(f"(() => {{ try {{ {call}; }} catch (error) {{ return error.message; }} }})()")


# ---- The shaders

WGSL = """
@group(0) @binding(1) var<storage, read> asked: array<u32>;
@group(0) @binding(2) var<storage, read_write> results: array<u32>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {
    if (id.x >= arrayLength(&asked) / 8u) { return; }
    let at = 8u * id.x;
    let last = min(asked[at + 3u], 3u);
    rngSeed(vec2u(asked[at + 5u], asked[at + 6u]));
    rngInit(vec2u(asked[at], asked[at + 1u]), asked[at + 2u], asked[at + 3u] - last);
    for (var i = 0u; i < last; i++) { rngNextBounce(); }
    let effect = asked[at + 4u];
    let two = bitcast<vec2u>(rand2(effect));
    let three = bitcast<vec3u>(rand3(effect));
    let four = bitcast<vec4u>(rand4(effect));
    let all = array<u32, 10>(bitcast<u32>(rand1(effect)), two.x, two.y, three.x, three.y, three.z, four.x, four.y, four.z, four.w);
    for (var i = 0u; i < 10u; i++) { results[16u * id.x + i] = all[i]; }
}
"""

GLSL = """
uniform highp usampler2D asked;
out highp uint word;

uint ask(int i) { return texelFetch(asked, ivec2(int(gl_FragCoord.x) / 16 * 8 + i, int(gl_FragCoord.y)), 0).r; }

void main() {
    uint last = min(ask(3), 3u), effect = ask(4);
    rngSeed(uvec2(ask(5), ask(6)));
    rngInit(uvec2(ask(0), ask(1)), ask(2), ask(3) - last);
    for (uint i = 0u; i < last; ++i) rngNextBounce();
    vec2 two = rand2(effect);
    vec3 three = rand3(effect);
    vec4 four = rand4(effect);
    float all[16] = float[16](rand1(effect), two.x, two.y, three.x, three.y, three.z, four.x, four.y, four.z, four.w,
                              0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    word = floatBitsToUint(all[int(gl_FragCoord.x) % 16]);
}
"""


def compare(random, result):
    got = np.frombuffer(result, "<u4").reshape(random.expected.shape)
    different = np.flatnonzero((got != random.expected).any(axis=1))
    assert len(different) == 0, f"{len(different)} cases differ, first {random.asked.reshape(-1, 8)[different[0]]}"


@pytest.mark.parametrize("name", ["buffer", "texture", "webgl"])
def test_in_a_browser(random, posted, name):
    result = posted[f"/{name}"]
    assert len(result) == random.expected.nbytes, result[:2000].decode()
    compare(random, result)


@needs_node
@pytest.mark.parametrize("version", ["300 es", "330"])
def test_the_glsl_is_valid(version, tmp_path):
    need(GLSLANG, "glslangValidator")
    (tmp_path / "a.frag").write_text(f"#version {version}\n{in_node('bn.glsl()')}{GLSL}")
    run(GLSLANG, tmp_path / "a.frag")


@needs_node
def test_the_readmes_examples(tmp_path):
    page = (PACKAGE / "README.md").read_text(encoding="utf-8")
    (code,) = re.findall(r"^<!-- listing: glsl -->\n```js\n(.*?)^```", page, re.M | re.S)
    (wgsl,) = re.findall(r"^<!-- listing: wgsl -->\n```js\n(.*?)^```", page, re.M | re.S)
    shutil.copytree(PACKAGE, tmp_path / "node_modules" / "libbn")
    for name, text in (("glsl", code), ("wgsl", wgsl)):
        (tmp_path / f"{name}.mjs").write_text(text + "process.stdout.write(shader);\n")
    shader = subprocess.run([NODE, tmp_path / "glsl.mjs"], capture_output=True, text=True, check=True).stdout
    if GLSLANG:
        (tmp_path / "a.frag").write_text(shader)
        run(GLSLANG, tmp_path / "a.frag")
    assert "fn rngInit(" in run(NODE, tmp_path / "wgsl.mjs")
