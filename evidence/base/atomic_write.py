# SPDX-License-Identifier: Apache-2.0
"""Atomic file writes, using only the standard library."""

import contextlib
import os
import tempfile
from pathlib import Path


@contextlib.contextmanager
def written_beside(path):
    """Yields a path in a private folder next to `path`. If the block succeeds, that file replaces `path` after it has been
    written and flushed to disk; otherwise `path` is untouched. The folder has a random name, and other users cannot put links into it."""
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix=".libbn-", dir=path.parent) as folder:
        beside = Path(folder) / path.name
        try:
            yield beside
            with open(beside, "r+b") as file:
                os.fsync(file.fileno())
            os.replace(beside, path)
        except OSError as error:
            # If the disk is full, the write error names no file.
            error.filename = error.filename or str(path)
            raise


def write_text(path, text):
    with written_beside(path) as beside:
        beside.write_bytes(text.encode())
