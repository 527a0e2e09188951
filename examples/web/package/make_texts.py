#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes texts.js, what index.js is made of: the shader texts of libbn and of this folder, and the words of a sampler's table.

Needs the Python package: .venv/bin/python examples/web/package/make_texts.py. `--check` writes nothing, and fails if texts.js is
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
INCLUDE = HERE.parents[2] / "libbn" / "include" / "bn"
NAMES = {f"{name}_{language}".upper(): folder / f"{name}.{language}" for language in ("glsl", "wgsl")
         for name, folder in (("bn_draw", INCLUDE), ("bn_path", INCLUDE), ("random", HERE))}
COLUMNS = 120


def export(name, path):
    # Without its line about the licence, which is that of texts.js.
    lines = re.sub(r"\A/\* SPDX-[^\n]*\n \* ", "/* ", path.read_text(encoding="utf-8").rstrip("\n")).split("\n")
    text = ",\n".join(f"  {json.dumps(line)}" for line in lines)
    return f'// {path.name}, Apache-2.0.\nexport const {name} = [\n{text},\n  "",\n].join("\\n");\n'


def texts():
    words = base64.b64encode(bluenoise.Sampler("blue", seed=0).table_words().astype("<u4").tobytes()).decode()
    rows = ",\n".join(f'  "{words[at:at + COLUMNS]}"' for at in range(0, len(words), COLUMNS))
    shaders = "\n".join(export(name, path) for name, path in NAMES.items())
    return f"""\
// SPDX-License-Identifier: Apache-2.0 AND CC0-1.0
// Made by make_texts.py.

{shaders}
// What bn_sampler_table_words() writes for seed 0, little-endian, in base64, CC0-1.0.
export const WORDS = [
{rows},
].join("");
"""


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--check", action="store_true", help="write nothing; fail if texts.js is not up to date")
    path, text = HERE / "texts.js", texts()
    if parser.parse_args().check:
        if not path.is_file() or path.read_text(encoding="utf-8") != text:
            sys.exit("make_texts.py: texts.js is not up to date; run .venv/bin/python examples/web/package/make_texts.py")
        return
    beside = path.with_suffix(".new")
    beside.write_text(text, encoding="utf-8")
    os.replace(beside, path)


if __name__ == "__main__":
    main()
