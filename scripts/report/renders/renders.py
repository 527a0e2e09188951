# SPDX-License-Identifier: Apache-2.0
"""Compares the samplers on rendered scenes: `scripts/bench renders` writes docs/report/renders.*

Renders crops of large pictures of every built-in scene with every sampler at 1 to 64 samples per pixel and 12 seeds,
measures each against a reference, and measures the cost of a sample. Writes renders.md with its plots and
renders_headline.csv to docs/report, and renders.csv and a contact sheet to out/renders. With `--views` other than held-out
everything goes to a folder of out/renders named after the set, with `--quick` (small crops, 4 seeds) to quick. References and results are
cached in ~/.cache/libbn ($XDG_CACHE_HOME): an interrupted run resumes, and a change to one sampler renders only that one again.
"""

import argparse
import dataclasses
from pathlib import Path

import numpy as np

from ..base.bench_options import add_common_options, finish_options
from ..base.command import positive
from ..base.files import write_text
from ..base.progress import duration
from ..measure import equal_quality, gains
from . import renders_plots, speed, variants, views
from .judge import SEEDS, Cells, Run, Task, pictures_of, plan, prepare, render_references, seeds_up_to
from .renders_report import Report

FURNACE_SPP = 64
REFERENCE_SPP, QUICK_SEEDS = 2048, 4


def furnace(options, run):
    """One dict per sampler for the furnace scene, whose pixels are known: relative error of the mean and the worst pixel."""
    view = views.View("furnace", "a", *((options.quick and options.size) or (96, 96)))
    rows = []
    for label in options.labels:
        task = Task(view, label, 0, (FURNACE_SPP,))
        key = {"furnace": [view.size, FURNACE_SPP], "label": label, "build": run.builds.key(view, label)}
        found = run.store.load(key)
        if not found:
            (_, picture, _), = pictures_of(options.pathtracer, task)
            # The walls emit 1/2 and reflect 1/2; paths end after 8 bounces.
            share = picture.astype(np.float64) / (1 - 0.5**9) - 1
            found = [{"mean": float(share.mean()), "worst": float(np.abs(share).max())}], {}
            run.store.save(key, *found)
        rows.append({"sampler": label, **found[0][0]})
    return rows


def place_of(options):
    """The subfolder of a set of views: only held-out ones go to docs/report."""
    return Path() if options.views == views.SHOWN else Path(options.views)


def parse_options(arguments):
    parser = argparse.ArgumentParser(prog="scripts/bench renders", description=__doc__.splitlines()[0])
    views.add_options(parser)
    variants.add_option(parser)
    parser.add_argument("--spp", type=positive, default=64, metavar="N", help="largest sample count, at most 64 (default 64)")
    add_common_options(parser, REFERENCE_SPP, "out/renders")
    parser.add_argument("--lights", choices=["coin"], help="one direction off each surface, by a coin, as many small renderers do")
    parser.add_argument("--prepare", action="store_true", help="render what is missing, for every sampler but blue, and write no report")
    parser.add_argument("--no-times", action="store_true", help="skip the timings, which need an idle machine")
    parser.add_argument("--retime", action="store_true", help="repeat timings that are in the cache")
    parser.set_defaults(out=None, pages=None)
    options = parser.parse_args(arguments)
    options.pages = options.pages or Path("out/renders") / ("quick" if options.quick else "") / place_of(options) / (options.lights or "")
    options.out = options.out or (options.pages if options.quick or options.lights or place_of(options).name else Path("docs/report"))
    finish_options(parser, options, "renders", arguments)
    lights = ("--lights", options.lights) if options.lights else ()
    options.chosen = tuple(dataclasses.replace(view, lights=lights) for view in views.of(parser, options))
    options.seeds = seeds_up_to(options.spp, options.seeds or (QUICK_SEEDS if options.quick else SEEDS))
    return options


def run(arguments):
    options = parse_options(arguments)
    chosen = options.chosen
    first_views = [next(view for view in chosen if view.scene == scene) for scene in options.scenes]
    work = Run(options.pathtracer, "renders", max(options.seeds), options.jobs, not options.no_flip)
    tasks = plan(chosen, options.labels, options.seeds, first_views)
    references = render_references(options.pathtracer, chosen, options.reference_spp)
    if options.prepare:
        prepare(work, references, tasks)
        return
    cells = Cells(work.results(references, tasks))
    furnaces = furnace(options, work)
    times = cost = None
    if not options.no_times:
        times = speed.measure_all(options, work.store, work.builds.key(first_views[0], "blue"))
        cost = equal_quality.costs(options.pathtracer, work.store, first_views, {label: variants.VARIANTS[label] for label in options.labels},
                                   times["machine"], work.builds, options.retime)
    report = Report(options, cells, references, furnaces, times, cost)
    # Write the text last, after the files it refers to.
    renders_plots.draw_all(report, options.out, options.pages)
    cells.write_csv(options.pages / "renders.csv")
    gains.write_rows(options.out / "renders_headline.csv", report.headline_rows())
    write_text(options.out / "renders.md", report.text())
    print(report.text())
    seconds = sum(reference.seconds for reference in references.values())
    print(f"Written: {options.out}/renders.md and renders_headline.csv; renders.csv and a contact sheet in {options.pages}. "
          f" References took {duration(seconds)} once.")
