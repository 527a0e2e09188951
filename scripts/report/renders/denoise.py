# SPDX-License-Identifier: Apache-2.0
"""Compares the samplers after denoising: `scripts/bench denoise` writes docs/report/denoise.*

Renders the views with white, sobol, blue and the peers in the build at 1 to 16 samples per pixel, denoises each picture in
three ways with Open Image Denoise (the optional package pyoidn), and measures the remaining error against the references
of `scripts/bench renders`. Results are cached in ~/.cache/libbn, so an interrupted run resumes.
"""

import argparse
import dataclasses
from pathlib import Path

from ..base.bench_options import add_common_options, finish_options
from ..base.command import positive
from ..base.files import read_first_half, write_text
from ..measure import equal_quality, gains
from . import denoise_report, denoiser, speed, variants, views
from .denoiser import DenoisedRun
from .judge import Cells, plan, render_references
from .renders import REFERENCE_SPP

COUNTS, SEEDS = (1, 2, 4, 8, 16), 4
LABELS = ("white", "sobol", "blue")


def parse_options(arguments):
    parser = argparse.ArgumentParser(prog="scripts/bench denoise", description=__doc__.splitlines()[0])
    views.add_options(parser)
    parser.add_argument("--spp", type=positive, default=max(COUNTS), metavar="N", help="largest sample count, at most 16 (default 16)")
    parser.add_argument("--no-times", action="store_true", help="skip the cost of samples, which needs an idle machine")
    parser.add_argument("--retime", action="store_true", help="repeat timings that are in the cache")
    add_common_options(parser, REFERENCE_SPP, "out/denoise")
    parser.set_defaults(out=None)
    options = parser.parse_args(arguments)
    options.out = options.out or (options.pages if options.quick or options.views != views.SHOWN else Path("docs/report"))
    options.samplers, options.chosen = LABELS, views.of(parser, options)
    finish_options(parser, options, "denoise", arguments)
    options.seeds = options.seeds or SEEDS
    options.counts = tuple(spp for spp in COUNTS if spp <= options.spp)
    return options


def with_own_errors(reference):
    """A judge.Reference whose own errors carry the names of the denoised measures."""
    own = denoiser.own_errors(reference.picture, read_first_half(reference.path), reference.exposure)
    return dataclasses.replace(reference, own={f"{way}:{name}": error for way in denoiser.WAYS for name, error in own.items()})


def run(arguments):
    options = parse_options(arguments)
    work = DenoisedRun(options.pathtracer, max(options.counts), options.jobs, not options.no_flip, denoiser.load())
    chosen = options.chosen
    first_views = [next(view for view in chosen if view.scene == scene) for scene in options.scenes]
    references = render_references(options.pathtracer, chosen, options.reference_spp)
    tasks = plan(chosen, options.labels, {spp: options.seeds for spp in options.counts}, first_views)
    results = work.results(references, tasks)
    cells = Cells({task: (rows, {}) for task, (rows, _) in results.items()})
    pictures = {(task.view, task.label, name): array.astype("float32")
                for task, (_, kept) in results.items() for name, array in kept.items()}
    cost = None if options.no_times else equal_quality.costs(
        options.pathtracer, work.store, first_views, {label: variants.VARIANTS[label] for label in options.labels}, speed.machine(),
        work.builds, options.retime)
    report = denoise_report.Report(options, cells, {view: with_own_errors(own) for view, own in references.items()}, pictures,
                                   work.version, cost)
    report.draw(options.out, options.pages)
    gains.write_rows(options.out / "denoise.csv", report.rows())
    text = report.text()
    write_text(options.out / "denoise.md", text)
    print(text)
