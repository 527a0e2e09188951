# SPDX-License-Identifier: Apache-2.0
"""Equal quality: the processor time until a sampler's pictures have the error that white noise has at a given count.

The errors are those of the report, at every count, seed and crop; the cost of a sample is measured apart, as processor time
of one thread, so that other work on the machine matters little. Between counts both are interpolated on logarithmic axes.
"""

import math
import os
import platform
import statistics
import tempfile
from pathlib import Path

import numpy as np

from ..base.progress import Progress
from ..others.other_renderer import processor_seconds
from ..renders import variants
from ..renders.renderer import progressive
from ..renders.views import View
from .gains import gain_of, row_of
from .ratios import seconds_to_error

# The counts of white noise whose errors are to be reached.
TARGETS = (16, 64)
MEASURE = "displayed_2.1"
COST_SPP, ROUNDS = 32, 5
SHARE_SPP, SHARE_ROUNDS = 64, 3


def machine():
    """One line that describes the machine."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    models = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return f"{(models or [platform.processor() or platform.machine()])[0]}, {os.cpu_count()} processors"


def _medians(rounds, cells, measure):
    """{(view, label): median of measure(view, label)}, of interleaved runs."""
    found = {cell: [] for cell in cells}
    with Progress(rounds * len(cells), "runs") as progress:
        for done, (view, label) in enumerate(rounds * list(cells)):
            progress(f"timing {label} in {view.scene}", done)
            found[view, label].append(measure(view, label))
    return {cell: statistics.median(values) for cell, values in found.items()}


def costs(program, store, views, labels, machine, builds, retime=False):
    """{(scene, label): processor seconds for one sample in each of a million pixels}.

    views: one of each scene. Start-up is left out, as the difference between runs of 1 and of 1 + COST_SPP samples; runs are
    interleaved, and medians taken over ROUNDS.
    """
    def seconds(view, label):
        with tempfile.TemporaryDirectory(prefix="libbn-") as folder:
            one, more = (processor_seconds([str(program), *view.request(label, spp).arguments(), "--threads", "1", "--quiet",
                                            "-o", f"{folder}/timed.exr"], program) for spp in (1, 1 + COST_SPP))
        return max(more - one, 1e-6) / (COST_SPP * view.pixels * 1e-6)

    key = {"costs": [view.key for view in views], "builds": [[builds.key(view, label) for label in labels] for view in views],
           "variants": [variants.key(label) for label in labels], "machine": machine, "settings": [COST_SPP, ROUNDS]}
    if retime:
        store.drop(key)
    rows, _ = store.get(key, lambda: ([[view.scene, label, median] for (view, label), median in _medians(
        ROUNDS, [(view, label) for view in views for label in labels], seconds).items()], {}))
    return {(scene, label): cost for scene, label, cost in rows}


def sampling_shares(program, labels):
    """{label: share of cornell's render time spent sampling}, medians of interleaved runs of one thread, as the path tracer reports it."""
    def share(view, label):
        (_, _, attributes), = progressive(program, view.request(label, SHARE_SPP), [SHARE_SPP], 1)
        return float(attributes["samplingShare"])

    found = _medians(SHARE_ROUNDS, [(View("cornell", "", 192, 192), label) for label in labels], share)
    return {label: median for (_, label), median in found.items()}


def seconds_of(gains, cost, counts, label, measure, at):
    """{view: (seconds of label, seconds of white noise)} per million pixels until white's error at `at` samples; without the
    views in which the label does not reach it."""
    found = {}
    for view in gains.views:
        own, white = ([gains.cells.get(view, name, spp, measure) for spp in counts] for name in (label, "white"))
        wanted = gains.cells.get(view, "white", at, measure)
        if not wanted or not all(own) or not all(white) or min(map(min, own)) <= 0 or not gains.is_judged(view, label, at, measure):
            continue
        errors = [math.exp(np.mean(np.log(values))) for values in own]
        seconds = seconds_to_error([spp * cost[view.scene, label] for spp in counts], errors, math.exp(np.mean(np.log(wanted))))
        if not math.isnan(seconds):
            found[view] = seconds, at * cost[view.scene, "white"]
    return found


def time_gain(gains, cost, counts, label, measure, at):
    """The processor time of white noise over that of a label, as a Gain; None where it is not reached."""
    found = seconds_of(gains, cost, counts, label, measure, at)
    return gain_of({view: [math.log(white / own)] for view, (own, white) in found.items()}, len(gains.views) - len(found))


def rows(gains, cost, counts, measure=MEASURE, targets=TARGETS):
    """The gains in time as dicts with gains.FIELDS, under the measure "seconds:MEASURE"."""
    found = [(at, label, time_gain(gains, cost, counts, label, measure, at)) for at in targets if at in counts
             for label in gains.labels if label != "white"]
    return [row_of(gain, f"seconds:{measure}", at, label, "white") for at, label, gain in found if gain]


def table_rows(gains, cost, counts, measure=MEASURE, targets=TARGETS):
    """(header, rows) of texts."""
    header = ["sampler", "seconds a sample", *(text for at in targets if at in counts for text in (
        f"seconds to white's error at {at}", "seconds of white over that"))]
    lines = []
    for label in gains.labels:
        line = [label, f"{statistics.geometric_mean(value for (_, name), value in cost.items() if name == label):.3g}"]
        for at in targets:
            if at in counts:
                found = seconds_of(gains, cost, counts, label, measure, at).values()
                gain = time_gain(gains, cost, counts, label, measure, at)
                line += [f"{statistics.geometric_mean(own for own, _ in found):.3g}" if found else "not reached",
                         gain.text() if gain and label != "white" else ""]
        lines.append(line)
    return header, lines
