# SPDX-License-Identifier: Apache-2.0
"""Options shared by the `scripts/bench` commands that compare rendered pictures."""

import os
from pathlib import Path

from ..renders import variants, views
from . import peers
from .command import positive

# Options that say where to read and write, or how often, not what to measure.
PLACES = ("--out", "--pages", "--pathtracer", "--jobs", "--program")
FOLDERS = ("--openqmc", "--pbrt", "--luxcore", "--cycles")  # whose name a report does not show


def command_shown(command, arguments):
    """The command line that a report quotes: what is measured, not where."""
    words, result = iter(arguments), [f"scripts/bench {command}"]
    for word in words:
        name, equals, _ = word.partition("=")
        if name in (*PLACES, *FOLDERS) and not equals:
            next(words, None)
        if name in FOLDERS:
            result += [name, "DIR"]
        elif name not in (*PLACES, "--retime"):
            result.append(word)
    return " ".join(result)


def add_common_options(parser, reference_spp, pages):
    """Options shared by `renders` and `denoise`."""
    parser.add_argument("--seeds", type=positive, metavar="N", help="at most N seeds for each picture")
    parser.number("--reference-spp", reference_spp, "samples per pixel of references, a multiple of 32")
    parser.number("--jobs", os.cpu_count() or 1, "pictures to render at a time, one thread each", ": one per core")
    parser.add_argument("--no-times", action="store_true", help="skip the cost of samples, which needs an idle machine")
    parser.add_argument("--retime", action="store_true", help="repeat timings that are in the cache")
    parser.add_argument("--out", type=Path, help="folder for the report (default docs/report)")
    parser.add_argument("--pages", type=Path, metavar="FOLDER", help=f"folder for large tables (default {pages})")
    parser.set_defaults(default_pages=Path(pages), lights=None)
    parser.pathtracer()


def finish_options(parser, options, command, arguments):
    """Checks the options of add_common_options() and derives folders, labels and command from them. What is not
    of the shown views, or a trial, goes to the folder of large tables alone."""
    if options.reference_spp % 32:
        parser.error(f"--reference-spp must be a multiple of 32, not {options.reference_spp}")
    place = Path() if options.views == views.SHOWN else Path(options.views)
    options.pages = options.pages or options.default_pages / ("quick" if options.quick else "") / place / (options.lights or "")
    options.out = options.out or (options.pages if options.quick or options.lights or place.name else Path("docs/report"))
    options.labels = variants.chosen(options.samplers, peers.chosen(options.openqmc, options.pathtracer))
    if "sobol-global" in options.labels and "sobol-global" not in peers.samplers(options.pathtracer):
        parser.error("sobol-global needs Boost (Debian: libboost-dev) when the path tracer is built; install it, or remove it from --samplers")
    options.command = command_shown(command, arguments)
