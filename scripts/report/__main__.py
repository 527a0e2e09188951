# SPDX-License-Identifier: Apache-2.0
"""Runs one part: python -m report [--check] PART [options].

With --check it ends after parsing the options, with status 2 and a message if they are wrong."""

import argparse
import runpy
import sys

PARTS = {
    "samplers": ("samplers", "paths"),
    "realtime": ("realtime", "moving"),
    "masks": ("masks", "neural", "points"),
    "renders": ("renders", "models", "summary", "denoise", "picture", "adaptive"),
    "others": ("mitsuba", "pbrt", "cycles", "web", "correctness"),
    "pages": ("convergence",),
}


def main():
    if sys.argv[1] == "--check":
        del sys.argv[1]
        parse_args = argparse.ArgumentParser.parse_args

        def parse_and_end(*arguments):
            parse_args(*arguments)
            sys.exit(0)

        argparse.ArgumentParser.parse_args = parse_and_end
    part = sys.argv.pop(1)
    folder = next(folder for folder, parts in PARTS.items() if part in parts)
    runpy.run_module(f"report.{folder}.{part}", run_name="__main__")


if __name__ == "__main__":
    main()
