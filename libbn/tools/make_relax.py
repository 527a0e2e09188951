#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Converts the schedule in libbn/data/relax.json to the integers of libbn/src/masks/relax_schedule.h, for bn_relax.

The schedule lists steps v <- keep v + sum over offsets o of w_o clip(v_p - v_(p+o), -1, 1). A step has one weight for
each group of offsets [y, x]; the square's symmetries map a group's offsets to each other. Each step gets the
finest scale at which no value can exceed 16 bits. `--check` writes nothing, and fails if the header is out of date.
"""

import argparse
import json
import re
import sys
import textwrap
from pathlib import Path

LIBBN = Path(__file__).resolve().parents[1]
HEADER = LIBBN / "src" / "masks" / "relax_schedule.h"
# 16-bit white noise at the scale 2^13 is v = 8 (u - 1/2).
FIRST_SCALE, FIRST_MOST = 1 << 13, 1 << 15
MOST = (1 << 15) - 1


def images(x, y):
    return {(sign_x * a, sign_y * b) for a, b in ((x, y), (y, x)) for sign_x in (-1, 1) for sign_y in (-1, 1)}


def corner(group):
    """A group's offset with 0 <= y <= x."""
    x, y = max((x, y) for y, x in group)
    if (x, y) == (0, 0) or len(group) != len(images(x, y)) or {(x, y) for y, x in group} != images(x, y):
        sys.exit(f"make_relax: the offsets {group} are not all images of one under the symmetries of the square")
    return x, y


def rounded(product):
    """The largest result when the kernel rounds a product of 16-bit numbers to its upper half."""
    return (abs(product) + (1 << 14)) >> 15


def integers(step, scale, most, to_scale):
    """Converts a step from one scale to another: shift, keep, weights, and the largest value after it."""
    shift = (MOST // scale).bit_length() - 1
    ratio = to_scale * 2**15 / scale
    keep = round(step["keep"] * ratio)
    weights = [round(weight * ratio / 2**shift) for weight in step["weights"]]
    after = rounded(keep * most) + sum(len(group) * rounded(weight * (scale << shift))
                                       for weight, group in zip(weights, step["groups"]))
    return shift, keep, weights, after


def quantise(schedule):
    steps, scale, most = [], FIRST_SCALE, FIRST_MOST
    for step in schedule:
        if len(step["weights"]) != len(step["groups"]):
            sys.exit("make_relax: a step must have one weight for each group of offsets")
        # Up to rounding, the largest value is proportional to the scale.
        finest = 1.05 * MOST**2 / integers(step, scale, most, MOST)[3] + 8
        for to_scale in range(min(MOST, int(finest)), 0, -1):
            shift, keep, weights, after = integers(step, scale, most, to_scale)
            if after <= MOST and max(map(abs, weights)) <= MOST and abs(keep) * most < 2**31 - 2**14:
                break
        else:
            sys.exit("make_relax: the values of a step do not fit 16 bits")
        steps.append((scale, shift, keep, [(*corner(group), weight) for group, weight in zip(step["groups"], weights)]))
        scale, most = to_scale, after
    return steps


def row(step):
    scale, shift, keep, groups = step
    text = ", ".join(f"{{{x},_{y},_{weight}}}" for x, y, weight in groups)
    lines = textwrap.wrap(f"{{{scale}, {shift}, {keep}, {len(groups)}, {{{text}}}}},", 94)
    return "\n".join(" " * (4 if i == 0 else 5) + line.replace("_", " ") for i, line in enumerate(lines))


def header(schedule, text):
    """The header's text, with its numbers replaced by a schedule's."""
    steps = quantise(schedule)
    offsets = [offset for _, _, _, groups in steps for x, y, _ in groups for offset in images(x, y)]
    for name, number in (("STEPS", len(steps)), ("GROUPS", max(len(groups) for _, _, _, groups in steps)),
                         ("PAIRS", len(offsets)), ("REACH", max(x for x, _ in offsets))):
        text = re.sub(rf"(BN_RELAX_LEARNED_{name} =) \d+", rf"\1 {number}", text)
    rows = "\n".join(map(row, steps))
    return re.sub(r"(\[BN_RELAX_LEARNED_STEPS\] = \{\n).*?(?=\n\};)", rf"\1{rows}", text, flags=re.S)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="write nothing; fail if the header is out of date")
    check, before = parser.parse_args().check, HEADER.read_text(encoding="utf-8")
    text = header(json.loads((LIBBN / "data" / "relax.json").read_text(encoding="utf-8")), before)
    if not check:
        HEADER.write_text(text, encoding="utf-8")
    elif before != text:
        sys.exit("make_relax: relax_schedule.h is not up to date; run libbn/tools/make_relax.py")


if __name__ == "__main__":
    main()
