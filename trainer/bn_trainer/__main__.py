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


def whole(least: int):  # type: ignore[no-untyped-def]
    def read(text: str) -> int:
        try:
            value = int(text)
        except ValueError:
            value = least - 1
        if value < least:
            raise argparse.ArgumentTypeError(f"must be an integer of at least {least}, not {text!r}")
        return value

    return read


def run_train(options: argparse.Namespace) -> None:
    from .train import train

    train(options.config, options.folder, resume=options.resume, device=options.device, threads=options.threads,
          stop_after=options.stop_after, quiet=options.quiet)


def run_evaluate(options: argparse.Namespace) -> None:
    import torch

    from .evaluate import evaluate

    if options.threads:
        torch.set_num_threads(options.threads)
    evaluate(options.model, seeds=options.seeds, flatness_seeds=options.flatness_seeds)


def run_export(options: argparse.Namespace) -> None:
    from .export import export
    from .files import load_model

    done = export(load_model(options.checkpoint), options.output)
    print(f"{options.output}: {done['bytes']} bytes, {done['compared']}\nSHA-256 {done['sha256']}")


def run_schedule(options: argparse.Namespace) -> None:
    from .files import load_model
    from .schedule import write_schedule

    write_schedule(load_model(options.checkpoint), options.output)


OUTPUT = {"type": Path, "required": True}
THREADS = {"type": whole(0), "default": 0, "help": "number of torch threads (default 0: torch chooses)"}
#: Each command's help, function and options.
OWN: dict[str, tuple[str, Callable[[argparse.Namespace], None], dict[str, dict[str, Any]]]] = {
    "train": ("train a network", run_train, {
        "--config": {"type": Path, "help": "TOML file; see trainer/configs"},
        "--folder": {"type": Path, "metavar": "FOLDER", "help": "folder for configuration, log and checkpoints (default "
                     "~/.cache/bn_trainer/<name of the config>)"},
        "--resume": {"action": "store_true", "help": "continue the run in the folder; results are as if it had never stopped"},
        "--device": {"default": "cpu", "choices": ("cpu", "cuda"), "help": "default cpu"},
        "--threads": THREADS,
        "--stop-after": {"type": whole(0), "default": 0, "metavar": "N", "help": "stop after N iterations in total"},
        "--quiet": {"action": "store_true", "help": "do not show progress"}}),
    "evaluate": ("print the quality and cost of a model", run_evaluate, {
        "model": {"type": Path, "help": "a checkpoint (.pt) or an ONNX file (.onnx)"},
        "--seeds": {"type": whole(1), "default": 20, "help": "number of seeds per size (default 20)"},
        "--flatness-seeds": {"type": whole(0), "default": 1000, "help": "masks in the test for fixed patterns (default 1000; 0 skips it)"},
        "--threads": THREADS}),
    "export": ("write a checkpoint's model as ONNX", run_export, {
        "checkpoint": {"type": Path, "help": "the checkpoint to export"}, "--output": {**OUTPUT, "help": "the ONNX file to write"}}),
    "schedule": ("write a checkpoint's steps as the schedule of bn_relax", run_schedule, {
        "checkpoint": {"type": Path, "help": "the checkpoint of a network with model.sharpness = false"},
        "--output": {**OUTPUT, "help": "the JSON file to write"}}),
}
#: Commands implemented by modules with add_arguments(parser) and main(options).
MODULES = {
    "train-paper": ("paper.perceptron", "train the paper's perceptron"),
    "table": ("paper.table", "reproduce the paper's Table I"),
}


def main(arguments: list[str] | None = None) -> int:
    arguments = sys.argv[1:] if arguments is None else arguments
    parser = argparse.ArgumentParser(prog="python -m bn_trainer", description="Trains, evaluates and exports libbn's network.")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for name, (help_text, run, arguments_of) in OWN.items():
        child = commands.add_parser(name, help=help_text)
        for argument, settings in arguments_of.items():
            child.add_argument(*(("-o",) if argument == "--output" else ()), argument, **settings)
        child.set_defaults(run_command=run)
    for name, (module_name, help_text) in MODULES.items():
        child = commands.add_parser(name, help=help_text)
        # Imported on demand because they need more packages.
        if arguments[:1] == [name]:
            module = importlib.import_module(f".{module_name}", __package__)
            module.add_arguments(child)
            child.set_defaults(run_command=module.main)
    options = parser.parse_args(arguments)
    try:
        options.run_command(options)
        return 0
    except TrainerError as error:
        print(f"bn_trainer: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("bn_trainer: interrupted; continue with --resume", file=sys.stderr)
        return 130


if __name__ == "__main__":
    sys.exit(main())
