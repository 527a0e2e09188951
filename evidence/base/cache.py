# SPDX-License-Identifier: Apache-2.0
"""The cache of references and results, which outlives a build: $XDG_CACHE_HOME/libbn, by default ~/.cache/libbn."""

import contextlib
import hashlib
import json
import os
import shutil
import time
import zipfile
import zlib
from pathlib import Path

import numpy as np

from .files import written_beside

KEPT_DAYS = 60
FORMAT = 1  # a new number invalidates what is there


def cache_folder():
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "libbn"


class Store:
    """Results in a folder, in files named by a hash of everything they depend on. Unused for KEPT_DAYS, a file is deleted."""

    def __init__(self, folder):
        self.folder = folder
        if folder.is_dir():
            for path in folder.iterdir():
                with contextlib.suppress(FileNotFoundError):  # of a run beside this one
                    if path.stat().st_mtime < time.time() - KEPT_DAYS * 86400:
                        # Folders are left by runs that were killed.
                        shutil.rmtree(path, ignore_errors=True) if path.is_dir() else path.unlink()

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
            os.utime(path)
            return rows, arrays
        except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile, zlib.error):
            return None  # missing or damaged

    def save(self, key, rows, arrays):
        with written_beside(self._path(key)) as beside:
            np.savez(beside, rows=json.dumps(rows), **arrays)

    def get(self, key, make):
        """What load() finds, or what make() returns, which is saved."""
        found = self.load(key)
        if not found:
            found = make()
            self.save(key, *found)
        return found
