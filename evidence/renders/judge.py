# SPDX-License-Identifier: Apache-2.0
"""Renders many views with many samplers and measures each against its reference, for `scripts/bench renders`.

Results are cached under everything they depend on: the view, the pixels of the reference, and the path tracer.
"""

import dataclasses
import hashlib
import sys
from pathlib import Path

import numpy as np

from ..base.cache import Store, cache_folder
from ..base.files import read_exr
from ..base.progress import Progress, in_parallel
from ..measure.image_error import LUMINANCE, all_errors, own_errors
from ..samplers import variants
from .renderer import REFERENCE_SEED, RenderError, files_beside, make_reference, progressive
from .views import View

COUNTS = (1, 2, 3, 4, 6, 8, 16, 32, 64)


@dataclasses.dataclass(frozen=True)
class Reference:
    """A converged image, and its own error for each measure."""

    picture: np.ndarray
    own: dict
    spp: int
    seconds: float
    exposure: float = 0.0  # in stops
    mean_error: float = 0.0  # standard error of the mean luminance
    first_half: np.ndarray | None = None  # the mean of the first half of the samples

    def key(self):
        return hashlib.sha256(self.picture.tobytes()).hexdigest()


@dataclasses.dataclass(frozen=True)
class Task:
    """All images of one view, sampler and seed: one progressive run, or one run per sample count."""

    view: View
    label: str
    seed: int
    counts: tuple
    keep_pictures: bool = False

    @property
    def cost(self):
        """The number of samples to render."""
        return self.view.pixels * (sum(self.counts) if variants.is_tuned(self.label) else max(self.counts))


def plan(views, labels, counts, seeds):
    return [Task(view, label, seed, tuple(counts)) for view in views for label in labels for seed in range(seeds)]


def render_reference(program, view, spp, report=lambda share: None):
    """The Reference of a view, read from the cache or rendered now. spp must be a multiple of 32."""
    request = dataclasses.replace(view, lights=()).request("sobol", spp, REFERENCE_SEED)
    picture, first_half, row = make_reference(program, request, report)
    own = own_errors(picture, first_half, view.exposure)
    return Reference(picture, own, spp, row["seconds"], view.exposure, row["mean_error"], first_half)


def render_references(program, views, spp):
    """{view: Reference}."""
    total = sum(view.pixels for view in views)
    done, result = 0, {}
    with Progress(total * spp, "samples") as progress:
        for view in views:
            result[view] = render_reference(program, view, spp, lambda share, view=view, done=done: progress(
                f"reference of {view.label}", (done + share * view.pixels) * spp))
            done += view.pixels
    return result


def pictures_of(program, task, read=read_exr):
    """Yields (spp, picture, attributes) for each sample count of a task."""
    for counts in ([n] for n in task.counts) if variants.is_tuned(task.label) else [task.counts]:
        yield from progressive(program, task.view.request(task.label, counts[-1], task.seed), counts, 1, read)


def measure(program, task, reference):
    """One row of figures per sample count."""
    rows = []
    for spp, picture, _ in pictures_of(program, task):
        rows.append({"spp": spp, **all_errors(picture, reference.picture, reference.exposure),
                     "mean": float(np.mean(picture.astype(np.float64) @ LUMINANCE))})
    return rows


class Run:
    """Runs a set of tasks, or loads their results from the cache."""

    def __init__(self, program, folder, jobs):
        self.program, self.jobs = program, jobs
        self.store = Store(cache_folder() / folder)
        try:
            self.sha256 = hashlib.sha256(Path(program).read_bytes()).hexdigest()
        except OSError as error:
            raise RenderError(f"cannot read {program} ({error.strerror}); build it with scripts/setup") from None

    def key(self, task, reference):
        return {"view": task.view.key, "files": files_beside(task.view.file), "sampler": task.label, "program": self.sha256, "seed": task.seed,
                "counts": task.counts, "exposure": reference.exposure, "pictures": task.keep_pictures,
                **({"plugin": variants.PLUGINS[task.label].key()} if task.label in variants.PLUGINS else {})}

    def measure(self, task, reference):
        """(rows, pictures) of a task. A subclass that measures differently also extends key()."""
        return measure(self.program, task, reference), {}

    def results(self, references, tasks):
        """{task: (rows, pictures)}."""
        sums = {view: reference.key() for view, reference in references.items()}
        keys = {task: {**self.key(task, references[task.view]), "reference": sums[task.view]} for task in tasks}
        results = {task: found for task in tasks if (found := self.store.load(keys[task]))}
        left = [task for task in tasks if task not in results]
        total, done = (sum(task.cost for task in own) for own in (tasks, results))
        if left:
            print(f"{len(tasks)} runs, {total / 1e6:.0f} million samples; {len(left)} left to render", file=sys.stderr)

        def make(task):
            found = self.measure(task, references[task.view])
            self.store.save(keys[task], *found)
            return found

        with Progress(total, "samples", done) as progress:
            # Long tasks go first, so that all cores finish at about the same time.
            for task, found in in_parallel(self.jobs, make, sorted(left, key=lambda task: -task.cost)):
                results[task] = found
                done += task.cost
                progress(f"{task.view.label}, {task.label}, seed {task.seed}", done)
        return results


class Cells:
    """Results by view, sampler and sample count: for each measure, a list with one value per seed."""

    def __init__(self, results):
        self.values, self.pictures = {}, {}
        for task, (rows, pictures) in sorted(results.items(), key=lambda item: item[0].seed):
            for row in rows:
                cell = self.values.setdefault((task.view, task.label, row["spp"]), {})
                for name, value in row.items():
                    if name != "spp":
                        cell.setdefault(name, []).append(value)
            for spp, picture in pictures.items():
                self.pictures[task.view, task.label, int(spp)] = picture.astype(np.float32)

    def get(self, view, label, spp, measure):
        return self.values.get((view, label, spp), {}).get(measure)
