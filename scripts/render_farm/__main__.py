# SPDX-License-Identifier: Apache-2.0
"""The command line of scripts/farm: splits an image into parts, renders them on workers, and merges them."""

import argparse
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from evidence.base.command import parse_size, positive

from . import cluster, worker
from .parts import FarmError, Part, PartsFolder, names_of, split

# Options of the path tracer that do not apply to a part.
REFUSED = ("--merge", "--resume", "--noise", "--visible-noise", "--min-spp", "--list", "--list-cameras", "--list-inputs")
MAX_PARTS = 20000  # their file names fit on a command line
MAX_PIXELS = 1 << 26  # of the path tracer


def region(text):
    match = re.fullmatch(r"(\d{1,5}),(\d{1,5}),(\d{1,5}),(\d{1,5})", text)
    if not match:
        raise argparse.ArgumentTypeError(f"takes x0,y0,x1,y1, not '{text}'")
    return tuple(map(int, match.groups()))


def file_or_name(text):
    """Workers and the merging program run in other folders."""
    return os.path.abspath(text) if Path(text).is_file() else text


class Parser(argparse.ArgumentParser):
    def error(self, message):
        raise FarmError(f"{message}; see scripts/farm --help")


def parse(arguments):
    parser = Parser(
        prog="farm", usage="scripts/farm [options] [options of the path tracer] -o out.exr", allow_abbrev=False,
        description="Renders one image on the workers of a Dask cluster, by default a local one, and merges the parts. All "
        "other options go to the path tracer (pathtracer --help). The first run installs Dask (scripts/requirements-farm.txt) "
        "into .venv.",
        epilog="Finished parts are kept in out.exr.parts until the image is complete. To resume after an interruption, run the "
        "same command again.")
    add = parser.add_argument
    add("--scheduler", metavar="ADDRESS", help="the scheduler of a running cluster, for example tcp://10.0.0.1:8786; every worker "
        "needs this build of the path tracer (see examples/pathtracer/README.md)")
    add("--workers", type=positive, metavar="N", help="local workers (default: one per core)")
    add("--threads", type=positive, default=1, metavar="N", help="threads per task (default 1)")
    add("--tile", type=parse_size, default=(128, 128), metavar="WxH", help="maximum size of a task in pixels (default 128x128)")
    add("--spp", type=positive, default=16, metavar="N", help="samples per pixel (default 16)")
    add("--first-sample", type=int, default=0, metavar="N", help="index of the first sample of each pixel (default 0); in a film, "
        "the frame number times a power of two that is at least --spp")
    add("--size", type=parse_size, default=(512, 512), metavar="WxH", help="size of the image in pixels (default 512x512)")
    add("--crop", type=region, metavar="x0,y0,x1,y1", help="render only this region")
    add("--scene", type=file_or_name, metavar="NAME|FILE", help="the scene (default cornell)")
    add("--env", type=file_or_name, metavar="FILE", help="the environment")
    add("--exposure", metavar="EV|auto", help="exposure of the preview")
    add("--quiet", action="store_true", help="print only errors and warnings")
    add("-o", dest="output", type=Path, required=True, metavar="out.exr", help="the image; a preview is written to out.png beside it")
    add("--pathtracer", type=Path, default=Path("build/examples/pathtracer/pathtracer"), help=argparse.SUPPRESS)
    options, others = parser.parse_known_args(arguments)
    if options.output.suffix != ".exr":
        parser.error(f"-o takes something.exr, not '{options.output}'")
    if options.scheduler and options.workers:
        parser.error("--workers is for a cluster on this machine; leave it or --scheduler out")
    for name in REFUSED:
        if name in others:
            parser.error(f"{name} does not work in parts; leave it out")
    x0, y0, x1, y1 = options.crop = options.crop or (0, 0, *options.size)
    if x1 > options.size[0] or y1 > options.size[1]:
        parser.error(f"--crop extends beyond the image of {options.size[0]}x{options.size[1]} pixels; set --size")
    if (x1 - x0) * (y1 - y0) > MAX_PIXELS:
        parser.error(f"at most {MAX_PIXELS} pixels are merged; render regions with --crop")
    files = [word for name in ("scene", "env") if (value := vars(options)[name]) for word in (f"--{name}", value)]
    options.shared = [*files, *others, "--size", "{}x{}".format(*options.size)]
    options.merging = ["--exposure", options.exposure] if options.exposure else []
    return options


def run_pathtracer(program, arguments, folder=None):
    try:
        done = subprocess.run([program, *arguments], cwd=folder, stdin=subprocess.DEVNULL, capture_output=True, text=True,
                              errors="surrogateescape", check=False)
    except OSError as error:
        raise FarmError(f"cannot run {program} ({error.strerror}); build it with scripts/setup") from None
    if done.returncode in (128 + signal.SIGINT, -signal.SIGINT):
        raise KeyboardInterrupt
    if done.returncode:
        # The last line is the error; the lines before it are notes on the scene.
        said = done.stderr.strip().rpartition("\n")[2].removeprefix("pathtracer: ")
        raise FarmError(said or f"{program} failed with {done.returncode}")
    return done


def render_parts(options, program, inputs, folder, parts, found):
    """Renders the parts that are missing in the folder. Returns the number of samples rendered."""
    from evidence.base.progress import Progress  # needs packages that set-up installs

    tasks = {part: [*options.shared, *part.arguments(), "--threads", str(options.threads)] for part in parts if not folder.has(part)}
    total, missing = (sum(part.samples for part in some) for some in (parts, tasks))
    done, left = total - missing, len(tasks)
    with cluster.connect(options.scheduler, options.workers, options.threads) as client:
        cluster.check_workers(client, program, found, inputs)
        with Progress(total, "samples", done) as progress:
            for part, data in cluster.render(client, program, found, inputs, tasks):
                if isinstance(part, str):
                    if not options.quiet:
                        progress.write(f"farm: worker {part} is gone; what it had is rendered elsewhere", sys.stderr)
                elif part is not None:
                    folder.add(part, data)
                    left -= 1
                    done += part.samples
                    progress(f"{len(parts) - left} of {len(parts)} parts", done)
                elif not cluster.workers(client):
                    progress("waiting for workers", done)
    return missing


def run(arguments):
    options = parse(arguments)
    program, output = os.path.abspath(options.pathtracer), Path(os.path.abspath(options.output))
    shared, merging = options.shared, options.merging
    # The path tracer checks all options before a worker sees them: first each value, then the last sample of one pixel.
    whole = Part(*options.crop, options.first_sample, options.spp)
    done = run_pathtracer(program, [*shared, *whole.arguments(), "--list-inputs"])
    for line in done.stderr.splitlines():
        print(f"farm: {plain(line.removeprefix('pathtracer: '))}", file=sys.stderr)
    listed = done.stdout
    inputs = names_of(listed)
    # Compare it with the inputs here, because the merging program does not know them.
    for file in (output, output.with_suffix(".png")):
        if file.is_dir():
            raise FarmError(f"{file} is a folder; choose another output")
        if any(file.exists() and os.path.samefile(file, other) for other in inputs):
            raise FarmError(f"{file} is also an input; choose another output")
    parts = split(options.crop, options.first_sample, options.spp, options.tile)
    if len(parts) > MAX_PARTS:
        raise FarmError(f"{len(parts)} tasks are more than {MAX_PARTS}; set a larger --tile")
    x0, y0 = options.crop[:2]
    last = Part(x0, y0, x0 + 1, y0 + 1, options.first_sample + options.spp - 1, 1)
    with tempfile.TemporaryDirectory(prefix="libbn-") as folder:
        run_pathtracer(program, [*shared, *merging, *last.arguments(), "-o", os.path.join(folder, "probe.exr")])
    found = worker.fingerprint(program, inputs)
    output.parent.mkdir(parents=True, exist_ok=True)
    folder = PartsFolder(output, {"arguments": shared, "files": found, "inputs": listed, "crop": options.crop, "tile": options.tile,
                                  "samples": [options.first_sample, options.spp]})
    kept = folder.count(parts)
    if kept and not options.quiet:
        print(f"farm: {kept} of {len(parts)} parts are in {folder.path}", flush=True)
    begun = time.monotonic()
    try:
        made = render_parts(options, program, inputs, folder, parts, found) / 1e6 if kept < len(parts) else 0
        seconds = time.monotonic() - begun
        try:
            done = run_pathtracer(program, [*(["--quiet"] if options.quiet else []), *merging, "-o", output,
                                            "--merge", *(part.file_name for part in parts)], folder.path)
        except FarmError as error:
            raise FarmError(f"{error}; the parts are kept in {folder.path}; if one is damaged, remove it; then try again") from None
    except KeyboardInterrupt:
        if kept := folder.count(parts):
            raise KeyboardInterrupt(f"{kept} of {len(parts)} parts are kept in {folder.path}; the same command goes on") from None
        raise
    finally:
        if not folder.count(parts):
            folder.remove(parts)
    folder.remove(parts)
    sys.stderr.write(done.stderr)
    sys.stdout.write(done.stdout)
    if made and not options.quiet:
        print(f"farm: {made:.3g} million samples in {seconds:.1f} s, {made / seconds:.3g} million a second")


def plain(text):
    """Makes text printable: file names may contain line breaks and terminal sequences."""
    return re.sub(r"[\x00-\x1f\x7f-\x9f]", "?", str(text))


def main():
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        run(sys.argv[1:])
    except KeyboardInterrupt as stop:
        print("farm: interrupted;", plain(stop) or "nothing was rendered", file=sys.stderr)
        return 130
    except (FarmError, worker.WorkerError) as error:
        print("farm:", plain(error), file=sys.stderr)
    except OSError as error:
        where = f"{error.filename}: " if error.filename else ""
        print("farm:", plain(f"{where}{error.strerror or error}"), file=sys.stderr)
    else:
        return 0
    return 1


if __name__ == "__main__":
    sys.exit(main())
