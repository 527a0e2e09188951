# SPDX-License-Identifier: Apache-2.0
"""python -m bn_trainer train | evaluate | export | schedule | train-paper | table"""

from __future__ import annotations

import argparse
import importlib
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from .config import TrainerError


def whole(least: int) -> Callable[[str], int]:
    def read(text: str) -> int:
        if not text.isdecimal() or int(text) < least:
            raise argparse.ArgumentTypeError(f"must be an integer of at least {least}, not {text!r}")
        return int(text)

    return read


CONFIG = {"type": Path, "help": "TOML file; see trainer/configs"}
FOLDER = {"type": Path, "help": "folder of the run (default ~/.cache/bn_trainer/<name of the config>)"}
THREADS = {"type": whole(0), "default": 0, "help": "number of torch threads (default 0: torch chooses)"}
CHECKPOINT = {"type": Path, "help": "a checkpoint written by train"}
OUTPUT = {"type": Path, "required": True, "help": "the file to write"}
#: Each command's help, module and options, which are the arguments of its function run().
COMMANDS: dict[str, tuple[str, str, dict[str, dict[str, Any]]]] = {
    "train": ("train a network", ".train", {
        "--config": CONFIG, "--folder": FOLDER, "--threads": THREADS,
        "--resume": {"action": "store_true", "help": "continue the run in the folder; results are as if it had never stopped"},
        "--device": {"default": "cpu", "choices": ("cpu", "cuda"), "help": "default cpu"},
        "--stop-after": {"type": whole(0), "default": 0, "metavar": "N", "help": "stop after N iterations in total"},
        "--quiet": {"action": "store_true", "help": "do not show progress"}}),
    "evaluate": ("print the quality and cost of a model", ".evaluate", {
        "model": {"type": Path, "help": "a checkpoint (.pt) or an ONNX file (.onnx)"},
        "--seeds": {"type": whole(1), "default": 20, "help": "number of seeds per size (default 20)"},
        "--flatness-seeds": {"type": whole(0), "default": 1000, "help": "masks in the test for fixed patterns (default 1000; 0 skips it)"},
        "--threads": THREADS}),
    "export": ("write a checkpoint's model as ONNX", ".export", {"checkpoint": CHECKPOINT, "-o --output": OUTPUT}),
    "schedule": ("write the steps of a network with model.sharpness = false as a JSON schedule for bn_relax", ".schedule", {
        "checkpoint": CHECKPOINT, "-o --output": OUTPUT}),
    "train-paper": ("train the paper's perceptron", ".paper.perceptron", {
        "--config": {**CONFIG, "required": True}, "--folder": FOLDER, "--threads": {**THREADS, "default": 1, "help": "default 1"}}),
    "table": ("reproduce the paper's Table I", ".paper.table", {
        "--runs": {"type": Path, "help": "folder that contains train-paper's run folders paper-64, paper-64-sum, paper-128 and "
                   "paper-128-sum (default ~/.cache/bn_trainer)"},
        "--sizes": {"type": whole(1), "nargs": "+", "default": [64, 128], "help": "mask sizes (default 64 128)"},
        "--masks": {"type": whole(1), "default": 100, "help": "number of masks per method (default 100)"},
        "--wronski-masks": {"type": whole(1), "default": 8, "help": "number of masks by Wronski's method (default 8)"},
        "--wronski-iterations": {"type": whole(1), "default": 1000, "help": "number of iterations of Wronski's method (default 1000)"},
        "--picture": {"action": "append", "default": [], "metavar": "FILE[@X,Y]",
                      "help": "also dither a 256x256 crop of this image with the given top-left corner"},
        "--out": {"type": Path, "default": Path(__file__).resolve().parents[2] / "evidence" / "results",
                  "help": "folder for the report (default evidence/results)"}}),
}


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m bn_trainer", description="Trains, evaluates and exports libbn's network.")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    for name, (help_text, module, arguments_of) in COMMANDS.items():
        child = commands.add_parser(name, help=help_text)
        child.set_defaults(module=module)
        for argument, settings in arguments_of.items():
            child.add_argument(*argument.split(), **settings)
    options = vars(parser.parse_args(arguments))
    try:
        importlib.import_module(options.pop("module"), __package__).run(**options)
        return 0
    except TrainerError as error:
        print(f"bn_trainer: {error}", file=sys.stderr)
        return 1
    except ModuleNotFoundError as error:
        print(f"bn_trainer: the {error.name} package is missing; run pip install './trainer[check]'", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("bn_trainer: interrupted; continue with --resume", file=sys.stderr)
        return 130


if __name__ == "__main__":
    sys.exit(main())
