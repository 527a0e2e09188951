# SPDX-License-Identifier: Apache-2.0
"""Splitting a picture into parts, and keeping the finished ones in a folder until all are there."""

import json
from pathlib import Path
from typing import NamedTuple

from report.files import written_beside, write_text


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


def split(crop, first, count, tile, samples_per_task=None):
    """The parts of a picture that cover each sample of each pixel of `crop` = (x0, y0, x1, y1) once, row by row.

    tile: (width, height) of the largest part. samples_per_task: the largest number of samples of a part; None: all, which
    keeps the picture's bits.
    """
    x0, y0, x1, y1 = crop
    step = samples_per_task or count
    return [Part(x, y, min(x + tile[0], x1), min(y + tile[1], y1), s, min(step, first + count - s))
            for y in range(y0, y1, tile[1]) for x in range(x0, x1, tile[0]) for s in range(first, first + count, step)]


class PartsFolder:
    """The finished parts of one picture, in a folder beside it. A file is there when it is complete."""

    def __init__(self, output, settings):
        self.path = Path(f"{output}.parts")
        record, text = self.path / "picture.json", json.dumps(settings, indent=1, sort_keys=True) + "\n"
        try:
            same = record.read_text(encoding="utf-8") == text
        except FileNotFoundError:
            same = not self.path.exists() or not any(self.path.iterdir())
        if not same:
            raise FarmError(f"{self.path} has parts of a picture with other settings, files or programs; remove it, or choose "
                            "another output")
        if not record.exists():
            write_text(record, text)

    def count(self, parts):
        return sum(self.has(part) for part in parts)

    def has(self, part):
        return (self.path / part.file_name).is_file()

    def add(self, part, data):
        with written_beside(self.path / part.file_name) as beside:
            beside.write_bytes(data)

    def remove(self):
        """Removes what this class wrote, and the folder if nothing else is in it."""
        for file in [*self.path.glob("*,*,*,*,*,*.exr"), self.path / "picture.json"]:
            file.unlink(missing_ok=True)
        try:
            self.path.rmdir()
        except OSError:
            pass
