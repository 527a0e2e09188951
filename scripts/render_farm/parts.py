# SPDX-License-Identifier: Apache-2.0
"""Splits an image into parts, and keeps finished parts in a folder until all of them are done."""

import contextlib
import json
from pathlib import Path
from typing import NamedTuple

from evidence.base.atomic_write import write_text, written_beside


class FarmError(Exception):
    """One line for the user."""


class Part(NamedTuple):
    """The pixels x0 <= x < x1, y0 <= y < y1, samples first to first + count - 1."""

    x0: int
    y0: int
    x1: int
    y1: int
    first: int
    count: int

    @property
    def samples(self):
        return (self.x1 - self.x0) * (self.y1 - self.y0) * self.count

    @property
    def file_name(self):
        return ",".join(map(str, self)) + ".exr"

    def arguments(self):
        return ["--crop", ",".join(map(str, self[:4])), "--first-sample", str(self.first), "--spp", str(self.count)]


def split(crop, first, count, tile):
    """The parts that together cover each sample of each pixel in `crop` = (x0, y0, x1, y1) exactly once, row by row. tile: (width, height)
    of the largest part."""
    x0, y0, x1, y1 = crop
    return [Part(x, y, min(x + tile[0], x1), min(y + tile[1], y1), first, count)
            for y in range(y0, y1, tile[1]) for x in range(x0, x1, tile[0])]


def names_of(listed):
    """The files that pathtracer --list-inputs lists."""
    return [line.partition("  ")[2] for line in listed.split("\n") if line]


class PartsFolder:
    """The finished parts of one image, in a folder beside it."""

    def __init__(self, output, settings):
        self.path = Path(f"{output}.parts")
        if self.path.is_symlink():
            raise FarmError(f"{self.path}, where parts are kept, is a symbolic link; remove it, or choose another output")
        record, text = self.path / "picture.json", json.dumps(settings, indent=1, sort_keys=True) + "\n"
        try:
            same = record.read_bytes() == text.encode()
        except FileNotFoundError:
            same = not self.path.exists() or not any(self.path.iterdir())
        if not same:
            raise FarmError(f"{self.path} has parts of an image with other settings, files or programs; remove it, or choose "
                            "another output")
        if not record.exists():
            write_text(record, text)

    def count(self, parts):
        return sum(self.has(part) for part in parts)

    def has(self, part):
        return (self.path / part.file_name).is_file()

    def add(self, part, data):
        """Keeps the bytes of a part's EXR."""
        with written_beside(self.path / part.file_name) as beside:
            beside.write_bytes(data)

    def remove(self, parts):
        """Removes the parts and their record, and also the folder if it contains nothing else."""
        for name in [*(part.file_name for part in parts), "picture.json"]:
            (self.path / name).unlink(missing_ok=True)
        with contextlib.suppress(OSError):
            self.path.rmdir()
