# SPDX-License-Identifier: Apache-2.0
"""Adaptive against plain sampling: `scripts/bench adaptive` writes docs/report/adaptive.md and adaptive.png

Renders a few built-in scenes with every sampler, adaptively (--noise) and plainly, and compares the errors that they have at
the same mean number of samples. Errors are relative and as displayed, like those that --noise estimates.
"""

import argparse
import dataclasses
import tempfile
from pathlib import Path

import numpy as np
import OpenEXR

from ..base import peers
from ..base.bench_options import arguments_that_count
from ..base.command import add_out, add_pathtracer
from ..base.files import read_exr, write_text
from ..base.palette import plain_numbers, style
from ..base.plots import plt, save
from ..base.progress import Progress
from ..base.tables import md_table
from ..measure.image_error import blurred, displayed
from .renderer import Renderer, Request, cache_folder, progressive, run_pathtracer

SCENES = {"cornell": 1.0, "penumbra": 0.0, "glossy": 0.0}  # and exposures, in stops
SAMPLERS = ("white", "sobol", "zorder", "blue")
WIDTH, HEIGHT = 120, 90
LEVELS = (0.2, 0.1, 0.05)
LEAST, MOST = 16, 256  # samples per pixel: --min-spp and --spp
COUNTS = (16, 32, 64, 128, 256)  # of plain pictures
REFERENCE_SEED, REFERENCE_SPP, PARTS = 1_000_003, 2048, 32
SIGMAS = (0.0, 2.1)
DARKEST = 0.02  # share of white added to the light that errors are divided by, as in --noise


@dataclasses.dataclass(frozen=True)
class Point:
    """A picture: samples per pixel on average, {sigma: error}, and its light over the reference's, minus 1."""

    samples: float
    errors: dict
    light: float


def relative_error(picture, reference, exposure, sigma):
    """Root mean square of the difference as displayed, blurred, over the reference as displayed plus DARKEST."""
    picture, reference = displayed(picture, exposure), displayed(reference, exposure)
    light = blurred(reference.mean(axis=2), SIGMAS[-1]) + DARKEST
    return float(np.sqrt(np.mean((blurred(picture - reference, sigma) / light[..., None]) ** 2)))


def point(picture, samples, reference, exposure):
    shown, wanted = displayed(picture, exposure), displayed(reference, exposure)
    return Point(samples, {sigma: relative_error(picture, reference, exposure, sigma) for sigma in SIGMAS},
                 float(shown.mean() / wanted.mean() - 1))


def mean_count(path):
    with OpenEXR.File(str(path), separate_channels=True) as file:
        return float(file.channels()["count"].pixels.mean())


def plain_points(program, request, reference, exposure):
    """One progressive run, or a run for each count if the sampler has to know it."""
    if request.sampler != "zorder":
        return [point(picture, spp, reference, exposure) for spp, picture, _ in progressive(program, request, COUNTS, 1)]
    return [point(picture, spp, reference, exposure) for n in COUNTS
            for spp, picture, _ in progressive(program, dataclasses.replace(request, declared=n), [n], 1)]


def adaptive_point(program, request, level, reference, exposure):
    declared = MOST if request.sampler == "zorder" else 0
    request = dataclasses.replace(request, spp=MOST, declared=declared, more=("--noise", str(level), "--min-spp", str(LEAST)))
    with tempfile.TemporaryDirectory(prefix="libbn-") as folder:
        path = Path(folder) / "adaptive.exr"
        run_pathtracer(program, [*request.arguments(), "--threads", 1, "--quiet", "-o", path])
        return point(read_exr(path)[0], mean_count(path), reference, exposure)


def measure(program, samplers):
    """{(scene, sampler): (points of plain pictures, points of adaptive ones)}."""
    renderer = Renderer(program, cache_folder() / "references" / "adaptive")
    progress, result = Progress(len(SCENES) * (1 + len(samplers)), "steps"), {}
    try:
        for s, (scene, exposure) in enumerate(SCENES.items()):
            done = s * (1 + len(samplers))
            request = Request("sobol", REFERENCE_SPP, REFERENCE_SEED, scene, WIDTH, HEIGHT, exposure=exposure)
            path = renderer.reference(request, f"{scene}-{WIDTH}x{HEIGHT}-{REFERENCE_SPP}.exr", PARTS,
                                      lambda share, scene=scene, done=done: progress(f"reference of {scene}", done + share))
            reference = read_exr(path)[0]
            for k, sampler in enumerate(samplers, 1):
                progress(f"{scene}, {sampler}", done + k)
                own = dataclasses.replace(request, sampler=sampler, spp=1, seed=0)
                result[scene, sampler] = (plain_points(program, own, reference, exposure),
                                          [adaptive_point(program, own, level, reference, exposure) for level in LEVELS])
    finally:
        progress.close()
    return result


def error_at(points, samples, sigma):
    """The error of plain pictures at a number of samples, on straight lines between logarithms."""
    x, y = np.log([p.samples for p in points]), np.log([p.errors[sigma] for p in points])
    return float(np.exp(np.interp(np.log(samples), x, y)))


def geometric_mean(values):
    return float(np.exp(np.mean(np.log(list(values)))))


def over_plain(result, sampler, level, sigma):
    """The error of adaptive pictures over that of plain ones with as many samples: geometric mean over scenes."""
    k = LEVELS.index(level)
    return geometric_mean(own.errors[sigma] / error_at(result[scene, sampler][0], own.samples, sigma)
                          for scene in scenes_in(result) for own in [result[scene, sampler][1][k]])


def over_blue(result, sampler, level):
    """The error of a sampler after the blur over blue's, in adaptive pictures of the same level."""
    k = LEVELS.index(level)
    return geometric_mean(result[scene, sampler][1][k].errors[2.1] / result[scene, "blue"][1][k].errors[2.1]
                          for scene in scenes_in(result))


def scenes_in(result):
    return list(dict.fromkeys(scene for scene, _ in result))


def names_in(result):
    return list(dict.fromkeys(sampler for _, sampler in result))


def table(result):
    rows = []
    for name in names_in(result):
        row = [name + (" (padded)" if name == "sobol" else f" (declared {MOST})" if name == "zorder" else "")]
        for k, level in enumerate(LEVELS):
            row += [f"{np.mean([result[scene, name][1][k].samples for scene in scenes_in(result)]):.0f}",
                    *(f"{over_plain(result, name, level, sigma):.2f}" for sigma in SIGMAS), f"{over_blue(result, name, level):.2f}"]
        rows.append(row)
    heads = [f"{level:g}: {what}" for level in LEVELS for what in ("samples", "unblurred", "blurred", "over blue")]
    return md_table(["sampler", *heads], rows)


def spread(values):
    """Such as `0.80 to 0.93`."""
    return f"{min(values):.2f} to {max(values):.2f}"


def answers(result):
    names = names_in(result)
    ratios = {(name, sigma): [over_plain(result, name, level, sigma) for level in LEVELS] for name in names for sigma in SIGMAS}
    # Clipping darkens noisy pictures, plain ones too.
    lights = 100 * np.array([p.light - np.interp(np.log(p.samples), np.log([q.samples for q in plain]), [q.light for q in plain])
                             for plain, adaptive in result.values() for p in adaptive])
    estimates = [[result[scene, name][1][k].errors[0.0] / level for name in names for scene in scenes_in(result)]
                 for k, level in enumerate(LEVELS)]
    white = [value for (name, sigma), found in ratios.items() if name == "white" and sigma == 2.1 for value in found]
    blue = ratios["blue", 2.1]
    others = [name for name in names if name != "blue"]
    best = {level: min(others, key=lambda name, level=level: over_blue(result, name, level)) for level in LEVELS}
    return [
        f"- **Is it worth it?** At the same mean number of samples, the adaptive error is {spread(white)} of the plain one with white "
        f"noise and {spread(blue)} with `blue`, after a blur of 2.1 pixels; unblurred {spread(ratios['white', 0.0])} and "
        f"{spread(ratios['blue', 0.0])}. Below 1, adaptive sampling helps.",
        "- **Which sampler?** In adaptive pictures of the same level, the best of the others has "
        + ", ".join(f"{over_blue(result, best[level], level):.2f}" for level in LEVELS) + " times the error of `blue` after the blur "
        + f"({', '.join(f'`{best[level]}` at {level:g}' for level in LEVELS)}).",
        "- **Does it reach the level?** Errors of single pixels are "
        + ", ".join(f"{spread(found)} of the level {level:g}" for found, level in zip(estimates, LEVELS))
        + f". The estimate is that of independent samples, so stratified ones are below it; blocks that reach {MOST} samples are above.",
        f"- **Is it biased?** The light of the displayed pictures is {lights.mean():+.3f} % off that of plain ones with as many "
        f"samples, with a standard error of {lights.std(ddof=1) / np.sqrt(len(lights)):.3f} % over all of them.",
    ]


def report_text(result, command, commit):
    parts = ["# Adaptive sampling", "", f"Printed by `{command}`.", "", *answers(result), "",
             "![Error against mean samples per pixel, plain and adaptive](adaptive.png)", "",
             f"Built-in scenes of the path tracer ({', '.join(f'`{scene}`' for scene in scenes_in(result))}) at {WIDTH}x{HEIGHT} pixels, "
             f"`--noise` {', '.join(f'{level:g}' for level in LEVELS)} with `--min-spp {LEAST} --spp {MOST}`, against plain pictures of "
             f"{', '.join(map(str, COUNTS))} samples. `zorder` is declared at each count of plain pictures, and at {MOST} in adaptive "
             f"ones, whose counts nobody knows before. References have {REFERENCE_SPP} samples per pixel (`sobol`, another seed).",
             "Errors are differences as displayed (exposed and clipped), over the light of the reference plus a fiftieth of white.", "",
             "For each level: samples per pixel on average, the error over that of plain pictures with as many samples (unblurred, and "
             "after a blur of 2.1 pixels), and the error after the blur over that of `blue`.", ""]
    if commit:
        parts += [f"OpenQMC is at commit {commit}.", ""]
    return "\n".join([*parts, table(result), ""])


def plot(result, path):
    scenes = scenes_in(result)
    figure, axes = plt.subplots(1, len(scenes), figsize=(max(4.4 * len(scenes), 8), 4.9), layout="constrained", squeeze=False)
    names = names_in(result)
    for axis, scene in zip(axes[0], scenes):
        for name in names:
            look = style(name, names)
            for points, line in zip(result[scene, name], ({"linestyle": ":", "linewidth": 1, "marker": "", "label": "_plain"}, {})):
                axis.loglog([p.samples for p in points], [p.errors[2.1] for p in points], **{**look, **line})
        axis.set(title=scene, xlabel="samples per pixel, on average")
        axis.set_xscale("log", base=2)
        axis.grid(True, which="both", alpha=0.22)
        plain_numbers(axis.xaxis, axis.yaxis)
    axes[0, 0].set_ylabel("relative error as displayed, sigma 2.1")
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=4,
                  title="lines: adaptive; dotted: plain")
    save(figure, path, laid_out=True)


def run(arguments):
    parser = argparse.ArgumentParser(prog="scripts/bench adaptive", description=__doc__.splitlines()[0])
    add_out(parser)
    add_pathtracer(parser)
    peers.add_option(parser)
    options = parser.parse_args(arguments)
    samplers = (*SAMPLERS, *peers.chosen(options.openqmc, options.pathtracer))
    result = measure(options.pathtracer, samplers)
    text = report_text(result, " ".join(["scripts/bench adaptive", *arguments_that_count(arguments)]), peers.commit(options.openqmc))
    plot(result, options.out / "adaptive.png")
    write_text(options.out / "adaptive.md", text)
    print(text)
