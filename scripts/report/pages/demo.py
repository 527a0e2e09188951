# SPDX-License-Identifier: Apache-2.0
"""The comparison of scripts/demo: one scene with white noise, Sobol' and blue noise, against a reference."""

import argparse
from pathlib import Path

import numpy as np
from PIL import Image

from ..base.command import run_or_say_why
from ..base.contact_sheet import enlarged_part, grey, preview, sheet
from ..base.files import read_exr, read_rows, sha256_of, write_exr, write_image, write_rows, write_text
from ..base.palette import style
from ..base.progress import Progress
from ..measure.image_error import SIGMAS, blurred, error_image, luminance_error, rmse
from ..renders.renderer import Renderer, Request, progressive
from . import comparison, curves, page
from .convergence import headlines, text_table
from .stepper import stepper

SAMPLERS = ("white", "sobol", "blue")
# Every count is a step of one progressive run. The first seeds go on to the last count, where pictures vary less.
COUNTS = (*range(1, 17), 64)
SEEDS, LATE_SEEDS = 8, 4
# What the printed table and the galleries show, what the headlines say, and where the page opens.
TABLE_COUNTS = (1, 2, 3, 4, 6, 8, 12, 16, 64)
GALLERY_COUNTS = (1, 3, 4, 16)
HEADLINE_COUNTS = (3, 16)
FIRST_COUNT, FIRST_BLUR = 3, "2.1"
SCENE, SIZE = "cornell", 256
EXPOSURE = 1.0  # of the previews, in stops: the scene is dark except for its lamp
# The reference has a different seed, so it shares no sample with the pictures.
REFERENCE_SEED, REFERENCE_SPP = 1_000_003, 2048
# Where a penumbra, the edge of a box and flat faces meet: left, top, width, height in pixels.
PART = (64, 166, 64, 64)
PARTS = 64


def seeds_at(spp):
    """The number of seeds at a count."""
    return LATE_SEEDS if spp > COUNTS[-2] else SEEDS


def counts_of(seed):
    return [spp for spp in COUNTS if seed < seeds_at(spp)]


def picture_name(sampler, spp):
    return f"{SCENE}_{sampler}_{spp}"


def render_pictures(renderer, sampler):
    """The EXR pictures of the first seed with one sampler, at all counts of one run, with a PNG of each beside it."""
    def make(paths):
        run = progressive(renderer.program, request, COUNTS, renderer.threads)
        for path, (_, picture, attributes) in zip(paths[::2], run):
            write_exr(path, picture, {name: attributes[name] for name in ("sampler", "seed", "spp", "seconds", "scene")
                                      if name in attributes})
            write_image(path.with_suffix(".png"), preview(picture, EXPOSURE))

    request = Request(sampler, COUNTS[-1], 0, SCENE, SIZE, SIZE, exposure=EXPOSURE)
    names = [f"{picture_name(sampler, spp)}{suffix}" for spp in COUNTS for suffix in (".exr", ".png")]
    return renderer.kept(request, names, make, counts=list(COUNTS))[::2]


def render_errors(renderer, sampler, seed, reference_path):
    """[{spp, seconds, sigma: error}] at the counts of one seed's run; those of the first are the pictures'."""
    counts = counts_of(seed)

    def make(paths):
        if seed == 0:
            run = ((spp, *read_exr(renderer.folder / f"{picture_name(sampler, spp)}.exr")) for spp in counts)
        else:
            run = progressive(renderer.program, request, counts, renderer.threads)
        reference, _ = read_exr(reference_path)
        write_rows(paths[0], ["spp", "seconds", *map(str, SIGMAS)],
                   [{"spp": spp, "seconds": attributes["seconds"],
                     **{str(sigma): rmse(picture, reference, sigma) for sigma in SIGMAS}} for spp, picture, attributes in run])

    request = Request(sampler, counts[-1], seed, SCENE, SIZE, SIZE)
    (path,) = renderer.kept(request, [f"errors/{sampler}_{seed}.csv"], make, counts=counts, reference=sha256_of(reference_path))
    return [{name: float(value) for name, value in row.items()} for row in read_rows(path)]


def measure(runs):
    """Rows of the table from {(sampler, seed): rows of render_errors}: dicts with sampler, spp, rmse (one per sigma, root mean
    square over seeds), each (errors of every seed, unblurred and after sigma 2.1) and seconds."""
    rows = []
    for spp in COUNTS:
        for sampler in SAMPLERS:
            same = [row for (name, _), run in sorted(runs.items()) if name == sampler for row in run if row["spp"] == spp]
            each = [[row[str(sigma)] for row in same] for sigma in SIGMAS]
            rows.append({"sampler": sampler, "spp": spp, "rmse": [comparison.rms(found) for found in each],
                         "seconds": float(np.median([row["seconds"] for row in same])),
                         "each": {"plain": each[0], "blurred": each[2]}})
    by_key = {(row["sampler"], row["spp"]): row for row in rows}
    for row in rows:
        row["plain"], row["blurred"] = row["rmse"][0], row["rmse"][2]
        for other in ("white", "sobol"):
            row[f"than_{other}"] = [theirs / own for own, theirs in
                                    zip(row["rmse"], by_key[other, row["spp"]]["rmse"])]
    return rows


HEADER = ("sampler", "spp", "RMSE", "sigma 1.0", "sigma 2.1", "seconds", "vs white", "vs sobol",
          "vs sobol, unblurred")


def texts(row):
    return (row["sampler"], str(row["spp"]), *(f"{error:.5f}" for error in row["rmse"]), f"{row['seconds']:.2f}",
            f"{row['than_white'][2]:.2f} x", f"{row['than_sobol'][2]:.2f} x", f"{row['than_sobol'][0]:.2f} x")


def printed_table(rows):
    return text_table(HEADER, [texts(row) for row in rows if row["spp"] in TABLE_COUNTS], len(SAMPLERS))


def write_csv(path, rows):
    names = [f"rmse_sigma_{sigma}" for sigma in SIGMAS]
    write_rows(path, ["sampler", "spp", *names, "seconds"], [
        {"sampler": row["sampler"], "spp": row["spp"], **dict(zip(names, row["rmse"])), "seconds": row["seconds"]} for row in rows])


def gallery(pictures, reference, spp):
    """The enlarged part with each sampler, its signed error, and that error after a blur."""
    left, top, width, height = PART
    box = (left, top, left + width, top + height)
    images = {sampler: pictures[sampler, spp] for sampler in SAMPLERS}
    errors = {sampler: luminance_error(image, reference) for sampler, image in images.items()}
    rows = [[preview(image, EXPOSURE).crop(box) for image in images.values()]]
    for sigma in (0.0, SIGMAS[-1]):
        blurs = {sampler: blurred(error, sigma) for sampler, error in errors.items()}
        # One grey scale for all samplers: three standard deviations of white noise, robust to the lights.
        full_scale = 3 * 1.4826 * float(np.median(np.abs(blurs["white"])))
        rows.append([grey(error_image(error, full_scale)).crop(box) for error in blurs.values()])
    return page.pictures(rows, ("enlarged", "error", "error, blurred"), SAMPLERS)


MEASURES = (("blurred", "RMSE after a blur of 2.1 pixels"), ("plain", "RMSE, unblurred"))


def charts(rows, errors):
    """Parts of the page: gains, errors against samples and time, spectra."""
    gains = [curves.gain_curve(rows, SAMPLERS, measure, title) for measure, title in MEASURES]
    plots = [curves.error_curve(rows, SAMPLERS, "spp", "plain", f"{MEASURES[1][1]}, against samples"),
             curves.error_curve(rows, SAMPLERS, "seconds", "blurred", f"{MEASURES[0][1]}, against time")]
    spectra = [curves.spectrum_curve({s: errors[s, spp] for s in SAMPLERS}, SAMPLERS, page.samples(spp))
               for spp in GALLERY_COUNTS]
    return [page.paragraph("Error reduction over white noise, and the error itself:"),
            page.grid(page.chart(figure) for figure in gains + plots),
            page.paragraph("Power spectrum of the luminance error. Blue noise has little power at low frequencies, the part "
                           "that survives a blur."), page.grid(page.chart(figure) for figure in spectra)]


LEAD = ("One scene with equally many samples of white noise, Sobol' and blue noise. Drag the divider, and step through the samples. The "
        "blur shows what remains visible from a distance; switch it off to see each pixel.")
TITLE = "Blue noise in the Cornell box"


def slider(images, reference, rows=(), own_error=0.0):
    """The pictures of two samplers under a divider. images: {(sampler, spp): 8-bit image}."""
    errors = {(row["sampler"], row["spp"]): row["each"]["blurred"] for row in rows}
    below, beside = stepper(COUNTS, SAMPLERS, rows)
    counts = {spp: {s: (comparison.data_uri(images[s, spp]), errors.get((s, spp), [])) for s in SAMPLERS} for spp in COUNTS}
    return comparison.widget(SCENE, (SIZE, SIZE), "" if reference is None else comparison.data_uri(preview(reference, EXPOSURE)),
                             counts, own_error, spp=FIRST_COUNT, blur=FIRST_BLUR, below=below, beside=beside)


def write_early_report(folder, images, missing):
    """The page while errors are measured: the pictures, and what is still to come."""
    write_text(folder / "report.html", page.page(
        TITLE, [("Side by side", [page.still_growing(f"Still to come: {missing}."), slider(images, None)])], LEAD))


def write_report(folder, rows, pictures, images, reference, own_error, notes):
    """pictures: {(sampler, spp): linear radiance}; images: the same as 8-bit images."""
    contact = sheet([[[images[s, n], enlarged_part(images[s, n], PART, SIZE // PART[2])] for n in GALLERY_COUNTS] for s in SAMPLERS], SAMPLERS,
                    [f"{spp} spp" for spp in GALLERY_COUNTS])
    write_image(folder / "contact_sheet.png", contact)

    facts = headlines([{**row, "each": {"rmse_2.1": row["each"]["blurred"]}} for row in rows], SAMPLERS, HEADLINE_COUNTS, own_error)
    said = [page.facts(facts, len(facts)), page.paragraph(
        f"Error of blue after a blur of 2.1 pixels: geometric means over {SEEDS} seeds with 95 % intervals.")]
    errors = {key: luminance_error(pictures[key], reference) for key in pictures if key[1] in GALLERY_COUNTS}
    grids = [page.folded(page.samples(spp), [gallery(pictures, reference, spp)], spp == FIRST_COUNT) for spp in GALLERY_COUNTS]
    blue = [i for i, row in enumerate(rows) if row["sampler"] == "blue"]
    sections = [
        ("Side by side", [*(said[:1] if facts else []), slider(images, reference, rows, own_error), *(said[1:] if facts else [])]),
        ("Pictures", [*grids, page.paragraph("A part of the picture, enlarged; its signed luminance error, grey where it is zero, on one "
                                             "scale for all samplers; and that error after a blur of 2.1 pixels, on another.")]),
        ("Plots", charts(rows, errors)),
        ("Figures", [page.table(HEADER, map(texts, rows), blue, range(len(SAMPLERS), len(rows), len(SAMPLERS)),
                                {s: style(s, SAMPLERS)["color"] for s in SAMPLERS}), *map(page.paragraph, notes)])]
    write_text(folder / "report.html", page.page(TITLE, sections, LEAD))


def render_all(renderer):
    """Renders what is missing, the pictures first, and writes the page twice: with the pictures, and with everything.

    Returns the rows of the table and the notes below it.
    """
    done, total = 0, REFERENCE_SPP + len(SAMPLERS) * sum(counts_of(seed)[-1] for seed in range(SEEDS))
    progress = Progress(total)
    try:
        paths = {}
        for sampler in SAMPLERS:
            progress(f"{sampler}, seed 0", done)
            paths.update(zip(((sampler, spp) for spp in COUNTS), render_pictures(renderer, sampler)))
            done += COUNTS[-1]
        images = {key: Image.open(path.with_suffix(".png")).convert("RGB") for key, path in paths.items()}
        write_early_report(renderer.folder, images, "errors, plots and tables, once the reference is rendered")
        progress.say(f"{renderer.folder}/report.html shows the pictures; errors and plots follow")
        before = done
        reference_path = renderer.reference(
            Request("sobol", REFERENCE_SPP, REFERENCE_SEED, SCENE, SIZE, SIZE), "reference.exr", PARTS,
            lambda fraction: progress(f"reference, {REFERENCE_SPP} spp", before + fraction * REFERENCE_SPP))
        done += REFERENCE_SPP
        runs = {}
        for seed in range(SEEDS):
            for sampler in SAMPLERS:
                progress(f"{sampler}, seed {seed}", done)
                runs[sampler, seed] = render_errors(renderer, sampler, seed, reference_path)
                done += counts_of(seed)[-1] if seed else 0
    finally:
        progress.close()
    reference, attributes = read_exr(reference_path)
    rows = measure(runs)
    notes = (
        f"Scene {SCENE}, {SIZE}x{SIZE} pixels. Errors are root mean squares over pixels, channels and seeds "
        f"({SEEDS}, {LATE_SEEDS} at {COUNTS[-1]} spp) of linear radiance, unblurred and after Gaussians of 1.0 and 2.1 pixels; "
        "all counts are steps of one progressive run for each seed, and seconds the median of these runs. "
        "'vs white' and 'vs sobol' say how many times smaller the error after sigma 2.1 is.",
        f"Reference: sampler sobol, {REFERENCE_SPP} spp, a different seed. Its own error is about "
        f"{attributes['error0']:.5f}, {attributes['error1']:.5f} after sigma 1.0 and {attributes['error2']:.5f} after 2.1.",
    )
    write_csv(renderer.folder / "table.csv", rows)
    pictures = {key: read_exr(path)[0] for key, path in paths.items()}
    write_report(renderer.folder, rows, pictures, images, reference, attributes["error2"], notes)
    return rows, notes


def main(arguments):
    parser = argparse.ArgumentParser(prog="demo", description=__doc__)
    parser.add_argument("--pathtracer", type=Path, required=True, help=argparse.SUPPRESS)
    parser.add_argument("--out", type=Path, default=Path("out/demo"), help="output folder (default out/demo)")
    options = parser.parse_args(arguments)
    renderer = Renderer(options.pathtracer, options.out)
    rows, notes = render_all(renderer)
    print(printed_table(rows))
    for note in notes:
        print(note)
    print(f"Written: {options.out}/report.html, contact_sheet.png, table.csv, and an EXR and a PNG of each picture.")


if __name__ == "__main__":
    run_or_say_why(main, program="demo")
