# SPDX-License-Identifier: Apache-2.0
"""Parses the options of a part of scripts/bench and ends there: status 2 and its message if they are wrong, before any set-up."""

import argparse
import runpy
import sys

parse_args = argparse.ArgumentParser.parse_args


def parse_and_end(self, args=None, namespace=None):
    parse_args(self, args, namespace)
    sys.exit(0)


if __name__ == "__main__":
    argparse.ArgumentParser.parse_args = parse_and_end
    part, sys.argv = sys.argv[1], sys.argv[1:]
    runpy.run_module(f"report.{part}", run_name="__main__")
