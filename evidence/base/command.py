# SPDX-License-Identifier: Apache-2.0
"""Shared by all commands: argument types, path options, and errors that exit with a one-line message."""

import argparse
import importlib
import os
import re
import subprocess
import sys
from pathlib import Path


class CommandError(Exception):
    """An error that the user can fix. The one-line message includes the remedy."""


def package(name, install):
    """Imports an optional package. Raises CommandError with the command that installs it."""
    try:
        return importlib.import_module(name)
    except ImportError:
        raise CommandError(f"the {name.replace('_', '-')} package is missing; run {install}") from None


def output_of(command, remedy, **options):
    """The standard output of a program. If it fails, CommandError names the remedy."""
    try:
        return subprocess.run(command, stdout=subprocess.PIPE, check=True, **options).stdout
    except (OSError, subprocess.CalledProcessError) as error:
        raise CommandError(f"{command[0]} failed ({error}); {remedy}") from None


def core_count():
    """The cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def run_or_say_why(run, arguments, program):
    """Runs a command. On errors, the program exits with a one-line message."""
    try:
        return run(list(arguments))
    except (CommandError, OSError) as error:
        sys.exit(f"{program}: {error}")
    except KeyboardInterrupt:
        sys.exit(f"{program}: interrupted; finished renders are kept, run the command again to resume")


# ---- Argument types for argparse

def positive(text):
    if not re.fullmatch(r"[1-9][0-9]{0,7}", text):
        raise argparse.ArgumentTypeError(f"must be a positive integer, not '{text}'")
    return int(text)


def parse_size(text):
    match = re.fullmatch(r"([1-9][0-9]{0,4})x([1-9][0-9]{0,4})", text)
    if not match:
        raise argparse.ArgumentTypeError(f"must be WIDTHxHEIGHT in pixels, not '{text}'")
    return int(match[1]), int(match[2])


def names_of(what, known):
    """An argument type: comma-separated names from `known`, returned as a tuple in the order of `known`."""
    def parse(text):
        names = [name for name in text.split(",") if name]
        unknown = [name for name in names if name not in known]
        if unknown or not names:
            raise argparse.ArgumentTypeError(f"unknown {what} '{', '.join(unknown)}'; choose from {', '.join(known)}")
        return tuple(name for name in known if name in names)

    return parse


def named(text):
    """An argument type: NAME=FILE as a pair."""
    if not (match := re.fullmatch(r"([A-Za-z0-9][\w.+-]*)=(.+)", text)):
        raise argparse.ArgumentTypeError(f"must be NAME=FILE, such as mine=./mine.so, not '{text}'")
    return match[1], match[2]


def name_and_file(text):
    name, file = named(text)
    if not Path(file.partition(":")[0]).is_file():
        raise argparse.ArgumentTypeError(f"there is no file {file.partition(':')[0]}")
    return name, file


# ---- Options

class Parser(argparse.ArgumentParser):
    """The options of one part of scripts/bench. The first line of `text` is its description."""

    def __init__(self, part, text, **more):
        super().__init__(prog=f"scripts/bench {part}", description=text.splitlines()[0], **more)

    def number(self, name, default, text, said=""):
        """Adds a positive integer; said: the default in words."""
        self.add_argument(name, type=positive, default=default, metavar="N", help=f"{text} (default{said or f' {default}'})")

    def hidden(self, name, default=None):
        """Adds a path option for tests, not listed in the help."""
        self.add_argument(name, type=Path, default=default and Path(default), help=argparse.SUPPRESS)

    def out(self):
        self.add_argument("--out", type=Path, default=Path("evidence/results"), help="folder for the report (default evidence/results)")

    def pathtracer(self):
        self.hidden("--pathtracer", "build/examples/pathtracer/pathtracer")
        self.sampler()
        self.add_argument("--openqmc", metavar="DIR", help="build with the OpenQMC checkout in DIR and include its samplers")
        self.add_argument("--heitz", type=Path, metavar="FOLDER",
                          help="include the sampler of Heitz et al. 2019, whose tables are in FOLDER: ..._1spp.cpp or spp1.rs, and so on")

    def sampler(self):
        self.add_argument("--sampler", type=name_and_file, action="append", default=[], metavar="NAME=FILE",
                          help="include a sampler of your own: a shared library (docs/bench.md); repeatable")

    def table(self, guide):
        """The options that tables.write_or_print() needs."""
        self.hidden("--guide", guide)
        self.add_argument("--print", action="store_true", help=f"print the table without changing {guide}")


# ---- The command line in a report

# Options that say where to read and write, or how many jobs to run, but not what to measure.
PLACES = ("--out", "--pathtracer", "--frames", "--jobs", "--slices", "--guide")
FOLDERS = ("--openqmc", "--heitz", "--program", "--luxcore", "--cycles")  # reports do not show these paths


def command_shown(command, arguments):
    """The command line as quoted in a report, without paths."""
    words, result = iter(arguments), [f"scripts/bench {command}"]
    for word in words:
        name, equals, _ = word.partition("=")
        if name in (*PLACES, *FOLDERS) and not equals:
            next(words, None)
        if name == "--sampler":
            result += [name, (equals and word.partition("=")[2] or next(words)).partition("=")[0] + "=FILE"]
        elif name in FOLDERS:
            result += [name, "FILE" if name == "--program" else "DIR"]
        elif name not in (*PLACES, "--again"):
            result.append(word)
    return " ".join(result)
