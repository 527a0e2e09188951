# SPDX-License-Identifier: Apache-2.0
"""The README's image, and the spread over seeds: `scripts/bench picture` writes docs/picture.png and evidence/results/worst.csv

The image is the crop from the *development* set in which `blue` has the median error relative to padded Sobol'.
"""

import numpy as np
from PIL import Image

from ..base.command import Parser
from ..base.contact_sheet import labelled, preview
from ..base.files import write_image, write_rows
from ..measure.image_error import blurred, displayed
from . import views
from .judge import Cells, Run, Task, pictures_of, render_references

SPP, SIGMA, CROP, ENLARGED, CONTRAST = 4, 2.1, (96, 96), 3, 2.5
SHOWN = {"white": "white noise", "sobol": "padded Sobol'", "blue": "blue"}
MEASURE = f"displayed_{SIGMA}"
REFERENCE_SPP = 512
WORST_SCENE, WORST_OF = "penumbra", 500


def typical(options):
    """The crop in which blue has the median error over padded Sobol', and that ratio. Seeds are averaged."""
    chosen = views.crops("development", views.BUILT_IN, crop=CROP)
    references = render_references(options.pathtracer, chosen, REFERENCE_SPP)
    tasks = [Task(view, label, seed, (SPP,)) for view in chosen for label in ("sobol", "blue") for seed in range(4)]
    cells = Cells(Run(options.pathtracer, "picture", options.jobs).results(references, tasks))
    ratios = {view: float(np.exp(np.mean(np.log(cells.get(view, "blue", SPP, MEASURE)) - np.log(cells.get(view, "sobol", SPP, MEASURE)))))
              for view in chosen if min(cells.get(view, "sobol", SPP, MEASURE)) > 1e-3}
    order = sorted(ratios, key=ratios.get)
    return order[len(order) // 2], ratios[order[len(order) // 2]]


def draw_picture(options):
    """Writes picture.png: the crop as rendered, and as seen from a distance, with more contrast."""
    view, ratio = typical(options)
    columns = [next(pictures_of(options.pathtracer, Task(view, label, 0, (SPP,))))[1] for label in SHOWN]
    distant = [blurred(displayed(picture, view.exposure), SIGMA) / 2.0**view.exposure for picture in columns]
    middle = np.mean(distant, axis=(0, 1, 2))
    figure = labelled({name: [preview(shown, view.exposure).resize([ENLARGED * length for length in view.size], Image.Resampling.NEAREST)
                              for shown in (picture, middle + CONTRAST * (far - middle))]
                       for name, picture, far in zip(SHOWN.values(), columns, distant)}, 28, 16)
    write_image(options.picture, figure.quantize(256), optimize=True)
    print(f"{options.picture}: {view.label}, crop {','.join(map(str, view.crop))}, {SPP} samples per pixel; blue has {ratio:.2f} times the error of padded Sobol', "
          "the median over crops.")


def draw_worst(options):
    view = views.crops("development", (WORST_SCENE,))[0]
    references = render_references(options.pathtracer, (view,), REFERENCE_SPP)
    work, found = Run(options.pathtracer, "picture", options.jobs), {}
    for label in ("sobol", "blue"):
        tasks = [Task(view, label, seed, (SPP,)) for seed in range(WORST_OF)]
        results = work.results(references, tasks)
        found[label] = [results[task][0][0][MEASURE] for task in tasks]
    write_rows(options.out / "worst.csv", ("seed", "sobol", "blue"), [
        {"seed": seed, **{label: f"{errors[seed]:.6g}" for label, errors in found.items()}} for seed in range(WORST_OF)])
    ordered = {label: sorted(errors) for label, errors in found.items()}
    middle = ordered["sobol"][WORST_OF // 2]
    worse = sum(blue > sobol for sobol, blue in zip(*found.values()))
    text = "; ".join(f"{label} {' '.join(f'{errors[at] / middle:.2f}' for at in (0, WORST_OF // 2, -1))}" for label, errors in ordered.items())
    print(f"{options.out}/worst.csv: {WORST_OF} seeds, {SPP} samples per pixel of {view.label}, relative to the median error of padded Sobol'; lowest, median, highest: {text}. "
          f"With the same seed, blue has the larger error {worse} times.")


def run(arguments):
    parser = Parser("picture", __doc__)
    parser.pathtracer()
    parser.number("--jobs", 2, "number of images to render in parallel")
    parser.out()
    parser.hidden("--picture", "docs/picture.png")
    options = parser.parse_args(arguments)
    draw_picture(options)
    draw_worst(options)
