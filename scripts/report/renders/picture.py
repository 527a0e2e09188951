# SPDX-License-Identifier: Apache-2.0
"""The README's picture: `scripts/bench picture` renders one scene, a third of it with each sampler, and enlarged parts

It writes docs/picture.jpg. Each third is cut out of a whole picture, and the error printed in it is that of the whole picture.
Pictures are kept in out/picture, so that an interrupted run goes on.
"""

import argparse
import dataclasses
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from ..base.command import add_pathtracer
from ..base.contact_sheet import BACKGROUND, GAP, INK, enlarged_part, preview
from ..base.files import read_exr
from ..base.whole_files import written_beside
from ..measure.image_error import displayed_rmse
from .renderer import Renderer, Request

NAMES = {"white": "white noise", "sobol": "Sobol', padded", "blue": "blue"}
SCENE, SIZE, SPP, SEED = "lens", (960, 640), 4, 0
REFERENCE_SEED, REFERENCE_SPP = 1_000_003, 256
SIGMA = 2.1
# Left and top of the parts that are enlarged, in pixels of the scene.
PARTS, PART_SIZE, FACTOR = ((400, 40), (735, 505)), (104, 64), 3
BAR = 34  # pixels, of labels
FILE = "picture.jpg"


def thirds(pictures):
    """One picture of the left third of the first, the middle third of the second and the right third of the last."""
    width = pictures[0].shape[1]
    edges = [width * i // len(pictures) for i in range(len(pictures) + 1)]
    return np.concatenate([picture[:, a:b] for picture, a, b in zip(pictures, edges, edges[1:])], axis=1)


def errors(pictures, reference):
    """Errors as displayed after the blur, over that of the first."""
    found = [displayed_rmse(picture, reference, sigma=SIGMA) for picture in pictures]
    return [error / found[0] for error in found]


def compose(pictures, relative):
    """The figure: labels, the scene in thirds, and a row of enlarged parts for each place."""
    scene = preview(thirds(pictures))
    cell = scene.width // len(pictures)
    height = PART_SIZE[1] * FACTOR
    figure = Image.new("RGB", (scene.width, BAR + scene.height + len(PARTS) * (GAP + height)), BACKGROUND)
    figure.paste(scene, (0, BAR))
    draw, font = ImageDraw.Draw(figure), ImageFont.load_default(18)
    for i, (picture, error, name) in enumerate(zip(pictures, relative, NAMES.values())):
        left = i * cell
        draw.text((left + cell / 2, BAR / 2), f"{name}: error {error:.2f}", INK, font, anchor="mm")
        if i:
            draw.line((left, BAR, left, BAR + scene.height), BACKGROUND, 2)
        for row, (x, y) in enumerate(PARTS):
            part = enlarged_part(preview(picture), (x, y, *PART_SIZE), FACTOR)
            figure.paste(part, (left + (cell - part.width) // 2, BAR + scene.height + GAP + row * (GAP + height)))
    return figure


def run(arguments):
    parser = argparse.ArgumentParser(prog="scripts/bench picture", description=__doc__.splitlines()[0])
    add_pathtracer(parser)
    parser.add_argument("--out", type=Path, default=Path("docs"), metavar="FOLDER", help="where the picture goes (default docs)")
    options = parser.parse_args(arguments)
    renderer = Renderer(options.pathtracer, Path("out/picture"))
    request = Request("white", SPP, SEED, SCENE, *SIZE)
    pictures = [read_exr(renderer.render(dataclasses.replace(request, sampler=name), f"{name}.exr"))[0] for name in NAMES]
    reference, _ = read_exr(renderer.reference(Request("blue", REFERENCE_SPP, REFERENCE_SEED, SCENE, *SIZE), "reference.exr"))
    found = errors(pictures, reference)
    with written_beside(options.out / FILE) as beside:
        # Half the size of a PNG. Without subsampling, what it changes is far below the noise.
        compose(pictures, found).save(beside, quality=95, subsampling=0)
    print(f"{options.out / FILE}: {SPP} samples per pixel of {SCENE}; errors as displayed after a blur of {SIGMA} pixels, "
          f"over white noise's: {', '.join(f'{error:.2f}' for error in found)}")
