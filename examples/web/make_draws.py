#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes draws.js, what a page in the browser needs of libbn: the texts of bn_draw.glsl and bn_path.glsl and the words of a
sampler's table.

Needs the Python package: .venv/bin/python examples/web/make_draws.py. `--check` writes nothing, and fails if draws.js is
not up to date.
"""

import argparse
import base64
import json
import os
import re
import sys
from pathlib import Path

import bluenoise

HERE = Path(__file__).resolve().parent
INCLUDE = HERE.parents[1] / "libbn" / "include" / "bn"
SEED = 1
COLUMNS = 120


def text_of(name):
    text = (INCLUDE / name).read_text(encoding="utf-8").rstrip("\n")
    # Without its line about the licence, which is that of the page's file.
    lines = re.sub(r"\A/\* SPDX-[^\n]*\n \* ", "/* ", text).split("\n")
    return ",\n".join(f"  {json.dumps(line)}" for line in lines)


def draws():
    words = base64.b64encode(bluenoise.Sampler("blue", seed=SEED).table_words().astype("<u4").tobytes()).decode()
    rows = ",\n".join(f'  "{words[at:at + COLUMNS]}"' for at in range(0, len(words), COLUMNS))
    return f"""\
// SPDX-License-Identifier: Apache-2.0 AND CC0-1.0
// Made by make_draws.py: the draws and paths of libbn for WebGL 2.
"use strict";

// libbn/include/bn/bn_draw.glsl, Apache-2.0. It says how to include it.
const BN_DRAW_GLSL = [
{text_of("bn_draw.glsl")}
].join("\\n");

// libbn/include/bn/bn_path.glsl, Apache-2.0: which domain each decision of a path draws from.
const BN_PATH_GLSL = [
{text_of("bn_path.glsl")}
].join("\\n");

// What bn_sampler_table_words() writes for seed {SEED}, little-endian, CC0-1.0: BN_WORD(i) in the text.
const BN_TABLE_WORDS = (() => {{
  const bytes = Uint8Array.from(atob([
{rows.replace("  ", "    ")}
  ].join("")), character => character.charCodeAt(0));
  const view = new DataView(bytes.buffer);
  return Uint32Array.from({{length: bytes.length / 4}}, (_, i) => view.getUint32(4 * i, true));
}})();
"""


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--check", action="store_true", help="write nothing; fail if draws.js is not up to date")
    path, text = HERE / "draws.js", draws()
    if parser.parse_args().check:
        if not path.is_file() or path.read_text(encoding="utf-8") != text:
            sys.exit("make_draws.py: examples/web/draws.js is not up to date; run .venv/bin/python examples/web/make_draws.py")
        return
    beside = path.with_suffix(".new")
    beside.write_text(text, encoding="utf-8")
    os.replace(beside, path)


if __name__ == "__main__":
    main()
