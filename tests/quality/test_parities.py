# SPDX-License-Identifier: Apache-2.0
"""Tests that the numbers of different decisions do not depend on each other, for every sampler type and all pairs of coordinates of a
path's first rays, additional numbers and splits. Everything is seeded. Run with -s to print each sampler type's worst value."""

import typing

import numpy as np
import pytest

import bluenoise

SIDE, SAMPLES, DIGITS = 8, 64, 4


@pytest.fixture
def sampler(request):
    """function(samples per pixel, seed) -> a sampler of the parametrised type."""
    return lambda count, seed: bluenoise.Sampler(request.param, seed=seed, samples_per_pixel=count)


def decisions(sampler, x, y, index):
    """A path's numbers as a list of domains (..., 4): its first rays, the camera's domain, additional numbers drawn in pairs, in fours and
    singly, a loop, and a branch's rays."""
    path = bluenoise.PathSampler(sampler, x, y, index)
    first, second = path.ray(0), path.ray(1)
    branch, loop = second.next_split(4)[0], second.next_loop()
    return [*(path.ray(ray).draw() for ray in range(5)), np.concatenate([path.first_light(), path.time_wavelength()], -1),
            *(np.concatenate([ray.next_2d(), ray.next_2d()], -1) for ray in (first, second)), first.next_4d(), second.next_4d(),
            *(branch.ray(ray).draw() for ray in range(2)), np.stack([loop.next_1d() for _ in range(4)], -1),
            *(np.stack([ray.draw_1d(k) for k in range(start, start + 4)], -1) for ray, start in ((first, 0), (first, 4), (second, 0)))]


def apart(rows, drawn):
    """Tells which pairs of rows belong to different domains. All domains have the same number of rows."""
    domain = np.arange(len(rows)) * len(drawn) // len(rows)
    return domain[:, None] != domain


every_sampler = pytest.mark.parametrize("sampler", typing.get_args(bluenoise.SamplerType), indirect=True)


@every_sampler
def test_digits_of_different_decisions_are_independent(sampler):
    """Two numbers are dependent if a sum modulo 2 of their leading digits is the same in all samples of a region. Half of their cells then
    stay empty, and a product over both decisions converges to a wrong value. The correlation of two such sums, as an RMS over regions, is
    1 for dependent numbers and about 1 / 64 for independent numbers."""
    squares, masks = 0, np.arange(1, 2**DIGITS, dtype=np.uint8)[:, None]
    y, x, index = np.ogrid[:SIDE, :SIDE, :SAMPLES]
    for region in range(6):
        drawn = decisions(sampler(SAMPLES, region + 3), x + 40 * region - 90, y + 24 * region**2 - 200, index)
        digits = (np.concatenate(drawn, -1).reshape(-1, 4 * len(drawn)).T * 2**DIGITS).astype(np.uint8)
        sums = digits[:, None] & masks
        parities = (sums ^ sums >> 1 ^ sums >> 2 ^ sums >> 3) & 1
        signs = 1 - 2 * parities.reshape(-1, digits.shape[1]).astype(np.float32)
        squares = squares + (signs @ signs.T / digits.shape[1]) ** 2 / 6
    worst = np.sqrt((squares * apart(squares, drawn)).max())
    print(f"\nlargest correlation of two parities: {worst:.3f}")
    assert worst < 0.5


@every_sampler
def test_every_cell_of_two_decisions_is_sampled(sampler, request):
    """The smallest sample count in any of 8 x 8 cells over an image, relative to the expected count."""
    if "mask" in request.node.callspec.id:
        return  # its first sample is a mask, shifted per coordinate, and one pair of coordinates in 4,096 has the same shift
    y, x = np.mgrid[:256, :256]
    drawn = decisions(sampler(1, 9), x, y, 0)
    cells = (np.concatenate(drawn, -1).reshape(-1, 4 * len(drawn)).T * 8).astype(np.uint8)
    met = (cells[:, None] == np.arange(8, dtype=np.uint8)[:, None]).astype(np.float32).reshape(8 * len(cells), -1)
    least = (met @ met.T)[apart(met, drawn)].min() * 64 / x.size
    print(f"\nevery cell has at least {least:.3f} of its expected samples")
    assert least > 0.75
