#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes texts.js for index.js and the pages in the parent folder: the shader sources of libbn and of this folder, and the table of
`blue`."""

import base64
import json
import os
import re
from pathlib import Path

HERE = Path(__file__).resolve().parent
INCLUDE = HERE.parents[2] / "libbn" / "include" / "bn"
TEXTS = HERE / "texts.js"
TYPES = {"uint": "u32", "float": "f32", "vec2": "vec2f", "vec3": "vec3f", "vec4": "vec4f", "uvec2": "vec2u", "bn_path": "bn_path"}


def function(found):
    """The head of a function in WGSL."""
    kind, name, listed = found.groups()
    parameters = ", ".join(f"{parameter}: {TYPES[of]}" for of, parameter in map(str.split, filter(None, listed.split(", "))))
    return f"fn {name}({parameters}) {'' if kind == 'void' else f'-> {TYPES[kind]} '}{{"


def wgsl(glsl):
    """random.glsl in WGSL, without its first comment and its macro."""
    text = glsl[glsl.index("uvec2 bn_rng_seed"):]
    text = re.sub(r"^(\w+) (\w+)( = .*)?;", lambda each: f"var<private> {each[2]}{each[3] or f': {TYPES[each[1]]}'};", text, flags=re.M)
    text = re.sub(r"^(\w+) (\w+)\((.*)\) \{", function, text, flags=re.M)
    text = re.sub(r"^( +)(?:bool|vec\d) (\w+ = )", r"\1let \2", text, flags=re.M)
    text = re.sub(r"^( +)if (\(.*\))\s+(return .*;)$", r"\1if \2 {\n\1    \3\n\1}", text, flags=re.M)
    text = re.sub(r"\bvec(\d)\(", r"vec\1f(", re.sub(r"\buvec2\(", "vec2u(", text))
    return f"const BN_NO_EFFECT = 0xffffffffu;\n\n{text}"


def main():
    files = [*(INCLUDE / f"{name}.{language}" for name in ("bn_draw", "bn_path") for language in ("glsl", "wgsl")), HERE / "random.glsl"]
    texts = {path.name.replace(".", "_").upper(): path.read_text(encoding="utf-8") for path in files}
    texts["RANDOM_WGSL"] = wgsl(texts["RANDOM_GLSL"])
    # The result of bn_tables(), little-endian.
    texts["WORDS"] = base64.b64encode((INCLUDE.parents[1] / "data" / "blue.u32").read_bytes()).decode()
    code = f"""\
// SPDX-License-Identifier: Apache-2.0 AND CC0-1.0
// Written by make_texts.py. A plain script with a global, because pages opened from disk cannot load modules. WORDS is CC0-1.0.
globalThis.LIBBN_TEXTS = {json.dumps(texts, indent=2)};
"""
    if TEXTS.is_file() and TEXTS.read_text(encoding="utf-8") == code:
        return  # a server that watches the folder need not rebuild
    beside = TEXTS.with_suffix(f".{os.getpid()}")
    beside.write_text(code, encoding="utf-8")
    os.replace(beside, TEXTS)


if __name__ == "__main__":
    main()
