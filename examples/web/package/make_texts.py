#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes texts.js for index.js and the pages in the parent folder: the shader sources of libbn and of this folder, and the table of
`blue`."""

import base64
import json
import os
from pathlib import Path

HERE = Path(__file__).resolve().parent
INCLUDE = HERE.parents[2] / "libbn" / "include" / "bn"
TEXTS = HERE / "texts.js"
FILES = [folder / f"{name}.{language}" for language in ("glsl", "wgsl")
         for name, folder in (("bn_draw", INCLUDE), ("bn_path", INCLUDE), ("random", HERE))]


def main():
    texts = {path.name.replace(".", "_").upper(): path.read_text(encoding="utf-8") for path in FILES}
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
