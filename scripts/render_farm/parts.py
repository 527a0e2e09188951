# SPDX-License-Identifier: Apache-2.0
"""Splits an image into parts, and keeps finished parts in a folder until all of them are done."""

import contextlib
import json
import os
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


@contextlib.contextmanager
def silent():
    """Stops C libraries from printing to standard error."""
    kept, nothing = os.dup(2), os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nothing, 2)
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)
        os.close(nothing)


def complaint(path, part, inputs):
    """Explains why the EXR is not this part rendered from these files; None if it is."""
    import OpenEXR  # scripts/farm --help works without it

    try:
        with silent(), OpenEXR.File(str(path), separate_channels=True) as file:
            header, channels = file.header(), file.channels()
            (x0, y0), (x1, y1) = (corner.tolist() for corner in header["dataWindow"])
            samples = channels["count"].pixels
            first, last = int(header["firstSample"]), int(header["endSample"])
            same_files = header.get("inputs") == inputs
    except Exception as error:  # the library raises many exception types
        return f"is damaged ({type(error).__name__})"
    if (x0, y0, x1 + 1, y1 + 1) != part[:4]:
        return f"shows the pixels {x0},{y0},{x1 + 1},{y1 + 1}"
    if (first, last) != (part.first, part.first + part.count) or (samples != part.count).any():
        return "has other samples"
    if not same_files:
        return "was rendered from other files"
    return None


class PartsFolder:
    """The finished parts of one image, in a folder beside it. `inputs` is the output of pathtracer --list-inputs."""

    def __init__(self, output, settings, inputs):
        self.path, self.inputs = Path(f"{output}.parts"), inputs
        settings = {**settings, "inputs": inputs}
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

    def remove_damaged(self, parts):
        """Removes damaged files of `parts`, and returns (file, problem) for each of them."""
        found = []
        for part in parts:
            path = self.path / part.file_name
            if path.is_file() and (wrong := complaint(path, part, self.inputs)):
                path.unlink()
                found.append((path, wrong))
        return found

    def add(self, part, data):
        """Raises FarmError unless `data` is the given part."""
        with written_beside(self.path / part.file_name) as beside:
            beside.write_bytes(data)
            if wrong := complaint(beside, part, self.inputs):
                raise FarmError(f"a worker's part {part.file_name} {wrong}; is its disk full, or did a file change?")

    def remove(self, parts):
        """Removes the parts and their record, and also the folder if it contains nothing else."""
        for name in [*(part.file_name for part in parts), "picture.json"]:
            (self.path / name).unlink(missing_ok=True)
        with contextlib.suppress(OSError):
            self.path.rmdir()
