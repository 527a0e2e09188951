# SPDX-License-Identifier: Apache-2.0
"""Runs the path tracer, and keeps references while nothing they depend on changes.

References take minutes: they are rendered in parts, so that an interrupted one resumes, and remain valid while their files are
unchanged and the path tracer gives the same bits for one sample in every pixel, so that changes to other samplers do not affect them.
"""

import dataclasses
import hashlib
import json
import os
import re
import signal
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from ..base.command import CommandError
from ..base.files import read_exr, sha256_of, write_exr, write_text
from ..measure.image_error import LUMINANCE, SIGMAS, rmse

# Shares no sample with the pictures, whatever their seed.
REFERENCE_SEED = 1_000_003
REFERENCE_PARTS = 32


class RenderError(CommandError):
    """The path tracer failed; the message is what it printed."""


def cache_folder():
    """The cache of references and results, which outlives a build: $XDG_CACHE_HOME/libbn, by default ~/.cache/libbn."""
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "libbn"


def run_pathtracer(program, arguments):
    """Returns its standard output. Raises RenderError with its error message if it fails."""
    try:
        done = subprocess.run([program, *map(str, arguments)], check=False, stdin=subprocess.DEVNULL,
                              capture_output=True, text=True)
    except OSError as error:
        raise RenderError(f"cannot run {program} ({error.strerror}); build it with scripts/setup") from None
    # Killed by the signal, or exited because of it: its output is incomplete.
    if done.returncode in (-signal.SIGINT, 128 + signal.SIGINT):
        raise KeyboardInterrupt
    if done.returncode != 0:
        raise RenderError(done.stderr.strip() or f"{program} failed with exit status {done.returncode}")
    return done.stdout


@dataclasses.dataclass(frozen=True)
class Request:
    """Everything that determines a picture."""

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
        """Everything that determines the picture, for a record, without unused options."""
        # A list, as records have it when they are read again.
        key = {**dataclasses.asdict(self), "more": list(self.more)}
        return {name: value for name, value in key.items() if value or name not in ("declared", "more")}


def progressive(program, request, counts, threads=None, read=read_exr):
    """Yields (spp, picture, attributes) for each of the ascending counts, as in one progressive run.

    Each sample is rendered once: pictures are means of the parts so far, in double precision. The attribute seconds is
    a sum over the parts. read(path) gives (array, attributes) of a part: the picture, or further layers too.
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


class Records:
    """What the pictures of a folder were made from, and what they are, in its renders.json."""

    def __init__(self, folder):
        self.folder, self.path = Path(folder), Path(folder) / "renders.json"
        try:
            self.found = json.loads(self.path.read_text(encoding="utf-8"))
        except (OSError, ValueError):
            self.found = {}  # missing or damaged: everything is rendered again

    def has(self, name, key):
        record, path = self.found.get(name, {}), self.folder / name
        return record.get("key") == key and path.is_file() and record.get("sha256") == sha256_of(path)

    def put(self, name, key):
        self.found[name] = {"key": key, "sha256": sha256_of(self.folder / name)}
        write_text(self.path, json.dumps(self.found, indent=1, sort_keys=True) + "\n")

    def delete(self, name):
        self.found.pop(name, None)
        for suffix in (".exr", ".png"):
            (self.folder / name).with_suffix(suffix).unlink(missing_ok=True)


def merge(paths, out):
    """Writes the mean of pictures of consecutive samples.

    Its attributes error0, error1 and so on estimate its own RMSE after each of SIGMAS, as half the difference of
    its two halves; its layer firstHalf is the mean of the first half (read_first_half). meanError is the standard
    error of its mean luminance, from the parts.
    """
    pictures, attributes = zip(*map(read_exr, paths))
    half = len(pictures) // 2
    first, second = (np.mean(group, axis=0, dtype=np.float64) for group in (pictures[:half], pictures[half:]))
    means = [float(np.mean(picture @ LUMINANCE)) for picture in pictures]
    kept = ("scene", "sampler", "seed", "firstSample", "maxDepth", "software", "version")
    write_exr(out, (first + second) / 2, {
        **{name: attributes[0][name] for name in kept if name in attributes[0]},
        **{f"error{i}": rmse(first, second, sigma) / 2 for i, sigma in enumerate(SIGMAS)},
        "meanError": float(np.std(means, ddof=1) / np.sqrt(len(means))), "spp": sum(a["spp"] for a in attributes),
        "seconds": float(sum(a["seconds"] for a in attributes))}, {"firstHalf": first})


def make_reference(program, request, folder, report=lambda fraction: None, name="", parts=0):
    """The path of a reference in a cache folder: merge() of renders of consecutive samples, so that an interrupted one resumes.
    report(fraction) is called after each."""
    records, name, parts = Records(folder), name or reference_name(request), parts or REFERENCE_PARTS
    if request.spp % parts or parts % 2:
        raise ValueError(f"{request.spp} samples cannot be split into {parts} equal parts in two halves")
    last_sample = dataclasses.replace(request, spp=1, first_sample=request.first_sample + request.spp - 1)
    (_, probe, _), = progressive(program, last_sample, [1])
    more = {"program": hashlib.sha256(probe.tobytes()).hexdigest()}
    key, path = {**request.key(), **more, "parts": parts}, records.folder / name
    if records.has(name, key):
        return path
    path.parent.mkdir(parents=True, exist_ok=True)
    names, step = [f"{path.stem}-part-{i:02d}.exr" for i in range(parts)], request.spp // parts
    for i, own in enumerate(names):
        report(i / parts)
        part = dataclasses.replace(request, spp=step, first_sample=request.first_sample + i * step)
        if not records.has(own, {**part.key(), **more}):
            run_pathtracer(program, [*part.arguments(), "--quiet", "-o", records.folder / own])
            records.put(own, {**part.key(), **more})
    merge([records.folder / own for own in names], path)
    records.put(name, key)
    for own in names:
        records.delete(own)
    report(1.0)
    return path


# ---- References in the cache

def scene_label(scene):
    """A name for files and headings: that of a built-in scene, or the file's."""
    return re.sub(r"[^A-Za-z0-9_.-]", "_", Path(scene).stem) or "scene"


def reference_name(request):
    """File name of the cached reference; a hash of the path distinguishes scene files of the same name."""
    scene = request.scene
    where = f"-{hashlib.sha256(str(Path(scene).resolve()).encode()).hexdigest()[:8]}" if Path(scene).exists() else ""
    more = f"-{hashlib.sha256(repr(request.more).encode()).hexdigest()[:8]}" if request.more else ""
    return (f"{scene_label(scene)}{where}{more}-{request.width}x{request.height}-{request.sampler}"
            f"-{request.spp}.exr")


def files_beside(scene):
    """Names, sizes and times of a scene's file and of every file in its folder, which the scene may refer to."""
    folder = Path(scene).parent
    if not Path(scene).is_file():
        return []
    stats = ((path.relative_to(folder).as_posix(), path.stat()) for path in sorted(folder.rglob("*")) if path.is_file())
    return [[name, stat.st_size, stat.st_mtime_ns] for name, stat in stats]
