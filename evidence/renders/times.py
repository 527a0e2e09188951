# SPDX-License-Identifier: Apache-2.0
"""CPU time per sample in the path tracer's built-in scenes: `scripts/bench times` writes evidence/results/times.csv

Medians of interleaved single-threaded runs, excluding program start-up.
"""

import statistics
import tempfile
from pathlib import Path

from ..base.command import Parser
from ..base.files import write_rows
from ..base.progress import Progress
from ..base.tables import md_table
from ..samplers import variants
from . import views
from .renderer import processor_seconds

SPP, ROUNDS = 32, 3


def of_a_sample(program, chosen, labels):
    """{(scene, label): microseconds}."""
    found, cells = {}, [(view, label) for view in chosen for label in labels]
    with Progress(ROUNDS * len(cells), "runs") as progress, tempfile.TemporaryDirectory(prefix="libbn-") as folder:
        for done, (view, label) in enumerate(ROUNDS * cells):
            progress(f"timing {label} in {view.scene}", done)
            one, more = (processor_seconds([str(program), *view.request(label, spp).arguments(), "--threads", "1", "--quiet",
                                            "-o", f"{folder}/timed.exr"], program) for spp in (1, 1 + SPP))
            found.setdefault((view.scene, label), []).append(1e6 * max(more - one, 1e-6) / (SPP * view.pixels))
    return {cell: statistics.median(values) for cell, values in found.items()}


def over(rows, base):
    """{sampler: time per sample relative to `base`}, geometric means over scenes."""
    times = {(row["scene"], row["sampler"]): row["microseconds"] for row in rows}
    found = {}
    for (scene, label), own in times.items():
        found.setdefault(label, []).append(own / times[scene, base])
    return {label: statistics.geometric_mean(values) for label, values in found.items()}


def run(arguments):
    parser = Parser("times", __doc__)
    parser.add_argument("--out", type=Path, help="folder for times.csv (default evidence/results; out/times with --sampler)")
    parser.pathtracer()
    options = parser.parse_args(arguments)
    labels = variants.chosen(variants.OWN, options)
    chosen = views.crops(scenes=views.BUILT_IN)[::4]  # one of each scene
    rows = [{"scene": scene, "sampler": label, "microseconds": f"{value:.4f}"}
            for (scene, label), value in of_a_sample(options.pathtracer, chosen, labels).items()]
    folder = options.out or Path("out/times" if options.sampler else "evidence/results")
    write_rows(folder / "times.csv", list(rows[0]), rows)
    found = over([{**row, "microseconds": float(row["microseconds"])} for row in rows], "sobol")
    print(md_table(["sampler", "CPU time per sample over padded Sobol'"], [[label, f"{value:.2f}"] for label, value in found.items()]))
