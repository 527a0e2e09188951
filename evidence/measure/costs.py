# SPDX-License-Identifier: Apache-2.0
"""The CPU time of a sample in the path tracer."""

import os
import platform
import statistics
import tempfile
from pathlib import Path

from ..base.progress import Progress
from ..base.tables import md_table
from ..external_renderers.other_renderer import processor_seconds

SPP, ROUNDS = 32, 5


def machine():
    """One line that describes the machine."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    models = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return f"{(models or [platform.processor() or platform.machine()])[0]}, {os.cpu_count()} processors"


def of_a_sample(program, views, labels):
    """{(scene, label): microseconds}: medians of interleaved runs of one thread, without what starting the program takes."""
    found, cells = {}, [(view, label) for view in views for label in labels]
    with Progress(ROUNDS * len(cells), "runs") as progress, tempfile.TemporaryDirectory(prefix="libbn-") as folder:
        for done, (view, label) in enumerate(ROUNDS * cells):
            progress(f"timing {label} in {view.scene}", done)
            one, more = (processor_seconds([str(program), *view.request(label, spp).arguments(), "--threads", "1", "--quiet",
                                            "-o", f"{folder}/timed.exr"], program) for spp in (1, 1 + SPP))
            found.setdefault((view.scene, label), []).append(1e6 * max(more - one, 1e-6) / (SPP * view.pixels))
    return {cell: statistics.median(values) for cell, values in found.items()}


def text(cost, labels):
    rows = []
    for label in labels:
        own = [value for (_, name), value in cost.items() if name == label]
        over = [value / cost[scene, "sobol"] for (scene, name), value in cost.items() if name == label]
        rows.append([label, f"{statistics.geometric_mean(own):.2f}", f"{statistics.geometric_mean(over):.2f}"])
    return (f"CPU time of a sample, one thread, geometric means over scenes ({machine()}):\n\n"
            + md_table(["sampler", "microseconds", "over padded Sobol'"], rows))
