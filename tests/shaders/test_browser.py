# SPDX-License-Identifier: Apache-2.0
"""Software WebGPU (WGSL) and WebGL 2 (GLSL) in headless Chromium: draws, choices and the numbers drawn by the package
examples/web/package are bit-identical to the library's."""

import base64
import json
import re
from types import SimpleNamespace

import numpy as np
import pytest
from conftest import HERE, PACKAGE, need
from test_shaders import TEXTURES, compare, wgsl, with_texts

WIDTH = 4096  # of the result image


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    """A browser with a page that contains the functions of harness.js."""
    found = pytest.importorskip("chromium", reason="not in the source distribution")
    need(found.chromium(), "Chromium")
    folder = tmp_path_factory.mktemp("chromium")
    browser = found.Browser(found.chromium(), folder, 300)
    page = folder / "page.html"  # WebGPU requires a page from a file or a server
    page.write_text(f"<!doctype html><script>{(HERE / 'harness.js').read_text()}</script>")
    browser.open(page.as_uri(), 100, 100)
    yield browser
    browser.close()


def numbers(data, kind="words") -> str:
    """Numbers as a JavaScript expression."""
    return f"{kind}('{base64.b64encode(data).decode()}')"


def run_webgpu(browser, code, inputs, size, threads):
    """The code and the inputs are JavaScript expressions."""
    return np.array(browser.value(f"webgpu({code}, [{', '.join(inputs)}], {size}, {threads}).then(found => Array.from(found))"), "<u4")


def run_webgl(browser, code, inputs, size):
    listed = ", ".join(f"{name}: {{width: {width}, texels: {texels}}}" for name, (width, texels) in inputs.items())
    return np.array(browser.value(f"Array.from(webgl({code}, {{{listed}}}, {-(-size // (4 * WIDTH))}))"), "<u4")[:size // 4]


# ---- Every fifth case of shader_cases


@pytest.fixture(scope="module")
def some(cases):
    return SimpleNamespace(**{**vars(cases), "asked": cases.asked[:, ::5], "expected": cases.expected[:, ::5]})


def test_webgpu(browser, some):
    def run(code, buffers, size, threads):
        return run_webgpu(browser, json.dumps(code), map(numbers, buffers), size, threads)

    compare(run, wgsl(), some)


def test_webgl(browser, some):
    def run(code, buffers, size, threads):
        textures = {name: (width or len(data) // 4, numbers(data, "words" if kind == "u4" else "floats"))
                    for (name, (width, kind)), data in zip(TEXTURES.items(), buffers)}
        return run_webgl(browser, json.dumps(code), textures, size)

    compare(run, with_texts((HERE / "draw.frag").read_text()), some)


# ---- The package

SEED = 2**64 - 1
# The effects of a renderer without and with a lens. Effects with these roles have fixed positions in the layout. All other effects are
# keys, including the lens, environment and choice effects of a renderer without a lens.
EFFECTS = [{"pixel": 0, "direction": 3, "light": 5}, {"pixel": 0, "lens": 4, "direction": 3, "light": 5, "choice": 6, "environment": 7}]

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


@pytest.fixture(scope="module")
def asked():
    """4,096 cases, each with x, y, index, bounce, effect, two seed words and zero."""
    i = np.arange(4096, dtype=np.uint32)
    random = i * np.uint32(0x9E3779B9) ^ i >> 5
    x, bounce = np.where(i % 7 > 0, random >> 20, -i), np.array([0, 0, 0, 1, 2, 3, 4, 50])[i // 10 % 8]
    index = np.array([0, 1, 2, 5, 64, 255, 256, 1000, 2**20, 2**32 - 1])[i % 10]
    effect = np.where(i % 3 > 0, i // 3 % 9, 50 + (random >> i % 32))
    seeds = pytest.importorskip("bluenoise").Sampler(seed=SEED).seed_words()
    return np.stack(np.broadcast_arrays(x, random & 1023, index, bounce, effect, *seeds, 0), -1).astype("<u4")


def expected(asked, effects):
    """Follows the layout in docs/paths.md: the ten numbers that rand1() to rand4() draw, and six zeros."""
    import bluenoise

    x, y, index, bounce, effect = asked[:, :5].T
    path = bluenoise.PathSampler(bluenoise.Sampler(seed=SEED), x.astype(np.int32), y.astype(np.int32), index)
    ray = path.ray(bounce)
    keyed, first, lens = ray.child(effect), bounce == 0, "lens" in effects
    u, light, end = keyed.draw(), effect == effects["light"], ray.draw_end_light()
    found = np.hstack([u[:, :1], u[:, :2], u[:, :3], u, np.zeros((len(x), 6), np.float32)])

    def put(where, at, values):
        found[where, at:at + values.shape[1]] = values[where]

    put(effect == effects["direction"], 1, path.ray(bounce + 1).draw_direction())
    put((effect == effects["pixel"]) & first, 1, ray.draw_direction())
    put(light | (effect == effects.get("environment")), 1, np.where(first[:, None] & lens, path.first_light(), end))
    put(light, 3, u[:, [2, 0, 1]])
    if lens:
        through = (effect == effects["lens"]) & first
        put(through, 1, end)
        put(through, 3, np.hstack([end, u[:, :1]]))
        put(effect == effects["choice"], 0, ray.child(effects["light"]).draw()[:, 3:])
    return found


@pytest.fixture(scope="module")
def package(browser):
    """Loads the package's modules as `bn` and `three` from blobs, because a page opened from disk may not import files."""
    browser.value((PACKAGE / "texts.js").read_text() + "; 0")
    code = (PACKAGE / "index.js").read_text().replace('import "./texts.js";', "")
    nodes = re.sub("(?m)^import .*\n", "", (PACKAGE / "three.js").read_text())
    for name, text in (("bn", code), ("three", THREE + nodes)):
        blob = f"new Blob([{json.dumps(text)}], {{type: 'text/javascript'}})"
        browser.value(f"import(URL.createObjectURL({blob})).then(module => {{ window.{name} = module; }})")
    return browser


# In place of the imports of three.js: nodes are texts, and a function also has the library that its template lists first.
THREE = """
const {seedWords, tableTexels, TABLE_HEIGHT, TABLE_WIDTH, wgsl} = bn, RedIntegerFormat = 0, UnsignedIntType = 0;
class DataTexture {}
const texture = () => "three_texture", wgslTagCode = (tokens, ...nodes) => String.raw({raw: tokens}, ...nodes);
const wgslTagFn = (tokens, [library], ...nodes) => ({library, code: String.raw({raw: tokens}, "", ...nodes).replace("-> void", "")});
"""


@pytest.mark.parametrize("way", ["buffer", "texture", "webgl", "three"])
@pytest.mark.parametrize("effects", EFFECTS, ids=["no lens", "lens"])
def test_package_draws_match_the_library(package, asked, effects, way):
    table = "{width: bn.TABLE_WIDTH, texels: bn.tableTexels()}"
    given, size = json.dumps(effects), 64 * len(asked)
    if way == "webgl":
        code = f"'#version 300 es\\n' + bn.glsl({{effects: {given}}}) + {json.dumps(GLSL)}"
        inputs = {"bn_table": ("bn.TABLE_WIDTH", "bn.tableTexels()"), "asked": (WIDTH // 2, numbers(asked.tobytes()))}
        found = run_webgl(package, code, inputs, size)
    else:
        code = f"bn.wgsl({{effects: {given}, table: '{way}'}}) + {json.dumps(WGSL)}"
        if way == "three":
            # A kernel of three-gpu-pathtracer calls the six nodes, and three.js declares the texture.
            kernel = re.sub(r"(rand\d)\(", r"bn_three_\1(", re.sub(r"rngSeed.*\n", "", WGSL))
            kernel = kernel.replace("rngInit", "bn_three_init").replace("rngNextBounce", "bn_three_next_bounce")
            made = f"Object.values(three.randomGenerator({{effects: {given}, seed: {SEED}n}}))"
            declared = "'@group(0) @binding(0) var three_texture: texture_2d<u32>;'"
            code = f"(made => {declared} + made[0].library + made.map(node => node.code).join(''))({made}) + {json.dumps(kernel)}"
        inputs = ["bn.tableWords()" if way == "buffer" else table, numbers(asked.tobytes())]
        found = run_webgpu(package, code, inputs, size, len(asked))
    different = np.flatnonzero((found.reshape(-1, 16) != expected(asked, effects).view("<u4")).any(axis=1))
    assert len(different) == 0, f"{len(different)} cases differ, first {asked[different[0]]}"


# State that a page may have set for its images, or that is undefined after other libraries, and its restored values.
PAGE_STATES = ["", "gl.pixelStorei(gl.UNPACK_FLIP_Y_WEBGL, true)", "gl.pixelStorei(gl.UNPACK_PREMULTIPLY_ALPHA_WEBGL, true)",
               "gl.pixelStorei(gl.UNPACK_ALIGNMENT, 8)", "gl.pixelStorei(gl.UNPACK_ROW_LENGTH, 128)",
               "gl.pixelStorei(gl.UNPACK_SKIP_ROWS, 3)", "gl.pixelStorei(gl.UNPACK_SKIP_PIXELS, 5)",
               "gl.bindBuffer(gl.PIXEL_UNPACK_BUFFER, buffer)", "gl.bindTexture(gl.TEXTURE_2D, texture)"]
READ_TABLE = """(() => {
    const gl = document.createElement("canvas").getContext("webgl2"), buffer = gl.createBuffer(), texture = gl.createTexture();
    gl.bindBuffer(gl.PIXEL_UNPACK_BUFFER, buffer);
    gl.bindBuffer(gl.PIXEL_UNPACK_BUFFER, null);
    STATE;
    const names = ["UNPACK_FLIP_Y_WEBGL", "UNPACK_PREMULTIPLY_ALPHA_WEBGL", "UNPACK_ALIGNMENT", "UNPACK_ROW_LENGTH", "UNPACK_SKIP_ROWS",
                   "UNPACK_SKIP_PIXELS", "PIXEL_UNPACK_BUFFER_BINDING", "TEXTURE_BINDING_2D", "ACTIVE_TEXTURE"];
    const state = () => names.map(name => gl.getParameter(gl[name]));
    const before = state(), table = bn.tableTexture(gl), after = state();
    gl.bindFramebuffer(gl.FRAMEBUFFER, gl.createFramebuffer());
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, table, 0);
    const read = new Uint32Array(4 * bn.TABLE_WIDTH * bn.TABLE_HEIGHT);
    gl.readPixels(0, 0, bn.TABLE_WIDTH, bn.TABLE_HEIGHT, gl.RGBA_INTEGER, gl.UNSIGNED_INT, read);
    const expected = bn.tableTexels();
    return {changed: names.filter((_, i) => before[i] !== after[i]), wrong: expected.filter((word, i) => read[4 * i] !== word).length,
            error: gl.getError()};
})()"""


@pytest.mark.parametrize("state", PAGE_STATES)
def test_table_upload_in_any_state(package, state):
    assert package.value(READ_TABLE.replace("STATE", state)) == {"changed": [], "wrong": 0, "error": 0}
