# SPDX-License-Identifier: Apache-2.0
"""Runs one part: python -m evidence [--check] PART [options]. Each part is a module with a function run(arguments).

With --check, only parses the options. If they are wrong, prints a message and exits with status 2."""

import argparse
import importlib
import os
import sys

from .base.command import run_or_say_why

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # benches run several jobs at a time

PARTS = {
    "samplers": ("samplers",),
    "realtime": ("realtime", "follow"),
    "films": ("films",),
    "masks": ("masks",),
    "renders": ("renders", "filters", "times", "denoise", "picture", "stop"),
    "external_renderers": ("mitsuba", "pbrt", "cycles"),
    "summary": ("summary",),
}


def main(arguments):
    if arguments[0] == "--check":
        parse_args = argparse.ArgumentParser.parse_args
        argparse.ArgumentParser.parse_args = lambda *given: (parse_args(*given), sys.exit(0))
        arguments = arguments[1:]
    part, *options = arguments
    folder = next(folder for folder, parts in PARTS.items() if part in parts)
    module = importlib.import_module(f"evidence.{folder}.{part}")
    run_or_say_why(module.run, options, "bench")


if __name__ == "__main__":
    main(sys.argv[1:])
