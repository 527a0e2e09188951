# SPDX-License-Identifier: Apache-2.0
"""Numbers for one sample a frame: libbn's samplers, a mask that moves by a constant each frame, and slices that others publish."""

import re
from pathlib import Path

import numpy as np
from PIL import Image

import bluenoise

from ..base.command import CommandError


class Draws:
    """A sampler of libbn. The index is that of the frame, or every frame has a key of its own and index 0. `at` moves pixels and
    index, (x, y, frame) -> (x, y, index)."""

    def __init__(self, kind, new_key=False, at=None):
        self.kind, self.new_key, self.at = kind, new_key, at or (lambda x, y, frame: (x, y, frame))

    def frame(self, frame, dimensions, seed, size):
        y, x = np.mgrid[:size, :size]
        x, y, index = self.at(x, y, frame)
        sampler = bluenoise.Sampler(self.kind, seed=seed)
        path = bluenoise.Path(sampler, x, y, 0, frame) if self.new_key else bluenoise.Path(sampler, x, y, index)
        ray = path.ray(0)
        return ray.next_1d()[..., None] if dimensions == 1 else ray.draw()[..., :dimensions]


class Slices:
    """Slices [depth][height][width][channels] in [0, 1), read as their authors say: repeated over the screen, slice frame % depth,
    and with an offset of its own for each number, or group of numbers, that a slice does not have."""

    def __init__(self, *stacks):
        self.stacks = {stack.shape[-1]: stack for stack in stacks}

    def stack_for(self, dimensions):
        """The one with as many channels, if there is one, or the next best."""
        return self.stacks[min(self.stacks, key=lambda channels: (channels > dimensions, -channels))]

    def frame(self, frame, dimensions, seed, size):
        stack, random = self.stack_for(dimensions), np.random.default_rng([seed, 5])
        y, x = np.mgrid[:size, :size]
        numbers = []
        while len(numbers) < dimensions:
            down, right = random.integers(0, 4096, 2)
            texels = stack[frame % len(stack), (y + down) % stack.shape[1], (x + right) % stack.shape[2]]
            numbers += list(np.moveaxis(texels, -1, 0))
        return np.stack(numbers[:dimensions], -1)


def steps(dimensions):
    """What each number moves by in a frame: the golden ratio for one, R2 for two (M. Roberts, "The Unreasonable Effectiveness
    of Quasirandom Sequences", 2018), and its like for more."""
    base = 2.0
    for _ in range(40):
        base = (1 + base) ** (1 / (dimensions + 1))
    return base ** -np.arange(1.0, dimensions + 1)


class MovedMask:
    """The built-in mask of 64x64, with an offset for each number, to which every frame adds a constant."""

    def __init__(self):
        self.still = Slices(bluenoise.to_float(bluenoise.mask((64, 64), method="builtin"))[None, ..., None])

    def frame(self, frame, dimensions, seed, size):
        moved = self.still.frame(0, dimensions, seed, size) + frame * steps(dimensions)
        return (moved % 1).astype(np.float32)


# ---- Slices in files

# The sets of the public packs that hold uniform numbers, and their channels: STBN's scalars and two-vectors (Wolfe et al., 2022),
# FAST's (Donnelly et al., 2024).
PACKS = {"STBN": {r"stbn_(?:scalar|vec1)_.*": 1, r"stbn_vec2_.*": 2},
         "FAST": {r"real_uniform_.*": 1, r"vector2_uniform_.*": 2}, "slices": {".*": 0}}


def read_set(folder, pattern, channels):
    """float32 [depth][height][width][channels] from the PNG files NAME_0.png, NAME_1.png ... of the first NAME that the pattern matches: the
    middles of the steps that their integers stand for. None without any. Channels 0: one where they are grey, else red and green."""
    found = sorted((match[1], int(match[2]), path) for path in Path(folder).glob("*.png")
                   if (match := re.fullmatch(rf"({pattern}?)_?(\d+)\.png", path.name)))
    files = [path for name, _, path in found if name == found[0][0]]
    if not files:
        return None
    try:
        pixels = np.stack([np.asarray(Image.open(path)) for path in files])
    except (OSError, ValueError) as error:
        raise CommandError(f"cannot read the slices of {found[0][0]} in {folder}: {error}") from None
    pixels, steps_of = pixels.reshape(*pixels.shape[:3], -1), np.float32(256 if pixels.dtype.itemsize == 1 else 65536)
    if not channels:
        channels = 2 if pixels.shape[-1] > 1 and np.any(pixels[..., 0] != pixels[..., 1]) else 1
    return (pixels[..., :channels] + np.float32(0.5)) / steps_of


def read_pack(pack, folder):
    """Slices from a folder of "STBN" or "FAST"; with several sets of a kind, the first by name. Of "slices", any stack of numbered files."""
    stacks = [stack for pattern, channels in PACKS[pack].items() if (stack := read_set(folder, pattern, channels)) is not None]
    if not stacks:
        raise CommandError(f"{folder} has no PNG files named like {' or '.join(PACKS[pack])}, with a number at the end")
    return Slices(*stacks)
