# SPDX-License-Identifier: Apache-2.0
"""Compares the samplers on rendered scenes: `scripts/bench renders` writes docs/report/renders.*

Renders crops of large pictures of every built-in scene with every sampler at 1 to 64 samples per pixel and 12 seeds,
measures each against a reference, and measures the cost of a sample. Writes renders.md with its plot and
renders_headline.csv to docs/report, and renders.csv to out/renders. With `--views` other than held-out everything goes to a folder of
out/renders named after the set, with `--quick` (small crops, 4 seeds) to quick, with `--lights coin` to coin. References and results are
cached in ~/.cache/libbn ($XDG_CACHE_HOME): an interrupted run resumes, and a change to one sampler renders only that one again.
"""

import dataclasses

from ..base.bench_options import add_common_options, finish_options
from ..base.command import Parser
from ..base.files import write_text
from ..base.progress import duration
from ..measure import equal_quality, gains
from . import variants, views
from .judge import SEEDS, Cells, Run, plan, prepare, render_references, seeds_up_to
from .renders_report import Report

REFERENCE_SPP, QUICK_SEEDS = 2048, 4


def parse_options(arguments):
    parser = Parser("renders", __doc__)
    views.add_options(parser)
    variants.add_option(parser)
    parser.number("--spp", 64, "largest sample count, at most 64")
    add_common_options(parser, REFERENCE_SPP, "out/renders")
    parser.add_argument("--lights", choices=["coin"], help="one direction off each surface, by a coin, as many small renderers do")
    parser.add_argument("--prepare", action="store_true", help="render what is missing, for every sampler but blue, and write no report")
    options = parser.parse_args(arguments)
    finish_options(parser, options, "renders", arguments)
    lights = ("--lights", options.lights) if options.lights else ()
    options.chosen = tuple(dataclasses.replace(view, lights=lights) for view in views.of(parser, options))
    options.seeds = seeds_up_to(options.spp, options.seeds or (QUICK_SEEDS if options.quick else SEEDS))
    return options


def run(arguments):
    options = parse_options(arguments)
    chosen = options.chosen
    work = Run(options.pathtracer, "renders", max(options.seeds), options.jobs)
    tasks = plan(chosen, options.labels, options.seeds)
    references = render_references(options.pathtracer, chosen, options.reference_spp)
    if options.prepare:
        prepare(work, references, tasks)
        return
    cells = Cells(work.results(references, tasks))
    machine = equal_quality.machine()
    cost = shares = None
    if not options.no_times:
        chosen_variants = variants.of(options.labels)
        cost = equal_quality.costs(options.pathtracer, work.store, views.first_of_each(chosen), chosen_variants, machine, work.builds, options.retime)
        shares = equal_quality.sampling_shares(options.pathtracer, chosen_variants)
    report = Report(options, cells, references, cost, shares, machine)
    # Write the text last, after the files it refers to.
    report.plot(options.out / "renders_gain.png")
    cells.write_csv(options.pages / "renders.csv")
    gains.write_rows(options.out / "renders_headline.csv", report.headline_rows())
    write_text(options.out / "renders.md", report.text())
    print(report.text())
    seconds = sum(reference.seconds for reference in references.values())
    print(f"Written: {options.out}/renders.md and renders_headline.csv, renders_gain.png; {options.pages}/renders.csv. "
          f"References took {duration(seconds)} once.")
