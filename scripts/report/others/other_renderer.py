# SPDX-License-Identifier: Apache-2.0
"""What the comparisons in other people's renderers share: runs of their programs, references and the command they print."""

import dataclasses
import hashlib
import os
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

from ..base.bench_options import arguments_that_count
from ..base.contact_sheet import enlarged_part, preview, sheet
from ..base.files import read_exr, write_rows, write_text
from ..base.progress import duration
from ..base.tables import update_table
from ..base.whole_files import written_beside
from ..measure.image_error import displayed_rmse
from ..renders.renderer import RenderError


def processor_seconds(command, what, environment=None):
    """Runs a program and returns its processor seconds; RenderError has the last line that it wrote."""
    with tempfile.TemporaryFile() as log:
        try:
            process = os.posix_spawn(command[0], command, environment or os.environ, file_actions=[
                (os.POSIX_SPAWN_OPEN, 0, os.devnull, os.O_RDONLY, 0), (os.POSIX_SPAWN_DUP2, log.fileno(), 1),
                (os.POSIX_SPAWN_DUP2, log.fileno(), 2)])
        except OSError as error:
            raise RenderError(f"cannot run {command[0]} ({error.strerror})") from None
        _, status, used = os.wait4(process, 0)
        if status:
            log.seek(0)
            said = log.read().decode(errors="replace").strip().splitlines()
            raise RenderError(f"{what}: {said[-1] if said else f'status {status}'}")
    return used.ru_utime + used.ru_stime


@dataclasses.dataclass(frozen=True)
class Reference:
    picture: np.ndarray
    own: dict  # {measure: its own error}
    spp: int
    seconds: float

    def key(self):
        return hashlib.sha256(self.picture.tobytes()).hexdigest()


def reference_of_halves(store, key, spp, render, errors):
    """The mean of two pictures; half their difference is its own error. render(half, path) returns its seconds."""
    found = store.load(key)
    if not found:
        halves, seconds = [], 0.0
        with tempfile.TemporaryDirectory(prefix="libbn-") as folder:
            for half in range(2):
                out = Path(folder) / "out.exr"
                seconds += render(half, out)
                halves.append(read_exr(out)[0])
        found = [{"seconds": seconds}], {"halves": np.array(halves)}
        store.save(key, *found)
    (row,), arrays = found
    first, second = arrays["halves"]
    own = {name: error / 2 for name, error in errors(first, second).items()}
    return Reference((first + second) / 2, own, spp, row["seconds"])


def references_of(views, make, jobs, progress, cost=lambda view: 1):
    """{view: make(view)}, `jobs` at a time; progress counts the costs."""
    done, found, pool = 0, {}, ThreadPoolExecutor(jobs)
    try:
        for view, reference in zip(views, pool.map(make, views)):
            found[view] = reference
            done += cost(view)
            progress(f"reference of {view.label}", done)
    finally:
        pool.shutdown(cancel_futures=True)
        progress.close()
    return found


def write_picture(path, pictures, reference, part, factor, sigma=2.1):
    """A part (left, top, width, height) of {name: picture} and of the reference side by side, enlarged. Printed above each is the
    error of the whole picture, as displayed after the blur, over that of the last."""
    found = {name: displayed_rmse(picture, reference, sigma=sigma) for name, picture in pictures.items()}
    last = list(found.values())[-1]
    names = [f"{name}: error {error / last:.2f}" for name, error in found.items()] + ["reference"]
    shown = [preview(picture) for picture in (*pictures.values(), reference)]
    cells = [[enlarged_part(image, part, factor)] for image in shown]
    with written_beside(path) as beside:
        sheet([cells], [""], names).save(beside, quality=92, subsampling=0)


def write_report(options, name, report, rows, fields, references):
    """Writes NAME.md and the CSV of all figures, and prints the report. In docs/report the guide's table changes, too; returns whether."""
    write_rows(options.pages / f"{name}.csv", fields, rows)
    text = report.text()
    write_text(options.out / f"{name}.md", text)
    whole = options.out.resolve() == Path("docs/report").resolve()
    if whole:
        update_table(options.guide, f"scripts/bench {name}", report.summary())
    print(text)
    print(f"Written: {options.out}/{name}.md and {options.pages}/{name}.csv. References took "
          f"{duration(sum(reference.seconds for reference in references.values()))} of processor time once.", file=sys.stderr)
    return whole


def command_shown(command, arguments, checkout):
    """The command line for the report: `checkout` is the option whose folder is not shown."""
    shown = arguments_that_count(arguments)
    for i, word in enumerate(shown):
        if word == checkout:
            shown[i + 1:i + 2] = ["DIR"]
        elif word.startswith(checkout + "="):
            shown[i] = checkout + "=DIR"
        elif word == "--program":
            del shown[i:i + 2]
    return " ".join([command, *shown])
