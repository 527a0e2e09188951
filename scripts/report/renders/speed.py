# SPDX-License-Identifier: Apache-2.0
"""Timings of the path tracer: share of time spent sampling, thread scaling, and rays per second compared with the path tracer
of embree-tools.

Compared runs are interleaved and medians taken, so that other load on the machine affects all alike. Timed runs use one
thread, except to measure thread scaling, and run one at a time.
"""

import os
import platform
import re
import shutil
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

from ..base.files import read_exr
from ..base.progress import Progress
from .embree_scene import CORNELL_VIEW, cornell_xml
from .renderer import Request, run_pathtracer
from .variants import VARIANTS

TIMED_SPP = 64
PAIRS = 5
THREADS = 2


def timed(program, arguments, threads, folder):
    """(picture, attributes) of a run."""
    path = Path(folder) / "timed.exr"
    run_pathtracer(program, [*arguments, "--threads", threads, "--quiet", "-o", path])
    return read_exr(path)


def sampling_shares(program, variants, size, folder):
    """{label: share of cornell's render time spent sampling, median of three}, as the path tracer reports it."""
    shares = {}
    for _ in range(3):
        for label, variant in variants.items():
            request = Request(variant.sampler, TIMED_SPP, 0, "cornell", *size, mask=variant.mask,
                              declared=TIMED_SPP if variant.declare else 0)
            attributes = timed(program, request.arguments(), 1, folder)[1]
            if "samplingShare" in attributes:
                shares.setdefault(label, []).append(float(attributes["samplingShare"]))
    return {label: statistics.median(values) for label, values in shares.items()}


def thread_pairs(program, size, spp, folder, step):
    """[(seconds of one thread, seconds of two)], interleaved."""
    pairs = []
    for _ in range(PAIRS):
        step("timing one thread and two")
        pairs.append(tuple(float(timed(program, Request("blue", spp, 0, "cornell", *size).arguments(), n, folder)[1]
                                 ["seconds"]) for n in (1, THREADS)))
    return pairs


def find_embree(wanted=None):
    """The path tracer of embree-tools under any of its names, or None; `pathtracer` may be another program."""
    for name in [wanted] if wanted else ["embree_pathtracer", "pathtracer"]:
        path = shutil.which(name)
        if path:
            try:
                text = subprocess.run([path, "--help"], stdin=subprocess.DEVNULL, capture_output=True, text=True,
                                      timeout=10, check=False).stdout
            except (OSError, subprocess.TimeoutExpired):
                continue
            if "Embree" in text and "--max-path-length" in text:
                return path
    return None


def embree_pairs(program, embree, size, spp, folder, step):
    """Millions of rays per second of both path tracers on the Cornell box, interleaved. Both count every ray, including
    shadow rays; Embree's reads the box from a file. embree_scene.py lists the differences."""
    scene = folder / "cornell.xml"
    scene.write_text(cornell_xml(), encoding="utf-8")
    # Embree counts path segments including the camera ray, we count surfaces.
    common = [embree, "-i", scene, *CORNELL_VIEW, "--size", *size, "--spp", spp, "--max-path-length", 9, "--threads", 1]
    pairs = []
    for _ in range(PAIRS):
        step("Embree's path tracer")
        attributes = timed(program, Request("blue", spp, 0, "cornell", *size).arguments(), 1, folder)[1]
        done = subprocess.run([str(word) for word in [*common, "--benchmark", 1, 3]], stdin=subprocess.DEVNULL,
                              capture_output=True, text=True, check=False, cwd=folder)
        found = re.search(r"BENCHMARK_RENDER_MRAYPS_AVG\s+([0-9.]+)", done.stdout)
        if done.returncode != 0 or not found:
            lines = (done.stderr or done.stdout).strip().splitlines()
            return {"failed": lines[-1] if lines else f"exit status {done.returncode}"}
        pairs.append((1e-6 * int(attributes["rays"]) / float(attributes["seconds"]), float(found[1])))
    return {"pairs": pairs, "program": Path(embree).name}


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


def measure_all(options, store, build):
    """All timings as one dict; cached like pictures, until --retime or a new build of blue."""
    trial = options.size is not None
    embree = find_embree(options.embree)
    if options.embree and not embree:
        print(f"bench: {options.embree} is not the path tracer of embree-tools; its row is omitted", file=sys.stderr)
    size, big = (192, 192), (128, 128) if trial else (256, 256)
    key = {"timed": build, "labels": list(options.labels), "settings": [size, big, embree], "machine": machine()}
    found = None if options.retime else store.load(key)
    if found:
        return found[0]
    progress = Progress(2 * PAIRS + 1, "runs")
    done = [0]

    def step(what):
        progress(what, done[0], found=done[0] == 0)
        done[0] += 1

    result = {"machine": machine(), "big": big}
    try:
        with tempfile.TemporaryDirectory(prefix="libbn-") as folder:
            folder = Path(folder)
            step("timing the sampling")
            result["shares"] = sampling_shares(options.pathtracer, {label: VARIANTS[label] for label in options.labels},
                                               size, folder)
            result["threads"] = thread_pairs(options.pathtracer, big, 16, folder, step)
            result["embree"] = embree_pairs(options.pathtracer, embree, big, 8, folder, step) if embree else None
    finally:
        progress.close()
    store.save(key, result, {})
    return result
