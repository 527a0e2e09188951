# SPDX-License-Identifier: Apache-2.0
"""Measures how fast samplers converge on one scene, including your own: `scripts/convergence my.gltf`

Renders a reference (cached in ~/.cache/libbn), then progressive runs of each sampler that record their error, and
pictures at a few sample counts. Writes report.html with a slider that compares two pictures, crops, error images and
their spectra, and plots of error against samples and time; the figures are in convergence.csv.
"""

import argparse
import dataclasses
import hashlib
import re
import statistics
from pathlib import Path

import numpy as np
from PIL import Image
from scipy import ndimage

from ..base.command import CommandError, add_pathtracer, parse_size, positive, run_or_say_why
from ..base.contact_sheet import enlarged_part, grey, preview
from ..base.files import read_exr, read_rows, write_rows, write_text
from ..base.palette import style
from ..base.progress import Progress
from ..measure.flip import mean_flip
from ..measure.image_error import LUMINANCE, SIGMAS, error_image, luminance_error, radial_spectrum, spectrum_image
from ..renders.renderer import Renderer, Request, cache_folder, progressive, run_pathtracer
from . import comparison, curves, page

RUN_ERRORS = ("rmse", "relative_rmse", "rmse_1.0", "rmse_2.1")
FIELDS = ("sampler", "spp", "seconds", "rmse", "relative_rmse", "rmse_1.0", "rmse_2.1", "flip")
SHOWN_COUNTS = (1, 4, 16, 64, 256)
# FLIP takes longer than the renders themselves and hardly differs between seeds.
FLIP_SEEDS = 3
# Shares no sample with the pictures, whatever their seed.
REFERENCE_SEED = 1_000_003
REFERENCE_PARTS = 32


def run_convergence(program, request, reference_path, output, threads=None):
    """The rows of one progressive run, as dicts of numbers; its final picture goes to `output`."""
    table = output.with_suffix(".csv")
    run_pathtracer(program, [*request.arguments(), *(["--threads", threads] if threads else []), "--quiet",
                             "--reference", reference_path, "--convergence", table, "-o", output])
    rows = [{name: float(value) for name, value in row.items()} for row in read_rows(table)]
    return [{**row, "spp": int(row["spp"])} for row in rows]


def over_seeds(runs):
    """One row per sample count from runs with several seeds: medians, which are robust to fireflies, and under "each"
    the errors of every seed."""
    rows = []
    for same in zip(*runs):
        each = {name: [row[name] for row in same] for name in RUN_ERRORS}
        rows.append({"spp": same[0]["spp"], "seconds": statistics.median(row["seconds"] for row in same),
                     **{name: statistics.median(errors) for name, errors in each.items()}, "each": each})
    return rows


def scene_label(scene):
    """A name for files and headings: that of a built-in scene, or the file's."""
    return re.sub(r"[^A-Za-z0-9_.-]", "_", Path(scene).stem) or "scene"


def reference_name(request):
    """File name of the cached reference; a hash of the path distinguishes scene files of the same name."""
    scene = request.scene
    where = f"-{hashlib.sha256(str(Path(scene).resolve()).encode()).hexdigest()[:8]}" if Path(scene).exists() else ""
    more = f"-{hashlib.sha256(repr(request.more).encode()).hexdigest()[:8]}" if request.more else ""
    return (f"{scene_label(scene)}{where}{more}-{request.width}x{request.height}-{request.sampler}"
            f"-{request.spp}.exr")


def make_reference(program, request, folder, report=lambda fraction: None):
    """The path of the reference for the scene, size and options of this request, in a cache folder."""
    return Renderer(program, folder).reference(request, reference_name(request), REFERENCE_PARTS, report)


def given_reference(path, size):
    """A reference supplied by the user, checked before anything is rendered."""
    try:
        picture, _ = read_exr(path)
    except (OSError, RuntimeError, KeyError, ValueError) as error:
        raise CommandError(f"{path} is not an EXR picture that can be read ({error})") from None
    if picture.shape[:2] != (size[1], size[0]):
        raise CommandError(f"the reference {path} has {picture.shape[1]}x{picture.shape[0]} pixels, the pictures "
                         f"{size[0]}x{size[1]}; set --size or use another reference")
    return Path(path).resolve()


def measure(options, reference_path, progress, done):
    """(rows of all samplers, {(sampler, spp): path of the EXR}) for the shown sample counts."""
    reference, _ = read_exr(reference_path)
    renderer = Renderer(options.pathtracer, options.out, options.threads)
    requests = {sampler: Request(sampler, options.spp, options.seed, options.scene, *options.size,
                                 exposure=options.exposure, more=options.more) for sampler in options.samplers}
    rows, pictures, runs = [], {}, {}
    final = options.out / ".progressive.exr"
    # Interleaved, so that other load on the machine affects all alike.
    for seed in range(options.seed, options.seed + options.seeds):
        for sampler, request in requests.items():
            progress(f"{sampler}, {options.spp} spp in one run, seed {seed}", done)
            runs.setdefault(sampler, []).append(run_convergence(
                options.pathtracer, dataclasses.replace(request, seed=seed), reference_path, final, options.threads))
            done += options.spp
    # The final picture of a progressive run is also one of the pictures below.
    for leftover in (final, final.with_suffix(".png"), final.with_suffix(".csv")):
        leftover.unlink(missing_ok=True)
    for sampler, request in requests.items():
        own, flips = over_seeds(runs[sampler]), {}
        for seed in range(options.seed, options.seed + flip_seeds(options.seeds)):
            for spp, picture, _ in progressive(options.pathtracer, dataclasses.replace(request, seed=seed),
                                               [row["spp"] for row in own], options.threads):
                progress(f"{sampler}, FLIP of {spp} spp, seed {seed}", done)
                flips.setdefault(spp, []).append(mean_flip(picture, reference))
                done += options.spp / len(own)
        for row in own:
            each = {**row["each"], "flip": flips[row["spp"]]}
            rows.append({"sampler": sampler, **row, "flip": statistics.median(each["flip"]), "each": each})
        for spp in shown_counts(options.spp):
            progress(f"{sampler}, {spp} spp", done)
            pictures[sampler, spp] = renderer.render(dataclasses.replace(request, spp=spp), f"{sampler}_{spp}.exr")
            done += spp
    return rows, pictures


def flip_seeds(seeds):
    return min(seeds, FLIP_SEEDS)


def shown_counts(spp):
    counts = [n for n in SHOWN_COUNTS if n < spp]
    return [*counts[-3:], spp]


def part_worth_showing(reference, picture):
    """(left, top, width, height) of a square, a quarter of the picture wide, that is noisy and has detail, ignoring
    lights and fireflies."""
    def local_mean(values):
        return ndimage.uniform_filter(np.minimum(values, np.quantile(values, 0.9)), side, mode="constant")

    height, width = reference.shape[:2]
    side = max(1, min(width, height) // 4)
    edges = ndimage.gaussian_gradient_magnitude(np.asarray(reference @ LUMINANCE, np.float64), 1.0)
    sums = local_mean(np.abs(luminance_error(picture, reference))) * local_mean(edges)
    inside = sums[side // 2:height - (side - 1) // 2, side // 2:width - (side - 1) // 2]
    top, left = np.unravel_index(np.argmax(inside), inside.shape)
    return int(left), int(top), side, side


ROWS = ("picture", "enlarged", "error", "spectrum")


def picture_rows(samplers, errors, previews, part):
    """The images for one sample count: a row over samplers for each of ROWS."""
    white = errors[samplers[0]]
    full_scale = max(float(np.quantile(np.abs(white), 0.95)), 1e-12)
    level = max(float(np.mean(radial_spectrum(white)[1])), 1e-30)
    factor = max(1, min(white.shape) // part[2])
    return [[previews[s] for s in samplers], [enlarged_part(previews[s], part, factor) for s in samplers],
            [grey(error_image(errors[s], full_scale)) for s in samplers],
            [grey(spectrum_image(errors[s], level)) for s in samplers]]


MEASURES = (("rmse_2.1", "RMSE after a blur of 2.1 pixels"), ("rmse", "RMSE"), ("flip", "mean FLIP"))


def charts(rows, samplers, errors):
    """{kind: plots side by side}: gains against samples, error against samples and seconds, spectra."""
    made = {
        "gain": [curves.gain_curve(rows, samplers, measure, title) for measure, title in MEASURES],
        "spp": [curves.error_curve(rows, samplers, "spp", measure, title) for measure, title in MEASURES],
        "seconds": [curves.error_curve(rows, samplers, "seconds", measure, title) for measure, title in MEASURES],
        "spectra": [curves.spectrum_curve({s: errors[s, spp] for s in samplers}, samplers, page.samples(spp))
                    for spp in sorted({spp for _, spp in errors})]}
    return {what: page.grid(page.chart(page.svg(figure, fit=False)) for figure in figures) for what, figures in made.items()}


def headlines(rows, samplers, counts, own_error):
    """(headline, caption) for the last sampler against each other one, where seeds and reference permit a ratio."""
    found, own = [], {(row["sampler"], row["spp"]): row["each"]["rmse_2.1"] for row in rows}
    for other in samplers[:-1]:
        for spp in counts:
            ratio, why = comparison.judged(own[other, spp], own[samplers[-1], spp], own_error)
            if ratio is None:
                found.append(("\u2013", f"{other} at {page.samples(spp)}. {why}"))
            elif ratio.low <= 1 <= ratio.high:
                found.append(("even", f"with {other} at {page.samples(spp)} ({ratio.low:.2f} to {ratio.high:.2f})"))
            else:
                found.append((f"{ratio.value:.2f} \u00d7", f"less error than {other} at {page.samples(spp)} "
                              f"({ratio.low:.2f} to {ratio.high:.2f})"))
    return found if any(value != "\u2013" for value, _ in found) else []


HEADER = ("sampler", "spp", "seconds", "RMSE", "relative", "sigma 1.0", "sigma 2.1", "FLIP")


def table_texts(rows, counts):
    shown = sorted((row for row in rows if row["spp"] in counts), key=lambda row: row["spp"])
    return [(row["sampler"], str(row["spp"]), f"{row['seconds']:.3f}", f"{row['rmse']:.5f}",
             f"{row['relative_rmse']:.4f}", f"{row['rmse_1.0']:.5f}", f"{row['rmse_2.1']:.5f}", f"{row['flip']:.4f}")
            for row in shown]


def text_table(header, lines, group=0):
    """Lines of texts in columns, with an empty line after every `group` of them."""
    widths = [max(map(len, column)) for column in zip(header, *lines)]
    return "".join(("\n" if group and i > 1 and i % group == 1 else "") + line[0].ljust(widths[0]) + "  "
                   + "  ".join(c.rjust(w) for c, w in zip(line[1:], widths[1:])) + "\n" for i, line in enumerate((header, *lines)))


def write_report(options, reference_path, rows, pictures, notes):
    reference, attributes = read_exr(reference_path)
    samplers, counts = options.samplers, shown_counts(options.spp)
    images = {key: read_exr(path)[0] for key, path in pictures.items()}
    errors = {key: luminance_error(image, reference) for key, image in images.items()}
    for spp in counts:
        # A single firefly would dominate a spectrum.
        most = max(float(np.quantile(np.abs(errors[samplers[0], spp]), 0.99)), 1e-12)
        errors.update({(s, spp): np.clip(errors[s, spp], -most, most) for s in samplers})
    previews = {key: Image.open(path.with_suffix(".png")).convert("RGB") for key, path in pictures.items()}
    part = part_worth_showing(reference, images[samplers[0], counts[min(1, len(counts) - 1)]])
    grids = {spp: picture_rows(samplers, {s: errors[s, spp] for s in samplers},
                               {s: previews[s, spp] for s in samplers}, part) for spp in counts}
    found = {(row["sampler"], row["spp"]): row["each"]["rmse_2.1"] for row in rows}
    name, own_error = scene_label(options.scene), float(attributes.get("error2", 0.0))
    slider = comparison.widget(
        name, options.size, comparison.data_uri(preview(reference, options.exposure), lossless=True),
        {spp: {s: (comparison.data_uri(previews[s, spp], lossless=True), found[s, spp]) for s in samplers} for spp in counts},
        own_error, samplers[0], samplers[-1], counts[min(1, len(counts) - 1)])
    plots = charts(rows, samplers, errors)
    facts = headlines(rows, samplers, counts, own_error)
    said = [page.facts(facts, len(counts)), page.paragraph(
        f"{samplers[-1]} after a blur of 2.1 pixels: geometric means over {options.seeds} seeds with 95 % intervals.")]
    lines = table_texts(rows, counts)
    sections = [
        ("Side by side", [slider, *(said if facts else [])]),
        ("Pictures", [page.folded(page.samples(spp), [page.pictures(cells, ROWS, samplers)], spp == counts[0])
                      for spp, cells in grids.items()] +
         [page.paragraph("From top to bottom: the picture; a noisy part of it, enlarged; the signed luminance error on one scale "
                         "for all samplers, grey where it is zero; and the power spectrum of that error, frequency 0 in the "
                         f"middle, black at a thousandth of {samplers[0]}'s mean.")]),
        ("Plots", [page.paragraph(f"Error reduction over {samplers[0]}, medians over seeds:"), plots["gain"],
                   page.paragraph("Error against samples; the band spans the seeds:"), plots["spp"],
                   page.paragraph("Error against time:"), plots["seconds"],
                   page.paragraph("Power spectrum of the error. Blue noise has little power at low frequencies, the part that "
                                  f"survives a blur. Errors beyond {samplers[0]}'s 99th percentile are clipped."),
                   plots["spectra"]]),
        ("Figures", [page.table(HEADER, lines, [i for i, row in enumerate(lines) if row[0] == samplers[-1]],
                                range(len(samplers), len(lines), len(samplers)),
                                {s: style(s, samplers)["color"] for s in samplers}), *map(page.paragraph, notes)])]
    lead = (f"The samplers {', '.join(samplers[:-1])} and {samplers[-1]} on one scene, {options.size[0]}x{options.size[1]} pixels, from 1 to "
            f"{options.spp} samples per pixel. Drag the divider, or move it with the arrow keys; the blur shows what remains "
            "visible from a distance.") if len(samplers) > 1 else ""
    write_text(options.out / "report.html", page.page(f"How samplers converge: {name}", sections, lead))


def seeds_text(count):
    return f"the median of {count} seeds" if count > 1 else "of one seed"


def parse_samplers(text):
    names = list(dict.fromkeys(name for name in text.split(",") if name))
    if not names:
        raise argparse.ArgumentTypeError("must be sampler names separated by commas")
    return names


def seed(text):
    if not re.fullmatch(r"[0-9]{1,19}", text):
        raise argparse.ArgumentTypeError(f"must be a non-negative integer, not '{text}'")
    return int(text)


def parse_options(arguments):
    parser = argparse.ArgumentParser(
        prog="scripts/convergence", formatter_class=argparse.RawDescriptionHelpFormatter, description=__doc__,
        epilog="Arguments after -- are passed to the path tracer: scripts/convergence my.gltf -- --env sky.exr")
    parser.add_argument("scene", help="a built-in scene (pathtracer --list) or a .gltf, .glb or .obj file")
    parser.add_argument("--samplers", type=parse_samplers, default=["white", "sobol", "blue"], metavar="A,B,...",
                        help="samplers to compare, the baseline first (default white,sobol,blue)")
    parser.add_argument("--spp", type=positive, default=64, metavar="N", help="largest number of samples per pixel (default 64)")
    parser.add_argument("--size", type=parse_size, default=(256, 256), metavar="WxH", help="picture size (default 256x256)")
    parser.add_argument("--seed", type=seed, default=1, metavar="N", help="first seed (default 1)")
    parser.add_argument("--seeds", type=positive, default=5, metavar="N",
                        help=f"number of seeds over which medians are taken (default 5); FLIP uses at most {FLIP_SEEDS}, "
                        "pictures show the first")
    parser.add_argument("--exposure", type=float, default=0.0, metavar="EV", help="exposure of the pictures, in stops")
    parser.add_argument("--reference", metavar="FILE", help="use this EXR instead of rendering a reference")
    parser.add_argument("--reference-spp", type=positive, default=2048, metavar="N",
                        help="samples per pixel of the reference, a multiple of 32 (default 2048)")
    parser.add_argument("--threads", type=positive, metavar="N", help="number of threads (default: one per core)")
    parser.add_argument("--out", type=Path, metavar="FOLDER", help="output folder (default out/convergence/SCENE)")
    add_pathtracer(parser)
    arguments = list(arguments)
    more = ()
    if "--" in arguments:
        more = tuple(arguments[arguments.index("--") + 1:])
        arguments = arguments[:arguments.index("--")]
    options = parser.parse_args(arguments)
    options.more = more
    options.out = options.out or Path("out/convergence") / scene_label(options.scene)
    if options.reference_spp % REFERENCE_PARTS:
        parser.error(f"--reference-spp must be a multiple of {REFERENCE_PARTS}, not {options.reference_spp}")
    if not re.fullmatch(r"[A-Za-z0-9_-]+", options.scene) and not Path(options.scene).is_file():
        parser.error(f"file {options.scene} does not exist")
    return options


def run(arguments):
    options = parse_options(arguments)
    # Try names and sizes with one sample before spending hours on a reference.
    if options.reference:
        reference_path = given_reference(options.reference, options.size)
    options.out.mkdir(parents=True, exist_ok=True)
    for sampler in options.samplers:
        run_pathtracer(options.pathtracer, [*Request(sampler, 1, options.seed, options.scene, *options.size,
                                                     more=options.more).arguments(),
                                            "--quiet", "-o", options.out / ".probe.exr"])
    for suffix in (".exr", ".png"):
        (options.out / f".probe{suffix}").unlink(missing_ok=True)

    wanted = 0 if options.reference else options.reference_spp
    each = (options.seeds + flip_seeds(options.seeds)) * options.spp + sum(shown_counts(options.spp))
    progress = Progress(wanted + len(options.samplers) * each)
    try:
        if not options.reference:
            request = Request("sobol", wanted, REFERENCE_SEED, options.scene, *options.size, more=options.more)
            reference_path = make_reference(options.pathtracer, request, cache_folder() / "references",
                                            lambda share: progress(f"reference, {wanted} spp", share * wanted))
        rows, pictures = measure(options, reference_path, progress, wanted)
    finally:
        progress.close()
    attributes = read_exr(reference_path)[1]
    notes = [f"Scene {options.scene}, {options.size[0]}x{options.size[1]} pixels. RMSE is the root mean square over pixels "
             f"and channels of linear radiance, {seeds_text(options.seeds)}; the relative RMSE divides each pixel's error by the "
             "reference. Sigma is the Gaussian blur, in pixels, before the error is measured: what remains visible from a "
             f"distance. FLIP is the mean of HDR-FLIP, {seeds_text(flip_seeds(options.seeds))}. Seconds count rendering only, "
             "the median of progressive runs."]
    fireflies = {sampler: int(read_exr(pictures[sampler, options.spp])[1].get("fireflies", 0))
                 for sampler in options.samplers}
    if any(fireflies.values()):
        found = ", ".join(f"{count} with {sampler}" for sampler, count in fireflies.items())
        notes.append(f"Fireflies at {page.samples(options.spp)}: {found}. These few pixels can dominate the RMSE, which then "
                     "says little about the rest of the picture; FLIP is hardly affected.")
    if "error0" in attributes:
        own = ", ".join(f"{attributes[f'error{i}']:.5f} after sigma {sigma}" for i, sigma in enumerate(SIGMAS) if sigma)
        own = f"{attributes['error0']:.5f}, {own}"
        notes.append(f"Reference: sampler sobol, {attributes['spp']} spp, a different seed. Its own error is about {own}; "
                     "errors close to that are unreliable.")
    write_rows(options.out / "convergence.csv", FIELDS, [{name: row[name] for name in FIELDS} for row in rows])
    write_report(options, reference_path, rows, pictures, notes)
    print(text_table(HEADER, table_texts(rows, shown_counts(options.spp))))
    for note in notes:
        print(note)
    print(f"Written: {options.out}/report.html, convergence.csv, and an EXR and a PNG of each picture.")


def main(arguments=None):
    run_or_say_why(run, arguments, "convergence")


if __name__ == "__main__":
    main()
