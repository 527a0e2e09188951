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
ROOT = HERE.parents[1]
INCLUDE = ROOT / "libbn" / "include" / "bn"
SEED = 1
COLUMNS = 120


def quoted(path):
    """A shader's lines as JavaScript strings, without its line about the licence, which is that of the file they go to."""
    lines = re.sub(r"\A/\* SPDX-[^\n]*\n \* ", "/* ", path.read_text(encoding="utf-8").rstrip("\n")).split("\n")
    return ",\n".join(f"  {json.dumps(line)}" for line in lines)


def quoted_words():
    """What bn_tables() returns, little-endian, in base64, as JavaScript strings."""
    words = base64.b64encode(bluenoise.tables().astype("<u4").tobytes()).decode()
    return ",\n".join(f'  "{words[at:at + COLUMNS]}"' for at in range(0, len(words), COLUMNS))


def draws():
    rows = quoted_words()
    seed = ", ".join(f"0x{word:08x}" for word in bluenoise.Sampler(seed=SEED).seed_words())
    return f"""\
// SPDX-License-Identifier: Apache-2.0 AND CC0-1.0
// Made by make_draws.py: the draws and paths of libbn for WebGL 2.
"use strict";

// libbn/include/bn/bn_draw.glsl, Apache-2.0. It says how to include it.
const BN_DRAW_GLSL = [
{quoted(INCLUDE / "bn_draw.glsl")}
].join("\\n");

// libbn/include/bn/bn_path.glsl, Apache-2.0: which domain each decision of a path draws from.
const BN_PATH_GLSL = [
{quoted(INCLUDE / "bn_path.glsl")}
].join("\\n");

// What bn_sampler_seed() gives for seed {SEED}.
const BN_SEED = [{seed}];

// What bn_tables() returns, little-endian, CC0-1.0: BN_WORD(i) in the text.
const BN_TABLE_WORDS = (() => {{
  const bytes = Uint8Array.from(atob([
{rows.replace("  ", "    ")}
  ].join("")), character => character.charCodeAt(0));
  const view = new DataView(bytes.buffer);
  return Uint32Array.from({{length: bytes.length / 4}}, (_, i) => view.getUint32(4 * i, true));
}})();
"""


def main(script, path, text, about):
    """Writes text to path, or with --check only compares. script: the file of the program, which is named in messages."""
    parser = argparse.ArgumentParser(description=about.split("\n")[0])
    parser.add_argument("--check", action="store_true", help=f"write nothing; fail if {path.name} is not up to date")
    if parser.parse_args().check:
        if not path.is_file() or path.read_text(encoding="utf-8") != text:
            sys.exit(f"{script.name}: {path.name} is not up to date; run .venv/bin/python {script.relative_to(ROOT)}")
        return
    beside = path.with_suffix(".new")
    beside.write_text(text, encoding="utf-8")
    os.replace(beside, path)


if __name__ == "__main__":
    main(Path(__file__).resolve(), HERE / "draws.js", draws(), __doc__)
