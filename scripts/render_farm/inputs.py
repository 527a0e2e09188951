# SPDX-License-Identifier: Apache-2.0
"""The files that a scene needs, as far as their text names them, so that they can be compared with those of workers."""

import re
from pathlib import Path
from urllib.parse import unquote

# The files named in a file of each kind, by its suffix. Images and buffers inside a GLB are part of it.
NAMES = {
    ".gltf": r'"uri"\s*:\s*"((?!data:)[^"]+)"',
    ".obj": r"^\s*mtllib\s+(.+?)\s*$",
    ".mtl": r"^\s*(?:map_\w+|norm)\s.*?(\S+)\s*$",
}


def files_of(path):
    """`path` and the existing files it names, directly or not."""
    found, left = [], [Path(path)]
    while left:
        file = left.pop()
        if file in found or not file.is_file():
            continue
        found.append(file)
        if pattern := NAMES.get(file.suffix.lower()):
            text = file.read_text(encoding="utf-8", errors="replace")
            names = re.findall(pattern, text, re.MULTILINE)
            left += [file.parent / (unquote(name) if file.suffix.lower() == ".gltf" else name.replace("\\", "/"))
                     for name in names]
    return found
