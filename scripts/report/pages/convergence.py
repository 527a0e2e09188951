# SPDX-License-Identifier: Apache-2.0
"""How samplers converge on one scene, including your own: `scripts/convergence my.gltf`, and `scripts/demo` for the Cornell box

Renders progressive runs of each sampler, then a reference (kept in ~/.cache/libbn), and measures the error at every count and
seed. Writes report.html with a slider that compares two pictures, enlarged parts, error images and their spectra, and plots of
error against samples and time; the figures are in convergence.csv. The page has the pictures first and grows while the rest is
rendered. What is rendered is kept in the output folder, so an interrupted run resumes.
"""

import argparse
import dataclasses
import re
import statistics
from pathlib import Path

import numpy as np
from PIL import Image
from scipy import ndimage

from ..base.command import CommandError, add_pathtracer, parse_size, positive, split_more
from ..base.contact_sheet import enlarged_part, grey, preview
from ..base.files import read_exr, read_rows, sha256_of, write_exr, write_image, write_rows, write_text
from ..base.palette import style
from ..base.progress import Progress
from ..measure.flip import mean_flip
from ..measure.image_error import (
    LUMINANCE,
    SIGMAS,
    blurred,
    error_image,
    fireflies,
    luminance_error,
    radial_spectrum,
    relative_rmse,
    rmse,
    spectrum_image,
)
from ..renders.renderer import (
    REFERENCE_PARTS,
    REFERENCE_SEED,
    Renderer,
    Request,
    cache_folder,
    files_beside,
    make_reference,
    progressive,
    run_pathtracer,
    scene_label,
)
from . import curves, page, slider

ERRORS = ("rmse", "relative_rmse", "rmse_1.0", "rmse_2.1", "flip")
FIELDS = ("sampler", "spp", "seconds", *ERRORS)
MEASURES = (("rmse_2.1", "RMSE after a blur of 2.1 pixels"), ("rmse", "RMSE"), ("flip", "mean FLIP"))
# FLIP takes longer than the renders themselves and hardly differs between seeds.
FLIP_SEEDS = 3
SAMPLERS = ("white", "sobol", "blue")
# scripts/demo: all counts are steps of one run, which is where padded Sobol' falls back. The scene is dark except for its lamp.
DEMO = {"counts": (*range(1, 17), 64), "shown": (*range(1, 17), 64), "galleries": (1, 3, 4, 16), "headlines": (3, 16), "start": (3, "2.1"),
        "exposure": 1.0, "seed": 0, "seeds": 6, "flip": False, "printed": (1, 2, 3, 4, 6, 8, 12, 16, 64)}


def counts_to(spp):
    """Powers of two and three times those, as the path tracer records its errors."""
    return sorted({n for k in range(17) for n in (2**k, 3 * 2**k) if n < spp} | {spp})


def shown_counts(spp):
    return [*[n for n in (1, 4, 16, 64, 256) if n < spp][-3:], spp]


# ---- Rendering and measuring

def render_pictures(renderer, request, options):
    """[EXR] of the first seed at all counts, steps of one run, with a PNG of each beside it."""
    def make(paths):
        for path, (_, picture, attributes) in zip(paths[::2], progressive(renderer.program, request, options.counts, renderer.threads)):
            write_exr(path, picture, {name: attributes[name] for name in ("sampler", "seed", "spp", "seconds", "scene") if name in attributes})
            write_image(path.with_suffix(".png"), preview(picture, options.exposure))

    names = [f"{request.sampler}_{spp}{suffix}" for spp in options.counts for suffix in (".exr", ".png")]
    return renderer.kept(request, names, make, counts=list(options.counts), shown_at=options.exposure, files=files_beside(request.scene))[::2]


def measure_run(renderer, request, options, reference_path, pictures=None):
    """[{spp, seconds, errors}] at the counts of one seed's run; pictures: those of the first seed, which are rendered."""
    flip = options.flip and request.seed < options.seed + FLIP_SEEDS

    def make(paths):
        run = ((spp, *read_exr(path)) for spp, path in zip(options.counts, pictures)) if pictures else progressive(
            renderer.program, request, options.counts, renderer.threads)
        reference, rows = read_exr(reference_path)[0], []
        for spp, picture, attributes in run:
            rows.append({"spp": spp, "seconds": attributes["seconds"], "relative_rmse": relative_rmse(picture, reference),
                         **{f"rmse_{sigma}" if sigma else "rmse": rmse(picture, reference, sigma) for sigma in SIGMAS}})
            if flip:
                rows[-1]["flip"] = mean_flip(picture, reference)
        write_rows(paths[0], list(rows[0]), rows)

    (path,) = renderer.kept(request, [f"errors/{request.sampler}_{request.seed}.csv"], make, counts=list(options.counts), flip=flip,
                            reference=sha256_of(reference_path), files=files_beside(request.scene))
    return [{name: float(value) for name, value in row.items()} for row in read_rows(path)]


def over_seeds(sampler, runs):
    """One row per sample count: medians, which are robust to fireflies, and under "each" the errors of every seed."""
    rows = []
    for same in zip(*runs):
        each = {name: [row[name] for row in same if name in row] for name in ERRORS}
        rows.append({"sampler": sampler, "spp": int(same[0]["spp"]), "seconds": statistics.median(row["seconds"] for row in same),
                     **{name: statistics.median(found) for name, found in each.items() if found}, "each": each})
    return rows


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


# ---- The page

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


def gallery(samplers, errors, previews, part):
    """For one count, a row over samplers: an enlarged part, its error, that error after a blur, and the spectrum of the error."""
    white = errors[samplers[0]]
    factor = max(1, min(white.shape) // part[2])
    rows = [[enlarged_part(previews[s], part, factor) for s in samplers]]
    for sigma in (0.0, SIGMAS[-1]):
        shown = {s: blurred(errors[s], sigma) for s in samplers}
        # One grey scale for all samplers: three standard deviations of white noise, robust to the lights.
        full_scale = max(3 * 1.4826 * float(np.median(np.abs(shown[samplers[0]]))), 1e-12)
        rows.append([enlarged_part(grey(error_image(shown[s], full_scale)), part, factor) for s in samplers])
    level = max(float(np.mean(radial_spectrum(white)[1])), 1e-30)
    return page.pictures([*rows, [grey(spectrum_image(errors[s], level)) for s in samplers]],
                         ("enlarged", "error", "error, blurred", "spectrum"), samplers)


def charts(rows, samplers, errors):
    """Parts of the page: gains, errors against samples and time, spectra."""
    measures = [(measure, title) for measure, title in MEASURES if measure in rows[0]]

    def against(key):
        return page.grid(page.chart(curves.error_curve(rows, samplers, key, measure, title)) for measure, title in measures)

    return [page.paragraph(f"Error reduction over {samplers[0]}, medians over seeds:"),
            page.grid(page.chart(curves.gain_curve(rows, samplers, measure, title)) for measure, title in measures),
            page.paragraph("Error against samples; the band spans the seeds:"), against("spp"),
            page.paragraph("Error against time:"), against("seconds"),
            page.paragraph("Power spectrum of the error. Blue noise has little power at low frequencies, the part that "
                           f"survives a blur. Errors beyond {samplers[0]}'s 99th percentile are clipped."),
            page.grid(page.chart(curves.spectrum_curve({s: errors[s, spp] for s in samplers}, samplers, page.samples(spp)))
                      for spp in sorted({spp for _, spp in errors}))]


def headlines(rows, samplers, counts, own_error):
    """(headline, caption) for the last sampler against each other one, where seeds and reference permit a ratio."""
    found, own = [], {(row["sampler"], row["spp"]): row["each"]["rmse_2.1"] for row in rows}
    for other in samplers[:-1]:
        for spp in counts:
            ratio, why = slider.judged(own[other, spp], own[samplers[-1], spp], own_error)
            if ratio is None:
                found.append(("\u2013", f"{other} at {page.samples(spp)}. {why}"))
            elif ratio.low <= 1 <= ratio.high:
                found.append(("even", f"with {other} at {page.samples(spp)} ({ratio.low:.2f} to {ratio.high:.2f})"))
            else:
                found.append((f"{ratio.value:.2f} \u00d7", f"less error than {other} at {page.samples(spp)} "
                              f"({ratio.low:.2f} to {ratio.high:.2f})"))
    return found if any(value != "\u2013" for value, _ in found) else []


def header(samplers):
    return ("sampler", "spp", "seconds", "RMSE", "relative", "sigma 1.0", "sigma 2.1", "FLIP", f"over {samplers[-1]}")


def texts(rows, samplers, counts):
    """The table's lines: of errors after sigma 2.1, the last column is that over the last sampler's."""
    last = {row["spp"]: row["rmse_2.1"] for row in rows if row["sampler"] == samplers[-1]}
    return [(row["sampler"], str(row["spp"]), f"{row['seconds']:.3f}", f"{row['rmse']:.5f}", f"{row['relative_rmse']:.4f}",
             f"{row['rmse_1.0']:.5f}", f"{row['rmse_2.1']:.5f}", f"{row['flip']:.4f}" if "flip" in row else "",
             f"{row['rmse_2.1'] / last[row['spp']]:.2f}" if last[row["spp"]] else "")
            for row in sorted(rows, key=lambda row: row["spp"]) if row["spp"] in counts]


def text_table(head, lines, group):
    """Lines of texts in columns, with an empty line after every `group` of them."""
    widths = [max(map(len, column)) for column in zip(head, *lines)]
    return "".join(("\n" if i > 1 and i % group == 1 % group else "") + line[0].ljust(widths[0]) + "  "
                   + "  ".join(c.rjust(w) for c, w in zip(line[1:], widths[1:])) + "\n" for i, line in enumerate((head, *lines)))


def write_page(options, images, rows=(), pictures=None, reference=None, own_error=0.0, notes=()):
    """The page, once with the pictures alone (images: {(sampler, spp): 8-bit image}), and once with everything."""
    samplers, name = options.samplers, scene_label(options.scene)
    shown = {key: image for key, image in images.items() if key[1] in options.shown}
    compare = slider.widget(name, None if reference is None else preview(reference, options.exposure), shown, samplers, rows, own_error,
                            *options.start)
    lead = ("Equally many samples with each sampler. Drag the divider, and step through the samples. The blur shows what remains visible from a "
            "distance; switch it off to see each pixel.")
    if not rows:
        growing = page.still_growing("Still to come: errors, plots and tables, once the reference is rendered.")
        return write_text(options.out / "report.html", page.page(f"How samplers converge: {name}", [("Side by side", [growing, compare])], lead))
    errors = {(s, spp): luminance_error(pictures[s, spp], reference) for spp in options.galleries for s in samplers}
    for spp in options.galleries:
        # A single firefly would dominate a spectrum.
        most = max(float(np.quantile(np.abs(errors[samplers[0], spp]), 0.99)), 1e-12)
        errors.update({(s, spp): np.clip(errors[s, spp], -most, most) for s in samplers})
    part = part_worth_showing(reference, pictures[samplers[0], options.start[0]])
    facts = headlines(rows, samplers, options.headlines, own_error)
    said = [page.facts(facts, min(len(facts), 4)), page.paragraph(
        f"{samplers[-1]} after a blur of 2.1 pixels: geometric means over {options.seeds} seeds with 95 % intervals.")] if facts else []
    lines = texts(rows, samplers, options.counts)
    sections = [
        ("Side by side", [*said[:1], compare, *said[1:]]),
        ("Pictures", [page.folded(page.samples(spp), [gallery(samplers, {s: errors[s, spp] for s in samplers},
                                                              {s: images[s, spp] for s in samplers}, part)], spp == options.start[0])
                      for spp in options.galleries] +
         [page.paragraph("A noisy part of the picture, enlarged; its signed luminance error, grey where it is zero, on one scale for all "
                         "samplers; that error after a blur of 2.1 pixels, on another; and the power spectrum of the error, frequency 0 in "
                         f"the middle, black at a thousandth of {samplers[0]}'s mean.")]),
        ("Plots", charts(rows, samplers, errors)),
        ("Figures", [page.table(header(samplers), lines, [i for i, row in enumerate(lines) if row[0] == samplers[-1]],
                                range(len(samplers), len(lines), len(samplers)),
                                {s: style(s, samplers)["color"] for s in samplers}), *map(page.paragraph, notes)])]
    write_text(options.out / "report.html", page.page(f"How samplers converge: {name}", sections, lead))


# ---- The command

def seeds_text(count):
    return f"the median of {count} seeds" if count > 1 else "of one seed"


def notes_of(options, attributes, last):
    notes = [f"Scene {options.scene}, {options.size[0]}x{options.size[1]} pixels. RMSE is the root mean square over pixels "
             f"and channels of linear radiance, {seeds_text(options.seeds)}; the relative RMSE divides each pixel's error by the "
             "reference. Sigma is the Gaussian blur, in pixels, before the error is measured: what remains visible from a "
             f"distance; the last column divides that after 2.1 pixels by {options.samplers[-1]}'s. "
             + (f"FLIP is the mean of HDR-FLIP, {seeds_text(min(options.seeds, FLIP_SEEDS))}. " if options.flip else "")
             + "Seconds count rendering only, the median of progressive runs."]
    found = {sampler: fireflies(picture) for sampler, picture in last.items()}
    if any(found.values()):
        notes.append(f"Fireflies at {page.samples(options.counts[-1])}: {', '.join(f'{count} with {name}' for name, count in found.items())}. "
                     "These few pixels can dominate the RMSE, which then says little about the rest of the picture; FLIP is hardly affected.")
    if "error0" in attributes:
        own = ", ".join([f"{attributes['error0']:.5f}", *(
            f"{attributes[f'error{i}']:.5f} after sigma {sigma}" for i, sigma in enumerate(SIGMAS) if sigma)])
        notes.append(f"Reference: sampler sobol, {attributes['spp']} spp, a different seed. Its own error is about {own}; "
                     "errors close to that are unreliable.")
    return notes


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
    parser.add_argument("--samplers", type=parse_samplers, default=list(SAMPLERS), metavar="A,B,...",
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
    parser.add_argument("--demo", action="store_true", help=argparse.SUPPRESS)
    add_pathtracer(parser)
    arguments, more = split_more(arguments)
    options = parser.parse_args(arguments)
    options.more = more
    options.out = options.out or Path("out/convergence") / scene_label(options.scene)
    shown = shown_counts(options.spp)
    vars(options).update({"counts": counts_to(options.spp), "shown": shown, "galleries": shown, "headlines": shown, "printed": shown,
                          "start": (shown[min(1, len(shown) - 1)], "0"), "flip": True, **(DEMO if options.demo else {})})
    if options.reference_spp % REFERENCE_PARTS:
        parser.error(f"--reference-spp must be a multiple of {REFERENCE_PARTS}, not {options.reference_spp}")
    if not re.fullmatch(r"[A-Za-z0-9_-]+", options.scene) and not Path(options.scene).is_file():
        parser.error(f"file {options.scene} does not exist")
    return options


def run(arguments):
    options = parse_options(arguments)
    renderer = Renderer(options.pathtracer, options.out, options.threads)
    requests = {sampler: Request(sampler, options.counts[-1], options.seed, options.scene, *options.size, exposure=options.exposure,
                                 more=options.more) for sampler in options.samplers}
    # Try names and sizes with one sample before spending hours on a reference.
    if options.reference:
        reference_path = given_reference(options.reference, options.size)
    options.out.mkdir(parents=True, exist_ok=True)
    for request in requests.values():
        run_pathtracer(options.pathtracer, [*dataclasses.replace(request, spp=1).arguments(), "--quiet", "-o", options.out / ".probe.exr"])
    for suffix in (".exr", ".png"):
        (options.out / f".probe{suffix}").unlink(missing_ok=True)

    wanted, each, done = 0 if options.reference else options.reference_spp, options.counts[-1], 0
    progress, paths, runs = Progress(wanted + len(requests) * options.seeds * each), {}, {}
    try:
        for sampler, request in requests.items():
            progress(f"{sampler}, seed {options.seed}", done)
            paths.update({(sampler, spp): path for spp, path in zip(options.counts, render_pictures(renderer, request, options))})
            done += each
        images = {key: Image.open(path.with_suffix(".png")).convert("RGB") for key, path in paths.items()}
        write_page(options, images)
        progress.say(f"{options.out}/report.html shows the pictures; errors and plots follow")
        if not options.reference:
            request = Request("sobol", wanted, REFERENCE_SEED, options.scene, *options.size, more=options.more)
            reference_path = make_reference(options.pathtracer, request, cache_folder() / "references",
                                            lambda share, done=done: progress(f"reference, {wanted} spp", done + share * wanted))
            done += wanted
        # Interleaved, so that other load on the machine affects all alike.
        for number in range(options.seed, options.seed + options.seeds):
            for sampler, request in requests.items():
                progress(f"{sampler}, seed {number}", done)
                own = [paths[sampler, spp] for spp in options.counts] if number == options.seed else None
                runs.setdefault(sampler, []).append(
                    measure_run(renderer, dataclasses.replace(request, seed=number), options, reference_path, own))
                done += 0 if own else each
    finally:
        progress.close()
    reference, attributes = read_exr(reference_path)
    rows = [row for sampler in options.samplers for row in over_seeds(sampler, runs[sampler])]
    pictures = {key: read_exr(path)[0] for key, path in paths.items()}
    notes = notes_of(options, attributes, {sampler: pictures[sampler, options.counts[-1]] for sampler in options.samplers})
    write_rows(options.out / "convergence.csv", FIELDS, [{name: row.get(name, "") for name in FIELDS} for row in rows])
    write_page(options, images, rows, pictures, reference, float(attributes.get("error2", 0.0)), notes)
    print(text_table(header(options.samplers), texts(rows, options.samplers, options.printed), len(options.samplers)))
    for note in notes:
        print(note)
    print(f"Written: {options.out}/report.html, convergence.csv, and an EXR and a PNG of each picture.")
