# SPDX-License-Identifier: Apache-2.0
"""Options shared by the `scripts/bench` commands that compare rendered pictures."""

import importlib.util
import os
from pathlib import Path

from ..renders import variants
from . import peers
from .command import add_out, add_pathtracer, positive

# Options that say where to read and write, not what to measure.
PLACES = ("--out", "--pages", "--pathtracer", "--jobs")


def arguments_that_count(arguments):
    """The options that a report quotes: what is measured, not where."""
    result, skip = [], False
    for word in arguments:
        if skip:
            skip = False
        elif word in PLACES:
            skip = True
        elif word == "--openqmc":
            result += ["--openqmc", "DIR"]
            skip = True
        elif word.partition("=")[0] not in (*PLACES, "--retime"):
            result.append("--openqmc=DIR" if word.startswith("--openqmc=") else word)
    return result


def find_onnxruntime():
    """Points BN_ONNXRUNTIME to the installed package onnxruntime, unless it is set already. False if there is none."""
    if os.environ.get("BN_ONNXRUNTIME"):
        return True
    spec = importlib.util.find_spec("onnxruntime")
    found = sorted((Path(spec.origin).parent / "capi").glob("libonnxruntime.so*")) if spec and spec.origin else []
    if found:
        os.environ["BN_ONNXRUNTIME"] = str(found[0])
    return bool(found)


def add_common_options(parser, reference_spp, pages):
    """Options shared by `renders` and `denoise`."""
    parser.add_argument("--seeds", type=positive, metavar="N", help="at most N seeds for each picture")
    parser.add_argument("--reference-spp", type=positive, default=reference_spp, metavar="N",
                        help=f"samples per pixel of references, a multiple of 32 (default {reference_spp})")
    parser.add_argument("--jobs", type=positive, default=os.cpu_count() or 1, metavar="N",
                        help="pictures to render at a time, one thread each (default: one per core)")
    parser.add_argument("--no-flip", action="store_true", help="skip HDR-FLIP")
    add_out(parser)
    parser.add_argument("--pages", type=Path, default=Path(pages), metavar="FOLDER",
                        help=f"folder for contact sheets and large tables (default {pages})")
    add_pathtracer(parser)
    peers.add_option(parser)


def finish_options(parser, options, command, arguments):
    """Checks the options of add_common_options() and derives labels and command from them."""
    if options.reference_spp % 32:
        parser.error(f"--reference-spp must be a multiple of 32, not {options.reference_spp}")
    options.labels = variants.chosen(options.samplers, peers.chosen(options.openqmc, options.pathtracer))
    if "sobol-global" in options.labels and "sobol-global" not in peers.samplers(options.pathtracer):
        parser.error("sobol-global needs Boost (Debian: libboost-dev) when the path tracer is built; install it, or remove it from --samplers")
    if "mask, neural" in options.labels and not find_onnxruntime():
        parser.error("mask-neural needs ONNX Runtime: run pip install onnxruntime, or remove it from --samplers")
    options.command = f"scripts/bench {command}" + "".join(f" {word}" for word in arguments_that_count(arguments))
