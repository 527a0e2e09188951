# SPDX-License-Identifier: Apache-2.0
"""The share of the path tracer's time that is spent sampling. Runs are interleaved and medians taken, so that other load on the
machine affects all samplers alike; they use one thread, one at a time."""

import os
import platform
import statistics
import tempfile
from pathlib import Path

from ..base.files import read_exr
from ..base.progress import Progress
from .renderer import Request, run_pathtracer
from .variants import VARIANTS

TIMED_SPP, ROUNDS, SIZE = 64, 3, (192, 192)


def machine():
    """One line that describes the machine."""
    model = platform.processor() or platform.machine()
    try:
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                model = line.split(":", 1)[1].strip()
                break
    except OSError:
        pass
    return f"{model}, {os.cpu_count()} processors"


def sampling_shares(program, labels, progress):
    """{label: share of cornell's render time spent sampling, the median}, as the path tracer reports it."""
    shares = {}
    with tempfile.TemporaryDirectory(prefix="libbn-") as folder:
        path = Path(folder) / "timed.exr"
        for done in range(ROUNDS * len(labels)):
            label = labels[done % len(labels)]
            progress(f"timing {label}", done, found=done == 0)
            variant = VARIANTS[label]
            request = Request(variant.sampler, TIMED_SPP, 0, "cornell", *SIZE, mask=variant.mask, declared=TIMED_SPP if variant.declare else 0)
            run_pathtracer(program, [*request.arguments(), "--threads", 1, "--quiet", "-o", path])
            shares.setdefault(label, []).append(float(read_exr(path)[1]["samplingShare"]))
    return {label: statistics.median(values) for label, values in shares.items()}


def measure_all(options, store, build):
    """{"machine": one line, "shares": of sampling_shares()}; cached like pictures, until --retime or a new build of blue."""
    key = {"timed": build, "labels": list(options.labels), "settings": [SIZE, (128, 128) if options.size else (256, 256), None],
           "machine": machine()}
    found = None if options.retime else store.load(key)
    if not found:
        progress = Progress(ROUNDS * len(options.labels), "runs")
        try:
            found = {"machine": machine(), "shares": sampling_shares(options.pathtracer, list(options.labels), progress)}, {}
        finally:
            progress.close()
        store.save(key, *found)
    return found[0]
