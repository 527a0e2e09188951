# SPDX-License-Identifier: Apache-2.0
"""The comparison of scripts/demo: the same scene with white noise, Sobol' and blue noise, against a reference."""

import argparse
import csv
import io
import shutil
import sys
from pathlib import Path

import numpy as np
from PIL import Image

from . import page
from .contact_sheet import grey, sheet, zoomed
from .files import read_exr, write_image, write_text, written_beside
from .image_error import SIGMAS, blurred, error_image, luminance_error, radial_spectrum, rmse
from .progress import Progress
from .renderer import RenderError, Renderer, Request

SAMPLERS = ("white", "sobol", "blue")
# Samples per pixel, and how many seeds the table takes of each: pictures of few samples differ more.
SEEDS = {1: 32, 4: 16, 16: 6, 64: 4}
COUNTS = tuple(SEEDS)
SCENE, SIZE = "cornell", 256
EXPOSURE = 1.0  # stops, of the previews: the scene is dark but for its lamp
# The reference and the pictures have different seeds, and so no sample in common.
REFERENCE_SEED, REFERENCE_SPP = 1_000_003, 4096
# Where half-shadow, the edge of a box and plain faces meet: left, top, width, height in pixels.
PART = (64, 166, 64, 64)
# The same for the README's picture, at the count where it is seen best.
README_PART, README_COUNT, README_SIZE = (40, 150, 96, 96), 4, 288
PARTS = 64


def render_all(renderer):
    """The reference, and {(sampler, spp): [path for each seed]}; what is there already is kept."""
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
    """Rows of the table: dicts with sampler, spp, rmse (one per sigma, mean square over seeds), seconds."""
    rows = []
    for (sampler, spp), paths in pictures.items():
        images = [read_exr(path) for path in paths]
        errors = [float(np.sqrt(np.mean([rmse(image, reference, sigma) ** 2 for image, _ in images])))
                  for sigma in SIGMAS]
        seconds = float(np.median([attributes["seconds"] for _, attributes in images]))
        rows.append({"sampler": sampler, "spp": spp, "rmse": errors, "seconds": seconds})
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


TABLE_BEGIN, TABLE_END = "<!-- table: scripts/demo --readme -->\n", "<!-- end of the table -->\n"


def update_readme(root, folder, rows):
    """Puts the table and the picture of this run into the README of the repository at `root`."""
    readme = root / "README.md"
    text = readme.read_text(encoding="utf-8")
    if text.count(TABLE_BEGIN) != 1 or text.count(TABLE_END) != 1:
        raise ValueError(f"{readme} has lost the marks of its table: {TABLE_BEGIN.strip()} and {TABLE_END.strip()}")
    before, rest = text.split(TABLE_BEGIN)
    after = rest.split(TABLE_END)[1]
    write_text(readme, f"{before}{TABLE_BEGIN}```\n{text_table(rows)}```\n{TABLE_END}{after}")
    with written_beside(root / "docs" / "cornell.png") as beside:
        shutil.copyfile(folder / "readme.png", beside)


def write_csv(path, rows):
    with written_beside(path) as beside, open(beside, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["sampler", "spp", *(f"rmse_sigma_{sigma}" for sigma in SIGMAS), "seconds"])
        for row in rows:
            writer.writerow([row["sampler"], row["spp"], *row["rmse"], row["seconds"]])


def grey_error(error, full_scale):
    return grey(error_image(error, full_scale))


def readme_picture(cells):
    """A part of the picture, and what a blur leaves of its error; one grey scale for all samplers."""
    left, top, width, height = README_PART
    errors = {sampler: blurred(cells[sampler, README_COUNT].error, 1.0) for sampler in SAMPLERS}
    full_scale = 3 * float(np.std(errors["white"][top:top + height, left:left + width]))
    rows = [[[zoomed(cells[sampler, README_COUNT].whole, README_PART, README_SIZE)] for sampler in SAMPLERS],
            [[zoomed(grey_error(errors[sampler], full_scale), README_PART, README_SIZE)] for sampler in SAMPLERS]]
    return sheet(rows, (f"{README_COUNT} spp", "error,\nblurred"), SAMPLERS)


class Cells:
    """The pictures of one sampler and count, as 8-bit images."""

    def __init__(self, path, reference, full_scale):
        self.error = luminance_error(read_exr(path)[0], reference)
        self.whole = Image.open(path.with_suffix(".png")).convert("RGB")
        self.part = zoomed(self.whole, PART, SIZE)
        self.difference = grey_error(self.error, full_scale)


def make_cells(pictures, reference):
    cells = {}
    for spp in COUNTS:
        # One grey scale for all samplers of a count: three standard deviations of white noise away from the lights.
        white = luminance_error(read_exr(pictures["white", spp][0])[0], reference)
        full_scale = 3 * 1.4826 * float(np.median(np.abs(white)))
        for sampler in SAMPLERS:
            cells[sampler, spp] = Cells(pictures[sampler, spp][0], reference, full_scale)
    return cells


def charts(rows, cells):
    import matplotlib

    matplotlib.use("svg")
    from matplotlib import pyplot

    colours = dict(zip(SAMPLERS, ("#888888", "#d08020", "#2060d0")))
    error_figure, axes = pyplot.subplots(1, 2, figsize=(11, 4), sharey=True)
    for axis, key, label in ((axes[0], "spp", "samples per pixel"), (axes[1], "seconds", "seconds")):
        for sampler in SAMPLERS:
            own = [row for row in rows if row["sampler"] == sampler]
            axis.loglog([row[key] for row in own], [row["rmse"][2] for row in own], "o-", label=sampler,
                        color=colours[sampler])
        axis.set_xlabel(label)
        axis.grid(True, which="both", alpha=.3)
    axes[0].set_ylabel("RMSE after sigma 2.1")
    axes[0].legend()

    spectrum_figure, axes = pyplot.subplots(1, len(COUNTS), figsize=(11, 3), sharey=True)
    for axis, spp in zip(axes, COUNTS):
        level = np.mean(radial_spectrum(cells["white", spp].error)[1])
        for sampler in SAMPLERS:
            frequency, power = radial_spectrum(cells[sampler, spp].error)
            axis.semilogy(frequency, power / level, label=sampler, color=colours[sampler])
        axis.set_title(f"{spp} spp", fontsize="medium")
        axis.set_xlabel("cycles per pixel")
        axis.grid(True, alpha=.3)
    axes[0].set_ylabel("power, white = 1")
    axes[0].legend()
    result = (page.chart(error_figure, "Error after a Gaussian of sigma 2.1, against samples and against seconds."),
              page.chart(spectrum_figure, "Radially averaged power spectra of the luminance error. Blue noise has "
                                          "little power at low frequencies: what is left after blurring."))
    pyplot.close("all")
    return result


def write_report(folder, rows, cells, notes):
    columns = [f"{spp} spp" for spp in COUNTS]
    contact = sheet([[[cells[s, n].whole, cells[s, n].part, cells[s, n].difference] for n in COUNTS]
                     for s in SAMPLERS], SAMPLERS, columns)
    write_image(folder / "contact_sheet.png", contact)
    write_image(folder / "readme.png", readme_picture(cells))

    best = [i for i, row in enumerate(rows) if row["sampler"] == "blue"]
    sections = [("Error", [page.table(HEADER, map(texts, rows), best), *map(page.paragraph, notes),
                           *charts(rows, cells)])]
    for spp in COUNTS:
        grid = [[[getattr(cells[sampler, spp], kind)] for sampler in SAMPLERS]
                for kind in ("whole", "part", "difference")]
        sections.append((f"{spp} spp", [page.picture(
            sheet(grid, ("picture", "enlarged", "error"), SAMPLERS),
            "Picture, a part of it enlarged four times, and the signed luminance error (grey is none; the same scale for all three).")]))
    write_text(folder / "report.html", page.page("Blue noise in the Cornell box", sections))


def main():
    parser = argparse.ArgumentParser(prog="demo", description=__doc__)
    parser.add_argument("--pathtracer", type=Path, required=True, help=argparse.SUPPRESS)
    parser.add_argument("--out", type=Path, default=Path("out/demo"), help="folder to write (default out/demo)")
    parser.add_argument("--readme", action="store_true", help="also put the table and the picture into the README")
    options = parser.parse_args()

    reference_path, pictures = render_all(Renderer(options.pathtracer, options.out))
    reference, attributes = read_exr(reference_path)
    rows = measure(reference, pictures)
    notes = (
        f"Scene {SCENE}, {SIZE}x{SIZE} pixels. Errors are root mean squares over pixels, channels and seeds "
        f"({', '.join(f'{count} seeds at {spp} spp' for spp, count in SEEDS.items())}), linear in radiance, "
        "as they are and after Gaussians of 1.0 and 2.1 pixels; seconds are the median "
        "render. 'vs white' and 'vs sobol' say how many times smaller the error after sigma 2.1 is.",
        f"Reference: sampler sobol, {REFERENCE_SPP} spp, another seed. Its own error is about "
        f"{attributes['error0']:.5f}, {attributes['error1']:.5f} after sigma 1.0 and {attributes['error2']:.5f} after 2.1.",
    )
    write_csv(options.out / "table.csv", rows)
    write_report(options.out, rows, make_cells(pictures, reference), notes)
    if options.readme:
        update_readme(Path(__file__).resolve().parents[2], options.out, rows)
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
        sys.exit("demo: interrupted; what is rendered is kept, run it again to go on")
