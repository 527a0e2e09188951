# SPDX-License-Identifier: Apache-2.0
"""The cache of references and results, which outlives a build: $XDG_CACHE_HOME/libbn, by default ~/.cache/libbn."""

import hashlib
import json
import os
import zipfile
import zlib
from pathlib import Path

import numpy as np

from .files import written_beside

FORMAT = 1  # a new number invalidates existing entries


def cache_folder():
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "libbn"


class Store:
    """Results stored in a folder. Each file is named after a hash of everything its result depends on."""

    def __init__(self, folder):
        self.folder = folder

    def _path(self, key):
        text = json.dumps([FORMAT, key], sort_keys=True)
        return self.folder / (hashlib.sha256(text.encode()).hexdigest()[:32] + ".npz")

    def load(self, key):
        """(rows, {name: array}), or None."""
        path = self._path(key)
        try:
            with np.load(path) as file:
                arrays = {name: file[name] for name in file.files}
            rows = json.loads(str(arrays.pop("rows")))
            return rows, arrays
        except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile, zlib.error):
            return None  # missing or damaged

    def save(self, key, rows, arrays):
        with written_beside(self._path(key)) as beside:
            np.savez(beside, rows=json.dumps(rows), **arrays)

    def get(self, key, make):
        """Returns what load() finds, or else saves and returns the result of make()."""
        found = self.load(key)
        if not found:
            found = make()
            self.save(key, *found)
        return found
