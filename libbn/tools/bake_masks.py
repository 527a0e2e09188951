#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Bakes a built-in mask from a void-and-cluster mask by long annealing, in steps of falling temperature."""

import sys

import bluenoise

STEPS = 40
# Each step's temperature is the product of this ratio and the one before, which pow() would round differently from
# machine to machine: (END / START) ** (1 / STEPS), rounded.
START, END, RATIO = 4e-4, 2e-6, 0.8759


def bake(size, sweeps):
    ranks, temperature = bluenoise.void_and_cluster((size, size)), START
    for step in range(STEPS):
        ranks = bluenoise.anneal((size, size), seed=step, sweeps=sweeps // STEPS, start_from_ranks=ranks,
                                 start_temperature=temperature, end_temperature=max(temperature * RATIO, END),
                                 order_ends=step + 1 == STEPS)
        temperature = max(temperature * RATIO, END)
    return ranks


def main():
    if len(sys.argv) != 4 or not 2 <= int(sys.argv[1]) <= 256 or int(sys.argv[2]) < STEPS:
        sys.exit(f"usage: bake_masks.py SIZE SWEEPS OUTPUT.u16, with a size of 2 to 256 and at least {STEPS} sweeps in all")
    ranks = bake(int(sys.argv[1]), int(sys.argv[2]))
    ranks.astype("<u2").tofile(sys.argv[3])
    print(*(f"E_{sigma:g} {bluenoise.dithering_error(ranks, sigma):.5f}" for sigma in (0.75, 1, 1.5, 2)))


if __name__ == "__main__":
    main()
