# SPDX-License-Identifier: Apache-2.0
"""The files that a scene needs, as far as their text names them, so that they can be compared with those of workers."""

import re
from pathlib import Path
from urllib.parse import unquote


def _names(suffix, text):
    """The files named in the text of a file. Images and buffers inside a GLB are part of it."""
    if suffix == ".gltf":
        return [unquote(name) for name in re.findall(r'"uri"\s*:\s*"((?!data:)[^"]+)"', text)]
    found = []
    if suffix in (".obj", ".mtl"):
        for line in text.splitlines():
            words = line.split()
            if len(words) < 2:
                continue
            if suffix == ".obj" and words[0] == "mtllib":
                found.append(line.split(None, 1)[1].rstrip())
            elif suffix == ".mtl" and (words[0] == "norm" or words[0].startswith("map_")):
                found.append(words[-1])
    return [name.replace("\\", "/") for name in found]


def _is_file(path):
    try:
        return path.is_file()
    except OSError:  # a name that no file can have
        return False


def files_of(path):
    """`path` and the existing files it names, directly or not."""
    found, left = {}, [Path(path)]  # in order
    while left:
        file = left.pop()
        if file in found or not _is_file(file):
            continue
        found[file] = True
        suffix = file.suffix.lower()
        if suffix in (".gltf", ".obj", ".mtl"):
            text = file.read_text(encoding="utf-8", errors="replace")
            left += [file.parent / name for name in _names(suffix, text)]
    return list(found)
