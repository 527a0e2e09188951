# SPDX-License-Identifier: Apache-2.0
"""Renders through the path tracer that are made once and kept while nothing they depend on has changed.

A file is valid while its record in renders.json names the same request (options and the SHA-256 of the path
tracer, which holds libbn) and the file has the bytes that were written then. References take minutes: they are
rendered in parts, so that an interrupted one goes on where it was, and are valid while the path tracer still
gives the same bits for one sample in every pixel, so that a change of another sampler leaves them alone.
"""

import dataclasses
import hashlib
import json
import signal
import subprocess
from pathlib import Path

import numpy as np

from .files import read_exr, sha256_of, write_exr, write_text


class RenderError(Exception):
    """The path tracer failed; the message is its own line."""


@dataclasses.dataclass(frozen=True)
class Request:
    """What decides a picture."""

    sampler: str
    spp: int
    seed: int = 0
    scene: str = "cornell"
    width: int = 256
    height: int = 256
    first_sample: int = 0
    exposure: float = 0.0  # stops, of the preview only

    def arguments(self):
        return ["--scene", self.scene, "--sampler", self.sampler, "--spp", str(self.spp),
                "--seed", str(self.seed), "--size", f"{self.width}x{self.height}",
                "--first-sample", str(self.first_sample), "--exposure", str(self.exposure)]


class Renderer:
    """Renders into one folder, which it keeps the records of."""

    def __init__(self, program, folder):
        self.program = Path(program)
        self.folder = Path(folder)
        self._program_sha256 = sha256_of(self.program)
        self._records_path = self.folder / "renders.json"
        try:
            self._records = json.loads(self._records_path.read_text(encoding="utf-8"))
        except (OSError, ValueError):
            self._records = {}  # none yet, or not ours: everything is rendered again

    def _key(self, request, **more):
        return {"program": self._program_sha256, **dataclasses.asdict(request), **more}

    def _valid(self, path, key):
        record = self._records.get(str(path.relative_to(self.folder)), {})
        return record.get("key") == key and path.is_file() and record.get("sha256") == sha256_of(path)

    def _record(self, path, key):
        self._records[str(path.relative_to(self.folder))] = {"key": key, "sha256": sha256_of(path)}
        write_text(self._records_path, json.dumps(self._records, indent=1, sort_keys=True) + "\n")

    def render(self, request, name):
        """The path of the EXR `name`; a preview PNG lies beside it. Rendered unless it is there already."""
        path, key = self.folder / name, self._key(request)
        if not self._valid(path, key) or not path.with_suffix(".png").is_file():
            path.parent.mkdir(parents=True, exist_ok=True)
            done = subprocess.run([self.program, *request.arguments(), "--quiet", "-o", path], check=False,
                                  stdin=subprocess.DEVNULL, capture_output=True, text=True)
            if done.returncode in (-signal.SIGINT, 128 + signal.SIGINT):  # what it left is not recorded
                raise KeyboardInterrupt
            if done.returncode != 0:
                raise RenderError(done.stderr.strip() or f"{self.program} ended with {done.returncode}")
            self._record(path, key)
        return path

    def reference(self, request, name, part_count=64, report=lambda fraction: None):
        """The path of a reference EXR: the mean of `part_count` renders of consecutive samples.

        Its attributes error0, error1 and so on estimate its own RMSE after each of SIGMAS: half of what its
        two halves differ by. report(fraction) is called as parts are done.
        """
        if request.spp % part_count or part_count % 2:
            raise ValueError(f"{request.spp} samples do not divide into {part_count} equal parts in two halves")
        path = self.folder / name
        last_sample = dataclasses.replace(request, spp=1, first_sample=request.first_sample + request.spp - 1)
        probe, _ = read_exr(self.render(last_sample, f"{path.stem}-probe.exr"))
        key = self._key(request, parts=part_count, program=hashlib.sha256(probe.tobytes()).hexdigest())
        if self._valid(path, key):
            return path
        part_spp = request.spp // part_count
        parts = []
        for i in range(part_count):
            report(i / part_count)
            part = dataclasses.replace(request, spp=part_spp, first_sample=request.first_sample + i * part_spp)
            parts.append(self.render(part, f"{path.stem}-part-{i:02d}.exr"))
        self._merge(parts, path)
        self._record(path, key)
        for part in parts:
            self._records.pop(part.name, None)
            part.unlink()
            part.with_suffix(".png").unlink(missing_ok=True)
        report(1.0)
        return path

    def _merge(self, parts, path):
        from .image_error import SIGMAS, rmse

        pictures, attributes = zip(*(read_exr(part) for part in parts))
        half = len(pictures) // 2
        first, second = (np.mean(group, axis=0, dtype=np.float64)
                         for group in (pictures[:half], pictures[half:]))
        own_error = {f"error{i}": rmse(first, second, sigma) / 2 for i, sigma in enumerate(SIGMAS)}
        kept = ("scene", "sampler", "seed", "firstSample", "maxDepth", "software", "version")
        write_exr(path, (first + second) / 2, {
            **{name: attributes[0][name] for name in kept if name in attributes[0]}, **own_error,
            "spp": sum(a["spp"] for a in attributes),
            "seconds": float(sum(a["seconds"] for a in attributes))})
