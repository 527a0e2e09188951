# SPDX-License-Identifier: Apache-2.0
"""Throughput of networks on an endless plane, on the processor and on a GPU: a section of docs/report/neural.md.

Part of `scripts/bench neural`. Each window lies beside the one before, so nothing could be reused.
"""

import argparse
import os
import subprocess
import time

import numpy as np

import bluenoise

from ..base.files import read_rows, write_rows

FIELDS = ("network", "device", "threads", "extent", "windows", "seconds")


def available(provider):
    """The argument, if it is not "cuda" or there is a GPU: an argument's type for argparse."""
    if provider == "cuda":
        try:
            bluenoise.NeuralGenerator(provider=provider)
        except bluenoise.RuntimeMissingError as error:
            raise argparse.ArgumentTypeError(str(error)) from None
    return provider


def add_option(parser):
    parser.add_argument("--provider", type=available, choices=("cpu", "cuda"),
                        help="measure the endless plane on the processor alone (cpu), or fail without a GPU (cuda); default: "
                             "on the GPU too, if there is one")


def gpu_name():
    try:
        asked = subprocess.run(["nvidia-smi", "--query-gpu=name", "--format=csv,noheader"], capture_output=True, text=True,
                               check=True)
        return asked.stdout.splitlines()[0].strip() or "GPU"
    except (OSError, subprocess.CalledProcessError, IndexError):
        return "GPU"


def time_windows(generator, extent, windows):
    """Seconds for so many windows. The first one, which is not counted, sets up the provider."""
    for i in range(windows + 1):
        if i == 1:
            start = time.perf_counter()
        generator.window(i * extent, 0, extent, extent, seed=1)
    return time.perf_counter() - start


def measure(models, provider, quick):
    """Rows as dicts; models: {name of a network: path}."""
    extent, windows = (256, 2) if quick else (2048, 4)
    cores = os.cpu_count() or 1
    rows = []
    for name, path in models.items():
        runs = [("cpu", threads, "processor") for threads in sorted({1, cores})]
        if provider != "cpu":
            runs.append(("cuda", 0, gpu_name()))
        for chosen, threads, device in runs:
            try:
                generator = bluenoise.NeuralGenerator(path, threads=threads, provider=chosen)
            except bluenoise.RuntimeMissingError:
                if provider == "cuda" or chosen == "cpu":
                    raise
                continue
            count = windows if chosen == "cpu" else 8 * windows
            seconds = time_windows(generator, extent, count)
            rows.append({"network": name, "device": device, "threads": threads or min(cores, 4), "extent": extent,
                         "windows": count, "seconds": f"{max(seconds, 1e-9):.9f}"})
            print(f"bench: endless plane, {name}, {device}, {rows[-1]['threads']} threads: {number(rate(rows[-1]))} gigatexels/s",
                  flush=True)
    return rows


def rate(row):
    """Gigatexels per second."""
    return int(row["windows"]) * int(row["extent"]) ** 2 / float(row["seconds"]) / 1e9


def number(value):
    """Three digits, without an exponent."""
    return np.format_float_positional(value, precision=3, fractional=False, trim="-")


def lines_of(rows):
    extent = rows[0]["extent"]
    lines = ["## An endless plane", "", f"Windows of {extent}x{extent} side by side, into main memory, on all cores and on one:", "",
             "| network | on | threads | nanoseconds per texel | gigatexels per second |", "| --- | --- |" + " ---: |" * 3,
             *(f"| {row['network']} | {row['device']} | {row['threads']} | {number(1 / rate(row))} | {number(rate(row))} |" for row in rows)]
    if all(row["device"] == "processor" for row in rows):
        lines += ["", "No GPU was measured: none was available for this run."]
    return lines


def section(models, options):
    """Measures, or with --again reads what was measured before, and returns lines of Markdown."""
    path = options.out / "neural_plane.csv"
    if options.again and path.is_file():
        return lines_of(read_rows(path))
    rows = measure(models, options.provider, options.quick)
    write_rows(path, FIELDS, rows)
    return lines_of(rows)
