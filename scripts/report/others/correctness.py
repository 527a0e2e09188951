# SPDX-License-Identifier: Apache-2.0
"""Checks the path tracer against Mitsuba 3: `scripts/bench correctness` writes docs/report/correctness.md

Renders the same small scenes with both, several seeds each, and compares means: of each channel over the whole picture,
and of blocks of pixels by Welch's t-test. The renderers share only the geometry and the material parameters.
Mitsuba is the optional package `mitsuba` (Jakob et al., "Mitsuba 3 renderer", 2022).
"""

import argparse
import dataclasses
import sys
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image
from scipy import stats

from ..base.bench_options import arguments_that_count
from ..base.command import add_out, add_pathtracer, names_of, package, parse_size, positive
from ..base.contact_sheet import preview, sheet
from ..base.files import read_exr, write_image, write_text
from ..base.progress import Progress
from ..base.tables import md_table
from ..renders.renderer import Request, run_pathtracer
from .correctness_scenes import SCENES, write_obj

BLOCK = 8  # side of a block, in pixels
FALSE_ALARMS = 0.01  # probability that any block of a scene is reported by chance
# Float precision and ray offsets differ between the renderers, so they cannot agree more closely.
PRECISION = 0.001
CHANNELS = "red", "green", "blue"
INSTALL = ".venv/bin/python -m pip install mitsuba"


# ---- The two renderers

def our_pictures(program, scene, folder, size, spp, sampler, seeds):
    """Yields float arrays (height, width, 3)."""
    path = scene.built_in or write_obj(scene, folder)
    eye, target, fov = scene.camera
    camera = ("--eye", ",".join(map(str, eye)), "--target", ",".join(map(str, target)), "--fov", str(fov))
    single = ("--single-scatter",) if scene.rough else ()
    for seed in range(seeds):
        request = Request(sampler, spp, seed, str(path), *size, more=(*camera, "--max-depth", str(scene.depth), *single))
        run_pathtracer(program, [*request.arguments(), "--quiet", "-o", folder / "ours.exr"])
        yield read_exr(folder / "ours.exr")[0]


def mitsuba_scene(mitsuba, scene, folder, size):
    """The same scene as a dictionary for mitsuba.load_dict(); meshes and textures are in the folder."""
    eye, target, fov = scene.camera
    result = {
        "type": "scene",
        # Mitsuba counts path segments, we count surfaces.
        "integrator": {"type": "volpath" if scene.fog else "path", "max_depth": scene.depth + 1},
        "sensor": {"type": "perspective", "fov": fov, "fov_axis": "y",
                   "to_world": mitsuba.ScalarTransform4f().look_at(list(eye), list(target), [0, 1, 0]),
                   "sampler": {"type": "independent"},
                   "film": {"type": "hdrfilm", "width": size[0], "height": size[1], "pixel_format": "rgb",
                            "component_format": "float32", "rfilter": {"type": "box"}}},
    }
    if scene.fog:
        result["fog"] = scene.fog.for_mitsuba(mitsuba)
    for i, part in enumerate(scene.parts):
        write_obj(dataclasses.replace(scene, parts=(part,)), folder, f"part{i}", with_materials=False)
        shape = {"type": "obj", "filename": str(folder / f"part{i}.obj"), "face_normals": True,
                 "bsdf": part.material.for_mitsuba(folder)}
        if part.light:
            shape["emitter"] = {"type": "area", "radiance": {"type": "rgb", "value": list(part.light)}}
        result[f"part{i}"] = shape
    return result


def mitsuba_pictures(mitsuba, scene, folder, size, spp, seeds):
    loaded = mitsuba.load_dict(mitsuba_scene(mitsuba, scene, folder, size))
    for seed in range(seeds):
        yield np.array(mitsuba.render(loaded, spp=spp, seed=seed), np.float32)


# ---- The comparison

def block_means(picture, block=BLOCK):
    """Means over complete blocks, (rows, columns, 3); partial blocks at the right and bottom are ignored."""
    height, width = (n // block * block for n in picture.shape[:2])
    parts = picture[:height, :width].astype(np.float64).reshape(height // block, block, width // block, block, -1)
    return parts.mean((1, 3))


@dataclasses.dataclass(frozen=True)
class Comparison:
    """Our mean over Mitsuba's, with its standard error, for each channel; and the results of the blocks."""

    ratio: np.ndarray
    error: np.ndarray
    block_count: int  # tested blocks, three channels each
    outside: int  # block channels that differ by more than the tolerance and chance
    worst: float  # largest |z| of a block beyond the tolerance
    limit: float  # of |z|, from FALSE_ALARMS
    scatter: float  # RMS of z without tolerance: 1 if only chance contributes

    @property
    def agrees(self):
        return not self.outside


def normal_scores(t, freedom):
    """Student's t as the z of equal probability, so that blocks with different degrees of freedom are comparable."""
    return np.sign(t) * stats.norm.isf(np.maximum(stats.t.sf(np.abs(t), freedom), 1e-300))


def compare(ours, theirs, tolerance=PRECISION):
    """Compares two lists of pictures, one per seed. tolerance: accepted difference, as a share of a block's mean."""
    ours, theirs = (np.array([block_means(picture) for picture in pictures]) for pictures in (ours, theirs))
    means, variances = [], []
    for blocks in (ours, theirs):
        means.append(blocks.mean(0))
        variances.append(blocks.var(0, ddof=1) / len(blocks))
    total = np.maximum(variances[0] + variances[1], 1e-30)
    freedom = total**2 / np.maximum(
        variances[0] ** 2 / (len(ours) - 1) + variances[1] ** 2 / (len(theirs) - 1), 1e-60)
    freedom = np.maximum(freedom, min(len(ours), len(theirs)) - 1)
    difference = means[0] - means[1]
    lit = (means[0] > 0) | (means[1] > 0)
    beyond = np.maximum(np.abs(difference) - tolerance * means[1], 0)
    z = normal_scores(beyond / np.sqrt(total), freedom)[lit]
    plain = normal_scores(difference / np.sqrt(total), freedom)[lit]
    limit = float(stats.norm.isf(FALSE_ALARMS / (2 * max(z.size, 1))))

    whole = [blocks.mean((1, 2)) for blocks in (ours, theirs)]
    ratio = whole[0].mean(0) / whole[1].mean(0)
    error = ratio * np.sqrt(sum(w.var(0, ddof=1) / len(w) / w.mean(0) ** 2 for w in whole))
    return Comparison(ratio, error, lit.size // 3, int(np.sum(z > limit)), float(z.max(initial=0)), limit,
                      float(np.sqrt(np.mean(plain**2))) if plain.size else 0.0)


def shown(ours, theirs):
    """Our picture, Mitsuba's, and the difference of block means: grey is none, white and black are 5 %."""
    blocks = block_means(ours), block_means(theirs)
    relative = (blocks[0] - blocks[1]).mean(-1) / (blocks[1].mean(-1) + 0.01 * blocks[1].mean())
    grey = np.clip(np.floor(128 + 127.5 * relative / 0.05), 0, 255).astype(np.uint8)
    difference = np.full(ours.shape[:2], 128, np.uint8)
    whole = np.kron(grey, np.ones((BLOCK, BLOCK), np.uint8))
    difference[:whole.shape[0], :whole.shape[1]] = whole
    images = preview(ours), preview(theirs), Image.fromarray(difference).convert("RGB")
    return [image.resize((2 * image.width, 2 * image.height), Image.Resampling.NEAREST) for image in images]


# ---- The report

def report_text(command, options, results):
    rows = []
    for scene, comparison in results:
        rows.append([scene.name, *(f"{r:.4f} ± {1.96 * e:.4f}" for r, e in zip(comparison.ratio, comparison.error)),
                     f"{100 * (scene.tolerance or PRECISION):g} %", f"{comparison.worst:.2f}", f"{comparison.limit:.2f}",
                     f"{comparison.scatter:.2f}", "agrees" if comparison.agrees else f"**{comparison.outside} blocks differ**"])
    size = "x".join(map(str, options.size))
    apart = [scene.name for scene, comparison in results if not comparison.agrees]
    most = max(abs(ratio - 1) for _, comparison in results for ratio in comparison.ratio)
    answer = (f"The two renderers agree in {len(results) - len(apart)} of {len(results)} scenes" +
              (f", and not in {', '.join(f'`{name}`' for name in apart)}" if apart else ", in every block of every picture") +
              f"; means of whole pictures differ by at most {100 * most:.2f} %.")
    what = [f"- `{scene.name}`: {scene.summary}" for scene, _ in results]
    return "\n".join([
        "# The path tracer and Mitsuba 3", "", f"Printed by `{command}` with Mitsuba {options.version}.", "", answer, "",
        "![Ours, Mitsuba's, the difference](correctness.png)", "",
        "*Ours, Mitsuba's, the difference of the means of blocks: grey is none, white and black are 5 %.*", "",
        f"Each scene in both renderers, {size} pixels, {options.seeds} seeds with {options.spp} samples per pixel "
        f"(`{options.sampler}` here, independent samples in Mitsuba).", "", *what, "",
        md_table(["scene", *(f"ours / Mitsuba, {c}" for c in CHANNELS), "tolerance", "worst block, z", "limit of z",
                        "RMS of z", ""], rows), "",
        "Ratios compare the means of the pictures, ± the 95 % interval. Each block of "
        f"{BLOCK}x{BLOCK} pixels is tested in each channel: z is the difference of the means beyond the tolerance, divided by "
        "the standard error over seeds (Welch's t, as a normal score). If the renderers agree, the probability that any "
        f"block of a scene exceeds the limit is at most {100 * FALSE_ALARMS:g} %. The RMS of z ignores the tolerance and is close "
        "to 1 if only chance contributes.", "",
        "Mitsuba uses the separable Smith shadowing-masking term, the path tracer the height-correlated one; the tolerance of "
        "rough materials allows for this. They are compared with `--single-scatter`, because Mitsuba ignores multiple "
        "scattering between facets.", ""])


def parse_options(arguments):
    names = tuple(scene.name for scene in SCENES)

    parser = argparse.ArgumentParser(prog="scripts/bench correctness", description=__doc__.splitlines()[0])
    parser.add_argument("--size", type=parse_size, default=(96, 80), metavar="WxH", help="pixels (default 96x80)")
    parser.add_argument("--spp", type=positive, default=64, metavar="N", help="samples per pixel for each seed (default 64)")
    parser.add_argument("--seeds", type=positive, default=16, metavar="N", help="number of seeds, at least 3 (default 16)")
    parser.add_argument("--sampler", default="sobol", metavar="NAME", help="sampler of the path tracer (default sobol)")
    parser.add_argument("--scenes", type=names_of("scene", names), default=names, metavar="A,B,...",
                        help=f"scenes out of {', '.join(names)} (default all)")
    add_out(parser)
    add_pathtracer(parser)
    options = parser.parse_args(arguments)
    if options.seeds < 3:
        parser.error(f"--seeds must be at least 3 to estimate the variance, not {options.seeds}")
    if min(options.size) < BLOCK:
        parser.error(f"--size must be at least {BLOCK}x{BLOCK}")
    return options


def run(arguments):
    options = parse_options(arguments)
    mitsuba = package("mitsuba", INSTALL)
    mitsuba.set_variant("scalar_rgb")
    options.version = mitsuba.__version__
    scenes = [scene for scene in SCENES if scene.name in options.scenes]
    progress, done = Progress(2 * len(scenes) * options.seeds, "pictures"), 0
    results, rows = [], []
    with tempfile.TemporaryDirectory(prefix="libbn-") as folder:
        try:
            for scene in scenes:
                pictures = {}
                for name, source in (
                        ("the path tracer", our_pictures(options.pathtracer, scene, Path(folder), options.size, options.spp,
                                                         options.sampler, options.seeds)),
                        ("Mitsuba", mitsuba_pictures(mitsuba, scene, Path(folder), options.size, options.spp, options.seeds))):
                    for picture in source:
                        pictures.setdefault(name, []).append(picture)
                        done += 1
                        progress(f"{scene.name}, {name}", done)
                ours, theirs = pictures.values()
                results.append((scene, compare(ours, theirs, scene.tolerance or PRECISION)))
                rows.append([[image] for image in shown(np.mean(ours, 0), np.mean(theirs, 0))])
        finally:
            progress.close()
    command = "scripts/bench correctness" + "".join(f" {word}" for word in arguments_that_count(arguments))
    text = report_text(command, options, results)
    write_text(options.out / "correctness.md", text)
    image = sheet(rows, [scene.name for scene in scenes], ["ours", "Mitsuba", "difference"])
    write_image(options.out / "correctness.png", image.quantize(128, dither=0))
    print(text)
    if not all(comparison.agrees for _, comparison in results):
        sys.exit("bench: the renderers differ; see the table")
