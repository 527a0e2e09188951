# SPDX-License-Identifier: Apache-2.0
"""The examples in docs/shaders.md, docs/realtime.md and the headers' comments compile unchanged."""

import re

import pytest
from conftest import GLSLANG, HERE, INCLUDE, ROOT, compile_text, need, need_wgpu, run
from test_device_code import compile_with_nvrtc
from test_shaders import with_texts

GUIDE = "".join((ROOT / "docs" / name).read_text(encoding="utf-8") for name in ("shaders.md", "realtime.md"))


def listing(name):
    (text,) = re.findall(rf"^<!-- listing: {re.escape(name)} -->\n```\w+\n(.*?)^```", GUIDE, re.MULTILINE | re.DOTALL)
    return text


def test_upload(tmp_path):
    compile_text(tmp_path, "upload.c", listing("upload.c"))


def test_cpp(tmp_path):
    compile_text(tmp_path, "realtime.cpp", listing("realtime.cpp"))
    compile_text(tmp_path, "follow.cpp", listing("follow.cpp"))


def compile_hlsl(folder, text):
    need(GLSLANG, "glslangValidator")
    (folder / "a.hlsl").write_text(text)
    run(GLSLANG, "-D", "-V", "-S", "comp", "-e", "main", f"-I{INCLUDE / 'bn'}", "-o", folder / "a.spv", folder / "a.hlsl")


def compile_metal(folder, text, *options):
    """Compiles Metal as C++."""
    words = "#define device\n#define thread\n#define constant const\n"
    (folder / "metal_stdlib").write_text((HERE / "stand_ins.h").read_text() + words)
    compile_text(folder, "a.cpp", text, "-I", folder, "-I", INCLUDE / "bn", *options)


def compile_wgsl(*texts):
    need_wgpu()
    import wgpu

    wgpu.gpu.request_adapter_sync().request_device_sync().create_shader_module(code="\n".join(texts))


@pytest.mark.parametrize("name", ["example.comp", "path.comp"])
def test_glsl(tmp_path, name):
    need(GLSLANG, "glslangValidator")
    (tmp_path / "a.comp").write_text(with_texts(listing(name)))
    run(GLSLANG, tmp_path / "a.comp")
    run(GLSLANG, "-V", "-o", tmp_path / "a.spv", tmp_path / "a.comp")


@pytest.mark.parametrize("name, define", [("example.hlsl", ""), ("realtime.hlsl", ""), ("realtime.hlsl", "#define TABLE_IS_A_TEXTURE\n")])
def test_hlsl(tmp_path, name, define):
    compile_hlsl(tmp_path, define + listing(name))


def test_wgsl():
    compile_wgsl(listing("example.wgsl"), *((INCLUDE / "bn" / name).read_text() for name in ("bn_draw.wgsl", "bn_choose.wgsl")))


def test_cuda(tmp_path):
    assert b".entry draw(" in compile_with_nvrtc(listing("example.cu").encode())


def test_metal(tmp_path):
    """Removes the attributes and a vector constructor, which C++ lacks."""
    text = re.sub(r" \[\[[^]]*\]\]", "", listing("example.metal")).replace("float4(u.xy,", "float4(u.x, u.y,")
    compile_metal(tmp_path, text, "-Dkernel=")


# ---- Listings in header comments: paragraphs indented by four more spaces than the text

SAMPLING = "uint64_t seed, int32_t x, int32_t y, uint32_t index, uint32_t depth"
# For each header, declarations and parameters that provide the undeclared names in its listings.
C_LISTINGS = {
    "bn.h": ("", f"{SAMPLING}, uint32_t decision, uint32_t bounce"),
    "bn_path.h": ("", f"{SAMPLING}, uint32_t max_depth, uint32_t count, const bn_sampler *sampler, bn_ray ray, uint32_t primitive, "
                      "uint32_t frame, uint32_t most, uint32_t i, bn_pan pan, float motion_x, float motion_y"),
    "bn_choose.h": ("""typedef struct vec3 { float x, y, z; } vec3;
vec3 point_on_light(uint32_t, float, float), sample_coat(float, float), sample_base(float, float);
""", f"{SAMPLING}, uint32_t domain, const bn_sampler *sampler, uint32_t light_count, float coat_probability"),
    "neural.h": ("", "uint64_t seed, uint32_t *ranks"),
}
SHADER_TYPES = {"glsl": ("ivec2", "uvec2", "void main() {"), "hlsl": ("int2", "uint2", "[numthreads(1, 1, 1)] void main() {")}
NUMBERS = "uint x = 1u, y = 2u, index = 3u, domain = 4u, depth = 5u, ray = 6u, light_count = 7u, first = 0u; float coat_probability = 0.5;"


def paragraphs(header):
    """A header's listings, one per paragraph of code."""
    comment = (INCLUDE / "bn" / header).read_text(encoding="utf-8").partition("*/\n" if not header.endswith("hpp") else "#ifndef")[0]
    found = re.findall(r"(?:^(?: \*|//)     .*(?: \*/)?\n?)+", comment + "\n", re.MULTILINE)
    texts = [re.sub(r"^(?: \*|//)     ", "", each, flags=re.MULTILINE).rstrip().removesuffix("*/") for each in found]
    code = [text for text in texts if not text.startswith(" ") and re.search(r"([;{}]|^#.*)\s*(//.*)?$", text, re.MULTILINE)]
    assert code, f"{header} has no listing"
    return code


def test_every_header_is_covered():
    tested = {*C_LISTINGS, "bn.hpp", *(f"bn_{name}.{language}" for name in ("draw", "path", "choose")
                                       for language in ("glsl", "hlsl", "metal", "wgsl")), "bn_choose_cdf.wgsl"}
    assert {path.name for path in (INCLUDE / "bn").iterdir()} - tested == {"bn_draw.h", "bn_device.h"}


@pytest.mark.parametrize("header", C_LISTINGS)
def test_c_header_listings(tmp_path, header):
    before, parameters = C_LISTINGS[header]
    texts = paragraphs(header)
    if header == "bn.h":  # it also has a listing outside its first comment
        texts += [re.sub(r"^ \*     ", "", each, flags=re.MULTILINE) for each in re.findall(
            r"(?:^ \*     uint32_t .*\n)+", (INCLUDE / "bn" / header).read_text(), re.MULTILINE)]
    nested = "{\n".join(re.sub(r"^#.*\n", "", text, flags=re.MULTILINE) + "\n" for text in texts) + "}" * (len(texts) - 1)
    text = (f"#include <bn/{header}>\n#include <bn/bn_path.h>\n{before}void listing({parameters});\n"
            f"void listing({parameters}) {{\n{nested}\n}}\n")
    compile_text(tmp_path, "a.c", text, "-Wno-unused", "-Wno-unused-parameter", "-Wno-maybe-uninitialized")


def test_cpp_header_listings(tmp_path):
    listings = "\n".join(text for text in paragraphs("bn.hpp") if not text.startswith("// numbers."))
    text = ("#include <bn/bn.hpp>\nenum { KEY_LIGHT = 3 };\n"
            f"void listing(uint64_t seed, int x, int y, unsigned index, unsigned depth) {{\n{listings}\n}}\n")
    compile_text(tmp_path, "a.cpp", text, "-std=c++14", "-Wno-unused")


def shader_of_listings(language, texture=False):
    """Combines all listings of a language into one shader, with their declarations before the includes and their statements in main()."""
    declared, statements = [], []
    for name in ("bn_draw", "bn_path", "bn_choose"):
        for text in paragraphs(f"{name}.{language}"):
            declares = re.match(r"#|layout|uniform|StructuredBuffer", text)
            (declared if declares else statements).append(text)
    # GLSL declares the words both as a buffer and as a texture.
    declared = [text for text in declared if "bn_words" not in text or ("usampler2D" in text) == texture]
    version = "#version 430\n" if language == "glsl" and texture else ""
    signed, unsigned, main = SHADER_TYPES[language]
    seed = "" if language == "glsl" and not texture else f"{unsigned} seed = {unsigned}(8u, 9u);"
    include = "".join(f'#include "{name}.{language}"\n' for name in ("bn_draw", "bn_path", "bn_choose"))
    cdf = "" if language == "glsl" else "StructuredBuffer<float> cdf : register(t1);\n#define BN_CDF(i) cdf[i]\n"
    layout = "layout(local_size_x = 1) in;\n" if language == "glsl" else ""
    return (version + "\n".join(declared) + f"\n{cdf}{layout}{include}{main}\n{NUMBERS}\n{signed} pixel = {signed}(1, 2); {seed}\n"
            + "\n".join(f"{{ {text}\n}}" for text in statements) + "\n}\n")


@pytest.mark.parametrize("texture", [False, True])
def test_glsl_header_listings(tmp_path, texture):
    need(GLSLANG, "glslangValidator")
    (tmp_path / "a.comp").write_text(with_texts(shader_of_listings("glsl", texture)))
    run(GLSLANG, tmp_path / "a.comp")


def test_hlsl_header_listings(tmp_path):
    compile_hlsl(tmp_path, shader_of_listings("hlsl"))


def test_metal_header_listings(tmp_path):
    first, *texts = [text for name in ("bn_draw", "bn_path", "bn_choose") for text in paragraphs(f"{name}.metal")]
    blocks = "\n".join(f"{{ {text}\n}}" for text in texts)
    compile_metal(tmp_path, f'{first}\n#include "bn_path.metal"\n#include "bn_choose.metal"\n'
                            f"void listing(const uint *bn_words, uint2 seed, uint2 pixel) {{ {NUMBERS}\n{blocks}\n}}\n", "-Wno-unused")


def test_wgsl_header_listings():
    names = ("bn_draw", "bn_path", "bn_choose", "bn_choose_cdf")
    texts = [text for name in names for text in paragraphs(f"{name}.wgsl")]
    declared = [text for text in texts if text.startswith("@group")]
    numbers = re.sub(r"uint (.*?);", lambda each: "".join(f"let {one};" for one in each[1].split(", ")), NUMBERS)
    numbers = numbers.replace("float coat_probability", "let coat_probability")
    given = f"{numbers} let pixel = vec2i(1, 2); let seed = vec2u(8u, 9u); let draw = vec4f(0.5); var u = 0.5;"
    compile_wgsl(*declared, *((INCLUDE / "bn" / f"{name}.wgsl").read_text() for name in names),
                 f"@compute @workgroup_size(1) fn main() {{ {given}", *(f"{{ {text}\n}}" for text in texts if text not in declared), "}")
