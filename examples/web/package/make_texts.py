#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes texts.js for index.js and the page in the parent folder: the shader sources of libbn and of this folder, and the
table of `blue`.

Needs the Python package: .venv/bin/python examples/web/package/make_texts.py. `--check` writes nothing, and fails if texts.js is
out of date.
"""

import argparse
import base64
import json
import os
import re
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
INCLUDE = HERE.parents[2] / "libbn" / "include" / "bn"
TEXTS = HERE / "texts.js"
COLUMNS = 120
NAMES = {f"{name}_{language}".upper(): folder / f"{name}.{language}" for language in ("glsl", "wgsl")
         for name, folder in (("bn_draw", INCLUDE), ("bn_path", INCLUDE), ("random", HERE))}


def quoted(path):
    """A shader's lines as JavaScript strings. Omits the licence line, because texts.js states the licence."""
    lines = re.sub(r"\A/\* SPDX-[^\n]*\n \* ", "/* ", path.read_text(encoding="utf-8")).split("\n")
    return ",\n".join(f"    {json.dumps(line)}" for line in lines)


def texts():
    shaders = "\n".join(f'  // {path.name}, Apache-2.0.\n  {name}: [\n{quoted(path)},\n  ].join("\\n"),' for name, path in NAMES.items())
    words = base64.b64encode((INCLUDE.parents[1] / "data" / "blue.u32").read_bytes()).decode()
    rows = ",\n".join(f'    "{words[at:at + COLUMNS]}"' for at in range(0, len(words), COLUMNS))
    return f"""\
// SPDX-License-Identifier: Apache-2.0 AND CC0-1.0
// Made by make_texts.py. A plain script with a global, so that pages opened from disk, which cannot load modules, can load it.
globalThis.LIBBN_TEXTS = {{
{shaders}
  // The result of bn_tables(), little-endian, in base64, CC0-1.0.
  WORDS: [
{rows},
  ].join(""),
}};
"""


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--check", action="store_true", help="write nothing; fail if texts.js is out of date")
    text = texts()
    if not parser.parse_args().check:
        beside = TEXTS.with_suffix(".new")
        beside.write_text(text, encoding="utf-8")
        os.replace(beside, TEXTS)
    elif not TEXTS.is_file() or TEXTS.read_text(encoding="utf-8") != text:
        sys.exit("make_texts.py: texts.js is not up to date; run .venv/bin/python examples/web/package/make_texts.py")


if __name__ == "__main__":
    main()
