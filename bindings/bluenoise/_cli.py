# SPDX-License-Identifier: Apache-2.0
"""The ``bluenoise`` command, which ``python -m bluenoise`` also runs."""

from __future__ import annotations

import argparse
import inspect
import json
import math
import os
import re
import signal
import sys
import unicodedata
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import Any, Callable, Iterable, Iterator, Mapping, NoReturn, Optional, Sequence, get_args

import numpy as np

from . import __version__, _files, dither
from . import _arguments as arguments
from . import measure as measure_mask
from . import points as make_points
from ._arguments import NeuralProvider
from ._masks import METHODS as MASKS
from ._noise import COLOURS, false_colour, visible_noise
from ._points import METHODS as POINTS_METHODS

_MASK_METHODS = {method: tuple(inspect.signature(make).parameters) for method, make in MASKS.items()}
_POINTS_SUFFIXES = (".csv", ".npy")
_EXAMPLES = """\
examples:
  bluenoise mask --size 128 -o mask.png          make a 128x128 mask
  bluenoise measure mask.png                     measure it
  bluenoise dither photo.jpg dithered.png        dither a photograph to black and white
  bluenoise noise first.exr second.exr -o n.png  measure a render's visible noise from two halves
"""


def main(argv: Optional[Sequence[str]] = None) -> int:
    """Runs a command. Returns the exit status: 0 for success, 1 for an error, 2 for wrong usage, 130 for Ctrl-C, 143 for SIGTERM."""
    _prepare()
    if argv is None:
        signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))  # removes unfinished files
    try:
        try:
            options = _parser().parse_args(argv)
            run: Callable[[argparse.Namespace], None] = options.run
            run(options)
        finally:
            _flush()
    except KeyboardInterrupt:
        _say("interrupted")
        return 130
    except BrokenPipeError:
        _drop(sys.stdout)  # the reader is gone
        return 1
    except (ValueError, TypeError, MemoryError, OSError, ImportError, RuntimeError) as error:
        if isinstance(error, OSError) and error.filename is not None and error.strerror:
            error = OSError(f"{error.filename}: {error.strerror}")
        _say(" ".join(str(error).split()) or type(error).__name__)
        return 1
    return 0


def _prepare() -> None:
    """Redirects closed standard streams to the null device so that no other file gets their descriptors."""
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)
    if sys.stderr is None:
        sys.stderr = open(os.devnull, "w", encoding="utf-8")


def _plain(text: str) -> str:
    """Replaces control characters so that a file name cannot send terminal sequences."""
    return "".join("?" if unicodedata.category(c) == "Cc" else c for c in text)


def _say(text: str) -> None:
    """Prints a message. If it cannot be printed, the exit status still reports the error."""
    _Bar.end_line()
    try:
        print(f"bluenoise: {_plain(text)}", file=sys.stderr, flush=True)
    except OSError:
        _drop(sys.stderr)


@contextmanager
def _standard_output() -> Iterator[None]:
    """Names standard output in its errors."""
    try:
        yield
    except BrokenPipeError:
        raise
    except OSError as error:
        _drop(sys.stdout)
        raise OSError(error.errno, error.strerror, "standard output") from None


def _print(text: str) -> None:
    _files.standard("stdout")
    with _standard_output():
        print(text)


def _flush() -> None:
    """Flushes standard output so that a full disk is detected."""
    if sys.stdout is not None:
        with _standard_output():
            sys.stdout.flush()


def _drop(stream: Any) -> None:
    """Discards a broken stream: otherwise Python would report the error again at exit, with a different exit status."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


class _Parser(argparse.ArgumentParser):
    """Reports errors on one line."""

    def error(self, message: str) -> NoReturn:
        self.exit(2, f"{self.prog}: {_plain(message)}; see {self.prog} --help\n")


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(
        prog="bluenoise",
        description="Makes and measures blue-noise masks, dithers images with them, makes points, and measures the noise of renders.",
        epilog=_EXAMPLES + "\nThe file name - stands for standard input or output.",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=f"bluenoise {__version__}")
    parser.set_defaults(run=lambda options: parser.exit(2, f"{parser.format_usage()}\n{_EXAMPLES}\nsee bluenoise --help\n"))
    commands = parser.add_subparsers(metavar="COMMAND")

    def add(run: Callable[[argparse.Namespace], None], name: str, text: str, description: str) -> argparse.ArgumentParser:
        command: argparse.ArgumentParser = commands.add_parser(name, help=text, description=description)
        command.set_defaults(run=run)
        return command

    command = add(
        _mask, "mask", "make a mask",
        "Makes a mask. Writes ranks to .npy, 8- or 16-bit values to .png, or float values to .exr (needs OpenEXR).",
    )
    command.add_argument("--size", required=True, type=_size, metavar="N, WxH or WxHxD", help="size in texels; N means NxN")
    _add_method(command, _MASK_METHODS, "auto", "auto, which chooses by size and number of channels", _MASK_OPTIONS)
    command.add_argument("--bits", type=int, choices=(8, 16), default=16, help="bits per channel of a .png (default 16)")
    _add_report(command, "describe the mask as JSON on standard output")
    _add_output(command, _files.MASK_SUFFIXES, "npy")

    command = add(
        _measure, "measure", "measure a mask",
        "Measures a mask; smaller values are better. Low-frequency power is measured after thresholding at a grey level. "
        "help(bluenoise.MaskMeasures) in Python defines each measure.",
    )
    command.add_argument("mask", type=Path, help="a mask: .npy, .exr (needs OpenEXR) or another image (needs Pillow), or -")
    command.add_argument("--channel", type=_positive, default=0, metavar="N", help="the channel to use, counted from 1 (default: all)")
    _add_report(command, "print one JSON object")

    command = add(_dither, "dither", "dither an image", "Dithers an image to a few levels; see bluenoise.dither. Needs Pillow.")
    command.add_argument("input", type=Path, help="an image in any format that Pillow reads, or -")
    command.add_argument("output", type=Path, help="the image to write, in a lossless format, or - for PNG")
    command.add_argument("--levels", default=2, type=_integer, help="number of levels, 2 to 256 (default 2)")
    command.add_argument("--palette", type=_palette, metavar="N, RRGGBB,... or FILE", help="dither to N colours that suit the image, "
                         "to the given colours, or to the palette of an image; the output may also be a .gif")
    command.add_argument("--mask", type=Path, metavar="FILE", help="the mask (default: the built-in 64x64 mask); with "
                         "multiple channels, one per image channel")
    command.add_argument("--channel", type=_positive, default=0, metavar="N", help="the mask channel to use, counted from 1")
    command.add_argument("--rank", action="store_true", help="accept a mask with repeated values, such as an 8-bit "
                         "texture, and break ties at random")
    command.add_argument("--srgb", action="store_true", help="preserve means in linear light")

    command = add(
        _points, "points", "make points in the unit square or cube",
        "Makes blue-noise points in the unit square and writes x and y to .csv or .npy; see bluenoise.points. Needs SciPy, except for "
        "--method mask.",
    )
    command.add_argument("--count", type=_integer, metavar="N", help="number of points (required without --density)")
    command.add_argument("--dims", type=int, choices=(2, 3), default=2, help="number of dimensions (default 2)")
    command.add_argument("--dark", action="store_true", help="the dark parts of --density are the dense ones")
    _add_method(command, POINTS_METHODS, None, "best-candidate; with --density, poisson-disk", _POINTS_OPTIONS)
    command.add_argument("--channel", type=_positive, default=0, metavar="N", help="the channel of --mask to use, counted from 1")
    _add_report(command, "describe the points as JSON on standard output")
    _add_output(command, _POINTS_SUFFIXES, "csv")

    command = add(
        _noise, "noise", "measure the visible noise of a render",
        "Prints the visible noise of a render in steps of an 8-bit display, from the means of two parts of its samples, and "
        "draws a map of it; see bluenoise.visible_noise.",
    )
    command.add_argument("first", type=Path, help="the mean of some of the samples: .exr (needs OpenEXR) or .npy, linear")
    command.add_argument("second", type=Path, help="the mean of the other samples")
    command.add_argument("--mean", action="store_true", help="SECOND is the mean of all samples")
    command.add_argument("--first-share", type=float, default=0.5, metavar="FRACTION", help="fraction of all samples that are in FIRST, "
                         "0.001 to 0.999 (default 0.5)")
    command.add_argument("--sigma", type=float, default=2.1, help="the eye's blur in pixels (default 2.1: 96 dpi at 75 cm)")
    command.add_argument("--exposure", type=float, default=1.0, metavar="FACTOR", help="white is at 1 / FACTOR (default 1)")
    command.add_argument("--window", type=_integer, default=33, metavar="N", help="side in pixels of the square that pools the noise "
                         "(default 33)")
    command.add_argument("-o", "--output", type=Path, metavar="FILE", help="the map: colours as .png, or steps as .npy")
    _add_report(command, "print one JSON object")
    return parser


def _add_report(command: argparse.ArgumentParser, text: str) -> None:
    command.add_argument("--json", action="store_true", help=text)
    command.add_argument("--quiet", action="store_true", help="do not show progress")


def _add_output(command: argparse.ArgumentParser, suffixes: Sequence[str], default: str) -> None:
    command.add_argument("-o", "--output", required=True, type=Path, metavar="FILE", help=f"{', '.join(suffixes)}, or -")
    command.add_argument(
        "--format",
        choices=[suffix[1:] for suffix in suffixes],
        help=f"output format (default: from the file name; {default} for -)",
    )
    command.set_defaults(default_format=default)


def _suffix(options: argparse.Namespace) -> str:
    """The output format as a suffix such as ".png"."""
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
        return int(text, 10 if re.fullmatch(r"[-+]?[0-9]+", text) else 0)  # Python takes no leading zeros
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not an integer") from None


def _palette(text: str) -> Any:
    colours = text.replace("#", "").split(",")
    if all(re.fullmatch("[0-9a-fA-F]{6}", colour) for colour in colours):
        return [tuple(bytes.fromhex(colour)) for colour in colours]
    return int(text) if re.fullmatch("[0-9]{1,3}", text) else Path(text)


def _positive(text: str) -> int:
    number = _integer(text)
    if number < 1:
        raise argparse.ArgumentTypeError(f"{text!r} is less than 1")
    return number


def _seed(text: str) -> int:
    return arguments.seed(None) if text == "random" else _integer(text)


# Options of individual methods. Each help text starts with the methods.
_MASK_OPTIONS: dict[str, dict[str, Any]] = {
    "sigma": {"type": float, "help": "standard deviation of the Gaussian in texels"},
    "initial_fraction": {"type": float, "help": "fraction of texels in the initial pattern (default 0.1)"},
    "sweeps": {"type": _integer, "help": "trial swaps per texel (default 1000)"},
    "channels": {"type": _integer, "metavar": "N", "help": "jointly blue channels, 1 to 4; neural: 1, 2 or as in --model (default 1)"},
    "model": {"type": Path, "metavar": "FILE", "help": "an ONNX file (default: a built-in network)"},
    "runtime": {"type": Path, "metavar": "FILE", "help": "the ONNX Runtime library"},
    "threads": {"type": _integer, "help": "number of threads (default: the CPUs that the process may use)"},
    "provider": {"choices": get_args(NeuralProvider), "help": "run on the CPU (default) or a GPU"},
}
_POINTS_OPTIONS: dict[str, dict[str, Any]] = {
    "candidates": {"type": _integer, "metavar": "N", "help": "more candidates are slower but better (default 1; poisson-disk: 30)"},
    "mask": {"type": Path, "metavar": "FILE", "help": "a mask; its lowest-ranked texels become the points"},
    "density": {"type": Path, "metavar": "FILE", "help": "an image or .npy array; its bright parts get more points"},
}


def _add_method(
    command: argparse.ArgumentParser, known: Mapping[str, Sequence[str]], default: Optional[str], note: str, options: Mapping[str, Any]
) -> None:
    command.add_argument("--method", default=default, choices=known, help=f"default {note}")
    command.add_argument("--seed", default=0, type=_seed, help="0 to 2**64 - 1, or random (default 0)")
    for name, words in options.items():
        methods = ", ".join(method for method in known if name in known[method])
        command.add_argument(f"--{name.replace('_', '-')}", **{**words, "help": f"{methods}: {words['help']}"})


class _Bar:
    """Shows percentages on a terminal."""

    shown: Optional[int] = None  # the percentage on the current line

    def __call__(self, fraction: float) -> None:
        percent = int(100 * fraction)
        if percent != _Bar.shown:
            _Bar.shown = percent
            print(f"\r{percent:3d}%", end="", file=sys.stderr, flush=True)
        if fraction >= 1:
            _Bar.end_line()

    @staticmethod
    def end_line() -> None:
        """Ends the bar's line so that messages start on a new line."""
        if _Bar.shown is not None:
            _Bar.shown = None
            print(file=sys.stderr, flush=True)


def _progress(quiet: bool) -> Optional[_Bar]:
    return None if quiet or not sys.stderr.isatty() else _Bar()


def _output(options: argparse.Namespace, suffixes: Sequence[str], *sources: Optional[Path]) -> tuple[Path, str]:
    """The output path and its suffix. Checks that the path can be written."""
    path, suffix = options.output, _suffix(options)
    _files.check_output(path, suffix, suffixes, *sources)
    if options.json and path == _files.STREAM:
        raise ValueError("--json and -o - both need standard output")
    return path, suffix


def _given(options: argparse.Namespace, names: Iterable[str], known: Mapping[str, Sequence[str]]) -> dict[str, Any]:
    """The given options with these names. Raises ValueError if the method does not accept one of them."""
    given = {name: getattr(options, name) for name in names if getattr(options, name) is not None}
    for name in given:
        if name not in known[options.method]:
            methods = " or ".join(method for method in known if name in known[method])
            raise ValueError(f"--{name.replace('_', '-')} needs --method {methods}, not {options.method}")
    return given


def _mask(options: argparse.Namespace) -> None:
    shape = options.size
    path, suffix = _output(options, _files.MASK_SUFFIXES, options.model)
    if len(shape) == 3 and suffix != ".npy":
        raise ValueError(f"a three-dimensional mask does not fit in {suffix}; write .npy")
    if suffix == ".exr":
        _files.openexr()
    given = _given(options, _MASK_OPTIONS, _MASK_METHODS)
    method = options.method
    shown = {name: given[name] for name in _MASK_OPTIONS if name in given and name not in ("threads", "runtime", "provider")}
    if method == "builtin":
        if options.seed != 0:
            raise ValueError("a built-in mask has no --seed")
    else:
        given.update(seed=options.seed, progress=_progress(options.quiet))
    ranks = MASKS[method](shape, **given)
    channels = ranks.shape[0] if ranks.ndim > len(shape) else 1
    if channels > 4 and suffix != ".npy":
        raise ValueError(f"a {channels}-channel mask does not fit in {suffix}; write .npy")
    text = "".join(f", {name} {value}" for name, value in shown.items())
    description = f"bluenoise {__version__}: {method}, seed {options.seed}{text}"
    _files.save_mask(path, suffix, ranks, options.bits, description)
    lost = _files.merged_ranks(path, suffix, options.bits, math.prod(shape))
    if lost:
        _say(lost)
    if options.json:
        facts: dict[str, Any] = {"output": str(path), "format": suffix[1:], "size": list(reversed(shape))}
        if suffix == ".png":
            facts["bits"] = options.bits
        facts.update(channels=channels, method=method, seed=options.seed)
        facts["options"] = {
            name: str(value) if isinstance(value, Path) else value for name, value in shown.items()
        }
        _print(json.dumps(facts))


def _channels(options: argparse.Namespace) -> Any:
    """The channels of options.mask, or only the one that --channel selects."""
    values = _files.load_values(options.mask)
    if options.channel or values.ndim != 3:
        return _files.one_channel(options.mask, values, options.channel)[None]
    if len(values) > 1 and values.dtype.kind != "f" and arguments.is_permutation(values.reshape(-1)):
        raise ValueError(f"{options.mask} is a three-dimensional mask, {values.shape}; choose a slice with --channel")
    return values


def _measure(options: argparse.Namespace) -> None:
    values = _channels(options)
    progress = _progress(options.quiet)

    def share(channel: int) -> Optional[Callable[[float], None]]:
        return progress and (lambda fraction: progress((channel + fraction) / len(values)))

    with _files.about(options.mask):
        found = [measure_mask(plane, progress=share(channel)) for channel, plane in enumerate(values)]
    size = [values.shape[2], values.shape[1]]
    if options.json:
        channels = [asdict(figures) for figures in found]
        _print(json.dumps(_without_nan({**channels[0], "size": size} if len(found) == 1 else {"size": size, "channels": channels})))
        return
    _line("size", [f"{size[0]} x {size[1]}"])
    if len(found) > 1:
        _line("channel", [str(number) for number in range(1, len(found) + 1)])
    _line("each rank once", ["yes" if figures.exact else "no" for figures in found])
    _print("dithering error after a blur of")
    for sigma in found[0].dithering_error:
        _line(f"  {sigma:g} texels", [_number(figures.dithering_error[sigma], ".5f") for figures in found])
    _line("anisotropy", [_number(figures.anisotropy, ".2f", " dB") for figures in found])
    _print("low-frequency power, thresholded at a grey level (white noise has 1):")
    for level in found[0].low_frequency:
        _line(f"  grey {level:g}", [_number(figures.low_frequency[level], ".3f") for figures in found])


def _line(name: str, values: Sequence[str]) -> None:
    _print(f"{name:18s}" + "".join(f"{value:12s}" for value in values).rstrip())


def _number(value: float, spec: str, unit: str = "") -> str:
    return "none" if math.isnan(value) else format(value, spec) + unit


def _dither(options: argparse.Namespace) -> None:
    path = options.output
    suffix = ".png" if path == _files.STREAM else path.suffix.lower()
    palette = options.palette
    _files.check_output(path, suffix, _files.LOSSLESS, options.input, options.mask, palette if isinstance(palette, Path) else None)
    if options.mask is None and (options.rank or options.channel):
        raise ValueError(f"{'--rank' if options.rank else '--channel'} needs --mask")
    picture, chunks = _files.open_picture(options.input)
    if isinstance(picture, np.ndarray) and suffix != ".png":
        raise ValueError(f"an image with 16 bits per channel does not fit in {suffix}; write .png")
    palette = _files.open_picture(palette)[0] if isinstance(palette, Path) else palette
    if palette is not None and isinstance(picture, np.ndarray):
        raise ValueError(f"{options.input} has 16 bits per channel; --palette needs 8")
    greyed = suffix == ".pgm" and picture.mode in ("RGB", "P") and "transparency" not in picture.info
    if greyed:
        picture = picture.convert("L")
    ranks = None
    if options.mask is not None:
        planes = _files.without_constants(_channels(options))
        if len(planes) > 2 and (planes[:3] == planes[0]).all():  # a grey texture saved as RGB or RGBA
            planes = planes[:1]
        ranks = np.stack([_files.ranked(options.mask, plane, options.rank, "--rank") for plane in planes])
        ranks = ranks if len(ranks) > 1 else ranks[0]
    with _files.about(options.input):
        if isinstance(picture, np.ndarray):
            colour = _files.without_alpha(picture)
            colour[:] = dither(colour, options.levels, mask=ranks, srgb=options.srgb)
        else:
            picture = dither(picture, options.levels, palette=palette, mask=ranks, srgb=options.srgb)
    _files.save_picture(path, suffix, picture, chunks)
    if greyed:
        _say(f"{path} holds grey: the colours became their luminance")


def _density(path: Path) -> Any:
    """The numbers in a .npy file, or the grey values of an image."""
    if path.suffix.lower() == ".npy":
        return _files.load_values(path)
    picture, _ = _files.open_picture(path)
    return _files.without_alpha(picture).mean(-1) if isinstance(picture, np.ndarray) else np.asarray(picture.convert("L"))


def _points(options: argparse.Namespace) -> None:
    path, suffix = _output(options, _POINTS_SUFFIXES, options.mask, options.density)
    options.method = options.method or ("poisson-disk" if options.density else "best-candidate")
    given = _given(options, _POINTS_OPTIONS, POINTS_METHODS)
    if options.channel and "mask" not in given:
        raise ValueError("--channel needs --mask")
    if "mask" in given:
        values = _files.one_channel(options.mask, _files.load_values(options.mask), options.channel)
        given["mask"] = _files.ranked(options.mask, values, False, "load(..., rank=True)")
    if "density" not in given and (options.dark or options.count is None):
        raise ValueError("--dark needs --density" if options.dark else "points needs --count or --density")
    if "density" in given:
        density = _density(options.density)
        given["density"] = density.max() - density.astype(float) if options.dark else density
    make: Callable[..., Any] = make_points
    found = make(options.count, method=options.method, seed=options.seed, dims=options.dims, progress=_progress(options.quiet), **given)
    with _files.replacing(path, suffix) as beside:
        if suffix == ".npy":
            _files.save_array(beside, found)
        else:
            rows = "".join(",".join(map(repr, point)) + "\n" for point in found.tolist())
            beside.write_text("x,y,z"[: 2 * options.dims - 1] + "\n" + rows, encoding="ascii")
    if options.json:
        _print(json.dumps({"output": str(path), "format": suffix[1:], "count": len(found), "method": options.method,
                           "seed": options.seed}))


def _noise(options: argparse.Namespace) -> None:
    output = options.output
    suffix = output.suffix.lower() if output else ""
    if output:
        _files.check_output(output, suffix, (".png", ".npy"), options.first, options.second)
    first, second = _files.load_light(options.first), _files.load_light(options.second)
    if np.array_equal(first, second) and np.ptp(first) > 0:
        raise ValueError(f"{options.first} and {options.second} hold the same image; they must come from different samples")
    share = arguments.real("first_share", options.first_share, 0.001, 0.999)
    if options.mean and first.shape == second.shape:
        second = (second - share * first) / (1 - share)
    noise = visible_noise(first, second, sigma=options.sigma, exposure=options.exposure, first_share=share, window=options.window,
                          progress=_progress(options.quiet))
    median, high = (float(value) for value in np.percentile(noise, (50, 95)))
    if output:
        with _files.replacing(output, suffix) as beside:
            if suffix == ".npy":
                _files.save_array(beside, noise)
            else:
                beside.write_bytes(_files.png(false_colour(noise), []))
    if options.json:
        _print(json.dumps({"median": median, "percentile_95": high, "width": noise.shape[1], "height": noise.shape[0]}))
        return
    _print(f"visible noise: median {median:.2f}, 95% of the image below {high:.2f} steps of an 8-bit display")
    if suffix == ".png":
        _print("colours: " + ", ".join(f"{name} {steps:g}" for steps, (name, _) in COLOURS.items()) + " steps")


def _without_nan(value: Any) -> Any:
    if isinstance(value, dict):
        return {str(key): _without_nan(item) for key, item in value.items()}
    return None if isinstance(value, float) and math.isnan(value) else value
