# SPDX-License-Identifier: Apache-2.0
"""The comparison of scripts/demo: one scene with white noise, Sobol' and blue noise, against a reference."""

import argparse
import csv
import io
import sys
from pathlib import Path

import numpy as np
from PIL import Image

from . import comparison, curves, page
from .contact_sheet import enlarged_part, grey, preview, sheet, zoomed
from .files import read_exr, write_image, write_text, written_beside
from .image_error import SIGMAS, blurred, error_image, luminance_error, rmse
from .palette import style
from .progress import Progress
from .renderer import RenderError, Renderer, Request

SAMPLERS = ("white", "sobol", "blue")
# Samples per pixel, and the number of seeds for each: pictures with few samples vary more.
SEEDS = {1: 32, 4: 16, 16: 6, 64: 4}
COUNTS = tuple(SEEDS)
SCENE, SIZE = "cornell", 256
EXPOSURE = 1.0  # of the previews, in stops: the scene is dark except for its lamp
# The reference has a different seed, so it shares no sample with the pictures.
REFERENCE_SEED, REFERENCE_SPP = 1_000_003, 4096
# Where a penumbra, the edge of a box and flat faces meet: left, top, width, height in pixels.
PART = (64, 166, 64, 64)
PARTS = 64
# The README's picture: a soft shadow at one sample per pixel, where the difference is obvious. Its size, the part shown,
# the magnification, and the blur that simulates a step back.
PICTURE_SCENE, PICTURE_COUNT, PICTURE_SIZE, PICTURE_SEED = "penumbra", 1, (384, 288), 0
PICTURE_PART, PICTURE_FACTOR, PICTURE_BLUR = (120, 92, 116, 110), 2, 1.0
PICTURE_FILE = "noise.png"
PICTURE_NAMES = {"white": "white noise", "sobol": "Sobol'", "blue": "blue noise"}


def render_all(renderer):
    """The reference, and {(sampler, spp): [path for each seed]}; valid renders are reused."""
    progress = Progress(REFERENCE_SPP + len(SAMPLERS) * sum(spp * count for spp, count in SEEDS.items()))
    try:
        reference = renderer.reference(
            Request("sobol", REFERENCE_SPP, REFERENCE_SEED, SCENE, SIZE, SIZE), "reference.exr", PARTS,
            lambda fraction: progress(f"reference, {REFERENCE_SPP} spp", fraction * REFERENCE_SPP))
        pictures, done = {}, REFERENCE_SPP
        for spp, seed_count in SEEDS.items():
            for seed in range(seed_count):
                for sampler in SAMPLERS:
                    progress(f"{sampler}, {spp} spp, seed {seed}", done)
                    folder = "" if seed == 0 else f"seeds/{seed}/"
                    name = f"{folder}{SCENE}_{sampler}_{spp}.exr"
                    path = renderer.render(Request(sampler, spp, seed, SCENE, SIZE, SIZE, exposure=EXPOSURE), name)
                    pictures.setdefault((sampler, spp), []).append(path)
                    done += spp
    finally:
        progress.close()
    return reference, pictures


def measure(reference, pictures):
    """Rows of the table: dicts with sampler, spp, rmse (one per sigma, root mean square over seeds), each (errors of every
    seed, unblurred and after sigma 2.1) and seconds."""
    rows = []
    for (sampler, spp), paths in pictures.items():
        images = [read_exr(path) for path in paths]
        each = [[rmse(image, reference, sigma) for image, _ in images] for sigma in SIGMAS]
        errors = [comparison.rms(found) for found in each]
        seconds = float(np.median([attributes["seconds"] for _, attributes in images]))
        rows.append({"sampler": sampler, "spp": spp, "rmse": errors, "seconds": seconds,
                     "each": {"plain": each[0], "blurred": each[2]}})
    by_key = {(row["sampler"], row["spp"]): row for row in rows}
    for row in rows:
        for other in ("white", "sobol"):
            row[f"than_{other}"] = [theirs / own for own, theirs in
                                    zip(row["rmse"], by_key[other, row["spp"]]["rmse"])]
    return sorted(rows, key=lambda row: (row["spp"], SAMPLERS.index(row["sampler"])))


HEADER = ("sampler", "spp", "RMSE", "sigma 1.0", "sigma 2.1", "seconds", "vs white", "vs sobol",
          "vs sobol, unblurred")


def texts(row):
    return (row["sampler"], str(row["spp"]), *(f"{error:.5f}" for error in row["rmse"]), f"{row['seconds']:.2f}",
            f"{row['than_white'][2]:.2f} x", f"{row['than_sobol'][2]:.2f} x", f"{row['than_sobol'][0]:.2f} x")


def text_table(rows):
    lines = [HEADER, *map(texts, rows)]
    widths = [max(map(len, column)) for column in zip(*lines)]
    out = io.StringIO()
    for i, line in enumerate(lines):
        if i and i % len(SAMPLERS) == 1:
            out.write("\n" if i > 1 else "")
        out.write(line[0].ljust(widths[0]) + "  " +
                  "  ".join(cell.rjust(width) for cell, width in zip(line[1:], widths[1:])) + "\n")
    return out.getvalue()


def write_csv(path, rows):
    with written_beside(path) as beside, open(beside, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["sampler", "spp", *(f"rmse_sigma_{sigma}" for sigma in SIGMAS), "seconds"])
        for row in rows:
            writer.writerow([row["sampler"], row["spp"], *row["rmse"], row["seconds"]])


def grey_error(error, full_scale):
    return grey(error_image(error, full_scale))


def readme_picture(renderer):
    """Part of a picture, pixel by pixel, and blurred in linear light as if seen from further away."""
    rows = ([], [])
    for sampler in SAMPLERS:
        request = Request(sampler, PICTURE_COUNT, PICTURE_SEED, PICTURE_SCENE, *PICTURE_SIZE)
        light = np.clip(read_exr(renderer.render(request, f"readme/{sampler}.exr"))[0], 0, 1)
        for row, sigma in zip(rows, (0.0, PICTURE_BLUR)):
            row.append([enlarged_part(preview(blurred(light, sigma)), PICTURE_PART, PICTURE_FACTOR)])
    return sheet(rows, ("each pixel", "from\nfurther\naway"), [PICTURE_NAMES[sampler] for sampler in SAMPLERS])


class Cells:
    """The pictures of one sampler and sample count, as 8-bit images."""

    def __init__(self, path, reference, full_scale):
        self.error = luminance_error(read_exr(path)[0], reference)
        self.whole = Image.open(path.with_suffix(".png")).convert("RGB")
        self.part = zoomed(self.whole, PART, SIZE)
        self.difference = grey_error(self.error, full_scale)


def make_cells(pictures, reference):
    cells = {}
    for spp in COUNTS:
        # One grey scale per sample count: three standard deviations of white noise, robust to the lights.
        white = luminance_error(read_exr(pictures["white", spp][0])[0], reference)
        full_scale = 3 * 1.4826 * float(np.median(np.abs(white)))
        for sampler in SAMPLERS:
            cells[sampler, spp] = Cells(pictures[sampler, spp][0], reference, full_scale)
    return cells


MEASURES = (("blurred", "RMSE after a blur of 2.1 pixels"), ("plain", "RMSE, unblurred"))


def charts(rows, cells):
    """Parts of the page: gains, errors against samples and time, spectra."""
    named = [{**row, "plain": row["rmse"][0], "blurred": row["rmse"][2]} for row in rows]
    gains = [curves.gain_curve(named, SAMPLERS, measure, title) for measure, title in MEASURES]
    errors = [curves.error_curve(named, SAMPLERS, key, "blurred", f"{MEASURES[0][1]}, against {word}")
              for key, word in (("spp", "samples"), ("seconds", "time"))]
    spectra = [curves.spectrum_curve({s: cells[s, spp].error for s in SAMPLERS}, SAMPLERS, page.samples(spp))
               for spp in COUNTS]
    return [page.paragraph("Error reduction over white noise, and the error itself:"),
            page.grid(page.chart(figure) for figure in gains + errors),
            page.paragraph("Power spectrum of the luminance error. Blue noise has little power at low frequencies, the part "
                           "that survives a blur."), page.grid(page.chart(figure) for figure in spectra)]


def write_report(folder, rows, cells, reference, own_error, notes):
    columns = [f"{spp} spp" for spp in COUNTS]
    contact = sheet([[[cells[s, n].whole, cells[s, n].part, cells[s, n].difference] for n in COUNTS]
                     for s in SAMPLERS], SAMPLERS, columns)
    write_image(folder / "contact_sheet.png", contact)

    errors = {(row["sampler"], row["spp"]): row["each"]["blurred"] for row in rows}
    slider = comparison.widget({SCENE: {
        "size": (SIZE, SIZE), "own_error": own_error,
        "reference": comparison.data_uri(preview(reference, EXPOSURE), lossless=True),
        "counts": {spp: {s: (comparison.data_uri(cells[s, spp].whole, lossless=True), errors[s, spp]) for s in SAMPLERS}
                   for spp in COUNTS}}}, spp=1)
    grids = [page.folded(page.samples(spp), [page.pictures(
        [[getattr(cells[sampler, spp], kind) for sampler in SAMPLERS] for kind in ("whole", "part", "difference")],
        ("picture", "enlarged", "error"), SAMPLERS)], spp == COUNTS[0]) for spp in COUNTS]
    blue = [i for i, row in enumerate(rows) if row["sampler"] == "blue"]
    sections = [
        ("Side by side", [slider]),
        ("Pictures", [*grids, page.paragraph("The picture, a part of it enlarged four times, and the signed luminance error on one "
                                             "scale for all samplers, grey where it is zero.")]),
        ("Plots", charts(rows, cells)),
        ("Figures", [page.table(HEADER, map(texts, rows), blue, range(len(SAMPLERS), len(rows), len(SAMPLERS)),
                                {s: style(s, SAMPLERS)["color"] for s in SAMPLERS}), *map(page.paragraph, notes)])]
    lead = ("White noise, Sobol' and blue noise in the same scene, with the same number of samples. Drag the divider, or move "
            "it with the arrow keys; the blur shows what remains visible from a distance.")
    write_text(folder / "report.html", page.page("Blue noise in the Cornell box", sections, lead))


def main():
    parser = argparse.ArgumentParser(prog="demo", description=__doc__)
    parser.add_argument("--pathtracer", type=Path, required=True, help=argparse.SUPPRESS)
    parser.add_argument("--out", type=Path, default=Path("out/demo"), help="output folder (default out/demo)")
    parser.add_argument("--picture", action="store_true", help=f"only draw the README's picture, docs/{PICTURE_FILE}")
    options = parser.parse_args()

    root, renderer = Path(__file__).resolve().parents[2], Renderer(options.pathtracer, options.out)
    if options.picture:
        # 256 colours suffice for pixels this large.
        write_image(root / "docs" / PICTURE_FILE, readme_picture(renderer).quantize(256, dither=0))
        print(f"Written: docs/{PICTURE_FILE}")
        return
    reference_path, pictures = render_all(renderer)
    reference, attributes = read_exr(reference_path)
    rows = measure(reference, pictures)
    notes = (
        f"Scene {SCENE}, {SIZE}x{SIZE} pixels. Errors are root mean squares over pixels, channels and seeds "
        f"({', '.join(f'{count} at {spp} spp' for spp, count in SEEDS.items())}) of linear radiance, "
        "unblurred and after Gaussians of 1.0 and 2.1 pixels; seconds are the median "
        "of the renders. 'vs white' and 'vs sobol' say how many times smaller the error after sigma 2.1 is.",
        f"Reference: sampler sobol, {REFERENCE_SPP} spp, a different seed. Its own error is about "
        f"{attributes['error0']:.5f}, {attributes['error1']:.5f} after sigma 1.0 and {attributes['error2']:.5f} after 2.1.",
    )
    write_csv(options.out / "table.csv", rows)
    write_report(options.out, rows, make_cells(pictures, reference), reference, attributes["error2"], notes)
    print(text_table(rows))
    for note in notes:
        print(note)
    print(f"Written: {options.out}/report.html, contact_sheet.png, table.csv, and an EXR and a PNG of each picture.")


if __name__ == "__main__":
    try:
        main()
    except RenderError as error:
        sys.exit(str(error))
    except OSError as error:
        sys.exit(f"demo: {error}")
    except KeyboardInterrupt:
        sys.exit("demo: interrupted; finished renders are kept, run the command again to resume")
