# SPDX-License-Identifier: Apache-2.0
"""Adaptive against plain sampling: `scripts/bench adaptive` writes docs/report/adaptive.md and adaptive.png

Renders a few built-in scenes with every sampler, adaptively (--noise) and plainly, and compares the errors that they have at
the same mean number of samples. Errors are relative and as displayed, like those that --noise estimates.
"""

import dataclasses
import tempfile
from pathlib import Path

import numpy as np
import OpenEXR

from ..base import peers
from ..base.command import Parser, command_shown
from ..base.files import read_exr, write_text
from ..base.plots import plain_numbers, plt, save, style
from ..base.progress import Progress
from ..base.tables import md_table
from ..measure.image_error import blurred, displayed
from .judge import Task, pictures_of, render_references
from .renderer import run_pathtracer
from .views import View

SCENES = {"cornell": 1.0, "penumbra": 0.0, "glossy": 0.0}  # and exposures, in stops
SAMPLERS = ("white", "sobol", "sobol-global", "zorder", "blue")
WIDTH, HEIGHT = 120, 90
LEVELS = (0.2, 0.1, 0.05)
LEAST, MOST = 16, 256  # samples per pixel: --min-spp and --spp
COUNTS = (16, 32, 64, 128, 256)  # of plain pictures
SEEDS = 4
REFERENCE_SPP = 2048
SIGMAS = (0.0, 2.1)
DARKEST = 0.02  # share of white added to the light that errors are divided by, as in --noise


@dataclasses.dataclass(frozen=True)
class Point:
    """A picture, or the mean of several: samples per pixel on average, {sigma: error}, and its light over the reference's, minus 1."""

    samples: float
    errors: dict
    light: float


def point(picture, samples, reference):
    """Errors are root mean squares of the difference as displayed, blurred, over the reference as displayed plus DARKEST."""
    shown, wanted = displayed(picture, reference.exposure), displayed(reference.picture, reference.exposure)
    light = blurred(wanted.mean(axis=2), SIGMAS[-1]) + DARKEST
    return Point(samples, {sigma: float(np.sqrt(np.mean((blurred(shown - wanted, sigma) / light[..., None]) ** 2))) for sigma in SIGMAS},
                 float(shown.mean() / wanted.mean() - 1))


def mean_point(points):
    """Of the pictures of all seeds; of errors the root of the mean square."""
    errors = {sigma: float(np.sqrt(np.mean([p.errors[sigma] ** 2 for p in points]))) for sigma in SIGMAS}
    return Point(float(np.mean([p.samples for p in points])), errors, float(np.mean([p.light for p in points])))


def adaptive_point(program, view, sampler, seed, level, reference):
    request = view.request(sampler, MOST, seed)
    more = ["--noise", str(level), "--min-spp", str(LEAST), "--threads", 1, "--quiet"]
    with tempfile.TemporaryDirectory(prefix="libbn-") as folder:
        path = Path(folder) / "adaptive.exr"
        run_pathtracer(program, [*request.arguments(), *more, "-o", path])
        with OpenEXR.File(str(path), separate_channels=True) as file:
            count = float(file.channels()["count"].pixels.mean())
        return point(read_exr(path)[0], count, reference)


def measure(program, samplers):
    """{scene: {sampler: (points of plain pictures, points of adaptive ones)}}."""
    references = render_references(program, [View(scene, "", WIDTH, HEIGHT, exposure=exposure) for scene, exposure in SCENES.items()], REFERENCE_SPP)
    result = {}
    with Progress(len(SCENES) * len(samplers), "runs") as progress:
        for view, reference in references.items():
            own = result.setdefault(view.scene, {})
            for sampler in samplers:
                plain = [[point(picture, spp, reference) for spp, picture, _ in pictures_of(program, Task(view, sampler, seed, COUNTS))]
                         for seed in range(SEEDS)]
                adaptive = [[adaptive_point(program, view, sampler, seed, level, reference) for level in LEVELS] for seed in range(SEEDS)]
                own[sampler] = tuple([mean_point(points) for points in zip(*pictures)] for pictures in (plain, adaptive))
                progress(f"{view.scene}, {sampler}", sum(map(len, result.values())))
    return result


def at_samples(points, samples, value):
    """A logarithm of plain pictures' at a number of samples, on straight lines between logarithms."""
    return np.interp(np.log(samples), np.log([p.samples for p in points]), [value(p) for p in points])


def over_plain(result, sampler, k, sigma):
    """The error of adaptive pictures of level k over that of plain ones with as many samples: geometric mean over scenes."""
    logs = [np.log(adaptive[k].errors[sigma]) - at_samples(plain, adaptive[k].samples, lambda p: np.log(p.errors[sigma]))
            for plain, adaptive in (own[sampler] for own in result.values())]
    return float(np.exp(np.mean(logs)))


def over_blue(result, sampler, k):
    """The error of a sampler after the blur over blue's, in adaptive pictures of the same level."""
    return float(np.exp(np.mean([np.log(own[sampler][1][k].errors[2.1] / own["blue"][1][k].errors[2.1]) for own in result.values()])))


def table(result, names):
    rows = []
    for name in names:
        row = [name + (" (padded)" if name == "sobol" else f" (declared {MOST})" if name == "zorder" else "")]
        for k in range(len(LEVELS)):
            row += [f"{np.mean([own[name][1][k].samples for own in result.values()]):.0f}",
                    *(f"{over_plain(result, name, k, sigma):.2f}" for sigma in SIGMAS), f"{over_blue(result, name, k):.2f}"]
        rows.append(row)
    return md_table(["sampler", *(f"{level:g}: {what}" for level in LEVELS for what in ("samples", "unblurred", "blurred", "over blue"))], rows)


def answers(result, names):
    def spread(values):
        return f"{min(values):.2f} to {max(values):.2f}"

    def gains(name, sigma):
        return spread([over_plain(result, name, k, sigma) for k in range(len(LEVELS))])

    both = [pair for own in result.values() for pair in own.values()]
    # Clipping darkens noisy pictures, plain ones too.
    lights = 100 * np.array([p.light - at_samples(plain, p.samples, lambda q: q.light) for plain, adaptive in both for p in adaptive])
    best = [min((name for name in names if name != "blue"), key=lambda name, k=k: over_blue(result, name, k)) for k in range(len(LEVELS))]
    return [
        f"- **Is it worth it?** At the same mean number of samples, the adaptive error is {gains('white', 2.1)} of the plain one with white "
        f"noise and {gains('blue', 2.1)} with `blue`, after a blur of 2.1 pixels; unblurred {gains('white', 0.0)} and "
        f"{gains('blue', 0.0)}. Below 1, adaptive sampling helps.",
        "- **Which sampler?** In adaptive pictures of the same level, the best of the others has "
        + ", ".join(f"{over_blue(result, name, k):.2f}" for k, name in enumerate(best)) + " times the error of `blue` after the blur "
        + f"({', '.join(f'`{name}` at {level:g}' for level, name in zip(LEVELS, best))}).",
        "- **Does it reach the level?** Errors of single pixels are "
        + ", ".join(f"{spread([adaptive[k].errors[0.0] / level for _, adaptive in both])} of the level {level:g}" for k, level in enumerate(LEVELS))
        + f". The level is judged as if samples were independent, so stratified ones end below it; where blocks stop at {MOST} "
        "samples, pictures may end above.",
        f"- **Is it biased?** The light of adaptive pictures as displayed differs by {lights.mean():+.3f} % from that of plain ones with as many "
        f"samples (standard error {lights.std(ddof=1) / np.sqrt(len(lights)):.3f} %). Blocks whose samples miss light "
        "stop early, which darkens adaptive pictures (Kirk and Arvo, \"Unbiased Sampling Techniques for Image Synthesis\", 1991).",
    ]


def report_text(result, names, command, commit):
    return "\n".join([
        "# Adaptive sampling", "", f"Printed by `{command}`.", "", *answers(result, names), "",
        "![Error against mean samples per pixel, plain and adaptive](adaptive.png)", "",
        f"Built-in scenes of the path tracer ({', '.join(f'`{scene}`' for scene in result)}) at {WIDTH}x{HEIGHT} pixels, "
        f"`--noise` {', '.join(f'{level:g}' for level in LEVELS)} with `--min-spp {LEAST} --spp {MOST}`, against plain pictures of "
        f"{', '.join(map(str, COUNTS))} samples. `zorder` is declared at each count of plain pictures, and at {MOST} in adaptive "
        f"ones, whose counts are not known in advance. References have {REFERENCE_SPP} samples per pixel (`sobol`, another seed).",
        f"Errors are differences as displayed (exposed and clipped), divided by the reference's blurred luminance plus {DARKEST}, and",
        f"root mean squares over {SEEDS} seeds. Where a few bright paths decide, as in `glossy`, one unlucky picture can move a ratio; there are no "
        "intervals.", "",
        "For each level: samples per pixel on average, the error over that of plain pictures with as many samples (unblurred, and "
        "after a blur of 2.1 pixels), and the error after the blur over that of `blue`.", "",
        *([f"OpenQMC is at commit {commit}.", ""] if commit else []), table(result, names), ""])


def plot(result, names, path):
    figure, axes = plt.subplots(1, len(result), figsize=(4.4 * len(result), 4.9), layout="constrained")
    for axis, (scene, own) in zip(axes, result.items()):
        for name in names:
            for points, line in zip(own[name], ({"linestyle": ":", "linewidth": 1, "marker": "", "label": "_plain"}, {})):
                axis.loglog([p.samples for p in points], [p.errors[2.1] for p in points], **{**style(name, names), **line})
        axis.set(title=scene, xlabel="samples per pixel, on average")
        axis.set_xscale("log", base=2)
        axis.grid(True, which="both", alpha=0.22)
        plain_numbers(axis.xaxis, axis.yaxis)
    axes[0].set_ylabel("relative error as displayed, sigma 2.1")
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=4, title="lines: adaptive; dotted: plain")
    save(figure, path, laid_out=True)


def run(arguments):
    parser = Parser("adaptive", __doc__)
    parser.out()
    parser.pathtracer()
    options = parser.parse_args(arguments)
    names = (*SAMPLERS, *peers.chosen(options.openqmc, options.pathtracer))
    result = measure(options.pathtracer, names)
    text = report_text(result, names, command_shown("adaptive", arguments), peers.commit(options.openqmc))
    plot(result, names, options.out / "adaptive.png")
    write_text(options.out / "adaptive.md", text)
    print(text)
