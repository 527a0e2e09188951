# SPDX-License-Identifier: Apache-2.0
"""The command line ``bluenoise``; also ``python -m bluenoise``."""

from __future__ import annotations

import argparse
import json
import math
import re
import sys
from pathlib import Path
from typing import Any, Callable, Optional, Sequence

import numpy as np

from . import __version__, _files, dither, power_spectrum, radial_power
from . import mask as make_mask
from . import measure as measure_mask
from ._masks import METHODS
from ._measure import ranks_of
from ._plot import plot_spectrum


def main(argv: Optional[Sequence[str]] = None) -> int:
    """Runs one command; returns the exit status: 0, 1 after an error, 130 after Ctrl-C (2 for wrong usage)."""
    options = _parser().parse_args(argv)
    run: Callable[[argparse.Namespace], None] = options.run
    try:
        run(options)
    except KeyboardInterrupt:
        print("bluenoise: interrupted", file=sys.stderr)
        return 130
    except BrokenPipeError:
        sys.stderr.close()  # the reader of the output has gone: nothing to say and nobody to say it to
        return 1
    except (ValueError, TypeError, MemoryError, OSError, ImportError, RuntimeError) as error:
        text = " ".join(str(error).split()) or type(error).__name__
        print(f"bluenoise: {text}", file=sys.stderr)
        return 1
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="bluenoise", description="Blue-noise masks: make, measure, dither with them."
    )
    parser.add_argument("--version", action="version", version=f"bluenoise {__version__}")
    commands = parser.add_subparsers(metavar="command", required=True)

    command = commands.add_parser(
        "mask", help="make a mask", description="Makes a mask as a 16-bit PNG or .npy of ranks."
    )
    command.add_argument("--size", required=True, type=_size, metavar="WxH[xD]", help="in texels")
    command.add_argument("--method", default="void-and-cluster", choices=METHODS)
    command.add_argument("--seed", default=0, type=_integer, help="0 to 2**64 - 1 (default 0)")
    command.add_argument("--sigma", type=float, help="viewing blur or Gaussian, in texels")
    command.add_argument("--initial-fraction", type=float, help="void-and-cluster: share (0.1)")
    command.add_argument("--steps", type=_integer, help="relax: steps (64)")
    command.add_argument("--sweeps", type=_integer, help="anneal: trial swaps per texel (1000)")
    command.add_argument("--model", type=Path, metavar="FILE", help="neural: an ONNX file")
    command.add_argument("--runtime", type=Path, metavar="FILE", help="neural: ONNX Runtime's library")
    command.add_argument("--threads", type=_integer, help="relax, neural: threads (one per core)")
    command.add_argument("--quiet", action="store_true", help="no progress")
    command.add_argument("-o", "--output", required=True, type=Path, metavar="FILE")
    command.set_defaults(run=_mask)

    command = commands.add_parser(
        "measure", help="measure a mask", description="Measures a mask; see bluenoise.measure."
    )
    command.add_argument("mask", type=Path, help="a grey picture or .npy")
    command.add_argument("--json", action="store_true", help="print one JSON object")
    command.set_defaults(run=_measure)

    command = commands.add_parser(
        "dither", help="dither a picture", description="Dithers a picture; see bluenoise.dither."
    )
    command.add_argument("input", type=Path, help="any picture that Pillow reads")
    command.add_argument("output", type=Path, help="a picture of a lossless kind")
    command.add_argument("--levels", default=2, type=_integer, help="2 to 256 (default 2)")
    command.add_argument("--mask", type=Path, metavar="FILE", help="mask (default: the built-in 64)")
    command.add_argument("--srgb", action="store_true", help="keep the mean in linear light")
    command.set_defaults(run=_dither)

    command = commands.add_parser(
        "spectrum",
        help="power spectrum of a mask",
        description="Writes a mask's power spectrum: a plot, the radial average (.csv) or the array (.npy).",
    )
    command.add_argument("mask", type=Path, help="a grey picture or .npy")
    command.add_argument("-o", "--output", required=True, type=Path, metavar="FILE")
    command.set_defaults(run=_spectrum)
    return parser


def _size(text: str) -> tuple[int, ...]:
    """WxH or WxHxD as a shape, slowest extent first."""
    if not re.fullmatch(r"[0-9]+(x[0-9]+){0,2}", text):
        raise argparse.ArgumentTypeError(f"{text!r} is not W, WxH or WxHxD, for example 128x128")
    return tuple(int(extent) for extent in reversed(text.split("x")))


def _integer(text: str) -> int:
    try:
        return int(text, 0)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not an integer") from None


def _progress(quiet: bool) -> Optional[Callable[[float], None]]:
    """Shows per cent on a terminal; None elsewhere."""
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
    shape, path = options.size, options.output
    _files.check_output(path, (".png", ".npy"))
    if path.suffix.lower() == ".png":
        _files.pillow()
        if len(shape) == 3:
            raise ValueError("a mask of three dimensions does not fit in a PNG: write .npy")
    names = ("sigma", "initial_fraction", "steps", "sweeps", "model", "runtime", "threads")
    given = {name: getattr(options, name) for name in names}
    given = {name: value for name, value in given.items() if value is not None}
    progress = _progress(options.quiet)
    if progress is not None and "progress" in METHODS[options.method]:
        given["progress"] = progress
    ranks = make_mask(shape, method=options.method, seed=options.seed, **given)
    if ranks.ndim == 3 and path.suffix.lower() == ".png":
        raise ValueError(f"a mask of {ranks.shape[0]} channels does not fit in a PNG: write .npy")
    for name in ("progress", "threads", "runtime"):
        given.pop(name, None)
    text = "".join(f", {name} {value}" for name, value in given.items())
    description = f"bluenoise {__version__}: {options.method}, seed {options.seed}{text}"
    if not _files.save_mask(path, ranks, description):
        print(
            f"bluenoise: {path} has 65536 levels for {ranks.size} ranks; .npy keeps every rank",
            file=sys.stderr,
        )


def _measure(options: argparse.Namespace) -> None:
    values = _files.load_mask(options.mask)
    figures = measure_mask(values)
    if options.json:
        figures["size"] = [values.shape[1], values.shape[0]]
        print(json.dumps(_without_nan(figures)))
        return
    _line("size", f"{values.shape[1]} x {values.shape[0]}")
    _line("every rank once", "yes" if figures["exact"] else "no")
    for name in ("e_0.75", "e_1", "e_1.5", "e_2"):
        _line(name.upper(), _number(figures[name], ".5f"))
    _line("anisotropy", _number(figures["anisotropy"], ".2f") + " dB")
    for level, power in figures["low_frequency"].items():
        _line(f"low power {level:g}", _number(power, ".3f"))


def _line(name: str, value: str) -> None:
    print(f"{name:18s}{value}")


def _number(value: float, spec: str) -> str:
    return "none" if math.isnan(value) else format(value, spec)


def _dither(options: argparse.Namespace) -> None:
    _files.check_output(options.output, _files.LOSSLESS)
    picture = _files.open_picture(options.input)
    ranks = None
    if options.mask is not None:
        ranks, exact = ranks_of("mask", _files.load_mask(options.mask))
        if not exact:
            raise ValueError(f"{options.mask} is no mask: some values occur more than once")
    result = dither(picture, options.levels, mask=ranks, srgb=options.srgb)
    _files.save_picture(options.output, result, picture)


def _spectrum(options: argparse.Namespace) -> None:
    path = options.output
    suffix = path.suffix.lower()
    _files.check_output(path, (".png", ".svg", ".pdf", ".csv", ".npy"))
    values = _files.load_mask(options.mask)
    with _files.replacing(path) as beside:
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
