# SPDX-License-Identifier: Apache-2.0
"""The judge of the samplers, rendered scenes: `scripts/bench renders` writes docs/report/renders.*

Renders every built-in scene with every sampler at 1 to 256 samples per pixel and several seeds, measures each
picture against a reference of at least 8192 samples, times progressive runs, and makes of it the tables of renders.md,
the plots, renders.csv, and renders.html with a slider that compares two pictures. References and measured rows are kept
in ~/.cache/libbn ($XDG_CACHE_HOME): an interrupted run goes on where it was, a second one takes seconds.
"""

import argparse
import dataclasses
import hashlib
import importlib.util
import json
import os
import shutil
import sys
import zipfile
import zlib
from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait
from pathlib import Path

import numpy as np

from . import renders_report, speed
from .convergence import make_reference, parse_size, positive
from .files import read_exr, sha256_of, written_beside
from .flip import FlipMissing, mean_flip
from .image_error import LUMINANCE, SIGMAS, luminance_error, radial_spectrum, rmse
from .progress import Progress, duration
from .renderer import RenderError, Request, cache_folder, progressive

DIRECT = ("cornell", "penumbra", "glossy", "lens")  # most light comes straight from a source
SCENES = (*DIRECT, "glass", "interior")
FURNACE_SPP = 64
REFERENCE_SEED, REFERENCE_SPP = 1_000_003, 8192
# Seeds of each count: pictures of few samples differ more, and cost less.
SEEDS = {1: 16, 2: 16, 4: 16, 8: 8, 16: 8, 32: 4, 64: 4, 128: 3, 256: 3}
MASK_COUNTS = tuple(spp for spp in SEEDS if spp <= 64)
FLIP_SEEDS = 3


@dataclasses.dataclass(frozen=True)
class Variant:
    """A sampler as it is used: declare says whether it is told each count, which makes a run of each."""

    sampler: str
    declare: bool = False
    mask: str = ""
    counts: tuple = tuple(SEEDS)


VARIANTS = {
    "white": Variant("white"),
    "sobol": Variant("sobol"),
    "zorder": Variant("zorder", declare=True),
    # A mask makes the first sample; from 4 samples on it is sobol, more or less.
    "mask": Variant("mask", counts=MASK_COUNTS),
    "mask, neural": Variant("mask", mask="neural", counts=MASK_COUNTS),
    "blue": Variant("blue"),
    # The counts for which libbn holds a set of its own.
    "blue, declared": Variant("blue", declare=True, counts=(1, 4, 16, 64)),
}


@dataclasses.dataclass(frozen=True)
class Task:
    """All pictures of one sampler and seed: a run that goes on, or one for each count."""

    scene: str
    label: str
    seed: int
    counts: tuple

    @property
    def variant(self):
        return VARIANTS[self.label]

    @property
    def cost(self):
        """Samples per pixel."""
        return sum(self.counts) if self.variant.declare else max(self.counts)


class Store:
    """Results of tasks, each in a file named after all that they depend on; those of other builds are dropped."""

    def __init__(self, folder, build):
        self.folder = folder / build
        if folder.is_dir():
            for other in folder.iterdir():
                if other.name != build and other.is_dir():
                    shutil.rmtree(other)

    def _path(self, key):
        text = json.dumps(key, sort_keys=True)
        return self.folder / (hashlib.sha256(text.encode()).hexdigest()[:32] + ".npz")

    def load(self, key):
        """(rows, {name: array}), or None."""
        try:
            with np.load(self._path(key)) as file:
                arrays = {name: file[name] for name in file.files}
            return json.loads(str(arrays.pop("rows"))), arrays
        except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile, zlib.error):
            return None  # not there, or not whole

    def save(self, key, rows, arrays):
        with written_beside(self._path(key)) as beside:
            np.savez(beside, rows=json.dumps(rows), **arrays)


def plan(scenes, labels, seeds, counts):
    tasks = []
    for scene in scenes:
        for label in labels:
            for seed in range(max(seeds.values())):
                own = tuple(n for n in counts if n in VARIANTS[label].counts and seed < seeds[n])
                if own:
                    tasks.append(Task(scene, label, seed, own))
    return tasks


def pictures_of(program, task, size):
    """Yields (spp, picture) for the counts of a task."""
    variant = task.variant
    request = Request(variant.sampler, 1, task.seed, task.scene, *size, mask=variant.mask)
    if variant.declare:
        for n in task.counts:
            for spp, picture, _ in progressive(program, dataclasses.replace(request, declared=n), [n], 1):
                yield spp, picture
    else:
        for spp, picture, _ in progressive(program, request, task.counts, 1):
            yield spp, picture


def measure(program, task, size, reference, want_flip):
    """(rows, pictures): a row for each count; pictures of the first seed alone."""
    rows, pictures = [], {}
    for spp, picture in pictures_of(program, task, size):
        rows.append({"spp": spp, "rmse": [rmse(picture, reference, sigma) for sigma in SIGMAS],
                     "flip": mean_flip(picture, reference) if want_flip else None,
                     "mean": float(np.mean(picture.astype(np.float64) @ LUMINANCE)),
                     "spectrum": radial_spectrum(luminance_error(picture, reference))[1].tolist()})
        if task.seed == 0:
            pictures[str(spp)] = picture
    return rows, pictures


def find_onnxruntime():
    """Tells the path tracer of the installed package onnxruntime, unless BN_ONNXRUNTIME is set. False if there is none."""
    if os.environ.get("BN_ONNXRUNTIME"):
        return True
    spec = importlib.util.find_spec("onnxruntime")
    found = sorted((Path(spec.origin).parent / "capi").glob("libonnxruntime.so*")) if spec and spec.origin else []
    if found:
        os.environ["BN_ONNXRUNTIME"] = str(found[0])
    return bool(found)


def render_references(options):
    """{scene: (path, picture, attributes)}."""
    folder = cache_folder() / "references"
    progress = Progress(len(options.scenes) * options.reference_spp)
    result = {}
    try:
        for i, scene in enumerate(options.scenes):
            request = Request("sobol", options.reference_spp, REFERENCE_SEED, scene, *options.size)
            path = make_reference(options.pathtracer, request, folder, lambda share, i=i, scene=scene: progress(
                f"reference of {scene}", (i + share) * options.reference_spp))
            result[scene] = (path, *read_exr(path))
    finally:
        progress.close()
    return result


def run_tasks(options, store, references, tasks):
    """{task: (rows, pictures)}, those found in the store and those made now."""
    sums = {scene: sha256_of(path) for scene, (path, _, _) in references.items()}
    keys = {task: {"task": dataclasses.astuple(task), "variant": dataclasses.astuple(task.variant),
                   "size": options.size, "reference": sums[task.scene], "flip": task.seed < FLIP_SEEDS} for task in tasks}
    results, left = {}, []
    for task in tasks:
        found = store.load(keys[task])
        if found:
            results[task] = found
        else:
            left.append(task)
    progress = Progress(sum(task.cost for task in tasks))
    done = sum(task.cost for task in results)
    progress("pictures", done, found=True)

    def make(task):
        rows, pictures = measure(options.pathtracer, task, options.size, references[task.scene][1], task.seed < FLIP_SEEDS)
        store.save(keys[task], rows, pictures)
        return rows, pictures

    # Long ones first, so that the processors end together.
    pool = ThreadPoolExecutor(options.jobs)
    try:
        running = {pool.submit(make, task): task for task in sorted(left, key=lambda task: -task.cost)}
        while running:
            for future in wait(running, return_when=FIRST_COMPLETED).done:
                task = running.pop(future)
                results[task] = future.result()
                done += task.cost
                progress(f"{task.scene}, {task.label}, seed {task.seed}", done, found=False)
    finally:
        # Those that have begun end, in seconds, and are kept.
        pool.shutdown(cancel_futures=True)
        progress.close()
    return results


def furnace(options, store):
    """Rows of the scene whose every pixel is known: {label, mean and worst pixel relative to what they should be}."""
    rows = []
    for label in options.samplers:
        if VARIANTS[label].declare and label != "zorder":
            continue
        task = Task("furnace", label, 0, (FURNACE_SPP,))
        key = {"furnace": dataclasses.astuple(task), "variant": dataclasses.astuple(task.variant), "size": options.size}
        found = store.load(key)
        if not found:
            (_, picture), = pictures_of(options.pathtracer, task, options.size)
            # Walls that glow with 1/2 and return 1/2, cut off after 8 bounces.
            share = picture.astype(np.float64) / (1 - 0.5**9) - 1
            found = [{"mean": float(share.mean()), "worst": float(np.abs(share).max())}], {}
            store.save(key, *found)
        rows.append({"sampler": label, **found[0][0]})
    return rows


class Cells:
    """What was measured, by scene, sampler and count: lists with a value for each seed."""

    def __init__(self, results):
        self.values, self.pictures = {}, {}
        for task, (rows, pictures) in sorted(results.items(), key=lambda item: item[0].seed):
            for row in rows:
                cell = self.values.setdefault((task.scene, task.label, row["spp"]), {
                    **{sigma: [] for sigma in SIGMAS}, "flip": [], "mean": [], "spectrum": []})
                for sigma, error in zip(SIGMAS, row["rmse"]):
                    cell[sigma].append(error)
                if row["flip"] is not None:
                    cell["flip"].append(row["flip"])
                cell["mean"].append(row["mean"])
                cell["spectrum"].append(row["spectrum"])
            for spp, picture in pictures.items():
                self.pictures[task.scene, task.label, int(spp)] = picture


def names(text, known, what):
    chosen = list(dict.fromkeys(name.strip() for name in text.split(";" if ";" in text else ",") if name.strip()))
    unknown = [name for name in chosen if name not in known]
    if unknown or not chosen:
        raise argparse.ArgumentTypeError(f"there is no {what} '{', '.join(unknown)}'; known are: {', '.join(known)}")
    return tuple(name for name in known if name in chosen)


# Names on the command line have no comma in them.
OPTION_NAMES = {name.replace(", ", "-"): name for name in VARIANTS}


def parse_options(arguments):
    parser = argparse.ArgumentParser(prog="scripts/bench renders", description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="48x48 pixels, up to 16 samples, 4 seeds, references of 1024")
    parser.add_argument("--size", type=parse_size, metavar="WxH", help="pixels of the pictures (default 192x192)")
    parser.add_argument("--scenes", type=lambda text: names(text, SCENES, "scene"), default=SCENES, metavar="A,B,...",
                        help=f"of {', '.join(SCENES)} (default all)")
    parser.add_argument("--samplers", type=lambda text: names(text, tuple(OPTION_NAMES), "sampler"),
                        default=tuple(OPTION_NAMES), metavar="A,B,...",
                        help=f"of {', '.join(OPTION_NAMES)} (default all); white and sobol are always there")
    parser.add_argument("--seeds", type=positive, metavar="N", help="at most N seeds of each picture (default 16 to 3)")
    parser.add_argument("--spp", type=positive, metavar="N", help="counts up to N (default 256)")
    parser.add_argument("--reference-spp", type=positive, metavar="N", help="a multiple of 32 (default 8192)")
    parser.add_argument("--jobs", type=positive, default=os.cpu_count() or 1, metavar="N",
                        help="pictures rendered at a time, one thread each (default: one per core)")
    parser.add_argument("--no-times", action="store_true", help="leave out what is timed; those need a quiet machine")
    parser.add_argument("--retime", action="store_true", help="time again what was timed before")
    parser.add_argument("--embree", metavar="PROGRAM", help="the path tracer of Embree's tools (default: looked for)")
    parser.add_argument("--out", type=Path, default=Path("docs/report"), help="folder (default docs/report)")
    parser.add_argument("--pathtracer", type=Path, default=Path("build/examples/pathtracer/pathtracer"),
                        help=argparse.SUPPRESS)
    options = parser.parse_args(arguments)
    options.samplers = tuple(label for name, label in OPTION_NAMES.items()
                             if name in options.samplers or label in ("white", "sobol"))
    options.command = "scripts/bench renders" + "".join(f" {word}" for word in arguments_that_count(arguments))
    options.size = options.size or ((48, 48) if options.quick else (192, 192))
    options.reference_spp = options.reference_spp or (1024 if options.quick else REFERENCE_SPP)
    if options.reference_spp % 32:
        parser.error(f"--reference-spp is a multiple of 32, not {options.reference_spp}")
    most = options.spp or (16 if options.quick else 256)
    limit = options.seeds or (4 if options.quick else max(SEEDS.values()))
    options.seeds = {spp: min(count, limit) for spp, count in SEEDS.items() if spp <= most}
    return options


def arguments_that_count(arguments):
    """The options for the command in the report: what is measured, not where."""
    result, skip = [], False
    for word in arguments:
        if skip:
            skip = False
        elif word in ("--out", "--pathtracer", "--jobs", "--embree"):
            skip = True
        elif not word.startswith(("--out=", "--pathtracer=", "--jobs=", "--embree=", "--retime")):
            result.append(word)
    return result


def run(arguments):
    options = parse_options(arguments)
    if not find_onnxruntime() and "mask, neural" in options.samplers:
        print("bench: ONNX Runtime is missing (pip install onnxruntime); masks by the network are left out",
              file=sys.stderr)
        options.samplers = tuple(label for label in options.samplers if label != "mask, neural")
    try:
        build = sha256_of(options.pathtracer)[:16]
    except OSError as error:
        raise RenderError(f"there is no path tracer {options.pathtracer} ({error.strerror}); "
                          "build it with scripts/setup") from None
    store = Store(cache_folder() / "renders", build)
    tasks = plan(options.scenes, options.samplers, options.seeds, tuple(options.seeds))
    if sys.stderr.isatty():
        print(f"{len(tasks)} runs of {sum(task.cost for task in tasks)} samples per pixel in all, and references of "
              f"{options.reference_spp}", file=sys.stderr)
    references = render_references(options)
    results = run_tasks(options, store, references, tasks)
    furnaces = furnace(options, store)
    times = None if options.no_times else speed.measure_all(options, store, references)
    report = renders_report.Report(options, Cells(results), references, furnaces, times)
    report.write(options.out)
    print(report.text())
    seconds = sum(float(attributes["seconds"]) for _, _, attributes in references.values())
    print(f"Written: {options.out}/renders.md, .csv, .html and plots. References took {duration(seconds)} once.")


def main(arguments=None):
    try:
        run(sys.argv[1:] if arguments is None else list(arguments))
    except (RenderError, FlipMissing) as error:
        sys.exit(f"bench: {error}")
    except OSError as error:
        sys.exit(f"bench: {error}")
    except KeyboardInterrupt:
        sys.exit("bench: interrupted; what is rendered is kept, run it again to go on")


if __name__ == "__main__":
    main()
