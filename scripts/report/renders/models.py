# SPDX-License-Identifier: Apache-2.0
"""Compares the samplers on third-party models: `scripts/bench models FOLDER...` writes docs/report/models.*

Renders four crops of a large picture of every .gltf, .glb and .obj below the folders with every sampler, 12 seeds and 1 to 64
samples per pixel, through the file's own camera or one that frames the model, lit by the file's lights or else by the path
tracer's sky, and displayed at the exposure that the path tracer picks for the picture. References and results are cached in
~/.cache/libbn, so an interrupted run resumes.
"""

import argparse
import dataclasses
import sys
import tempfile
import types
from pathlib import Path

from ..base import peers
from ..base.bench_options import add_common_options, finish_options
from ..base.command import parse_size, split_more
from ..base.files import read_exr, write_text
from ..measure import gains
from ..measure.gains import HEADLINE_MEASURES, REFERENCE_MARGIN, VISIBLE
from ..measure.image_error import measure_name
from . import variants, views
from .judge import COUNTS, SEEDS, Cells, Run, plan, prepare, render_references
from .renderer import REFERENCE_SEED, RenderError, Request, run_pathtracer
from .renders_plots import plot_gains
from .renders_report import Report, gain_table, samplers_tables
from .views import View

ENDINGS = (".gltf", ".glb", ".obj")
REFERENCE_SPP = 2048
# The cameras that frame a model leave empty space around it.
SIZE, MARGIN = (1280, 960), 0.25
SAMPLERS = ("white", "sobol", "zorder", "blue")


def models_below(folders):
    """Their paths, sorted by name."""
    found = [path.resolve() for folder in folders for path in sorted(folder.rglob("*"))
             if path.suffix.lower() in ENDINGS and path.is_file()]
    return list(dict.fromkeys(found))


def names_of(paths):
    """{path: short name}: the file's stem, preceded by as many folders as make it unique."""
    names, stems = {}, {}
    for path in paths:
        stems.setdefault(path.stem, []).append(path)
    for stem, same in stems.items():
        for path in same:
            depth = 1
            while len({other.parts[-depth:] for other in same}) < len(same):
                depth += 1
            names[path] = stem if len(same) == 1 else "/".join(path.parts[-depth:])
    return names


def exposure_of(program, view):
    """The exposure in stops that the path tracer picks for a picture, from a small one."""
    with tempfile.TemporaryDirectory(prefix="libbn-") as folder:
        path = Path(folder) / "small.exr"
        request = Request("sobol", 16, REFERENCE_SEED, view.scene, 160, 160 * view.height // view.width, exposure="auto", more=view.camera)
        run_pathtracer(program, [*request.arguments(), "--quiet", "-o", path])
        return float(read_exr(path)[1]["exposure"])


def run_models(options, paths, seeds):
    """(results of all tasks, {view: Reference}, {path: error message})."""
    work = Run(options.pathtracer, "models", max(COUNTS), options.jobs, not options.no_flip)
    results, references, failures = {}, {}, {}
    for i, path in enumerate(paths):
        view = View(str(path), "", *options.size, options.more)
        print(f"{i + 1} of {len(paths)}: {path}", file=sys.stderr)
        try:
            view = dataclasses.replace(view, exposure=exposure_of(options.pathtracer, view))
            own = render_references(options.pathtracer, views.crops_of(view, options.crop, MARGIN), options.reference_spp)
            if not any(reference.picture.any() for reference in own.values()):
                raise RenderError("the picture is black: nothing is visible")
            tasks = plan(own, options.labels, seeds)
            if options.prepare:
                prepare(work, own, tasks)
                continue
            results.update(work.results(own, tasks))
            references.update(own)
        except RenderError as error:
            failures[path] = str(error).splitlines()[-1]
    return results, references, failures


def report_text(options, report, failures):
    found, count = report.gains, len(report.scenes)
    parts = ["# Third-party models", "", f"Printed by `{options.command}`.", "",
             f"{count} model{'s' if count != 1 else ''}"
             + f", each in four crops of {options.crop[0]}x{options.crop[1]} pixels out of a picture of "
             f"{options.size[0]}x{options.size[1]}: one in each quarter of its middle, without a margin of "
             f"{100 * MARGIN:.0f} % on each side, placed by a hash before anything was rendered. "
             f"{options.seeds} seeds, against references with {options.reference_spp} samples per pixel (`sobol`, padded, a different seed). "
             "No choice of the library has seen these models. The camera is the file's own, or one that "
             "frames the model; the light comes from the file, or from the path tracer's sky if the file has none. \"As displayed\" "
             "means at the exposure that the path tracer picks for the picture (`--exposure auto`).", "",
             "## Error reduction", "",
             "Each number says how many times smaller blue's error is: geometric means over models, crops and seeds, with 95 % "
             "intervals of a bootstrap that resamples all three. A crop is excluded at sample counts where blue's error is less than "
             f"{REFERENCE_MARGIN:g} times the error of the reference itself, and everywhere if the error of white noise as displayed is below "
             f"{VISIBLE:g} at one sample: an empty sky, for instance.", ""]
    if found.peers:
        parts += [f"OpenQMC's commit is {peers.commit(options.openqmc)}.", ""]
    for measure in HEADLINE_MEASURES:
        parts += [f"### blue, {measure_name(measure)}", "", gain_table(found, COUNTS, found.thans(), measure), ""]
    parts += ["![Error reduction over white noise](models.png)", "",
              "## Every sampler", "", "White noise's error divided by each sampler's.", ""]
    parts += samplers_tables(found, COUNTS, (*HEADLINE_MEASURES, "displayed", "rmse", "trimmed_2.1", "flip"))
    parts += ["## Every model", "", "The geometric mean over a model's crops, followed by the smallest and the largest.", ""]
    for measure in HEADLINE_MEASURES:
        for than in found.thans():
            parts += [f"### {than} / blue, {measure_name(measure)}", "", report.spread_table(than, measure), ""]
    parts += ["## The error of the references", "", report.references_table(), "", "## Failures", "",
              *([f"- {name}: {line}" for name, line in failures.items()] or ["None."])]
    return "\n".join([*parts, ""])


def parse_options(arguments):
    parser = argparse.ArgumentParser(
        prog="scripts/bench models", description=__doc__.splitlines()[0],
        epilog="Arguments after -- are passed to the path tracer: scripts/bench models folder -- --env sky")
    parser.add_argument("folders", nargs="+", type=Path, metavar="FOLDER", help="folder to search recursively for models")
    parser.add_argument("--size", type=parse_size, default=SIZE, metavar="WxH", help=f"picture size (default {SIZE[0]}x{SIZE[1]})")
    parser.add_argument("--crop", type=parse_size, default=views.CROP, metavar="WxH",
                        help=f"size of the four crops (default {views.CROP[0]}x{views.CROP[1]})")
    parser.add_argument("--prepare", action="store_true", help="render what is missing, for every sampler but blue, and write no report")
    variants.add_option(parser, SAMPLERS)
    add_common_options(parser, REFERENCE_SPP, "out/models")
    arguments, more = split_more(arguments)
    options = parser.parse_args(arguments)
    options.more = more
    finish_options(parser, options, "models", arguments)
    options.command += "".join(f" {word}" for word in (("--", *more) if more else ()))
    try:
        views.crops_of(View("", "", *options.size), options.crop, MARGIN)
    except ValueError as error:
        parser.error(str(error))
    for folder in options.folders:
        if not folder.is_dir():
            parser.error(f"folder {folder} does not exist")
        # Local folder names do not belong in a report.
        options.command = options.command.replace(f" {folder}", " FOLDER", 1)
    options.seeds = options.seeds or SEEDS
    return options


def run(arguments):
    options = parse_options(arguments)
    paths = models_below(options.folders)
    if not paths:
        raise OSError(f"no {', '.join(ENDINGS)} file below {', '.join(map(str, options.folders))}")
    names = names_of(paths)
    results, references, failures = run_models(options, paths, dict.fromkeys(COUNTS, options.seeds))
    if options.prepare:
        return
    failures = {names[path]: line.replace(str(path), names[path]) for path, line in failures.items()}
    if not references:
        lines = "; ".join(f"{name}: {line}" for name, line in failures.items())
        raise OSError(f"no model could be rendered: {lines}")
    cells = Cells(results)
    shown = types.SimpleNamespace(labels=options.labels, seeds=dict.fromkeys(COUNTS, options.seeds))
    report = Report(shown, cells, references, [], None, names={str(path): name for path, name in names.items()})
    plot_gains(report.gains, COUNTS, options.out / "models.png")
    cells.write_csv(options.pages / "models.csv")
    gains.write_rows(options.out / "models_headline.csv", report.gains.rows(COUNTS, HEADLINE_MEASURES))
    text = report_text(options, report, failures)
    write_text(options.out / "models.md", text)
    print(text)
    print(f"Written: {options.out}/models.md, models.png and models_headline.csv; {options.pages}/models.csv.")
