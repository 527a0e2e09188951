# SPDX-License-Identifier: Apache-2.0
"""Shows how samplers converge on your own scene (`scripts/demo my.gltf`) or on the Cornell box.

Renders a reference and progressive runs of each sampler, and measures the error at every sample count and seed. Writes report.html
(a slider to compare two images, enlarged crops, error images, and plots of error against samples and time),
convergence.csv with all figures, and every image of the first seed as EXR and PNG. References and results are cached in
~/.cache/libbn ($XDG_CACHE_HOME), so an interrupted run resumes.
"""

import argparse
import base64
import html
import io
import itertools
import json
import re
import statistics
import sys
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from PIL import Image
from scipy import ndimage

import bluenoise
from bluenoise._noise import COLOURS, false_colour
from evidence.base.command import Parser, names_of, parse_size, run_or_say_why
from evidence.base.contact_sheet import enlarged_part, grey, preview, sheet
from evidence.base.files import write_exr, write_image, write_rows, write_text
from evidence.base.plots import plain_numbers, style
from evidence.measure.compare import REFERENCE_MARGIN
from evidence.measure.image_error import LUMINANCE, SIGMAS, all_errors, blurred
from evidence.measure.statistics import ratio
from evidence.renders.judge import Cells, Run, Task, pictures_of, render_references
from evidence.renders.renderer import REFERENCE_PARTS, progressive, scene_label
from evidence.renders.renderer import notes_of as notes_on
from evidence.renders.views import View
from evidence.samplers.variants import OWN

from .to_gltf import scene_for

MEASURES = {"rmse": "RMSE", "rmse_1.0": "sigma 1.0", "rmse_2.1": "sigma 2.1", "displayed_2.1": "displayed, sigma 2.1"}
PLOTTED = {"rmse_2.1": "RMSE after a 2.1-pixel blur", "rmse": "RMSE"}
ERROR = "rmse_2.1"  # the measures shown beside the images
SEEDS_FOR_RATIO = 3  # with fewer seeds, the intervals are too wide
SAMPLERS = ("white", "sobol", "blue")
# Without a scene, all sample counts are steps of one run, where padded Sobol' falls back. The scene is dark except for its lamp.
DEMO = {"counts": (*range(1, 17), 64), "shown": (*range(1, 17), 64), "galleries": (1, 3, 4, 16), "start": 3, "exposure": 1.0,
        "seeds": 6, "printed": (1, 2, 3, 4, 6, 8, 12, 16, 64)}


class Pictures(Run):
    """A judge.Run that keeps every image of the first seed, and the rendering time in seconds."""

    def measure(self, task, reference):
        rows, kept = [], {}
        for spp, picture, attributes in pictures_of(self.program, task):
            rows.append({"spp": spp, "seconds": attributes["seconds"], **all_errors(picture, reference.picture, reference.exposure)})
            if task.keep_pictures:
                kept[str(spp)] = picture
        return rows, kept


# ---- The page

def luminance_error(picture, reference):
    """The signed error, (height, width)."""
    return (np.asarray(picture, np.float64) - reference) @ LUMINANCE


def part_worth_showing(reference, picture):
    """(left, top, width, height) of a noisy, detailed square a quarter of the image wide, ignoring lights and fireflies."""
    def local_mean(values):
        return ndimage.uniform_filter(np.minimum(values, np.quantile(values, 0.9)), side, mode="constant")

    height, width = reference.shape[:2]
    side = max(1, min(width, height) // 4)
    edges = ndimage.gaussian_gradient_magnitude(np.asarray(reference @ LUMINANCE, np.float64), 1.0)
    sums = local_mean(np.abs(luminance_error(picture, reference))) * local_mean(edges)
    inside = sums[side // 2:height - (side - 1) // 2, side // 2:width - (side - 1) // 2]
    top, left = np.unravel_index(np.argmax(inside), inside.shape)
    return int(left), int(top), side, side


def gallery(samplers, errors, previews, part):
    """For one sample count, one column per sampler: an enlarged crop, and its error before and after a blur."""
    factor = max(1, min(errors[samplers[0]].shape) // part[2])
    rows = [[enlarged_part(previews[s], part, factor) for s in samplers]]
    for sigma in (0.0, SIGMAS[-1]):
        shown = {s: blurred(errors[s], sigma) for s in samplers}
        # All samplers share one grey scale: three standard deviations of white noise, robust to lights.
        full_scale = max(3 * 1.4826 * float(np.median(np.abs(shown[samplers[0]]))), 1e-12)
        greys = {s: np.uint8(np.clip(128 + 127.5 * shown[s] / full_scale, 0, 255)) for s in samplers}
        rows.append([enlarged_part(grey(greys[s]), part, factor) for s in samplers])
    return sheet(rows, ("enlarged", "error", "blurred"), samplers)


def noise_maps(pictures, samplers, counts, exposure):
    """{count: {sampler: map of visible noise}}, from the halves of the samples: for counts of which half was rendered too."""
    return {n: {s: bluenoise.visible_noise(pictures[s, n // 2], 2 * pictures[s, n] - pictures[s, n // 2], exposure=2.0**exposure) for s in samplers}
            for n in counts if n % 2 == 0 and (samplers[0], n // 2) in pictures}


def noise_text(noises):
    return "; ".join(f"{sampler} {np.percentile(noise, 95):.2f}" for sampler, noise in noises.items())


def noise_section(samplers, maps):
    """Maps of visible noise. maps: {count: {sampler: map}}."""
    if not maps:
        return []
    colours = ", ".join(f"{name} {steps:g}" for steps, (name, _) in COLOURS.items())
    rows = [[Image.fromarray(false_colour(noises[s])) for s in samplers] for noises in maps.values()]
    return ["<h2>Visible noise</h2>", "<p>How much noise a viewer sees in the whole image, in steps of an 8-bit display, estimated from the two halves of its "
            f"samples. Below 1 step, noise is hard to see. Colours: {colours}. 95% of the image is below: "
            + "; ".join(f"at {n} samples, {noise_text(noises)}" for n, noises in maps.items()) + ".</p>",
            f'<div class="wide" tabindex="0"><img class=gallery alt="maps of visible noise" src="{uri(sheet(rows, [str(n) for n in maps], samplers))}"></div>']


def plots(rows):
    """SVG plots: error reduction relative to the first sampler, and errors against samples and time."""
    samplers, measures = list(rows), list(PLOTTED)
    figure = Figure(figsize=(14, 11), layout="constrained")
    axes = figure.subplots(3, len(measures), squeeze=False)
    for column, measure in enumerate(measures):
        base = [row[measure] for row in rows[samplers[0]].values()]
        for name, own in rows.items():
            values, seconds = ([row[key] for row in own.values()] for key in (measure, "seconds"))
            for axis, x, y in zip(axes[:, column], (list(own), list(own), seconds), (np.divide(base, values), values, values)):
                axis.loglog(x, y, **style(name, samplers))
        axes[0, column].set_title(f"{PLOTTED[measure]}: reduction relative to {samplers[0]}")
        for row, label in enumerate(("samples per pixel", "samples per pixel", "seconds of rendering, one thread")):
            axes[row, column].set_xlabel(label)
            plain_numbers(axes[row, column].xaxis, axes[row, column].yaxis)
    for axis in axes.flat:
        axis.grid(True, which="both", alpha=.22)
    axes[0, 0].legend()
    text = io.StringIO()
    figure.savefig(text, format="svg", transparent=True)
    return "<svg class=chart" + text.getvalue().partition("<svg")[2]


def uri(image, kind="PNG", **options):
    data = io.BytesIO()
    image.convert("RGB").save(data, kind, optimize=True, **options)
    return f"data:image/{kind.lower()};base64," + base64.b64encode(data.getvalue()).decode()


def note(one, other, errors, own_error):
    """The line below the images: the errors of two samplers and, if the seeds and the reference permit it, their ratio."""
    rms = {name: float(np.sqrt(np.mean(np.square(errors[name])))) for name in (one, other)}
    text = f"Error after a 2.1-pixel blur: {one} {rms[one]:.3g}, {other} {rms[other]:.3g}. "
    if len(errors[one]) < SEEDS_FOR_RATIO:
        return text + f"A ratio needs at least {SEEDS_FOR_RATIO} seeds."
    if min(rms.values()) < REFERENCE_MARGIN * own_error:
        return text + f"The reference's own error, {own_error:.2g}, is too large for a ratio."
    found = ratio(errors[one], errors[other])
    if not found.significant:
        return text + f"No significant difference over {len(errors[one])} seeds."
    times = sorted(max(value, 1 / value) for value in (found.low, found.value, found.high))
    return (text + f"The error of {other if found.value > 1 else one} is {times[1]:.2f} times smaller ({times[0]:.2f} to {times[2]:.2f} "
            f"over {len(errors[one])} seeds).")


def html_table(head, lines):
    rows = ["<tr>" + "".join(f"<{tag}>{html.escape(text)}</{tag}>" for text in line) + "</tr>"
            for tag, line in (("th", head), *(("td", line) for line in lines))]
    return f'<div class="wide" tabindex="0"><table>{"".join(rows)}</table></div>'


def page(options, rows, pictures, reference, notes, ignored):
    """The text of report.html. rows: of summary(); pictures: {(sampler, count): array}; ignored: lines about what the image lacks."""
    samplers, name = options.samplers, scene_label(options.scene)
    images = {key: preview(picture, options.exposure) for key, picture in pictures.items()}
    data = {
        "scene": name, "size": options.size, "counts": options.shown, "start": options.shown.index(options.start),
        "reference": uri(preview(reference.picture, options.exposure)),
        # JPEG at a quality that preserves noise.
        "pictures": {s: [uri(images[s, n], "JPEG", quality=86, subsampling=0) for n in options.shown] for s in samplers},
        "errors": {s: [f"{rows[s][n][ERROR]:.3g}" for n in options.shown] for s in samplers},
        "notes": [{f"{one}|{other}": note(one, other, {s: rows[s][n]["each"] for s in samplers}, reference.own[ERROR])
                   for one, other in itertools.combinations(samplers, 2)} for n in options.shown]}
    part = part_worth_showing(reference.picture, pictures[samplers[0], options.start])
    parts = [*(f"<p><strong>{html.escape(line)}</strong></p>" for line in ignored), "<h2>Images</h2>", "<p>Top: a noisy part of the image, enlarged. Middle: its signed luminance error, grey where it is zero, on one scale "
             "for all samplers. Bottom: this error after a 2.1-pixel blur, on another scale.</p>"]
    for n in options.galleries:
        errors = {s: luminance_error(pictures[s, n], reference.picture) for s in samplers}
        shown = gallery(samplers, errors, {s: images[s, n] for s in samplers}, part)
        parts.append(f'<details{" open" * (n == options.start)}><summary>{n} sample{"s" * (n > 1)} per pixel</summary><div class="wide" tabindex="0">'
                     f'<img class=gallery alt="parts and their errors" src="{uri(shown)}"></div></details>')
    parts += noise_section(samplers, noise_maps(pictures, samplers, options.galleries, options.exposure))
    parts += ["<h2>Plots</h2>", f'<div class="wide" tabindex="0">{plots(rows)}</div>',
              "<h2>Figures</h2>", html_table(header(samplers), texts(rows, options.counts)), *(f"<p>{html.escape(text)}</p>" for text in notes)]
    text = (Path(__file__).parent / "report.html").read_text(encoding="utf-8").replace("SCENE", html.escape(name))
    # "</" would end the script element.
    return text.replace("DATA", json.dumps(data).replace("</", "<\\/")).replace("PARTS", "\n".join(parts))


# ---- Figures

def summary(cells, view, samplers, counts):
    """{sampler: {count: row}}: medians over seeds, which are robust to fireflies. row["each"] lists the error ERROR of every seed."""
    def row(cell):
        return {**{name: statistics.median(cell[name]) for name in ("seconds", *MEASURES)}, "each": cell[ERROR]}

    return {label: {spp: row(cells.values[view, label, spp]) for spp in counts} for label in samplers}


def header(samplers):
    return ["sampler", "spp", "seconds", *MEASURES.values(), f"sigma 2.1, over {samplers[-1]}"]


def texts(rows, counts):
    """The table's lines. The last column is the error after a 2.1-pixel blur divided by the last sampler's error."""
    *_, last = rows.values()
    return [[label, str(spp), f"{own[spp]['seconds']:.3f}", *(f"{own[spp][name]:.5f}" for name in MEASURES),
             f"{own[spp][ERROR] / last[spp][ERROR]:.2f}" if last[spp][ERROR] else ""] for spp in counts for label, own in rows.items()]


def text_table(lines):
    widths = [max(map(len, column)) for column in zip(*lines)]
    return "".join(line[0].ljust(widths[0]) + "  " + "  ".join(c.rjust(w) for c, w in zip(line[1:], widths[1:])) + "\n" for line in lines)


def notes_of(options, reference):
    own = ", ".join(f"{reference.own[name]:.5f} ({MEASURES[name]})" for name in ("rmse", "rmse_1.0", "rmse_2.1"))
    return [f"Scene {options.scene}, {options.size[0]}x{options.size[1]} pixels: medians over {options.seeds} seeds. RMSE is the root mean square "
            "over pixels and channels of linear radiance. Sigma is the width, in pixels, of the Gaussian blur applied before the error is measured; it leaves only the noise "
            "visible from a distance. For errors as displayed, images are first exposed and clipped. Seconds count only rendering, on one thread.",
            f"The reference uses the sobol sampler, {reference.spp} samples per pixel and a different seed. Its own error is about {own}; errors close to "
            "this are unreliable."]


# ---- The command

def say(text):
    print(f"demo: {text}", file=sys.stderr, flush=True)


def parse_options(arguments):
    parser = Parser("", __doc__, formatter_class=argparse.RawDescriptionHelpFormatter,
                    epilog="Arguments after -- are passed to the path tracer: scripts/demo my.gltf -- --env sky.exr")
    parser.prog, parser.description = "scripts/demo", __doc__
    parser.add_argument("scene", nargs="?", help="a built-in scene (pathtracer --list), a .gltf or .glb file, or a .blend file or a mesh, which scripts/to-gltf converts")
    parser.add_argument("--samplers", type=names_of("sampler", OWN), default=SAMPLERS, metavar="A,B,...",
                        help=f"samplers from {', '.join(OWN)} (default {','.join(SAMPLERS)})")
    parser.number("--spp", 64, "largest sample count per pixel")
    parser.add_argument("--size", type=parse_size, default=(256, 256), metavar="WxH", help="image size (default 256x256)")
    parser.number("--seeds", 5, "number of seeds for the medians")
    parser.add_argument("--exposure", type=float, default=0.0, metavar="EV", help="exposure of the images, in stops")
    parser.number("--reference-spp", 2048, f"samples per pixel of the reference, a multiple of {REFERENCE_PARTS}")
    parser.number("--jobs", 2, "number of single-threaded runs in parallel")
    parser.add_argument("--out", type=Path, metavar="FOLDER", help="output folder (default out/demo or out/demo/SCENE)")
    parser.hidden("--pathtracer", "build/examples/pathtracer/pathtracer")
    end = arguments.index("--") if "--" in arguments else len(arguments)
    options, more = parser.parse_args(arguments[:end]), tuple(arguments[end + 1:])
    settings = {} if options.scene else DEMO
    options.out = options.out or Path("out/demo") / (scene_label(options.scene) if options.scene else "")
    options.scene = options.scene or "cornell"
    counts = tuple(sorted({n for k in range(17) for n in (2**k, 3 * 2**k) if n < options.spp} | {options.spp}))
    shown = [*[n for n in (1, 4, 16, 64, 256) if n < options.spp][-3:], options.spp]
    vars(options).update({"more": more, "counts": counts, "shown": counts, "galleries": shown, "printed": shown,
                          "start": shown[min(1, len(shown) - 1)], **settings})
    if options.reference_spp % REFERENCE_PARTS:
        parser.error(f"--reference-spp must be a multiple of {REFERENCE_PARTS}, not {options.reference_spp}")
    if not re.fullmatch(r"[A-Za-z0-9_-]+", options.scene) and not Path(options.scene).is_file():
        parser.error(f"file {options.scene} does not exist")
    return options


def run(arguments):
    options = parse_options(arguments)
    given = {*options.more}
    options.scene, own_options, lines = scene_for(options.scene, options.out, "demo")
    # The user's own options replace those of the scene.
    for name, value in zip(own_options[::2], own_options[1::2]):
        if name not in given:
            options.more = (*options.more, name, value)
    ignored = [*lines[1:], *notes_on(options.pathtracer, ["--scene", options.scene, *options.more])]
    for line in (*lines[:1], *ignored):
        print(f"demo: {line}", flush=True)
    view = View(options.scene, "", *options.size, options.more, options.exposure)
    # Try names and options with one sample before spending hours on a reference.
    for label in options.samplers:
        list(progressive(options.pathtracer, view.request(label, 1), [1]))
    tasks = [Task(view, label, seed, options.counts, seed == 0) for seed in range(options.seeds) for label in options.samplers]
    say(f"renders a reference with {options.reference_spp} samples per pixel, then {len(tasks)} images with up to {options.spp}; "
        "this takes minutes, and progress is shown only on a terminal")
    references = render_references(options.pathtracer, (view,), options.reference_spp)
    say(f"the reference is ready; renders the images of {', '.join(options.samplers)}")
    work = Pictures(options.pathtracer, "convergence", options.jobs)
    cells, reference = Cells(work.results(references, tasks)), references[view]
    rows = summary(cells, view, options.samplers, options.counts)
    pictures = {(label, spp): picture for (_, label, spp), picture in cells.pictures.items()}
    for (label, spp), picture in pictures.items():
        path = options.out / f"{label}_{spp}.exr"
        write_exr(path, picture, {"sampler": label, "spp": spp, "scene": options.scene})
        write_image(path.with_suffix(".png"), preview(picture, options.exposure))
    notes = notes_of(options, reference)
    fields = ("sampler", "spp", "seconds", *MEASURES)
    write_rows(options.out / "convergence.csv", fields,
               [{"sampler": label, "spp": spp, **{name: row[name] for name in fields[2:]}} for label, own in rows.items() for spp, row in own.items()])
    write_text(options.out / "report.html", page(options, rows, pictures, reference, notes, ignored))
    print(text_table([header(options.samplers), *texts(rows, options.printed)]))
    for n, noises in noise_maps(pictures, options.samplers, options.printed, options.exposure).items():
        print(f"visible noise at {n} samples, in steps of an 8-bit display; 95% of the image is below: {noise_text(noises)}")
    print(*notes, sep="\n")
    print(f"Written: {options.out}/report.html, convergence.csv, and an EXR and a PNG of each image.")


if __name__ == "__main__":
    run_or_say_why(run, sys.argv[1:], "demo")
