# SPDX-License-Identifier: Apache-2.0
"""The command line ``bluenoise``; also ``python -m bluenoise``."""

from __future__ import annotations

import argparse
import json
import math
import os
import re
import sys
from pathlib import Path
from typing import Any, Callable, Optional, Sequence, get_args

import numpy as np

from . import __version__, _files, dither, power_spectrum, radial_power
from . import mask as make_mask
from . import measure as measure_mask
from . import _arguments as arguments
from ._arguments import NeuralProvider
from ._masks import METHODS
from ._measure import ranks_of
from ._plot import plot_spectrum

_MASK_SUFFIXES = (".png", ".exr", ".npy")
_SPECTRUM_SUFFIXES = (".png", ".svg", ".pdf", ".csv", ".npy")
_OPTIONS = ("sigma", "initial_fraction", "steps", "sweeps", "channels", "model", "runtime", "threads", "provider")


def main(argv: Optional[Sequence[str]] = None) -> int:
    """Runs a command. Returns the exit status: 0, 1 after an error, 2 for wrong usage, 130 after Ctrl-C."""
    options = _parser().parse_args(argv)
    run: Callable[[argparse.Namespace], None] = options.run
    try:
        run(options)
        sys.stdout.flush()
    except KeyboardInterrupt:
        print("bluenoise: interrupted", file=sys.stderr)
        return 130
    except BrokenPipeError:
        # The reader is gone. Python would complain again when it flushes standard output at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    except (ValueError, TypeError, MemoryError, OSError, ImportError, RuntimeError) as error:
        text = " ".join(str(error).split()) or type(error).__name__
        print(f"bluenoise: {text}", file=sys.stderr)
        return 1
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="bluenoise",
        description="Makes and measures blue-noise masks, and dithers pictures with them.",
        epilog="The file name - stands for standard input or output.",
    )
    parser.add_argument("--version", action="version", version=f"bluenoise {__version__}")
    commands = parser.add_subparsers(metavar="COMMAND", required=True)

    command = commands.add_parser(
        "mask",
        help="make a mask",
        description="Makes a mask: .npy with ranks, .png with 8- or 16-bit values, or .exr with float values (needs OpenEXR).",
    )
    command.add_argument("--size", required=True, type=_size, metavar="N, WxH or WxHxD", help="size in texels; N is NxN")
    command.add_argument("--channels", type=_integer, metavar="N", help="auto, anneal: 1 to 4 jointly blue channels; neural: 1 or 2, or those of --model (default 1)")
    command.add_argument("--method", default="void-and-cluster", choices=METHODS, help="default void-and-cluster; auto chooses by size and channels")
    command.add_argument("--seed", default=0, type=_seed, help="0 to 2**64 - 1, or random (default 0)")
    command.add_argument("--sigma", type=float, help="void-and-cluster, relax (which then makes 64 steps), anneal: width of the Gaussian in texels")
    command.add_argument(
        "--initial-fraction", type=float, help="void-and-cluster: share of texels in the initial pattern (default 0.1)"
    )
    command.add_argument("--steps", type=_integer, help="relax: number of steps (default: a learned schedule)")
    command.add_argument("--sweeps", type=_integer, help="anneal: trial swaps per texel (default 1000)")
    command.add_argument("--model", type=Path, metavar="FILE", help="neural: an ONNX file (default: a built-in network)")
    command.add_argument("--runtime", type=Path, metavar="FILE", help="neural: the ONNX Runtime library")
    command.add_argument("--threads", type=_integer, help="relax, neural: number of threads (default: one per core)")
    command.add_argument("--provider", choices=get_args(NeuralProvider), help="neural: run on the processor (default) or a GPU")
    command.add_argument("--bits", type=int, choices=(8, 16), default=16, help="bits per channel of a .png (default 16)")
    command.add_argument("--json", action="store_true", help="describe the mask as JSON on standard output")
    command.add_argument("--quiet", action="store_true", help="do not show progress")
    _add_output(command, _MASK_SUFFIXES, "npy")
    command.set_defaults(run=_mask)

    command = commands.add_parser(
        "measure",
        help="measure a mask",
        description="Measures a mask; lower is better. E_s is the error of dithering after a Gaussian blur of s texels, the "
        "low-frequency power that of the mask thresholded at a grey level. help(bluenoise.measure) in Python defines each.",
    )
    _add_mask_input(command)
    command.add_argument("--json", action="store_true", help="print one JSON object")
    command.set_defaults(run=_measure)

    command = commands.add_parser(
        "dither",
        help="dither a picture",
        description="Dithers a picture to a few levels; see bluenoise.dither. Needs Pillow.",
    )
    command.add_argument("input", type=Path, help="a picture in any format that Pillow reads, or -")
    command.add_argument("output", type=Path, help="the picture to write, in a lossless format, or - for PNG")
    command.add_argument("--levels", default=2, type=_integer, help="number of levels, 2 to 256 (default 2)")
    command.add_argument("--mask", type=Path, metavar="FILE", help="the mask (default: the built-in 64x64 mask)")
    command.add_argument("--srgb", action="store_true", help="preserve means in linear light")
    command.set_defaults(run=_dither)

    command = commands.add_parser(
        "spectrum",
        help="compute the power spectrum of a mask",
        description="Writes the power spectrum of a mask: as a plot (.png, .svg, .pdf; needs Matplotlib), its radial average "
        "(.csv), or as an array (.npy).",
    )
    _add_mask_input(command)
    command.add_argument("--json", action="store_true", help="print the radial average as JSON")
    _add_output(command, _SPECTRUM_SUFFIXES, "csv", required=False)
    command.set_defaults(run=_spectrum)
    return parser


def _add_mask_input(command: argparse.ArgumentParser) -> None:
    command.add_argument("mask", type=Path, help="a mask as .npy, .exr (needs OpenEXR) or picture (needs Pillow), or -")
    command.add_argument("--channel", type=_positive, default=0, metavar="N", help="the channel to use, counted from 1")


def _add_output(
    command: argparse.ArgumentParser, suffixes: Sequence[str], default: str, required: bool = True
) -> None:
    command.add_argument(
        "-o", "--output", required=required, type=Path, metavar="FILE", help=f"{', '.join(suffixes)}, or -"
    )
    command.add_argument(
        "--format",
        choices=[suffix[1:] for suffix in suffixes],
        help=f"format of the output (default: from its name; {default} for -)",
    )
    command.set_defaults(default_format=default)


def _suffix(options: argparse.Namespace) -> str:
    """The format of the output as a suffix such as ".png"."""
    if options.format is not None:
        return f".{options.format}"
    if options.output == _files.STREAM:
        return f".{options.default_format}"
    return str(options.output.suffix.lower())


def _size(text: str) -> tuple[int, ...]:
    """N, WxH or WxHxD as a shape, slowest extent first."""
    if not re.fullmatch(r"[0-9]+(x[0-9]+){0,2}", text):
        raise argparse.ArgumentTypeError(f"{text!r} is not N, WxH or WxHxD, for example 128x128")
    extents = tuple(int(extent) for extent in reversed(text.split("x")))
    if 0 in extents:
        raise argparse.ArgumentTypeError(f"{text!r} has an extent of 0; the least is 1")
    return extents if len(extents) > 1 else extents * 2


def _integer(text: str) -> int:
    try:
        return int(text, 0)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not an integer") from None


def _positive(text: str) -> int:
    number = _integer(text)
    if number < 1:
        raise argparse.ArgumentTypeError(f"{text!r} is less than 1")
    return number


def _seed(text: str) -> int:
    return arguments.seed(None) if text == "random" else _integer(text)


def _progress(quiet: bool) -> Optional[Callable[[float], None]]:
    """A function that shows percentages on a terminal, else None."""
    if quiet or not sys.stderr.isatty():
        return None
    shown = -1

    def show(fraction: float) -> None:
        nonlocal shown
        percent = int(100 * fraction)
        if percent != shown:
            shown = percent
            print(f"\r{percent:3d} %", end="\n" if percent == 100 else "", file=sys.stderr, flush=True)

    return show


def _mask(options: argparse.Namespace) -> None:
    shape, path, suffix = options.size, options.output, _suffix(options)
    _files.check_output(path, suffix, _MASK_SUFFIXES)
    if options.json and path == _files.STREAM:
        raise ValueError("--json and -o - both need standard output")
    if len(shape) == 3 and suffix != ".npy":
        raise ValueError(f"a three-dimensional mask does not fit in {suffix}; write .npy")
    if suffix == ".exr":
        _files.openexr()
    given: dict[str, Any] = {name: getattr(options, name) for name in _OPTIONS}
    given = {name: value for name, value in given.items() if value is not None}
    for name in given:
        if name not in METHODS[options.method]:
            methods = " or ".join(method for method in METHODS if name in METHODS[method])
            raise ValueError(f"--{name.replace('_', '-')} needs --method {methods}, not {options.method}")
    shown = {name: value for name, value in given.items() if name not in ("threads", "runtime", "provider")}
    progress = _progress(options.quiet)
    if progress is not None and "progress" in METHODS[options.method]:
        given["progress"] = progress
    make: Callable[..., arguments.Ranks] = make_mask
    ranks = make(shape, method=options.method, seed=options.seed, **given)
    channels = ranks.shape[0] if ranks.ndim > len(shape) else 1
    if channels > 4 and suffix != ".npy":
        raise ValueError(f"a mask of {channels} channels does not fit in {suffix}; write .npy")
    text = "".join(f", {name} {value}" for name, value in shown.items())
    description = f"bluenoise {__version__}: {options.method}, seed {options.seed}{text}"
    _files.save_mask(path, suffix, ranks, options.bits, description)
    count = math.prod(shape)
    if suffix == ".png" and options.bits == 16 and count > 2**16:
        print(
            f"bluenoise: {path} has 65536 levels for {count} ranks; .npy keeps every rank",
            file=sys.stderr,
        )
    if options.json:
        facts: dict[str, Any] = {"output": str(path), "format": suffix[1:], "size": list(reversed(shape))}
        if suffix == ".png":
            facts["bits"] = options.bits
        facts.update(channels=channels, method=options.method, seed=options.seed)
        facts["options"] = {
            name: str(value) if isinstance(value, Path) else value for name, value in shown.items()
        }
        print(json.dumps(facts))


def _measure(options: argparse.Namespace) -> None:
    values = _files.load_mask(options.mask, options.channel)
    figures = measure_mask(values)
    if options.json:
        print(json.dumps(_without_nan({**figures, "size": [values.shape[1], values.shape[0]]})))
        return
    _line("size", f"{values.shape[1]} x {values.shape[0]}")
    _line("each rank once", "yes" if figures["exact"] else "no")
    _line("E_0.75", _number(figures["e_0.75"], ".5f"))
    _line("E_1", _number(figures["e_1"], ".5f"))
    _line("E_1.5", _number(figures["e_1.5"], ".5f"))
    _line("E_2", _number(figures["e_2"], ".5f"))
    _line("anisotropy", _number(figures["anisotropy"], ".2f") + " dB")
    print("low-frequency power, thresholded at a grey level (white noise has 1):")
    for level, power in figures["low_frequency"].items():
        _line(f"  grey {level:g}", _number(power, ".3f"))


def _line(name: str, value: str) -> None:
    print(f"{name:18s}{value}")


def _number(value: float, spec: str) -> str:
    return "none" if math.isnan(value) else format(value, spec)


def _dither(options: argparse.Namespace) -> None:
    path = options.output
    suffix = ".png" if path == _files.STREAM else path.suffix.lower()
    _files.check_output(path, suffix, _files.LOSSLESS)
    picture = _files.open_picture(options.input)
    ranks = None
    if options.mask is not None:
        ranks, exact = ranks_of("mask", _files.load_mask(options.mask))
        if not exact:
            raise ValueError(f"{options.mask} is not a mask: some values occur more than once")
    result = dither(picture, options.levels, mask=ranks, srgb=options.srgb)
    _files.save_picture(path, suffix, result, picture)


def _spectrum(options: argparse.Namespace) -> None:
    path = options.output
    if path is None and not options.json:
        raise ValueError("give an output with -o, or --json")
    if path is not None:
        suffix = _suffix(options)
        _files.check_output(path, suffix, _SPECTRUM_SUFFIXES)
        if options.json and path == _files.STREAM:
            raise ValueError("--json and -o - both need standard output")
    values = _files.load_mask(options.mask, options.channel)
    if path is not None:
        _write_spectrum(path, suffix, values)
    if options.json:
        frequency, power = radial_power(values)
        print(json.dumps({"frequency": frequency.tolist(), "power": power.tolist()}))


def _write_spectrum(path: Path, suffix: str, values: Any) -> None:
    with _files.replacing(path, suffix) as beside:
        if suffix == ".npy":
            np.save(beside, power_spectrum(values))
        elif suffix == ".csv":
            frequency, power = radial_power(values)
            rows = "".join(f"{f:.6f},{p:.6f}\n" for f, p in zip(frequency, power))
            beside.write_text("frequency,power\n" + rows, encoding="ascii")
        else:
            plot_spectrum(values, beside)


def _without_nan(value: Any) -> Any:
    if isinstance(value, dict):
        return {str(key): _without_nan(item) for key, item in value.items()}
    return None if isinstance(value, float) and math.isnan(value) else value
