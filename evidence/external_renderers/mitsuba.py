# SPDX-License-Identifier: Apache-2.0
"""Compares the `bluenoise` sampler with Mitsuba's own samplers: `scripts/bench mitsuba` writes the table in docs/mitsuba.md and its image"""

import itertools
import subprocess
import sys

import numpy as np

from ..base.command import CommandError, Parser, package
from ..base.progress import Progress
from ..base.tables import md_table, write_or_print
from .other_renderer import shown_and_raw, write_picture

COMMAND = "scripts/bench mitsuba"
INSTALL = ".venv/bin/python -m pip install mitsuba"
OWN = ("independent", "stratified", "multijitter", "orthogonal", "ldsampler")
SAMPLERS = (*OWN, "bluenoise")
BASE = "independent"
COUNTS = (1, 4, 16)
REFERENCE_SPP = 1024  # in two images, which take less memory
# The image at the top of the page.
PICTURE, PICTURE_SCENE, PICTURE_SPP = "docs/mitsuba.jpg", "Cornell box, direct lighting", 4
PICTURE_SIZE, PICTURE_PART = 320, (20, 110, 200, 200)
PICTURE_SAMPLERS = ("independent", "multijitter", "bluenoise")
TRIAL = """import mitsuba
mitsuba.set_variant("llvm_ad_rgb")
print(mitsuba.render(mitsuba.load_dict(mitsuba.cornell_box()), spp=1))
"""


def load_mitsuba():
    mitsuba = package("mitsuba", INSTALL)
    # An LLVM version that is too old kills the process.
    if subprocess.run([sys.executable, "-c", TRIAL], capture_output=True, check=False).returncode:
        raise CommandError("Mitsuba cannot render with llvm_ad_rgb; run apt-get install libllvm19 or set DRJIT_LIBLLVM_PATH")
    mitsuba.set_variant("llvm_ad_rgb")
    mitsuba.set_log_level(mitsuba.LogLevel.Error)
    import bluenoise.mitsuba

    assert bluenoise.mitsuba
    return mitsuba


# ---- Scenes: dictionaries, so nothing has to be downloaded

def with_film(scene, size):
    scene["sensor"]["film"] = {"type": "hdrfilm", "width": size, "height": size, "pixel_format": "rgb",
                               "component_format": "float32", "rfilter": {"type": "box"}}
    return scene


def grey(value):
    return {"type": "rgb", "value": [value] * 3}


def balls(mitsuba, size, lights):
    """Plastic and metal balls on a floor under a sky, with a row of lights above, seen from the side."""
    transform = mitsuba.ScalarTransform4f
    scene = {
        "type": "scene", "integrator": {"type": "path", "max_depth": 5},
        "sky": {"type": "constant", "radiance": grey(0.2 if lights == 1 else 0.02)},
        "floor": {"type": "rectangle", "to_world": transform().scale(8), "bsdf": {"type": "diffuse", "reflectance": grey(0.6)}},
        "sensor": {"type": "perspective", "fov": 40,
                   "to_world": transform().look_at([0, -9, 4], [0, 0, 0.8], [0, 0, 1])},
    }
    surfaces = ({"type": "roughplastic", "diffuse_reflectance": grey(0.4)}, {"type": "roughconductor", "alpha": 0.2},
                {"type": "diffuse", "reflectance": grey(0.7)})
    for i, surface in enumerate(surfaces):
        scene[f"ball{i}"] = {"type": "sphere", "center": [2.1 * i - 2.1, 0, 1], "radius": 1, "bsdf": surface}
    side = 0.8 if lights == 1 else 0.12
    for i in range(lights):
        place = [(i % 4 - 1.5) * 1.6 * (lights > 1), (i // 4 - 1.5) * 1.6 * (lights > 1), 4]
        scene[f"lamp{i}"] = {
            "type": "rectangle", "to_world": transform().look_at(place, [place[0], place[1], 0], [0, 1, 0]).scale(side),
            "emitter": {"type": "area", "radiance": grey(12 if lights == 1 else 4 + 10 * (i * 7 % 16))}}
    return with_film(scene, size)


def cornell(integrator):
    return lambda mitsuba, size: with_film({**mitsuba.cornell_box(), "integrator": integrator}, size)


SCENES = {
    "Cornell box, direct lighting": cornell({"type": "direct"}),
    "Cornell box, global illumination": cornell({"type": "path", "max_depth": 6}),
    "balls under one light and the sky": lambda mitsuba, size: balls(mitsuba, size, 1),
    "balls under 16 lights": lambda mitsuba, size: balls(mitsuba, size, 16),
}


# ---- Measuring

def images(mitsuba, scene, sampler, spp, seeds):
    """An image for each seed. None if the sampler rounds the sample count up."""
    scene["sensor"]["sampler"] = {"type": sampler, "sample_count": spp}
    loaded = mitsuba.load_dict(scene)
    return [np.array(mitsuba.render(loaded, seed=seed, spp=spp), np.float64) for seed in seeds if loaded.sensors()[0].sampler().sample_count() == spp]


def reference_of(mitsuba, scene):
    return np.mean(images(mitsuba, scene, BASE, REFERENCE_SPP // 2, (1000, 1001)), 0)


def measure(mitsuba, size, seeds):
    """{(scene, spp): {sampler: (error as displayed, raw error)}}: root mean squares over seeds, both after the blur."""
    result, done = {}, 0
    with Progress(len(SCENES) * len(COUNTS) * len(SAMPLERS), "images") as progress:
        for name, make in SCENES.items():
            progress(f"{name}, reference", done)
            scene = make(mitsuba, size)
            reference = reference_of(mitsuba, scene)
            for spp, sampler in itertools.product(COUNTS, SAMPLERS):
                progress(f"{name}, {sampler}, {spp} spp", done := done + 1)
                if found := images(mitsuba, scene, sampler, spp, range(seeds)):
                    result.setdefault((name, spp), {})[sampler] = shown_and_raw(found, reference)
    return result


def make_picture(mitsuba, path):
    scene = SCENES[PICTURE_SCENE](mitsuba, PICTURE_SIZE)
    write_picture(path, {sampler: images(mitsuba, scene, sampler, PICTURE_SPP, (0,))[0] for sampler in PICTURE_SAMPLERS},
                  reference_of(mitsuba, scene), PICTURE_PART)


def table(result):
    """Errors relative to BASE: as displayed, and raw in brackets."""
    return md_table(["scene", "spp", *(f"`{sampler}`" for sampler in SAMPLERS[1:])], [
        [name, str(spp), *("{:.2f} ({:.2f})".format(*row[sampler] / row[BASE]) if sampler in row else "" for sampler in SAMPLERS[1:])]
        for (name, spp), row in result.items()])


def run(arguments):
    parser = Parser("mitsuba", __doc__)
    parser.number("--size", 320, "side length of the images")
    parser.number("--seeds", 8, "number of images per sampler")
    parser.add_argument("--picture", metavar="FILE", nargs="?", const=PICTURE,
                        help=f"only make the image at {PICTURE_SPP} samples per pixel (default {PICTURE})")
    parser.table("docs/mitsuba.md")
    options = parser.parse_args(arguments)
    if options.picture:
        return make_picture(load_mitsuba(), options.picture)
    write_or_print(options, COMMAND, table(measure(load_mitsuba(), options.size, options.seeds)))
