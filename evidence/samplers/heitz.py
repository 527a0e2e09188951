# SPDX-License-Identifier: Apache-2.0
"""The sampler of Heitz, Belcour, Ostromoukhov, Coeurjolly and Iehl ("A Low-Discrepancy Sampler that Distributes Monte Carlo Errors as a
Blue Noise in Screen Space", 2019), from the authors' tables for each power of two of samples.

The tables are read from source files in a folder: the authors' samplerBlueNoiseErrorDistribution_128x128_OptimizedFor_2d2d2d2d_16spp.cpp or
copies of them in another language, such as spp16.rs. The last number before "spp", or after it, is the number of samples.
"""

import functools
import re
import zlib
from pathlib import Path

import numpy as np

from ..base.atomic_write import written_beside
from ..base.command import CommandError

SIDE, POINTS, OPTIMISED = 128, 256, 8  # pixels of the tile, points and dimensions of the sequence, dimensions of the tile
SIZES = {"sobol": POINTS * POINTS, "scrambling": SIDE * SIDE * OPTIMISED, "ranking": SIDE * SIDE * OPTIMISED}


def read_table(path):
    """{name: uint8 array} of SIZES from a source file, whose arrays have one of these names in theirs. Tables for one sample need no ranking."""
    text, found = path.read_text(errors="replace"), {"ranking": np.zeros(SIZES["ranking"], np.uint8)}
    for match in re.finditer(r"[\[{]([\d\s,]{10000,})[\]}]", text):
        before = text[max(0, match.start() - 80):match.start()].lower()
        kind = max(SIZES, key=before.rfind)
        if kind in before:
            found[kind] = np.array(match[1].replace(",", " ").split(), np.uint8)
    if {kind: len(table) for kind, table in found.items()} != SIZES:
        raise CommandError(f"{path} does not contain the tables {', '.join(SIZES)} of 256x256, 128x128x8 and 128x128x8 numbers")
    return found


class Tables:
    """The tables of a folder by sample count."""

    def __init__(self, folder):
        self.paths = {int(match[1] or match[2]): path for path in sorted(Path(folder).iterdir())
                      if path.is_file() and (match := re.search(r"(\d+)spp\b|spp(\d+)\b", path.stem))}
        if not self.paths:
            raise CommandError(f"{folder} has no files named like ..._16spp.cpp")
        self.read = functools.cache(lambda spp: read_table(self.paths[spp]))

    def for_count(self, count):
        """The power of two whose tables suit `count` samples: the next one, or the largest there is."""
        return min(self.paths, key=lambda spp: (spp < count, spp if spp >= count else -spp))

    def write(self, folder):
        """A folder in `folder` with the tables for the plug-in (plugins/heitz.cpp), written unless it is there."""
        digest = zlib.crc32("".join(path.read_text(errors="replace") for path in self.paths.values()).encode())
        folder = Path(folder) / f"{digest:08x}"
        for spp in self.paths:
            if not (path := folder / f"{spp}.bin").is_file():
                with written_beside(path) as beside:
                    beside.write_bytes(b"".join(self.read(spp)[kind].tobytes() for kind in SIZES))
        return folder

    def numbers(self, x, y, indices, dimensions, spp, seed=0):
        """float32 [...pixels][indices][dimensions] from the tables for `spp`. Seeds shift the tile."""
        tables = self.read(spp)
        down, right = np.random.default_rng([seed, 8]).integers(0, SIDE, 2)
        tile = {kind: tables[kind].reshape(SIDE, SIDE, OPTIMISED)[(y + down) % SIDE, (x + right) % SIDE] for kind in ("scrambling", "ranking")}
        own = np.arange(dimensions)
        points = np.asarray(indices)[:, None] % POINTS ^ tile["ranking"][..., None, own % OPTIMISED]
        values = tables["sobol"].reshape(POINTS, POINTS)[points, own] ^ tile["scrambling"][..., None, own % OPTIMISED]
        return (values + np.float32(0.5)) / np.float32(POINTS)
