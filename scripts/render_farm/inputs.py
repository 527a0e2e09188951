# SPDX-License-Identifier: Apache-2.0
"""The files that a picture needs, as pathtracer --list-inputs lists them."""

import os
import re

_ESCAPE = re.compile(rb"\\(?:([nr\\])|x([0-9a-f]{2}))")
_MEANING = {b"n": b"\n", b"r": b"\r", b"\\": b"\\"}


def hashes_of(listed):
    """{path: SHA-256} of the lines of sha256sum."""
    found = {}
    for line in filter(None, os.fsencode(listed).split(b"\n")):
        escaped = line.startswith(b"\\")
        digest, _, name = line[escaped:].partition(b"  ")
        if escaped:
            name = _ESCAPE.sub(lambda e: _MEANING[e[1]] if e[1] else bytes([int(e[2], 16)]), name)
        found[os.fsdecode(name)] = digest.decode()
    return found
