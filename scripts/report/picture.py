# SPDX-License-Identifier: Apache-2.0
"""The README's picture: `scripts/bench picture` renders one scene, a third of it with each sampler, and enlarged parts

It writes docs/picture.jpg. Each third is cut out of a whole picture, and the error printed in it is that of the whole picture.
Pictures are kept in out/picture, so that an interrupted run goes on.
"""

import argparse
import dataclasses
import sys
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from .contact_sheet import BACKGROUND, GAP, INK, _font, enlarged_part, preview
from .convergence import positive
from .files import read_exr
from .image_error import displayed_rmse
from .renderer import Renderer, RenderError, Request
from .whole_files import written_beside

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
    draw, font = ImageDraw.Draw(figure), _font(18)
    for i, (picture, error, name) in enumerate(zip(pictures, relative, NAMES.values())):
        left = i * cell
        draw.text((left + cell / 2, BAR / 2), f"{name}: error {error:.2f}", INK, font, anchor="mm")
        if i:
            draw.line((left, BAR, left, BAR + scene.height), BACKGROUND, 2)
        for row, (x, y) in enumerate(PARTS):
            part = enlarged_part(preview(picture), (x, y, *PART_SIZE), FACTOR)
            figure.paste(part, (left + (cell - part.width) // 2, BAR + scene.height + GAP + row * (GAP + height)))
    return figure


def main(arguments=None):
    parser = argparse.ArgumentParser(prog="scripts/bench picture", description=__doc__.splitlines()[0])
    parser.add_argument("--scene", default=SCENE, help=f"a scene of the path tracer (default {SCENE})")
    parser.add_argument("--spp", type=positive, default=SPP, metavar="N", help=f"samples per pixel (default {SPP})")
    parser.add_argument("--reference-spp", type=positive, default=REFERENCE_SPP, metavar="N",
                        help=f"samples per pixel of the reference (default {REFERENCE_SPP})")
    parser.add_argument("--pathtracer", default="build/examples/pathtracer/pathtracer", help=argparse.SUPPRESS)
    parser.add_argument("--size", type=lambda text: tuple(map(int, text.split("x"))), default=SIZE, help=argparse.SUPPRESS)
    parser.add_argument("--out", type=Path, default=Path("docs"), metavar="FOLDER", help="where the picture goes (default docs)")
    parser.add_argument("--pages", type=Path, default=Path("out/picture"), help=argparse.SUPPRESS)
    options = parser.parse_args(arguments)
    try:
        renderer = Renderer(options.pathtracer, options.pages)
        request = Request("white", options.spp, SEED, options.scene, *options.size)
        pictures = [read_exr(renderer.render(dataclasses.replace(request, sampler=name), f"{name}.exr"))[0] for name in NAMES]
        reference, _ = read_exr(renderer.reference(
            Request("blue", options.reference_spp, REFERENCE_SEED, options.scene, *options.size), "reference.exr"))
        with written_beside(options.out / FILE) as beside:
            # Half the size of a PNG. Without subsampling, what it changes is far below the noise.
            compose(pictures, errors(pictures, reference)).save(beside, quality=95, subsampling=0)
    except (RenderError, OSError) as error:
        sys.exit(f"bench: {error}")
    print(f"{options.out / FILE}: {options.spp} samples per pixel of {options.scene}; errors as displayed after a blur of {SIGMA} pixels, "
          f"over white noise's: {', '.join(f'{error:.2f}' for error in errors(pictures, reference))}")


if __name__ == "__main__":
    main()
