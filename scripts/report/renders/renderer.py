# SPDX-License-Identifier: Apache-2.0
"""Runs the path tracer and caches its pictures while nothing they depend on changes.

A file is valid if its record in renders.json names the same request (options and the SHA-256 of the path tracer, which
contains libbn) and its contents are unchanged. References take minutes: they are rendered in parts, so that an
interrupted one resumes, and remain valid while the path tracer gives the same bits for one sample in every pixel, so
that changes to other samplers do not affect them.
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

    Each sample is rendered once: pictures are means of the parts so far, in double precision. The attributes seconds and
    rays are sums over the parts. read(path) gives (array, attributes) of a part: the picture, or further layers too.
    """
    total, first, sums = 0.0, 0, {"seconds": 0.0, "rays": 0}
    with tempfile.TemporaryDirectory(prefix="libbn-") as folder:
        for spp in counts:
            part = dataclasses.replace(request, spp=spp - first, first_sample=request.first_sample + first)
            path = Path(folder) / "part.exr"
            run_pathtracer(program, [*part.arguments(), *(["--threads", threads] if threads else []), "--quiet",
                                     "-o", path])
            picture, attributes = read(path)
            total = total + picture.astype(np.float64) * (spp - first)
            first = spp
            sums = {"seconds": sums["seconds"] + float(attributes["seconds"]),
                    "rays": sums["rays"] + int(attributes["rays"])}
            yield spp, (total / spp).astype(np.float32), {**attributes, **sums, "spp": spp}


class Renderer:
    """Renders into one folder and keeps its records."""

    def __init__(self, program, folder):
        self.program = Path(program)
        self.folder = Path(folder)
        try:
            self._program_sha256 = sha256_of(self.program)
        except OSError as error:
            raise RenderError(f"cannot read the path tracer {program} ({error.strerror}); "
                              "build it with scripts/setup") from None
        self._records_path = self.folder / "renders.json"
        try:
            self._records = json.loads(self._records_path.read_text(encoding="utf-8"))
        except (OSError, ValueError):
            self._records = {}  # missing or damaged: everything is rendered again

    def _key(self, request, **more):
        return {"program": self._program_sha256, **request.key(), **more}

    def _valid(self, path, key):
        record = self._records.get(str(path.relative_to(self.folder)), {})
        return record.get("key") == key and path.is_file() and record.get("sha256") == sha256_of(path)

    def _record(self, path, key):
        self._records[str(path.relative_to(self.folder))] = {"key": key, "sha256": sha256_of(path)}
        write_text(self._records_path, json.dumps(self._records, indent=1, sort_keys=True) + "\n")

    def render(self, request, name, **more):
        """The path of the EXR `name`, with a preview PNG beside it, rendered unless it is valid already.

        more: further conditions for validity, besides the request and the program.
        """
        path, key = self.folder / name, self._key(request, **more)
        if not self._valid(path, key) or not path.with_suffix(".png").is_file():
            path.parent.mkdir(parents=True, exist_ok=True)
            run_pathtracer(self.program, [*request.arguments(), "--quiet", "-o", path])
            self._record(path, key)
        return path

    def reference(self, request, name, part_count=64, report=lambda fraction: None):
        """The path of a reference EXR: the mean of `part_count` renders of consecutive samples.

        Its attributes error0, error1 and so on estimate its own RMSE after each of SIGMAS, as half the difference of
        its two halves; its layer firstHalf is the mean of the first half (read_first_half). meanError is the standard
        error of its mean luminance, from the parts. report(fraction) is called after each part.
        """
        if request.spp % part_count or part_count % 2:
            raise ValueError(f"{request.spp} samples cannot be split into {part_count} equal parts in two halves")
        path = self.folder / name
        last_sample = dataclasses.replace(request, spp=1, first_sample=request.first_sample + request.spp - 1)
        # The path tracer may be unchanged while the scene's files are not.
        probe_name = f"{path.stem}-probe.exr"
        if Path(request.scene).exists():
            self._records.pop(probe_name, None)
        probe = hashlib.sha256(read_exr(self.render(last_sample, probe_name))[0].tobytes()).hexdigest()
        key = self._key(request, parts=part_count, program=probe)
        if self._valid(path, key):
            return path
        part_spp = request.spp // part_count
        parts = []
        for i in range(part_count):
            report(i / part_count)
            part = dataclasses.replace(request, spp=part_spp, first_sample=request.first_sample + i * part_spp)
            parts.append(self.render(part, f"{path.stem}-part-{i:02d}.exr", program=probe))
        self._merge(parts, path)
        self._record(path, key)
        for part in parts:
            self._records.pop(part.name, None)
            part.unlink()
            part.with_suffix(".png").unlink(missing_ok=True)
        report(1.0)
        return path

    def _merge(self, parts, path):
        pictures, attributes = zip(*(read_exr(part) for part in parts))
        half = len(pictures) // 2
        first, second = (np.mean(group, axis=0, dtype=np.float64)
                         for group in (pictures[:half], pictures[half:]))
        own_error = {f"error{i}": rmse(first, second, sigma) / 2 for i, sigma in enumerate(SIGMAS)}
        means = [float(np.mean(picture @ LUMINANCE)) for picture in pictures]
        own_error["meanError"] = float(np.std(means, ddof=1) / np.sqrt(len(means)))
        kept = ("scene", "sampler", "seed", "firstSample", "maxDepth", "software", "version")
        write_exr(path, (first + second) / 2, {
            **{name: attributes[0][name] for name in kept if name in attributes[0]}, **own_error,
            "spp": sum(a["spp"] for a in attributes),
            "seconds": float(sum(a["seconds"] for a in attributes))}, {"firstHalf": first})


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


def make_reference(program, request, folder, report=lambda fraction: None):
    """The path of the reference for the scene, size and options of this request, in a cache folder."""
    return Renderer(program, folder).reference(request, reference_name(request), REFERENCE_PARTS, report)


def files_beside(scene):
    """Names, sizes and times of a scene's file and of every file in its folder, which the scene may refer to."""
    folder = Path(scene).parent
    if not Path(scene).is_file():
        return []
    stats = ((path.relative_to(folder).as_posix(), path.stat()) for path in sorted(folder.rglob("*")) if path.is_file())
    return [[name, stat.st_size, stat.st_mtime_ns] for name, stat in stats]
