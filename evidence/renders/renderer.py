# SPDX-License-Identifier: Apache-2.0
"""Runs the path tracer, and caches references until something they depend on changes.

Rendering a reference takes minutes. It remains valid as long as one sample in every pixel is bit-identical, so changes to other samplers do
not affect it.
"""

import dataclasses
import hashlib
import os
import re
import signal
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from ..base.cache import Store, cache_folder
from ..base.command import CommandError
from ..base.files import read_exr
from ..measure.image_error import LUMINANCE

# References share no samples with the images, whatever their seed.
REFERENCE_SEED = 1_000_003
REFERENCE_PARTS = 32


class RenderError(CommandError):
    """The path tracer failed. The message is its error output."""


def notes_of(program, arguments):
    """The path tracer's lines about what it ignores in a scene file."""
    done = subprocess.run([program, *map(str, arguments), "--list-inputs"], check=False, stdin=subprocess.DEVNULL, capture_output=True, text=True)
    if done.returncode != 0:
        raise RenderError(done.stderr.strip())
    return [line.removeprefix("pathtracer: ") for line in done.stderr.splitlines()]


def run_pathtracer(program, arguments):
    """Runs the path tracer and returns its standard output. Raises RenderError with its error message if it fails."""
    try:
        done = subprocess.run([program, *map(str, arguments)], check=False, stdin=subprocess.DEVNULL,
                              capture_output=True, text=True)
    except OSError as error:
        raise RenderError(f"cannot run {program} ({error.strerror}); build it with scripts/setup") from None
    # The program was killed by the signal or exited because of it, so its output is incomplete.
    if done.returncode in (-signal.SIGINT, 128 + signal.SIGINT):
        raise KeyboardInterrupt
    if done.returncode != 0:
        raise RenderError(done.stderr.strip() or f"{program} failed with exit status {done.returncode}")
    return done.stdout


def processor_seconds(command, what, environment=None):
    """Runs a program and returns its CPU seconds. RenderError contains the last line that the program wrote."""
    with tempfile.TemporaryFile() as log:
        try:
            process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=log, stderr=log, env=environment)
        except OSError as error:
            raise RenderError(f"cannot run {command[0]} ({error.strerror})") from None
        _, process.returncode, used = os.wait4(process.pid, 0)
        if status := process.returncode:
            log.seek(0)
            said = log.read().decode(errors="replace").strip().splitlines()
            raise RenderError(f"{what}: {said[-1] if said else f'status {status}'}")
    return used.ru_utime + used.ru_stime


@dataclasses.dataclass(frozen=True)
class Request:
    """Everything that determines an image."""

    sampler: str
    spp: int
    seed: int = 0
    scene: str = "cornell"
    width: int = 256
    height: int = 256
    first_sample: int = 0
    exposure: float | str = 0.0  # of the preview, in stops, or "auto"
    declared: int = 0  # sample count passed to the sampler; 0: none
    more: tuple = ()  # further options of the path tracer

    def arguments(self):
        return ["--scene", self.scene, "--sampler", self.sampler, "--spp", str(self.spp),
                "--seed", str(self.seed), "--size", f"{self.width}x{self.height}",
                "--first-sample", str(self.first_sample), "--exposure", str(self.exposure),
                *(["--declare", str(self.declared)] if self.declared else []),
                *self.more]

    def key(self):
        """Everything that determines the image, without unused options, as a cache key."""
        key = dataclasses.asdict(self)
        return {name: value for name, value in key.items() if value or name not in ("declared", "more")}


def progressive(program, request, counts, threads=None, read=read_exr):
    """Yields (spp, image, attributes) for each of the ascending sample counts, as in one progressive run.

    Each sample is rendered once: images are double-precision means of the parts rendered so far. The attribute seconds is
    summed over the parts. read(path) returns (array, attributes) of a part: the image, optionally with further layers.
    """
    total, first, seconds = 0.0, 0, 0.0
    with tempfile.TemporaryDirectory(prefix="libbn-") as folder:
        for spp in counts:
            part = dataclasses.replace(request, spp=spp - first, first_sample=request.first_sample + first)
            path = Path(folder) / "part.exr"
            run_pathtracer(program, [*part.arguments(), *(["--threads", threads] if threads else []), "--quiet",
                                     "-o", path])
            picture, attributes = read(path)
            total = total + picture.astype(np.float64) * (spp - first)
            first, seconds = spp, seconds + float(attributes["seconds"])
            yield spp, (total / spp).astype(np.float32), {**attributes, "seconds": seconds, "spp": spp}


def make_reference(program, request, report=lambda fraction: None):
    """(image, mean of the first half of its samples, {"seconds", "mean_error": standard error of the mean luminance}), from the cache
    or averaged over renders of consecutive samples. Calls report(fraction) before each render."""
    store, step = Store(cache_folder() / "references"), request.spp // REFERENCE_PARTS
    last_sample = dataclasses.replace(request, spp=1, first_sample=request.spp - 1)
    (_, probe, _), = progressive(program, last_sample, [1])
    key = {**request.key(), "program": hashlib.sha256(probe.tobytes()).hexdigest(), "parts": REFERENCE_PARTS}

    def whole():
        pictures, seconds = [], 0.0
        for i in range(REFERENCE_PARTS):
            report(i / REFERENCE_PARTS)
            (_, picture, attributes), = progressive(program, dataclasses.replace(request, spp=step, first_sample=i * step), [step])
            pictures.append(picture)
            seconds += attributes["seconds"]
        first, second = (np.mean(half, 0, np.float64) for half in (pictures[:REFERENCE_PARTS // 2], pictures[REFERENCE_PARTS // 2:]))
        error = np.std([np.mean(picture @ LUMINANCE) for picture in pictures], ddof=1) / np.sqrt(REFERENCE_PARTS)
        return {"seconds": seconds, "mean_error": float(error)}, {"picture": np.float32((first + second) / 2), "first_half": np.float32(first)}

    row, arrays = store.get(key, whole)
    return arrays["picture"], arrays["first_half"], row


def scene_label(scene):
    """A name for files and headings: the name of a built-in scene, or of the file."""
    return re.sub(r"[^A-Za-z0-9_.-]", "_", Path(scene).stem) or "scene"


def files_beside(scene):
    """Names, sizes and times of a scene file and of every other file in its folder, because the scene may refer to them."""
    folder = Path(scene).parent
    if not Path(scene).is_file():
        return []
    stats = ((path.relative_to(folder).as_posix(), path.stat()) for path in sorted(folder.rglob("*")) if path.is_file())
    return [[name, stat.st_size, stat.st_mtime_ns] for name, stat in stats]
