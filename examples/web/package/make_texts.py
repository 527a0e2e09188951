#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes texts.js, what index.js is made of: the shader texts of libbn and of this folder, and the words of a sampler's table.

Needs the Python package: .venv/bin/python examples/web/package/make_texts.py. `--check` writes nothing, and fails if texts.js is
not up to date.
"""

import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
from make_draws import INCLUDE, main, quoted, quoted_words  # noqa: E402

NAMES = {f"{name}_{language}".upper(): folder / f"{name}.{language}" for language in ("glsl", "wgsl")
         for name, folder in (("bn_draw", INCLUDE), ("bn_path", INCLUDE), ("random", HERE))}


def export(name, path):
    return f'// {path.name}, Apache-2.0.\nexport const {name} = [\n{quoted(path)},\n  "",\n].join("\\n");\n'


def texts():
    shaders = "\n".join(export(name, path) for name, path in NAMES.items())
    return f"""\
// SPDX-License-Identifier: Apache-2.0 AND CC0-1.0
// Made by make_texts.py.

{shaders}
// What bn_tables() returns, little-endian, in base64, CC0-1.0.
export const WORDS = [
{quoted_words()},
].join("");
"""


if __name__ == "__main__":
    main(Path(__file__).resolve(), HERE / "texts.js", texts(), __doc__)
