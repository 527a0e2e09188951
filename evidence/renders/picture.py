# SPDX-License-Identifier: Apache-2.0
"""The README's pictures: `scripts/bench picture` shows one part of a scene with each sampler, and errors at every count

It writes docs/picture.png, a part of one picture with each sampler and its reference, pixel by pixel, above the same after a
blur and the error that the blur leaves; docs/every.png, the error in the held-out crops at every sample count; and
evidence/results/worst.png, the median and the worst of 500 pictures. Results are kept, so that an interrupted run goes on.
"""

import dataclasses
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from PIL import Image

from ..base import peers
from ..base.command import Parser
from ..base.contact_sheet import before_and_after, preview, sheet
from ..base.files import write_image
from ..base.plots import save, style
from ..base.tables import md_table
from ..measure.image_error import blurred, displayed, displayed_rmse
from . import variants, views
from .judge import Cells, Run, Task, pictures_of, render_references
from .renderer import REFERENCE_SEED, Request, make_reference, progressive

SCENE, SIZE, SPP, SEED = "penumbra", (960, 640), 6, 0
REFERENCE_SPP = 2048
SIGMA = 2.1
GREY, AMPLIFIED = 0.2, 8  # what stands for no error; how much errors are
PART = (150, 408, 140, 150)  # left, top, width, height in pixels of the scene
MARGIN = 8  # pixels around the part, for the blur
NAMES = {"sobol": "padded Sobol'", "sobol-global": "global Sobol'", "zorder": "Z-order", "blue": "blue"}
LABELS = {**NAMES, "zorder": "Z-order, told each count"}
COUNTS = (*range(1, 17), 20, 24, 28, 32)
MEASURE = f"displayed_{SIGMA}"
WORST_SCENE, WORST_OF, WORST_SPP, WORST_FACTOR = "penumbra", 500, 4, 2  # scene; seeds; samples per pixel; enlargement


def part_of(picture):
    return picture[MARGIN:-MARGIN, MARGIN:-MARGIN]


def draw_picture(options, others):
    """Writes picture.png and returns {sampler: its error over that of blue}."""
    left, top, width, height = PART
    crop = (left - MARGIN, top - MARGIN, left + width + MARGIN, top + height + MARGIN)
    request = Request("sobol", SPP, SEED, SCENE, *SIZE, more=("--crop", ",".join(map(str, crop))))
    reference, *_ = make_reference(options.pathtracer, dataclasses.replace(request, spp=REFERENCE_SPP, seed=REFERENCE_SEED))
    pictures, errors = {}, {}
    for name in (*NAMES, *others):
        own = dataclasses.replace(request, sampler=name, declared=SPP if name in variants.DECLARED else 0)
        (_, pictures[name], _), = progressive(options.pathtracer, own, [SPP])
        errors[name] = displayed_rmse(part_of(pictures[name]), part_of(reference), sigma=SIGMA)
    shown = ["sobol", "sobol-global", "zorder", *([min(others, key=errors.get)] if others else []), "blue"]
    relative = {name: error / errors["blue"] for name, error in errors.items()}
    columns = {f"{NAMES.get(name, name.replace('openqmc-', 'OpenQMC '))}\n{relative[name]:.2f}": pictures[name] for name in shown}
    soft = blurred(displayed(reference), SIGMA)
    figure = before_and_after({**columns, "reference\n0": reference}, (MARGIN, MARGIN, width, height),
                              lambda picture: blurred(displayed(picture), SIGMA),
                              lambda picture: GREY + AMPLIFIED * (blurred(displayed(picture), SIGMA) - soft))
    write_image(options.out / "picture.png", figure, optimize=True)
    return relative


def every_count(options, others):
    """{sampler: [error over that of blue at each of COUNTS]}: geometric means over crops and seeds."""
    chosen = views.crops("held-out")
    labels = ("sobol", "sobol-global", "zorder", *others, "blue")
    references = render_references(options.pathtracer, chosen, REFERENCE_SPP)
    tasks = [Task(view, label, seed, COUNTS) for view in chosen for label in labels for seed in range(options.seeds)]
    cells = Cells(Run(options.pathtracer, "picture", max(COUNTS), options.jobs).results(references, tasks))

    def logs(label, spp):
        return np.mean([np.log(cells.get(view, label, spp, MEASURE)) for view in chosen])

    return {label: [float(np.exp(logs(label, spp) - logs("blue", spp))) for spp in COUNTS] for label in labels}


def draw_every(folder, found):
    figure, axis = plt.subplots(figsize=(10, 3.6))
    for label, values in found.items():
        axis.plot(COUNTS, values, **{**style(label, found), "label": LABELS.get(label, label.replace("openqmc-", "OpenQMC "))})
    axis.set(xscale="log", xlabel="samples per pixel", ylabel="error / error of blue")
    axis.set_xscale("log", base=2)
    axis.set_xticks([*range(1, 9), 10, 12, 16, 24, 32], minor=False)
    axis.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
    axis.grid(True, alpha=.25)
    axis.set_ylim(top=1.65)  # room for the names
    axis.legend(ncols=4, fontsize=8.5, loc="upper center")
    save(figure, folder / "every.png")


def draw_worst(options):
    """Writes worst.png, the median and the worst picture of WORST_OF seeds, and returns {sampler: errors, ascending}."""
    view = views.crops("core", (WORST_SCENE,))[0]
    references = render_references(options.pathtracer, (view,), REFERENCE_SPP)
    work = Run(options.pathtracer, "picture", WORST_SPP, options.jobs)
    found = {}
    for label in ("sobol", "blue"):
        tasks = [Task(view, label, seed, (WORST_SPP,)) for seed in range(WORST_OF)]
        results = work.results(references, tasks)
        found[label] = sorted(((results[task][0][0][MEASURE], task) for task in tasks), key=lambda pair: pair[0])
    size = tuple(WORST_FACTOR * side for side in view.size)

    def images(task):
        picture = displayed(next(pictures_of(options.pathtracer, task))[1], view.exposure)
        return [preview(part).resize(size, Image.Resampling.NEAREST) for part in (picture, blurred(picture, SIGMA))]

    places = {"median": WORST_OF // 2, "worst": -1}
    figure = sheet([[images(pairs[at][1]) for at in places.values()] for pairs in found.values()], list(found), list(places))
    write_image(options.worst, figure, optimize=True)
    return {label: [error for error, _ in pairs] for label, pairs in found.items()}


def run(arguments):
    parser = Parser("picture", __doc__)
    parser.pathtracer()
    parser.number("--seeds", 1, "seeds of each crop")
    parser.number("--jobs", 2, "pictures to render at a time")
    parser.add_argument("--out", type=Path, default=Path("docs"), metavar="FOLDER", help="where the pictures go (default docs)")
    parser.hidden("--worst", "evidence/results/worst.png")
    options = parser.parse_args(arguments)
    others = peers.chosen(options.openqmc, options.pathtracer)
    relative = draw_picture(options, others)
    print(f"{options.out}/picture.png: {SPP} samples per pixel of {SCENE}; errors of the part as displayed after a blur of {SIGMA} pixels, over "
          f"that of blue: {', '.join(f'{name} {error:.2f}' for name, error in relative.items())}")
    errors = draw_worst(options)
    middle = errors["sobol"][WORST_OF // 2]
    print(f"{options.worst}: {WORST_OF} seeds, {WORST_SPP} samples per pixel of a crop of {WORST_SCENE}; errors over the median of Sobol's, least, "
          "median, worst: " + "; ".join(f"{label} {' '.join(f'{values[at] / middle:.2f}' for at in (0, WORST_OF // 2, -1))}"
                                         for label, values in errors.items()))
    found = every_count(options, others)
    draw_every(options.out, found)
    print(f"{options.out}/every.png: errors as displayed after the blur over that of blue, geometric means over the held-out crops and "
          f"{options.seeds} seed{'s' * (options.seeds > 1)} of each:\n")
    print(md_table(["sampler", *map(str, COUNTS)], [[label, *(f"{value:.2f}" for value in values)] for label, values in found.items()]))
