# SPDX-License-Identifier: Apache-2.0
"""Compares `blue` with other samplers in the path tracer of examples/web: `scripts/bench web` writes the table in examples/web/package/README.md and its image

Opens the page in headless Chromium (WebGL 2 on its software renderer) and reads the sample sums that the page's shaders compute with
white noise, padded Sobol' points and `blue`.
"""

import base64
import contextlib
import tempfile
from pathlib import Path

import numpy as np
from chromium import Browser, chromium

from ..base.command import CommandError, Parser
from ..base.progress import Progress
from ..base.tables import md_table, write_or_print
from .other_renderer import shown_and_raw, write_picture

COMMAND = "scripts/bench web"
PAGE = Path(__file__).resolve().parents[2] / "examples" / "web" / "index.html"
SAMPLERS = {"white": "white noise", "sobol": "padded Sobol'", "blue": "blue"}
COUNTS = (1, 2, 3, 4, 6, 8, 16)
REFERENCE_RUN = 1_000_000  # differs from the run of every image
PICTURE, PICTURE_SPP, PICTURE_PART = "docs/web.jpg", 3, (20, 30, 200, 190)
# A sampler's current sums, four floats per pixel, as text, because encoding them as JSON would take longer than rendering.
READ = """(kind => {{
  const bytes = new Uint8Array(tracer.read(kind).buffer);
  let text = "";
  for (let i = 0; i < bytes.length; i += 32768) text += String.fromCharCode(...bytes.subarray(i, i + 32768));
  return btoa(text);
}})("{}")"""


class Tracer:
    """The page's path tracer, paused, with images `width` pixels wide."""

    def __init__(self, browser, width):
        self.browser = browser
        browser.open(PAGE.as_uri(), width, width)
        browser.wait("!element('problem').hidden || tracer.count >= 1")
        problem = browser.value("element('problem').textContent")
        if problem:
            raise CommandError(problem)
        browser.value("(limitTo(1), errors.restart(null))")
        browser.wait("tracer.count === 1 && !asked")
        browser.value(f"tracer.resize({width}, {width * 2 // 3})")
        self.shape = (width * 2 // 3, width, 4)

    def restart(self, run):
        self.browser.value(f"tracer.restart({run})")

    def sample(self, count):
        """Adds samples to every sampler's image until each has `count`. Reading pixels waits for each sample, which gl.finish() does not do."""
        while self.browser.value("tracer.count") < count:
            self.browser.value("(tracer.sample(), tracer.read('blue').length)")

    def picture(self, kind):
        sums = np.frombuffer(base64.b64decode(self.browser.value(READ.format(kind))), np.float32).reshape(self.shape)
        return sums[::-1, :, :3] / self.browser.value("tracer.count")


def measure(tracer, seeds, reference_spp, progress):
    """{(sampler, count): images}, one per seed, and the reference: the mean of the two images with the least noise, which share no random
    numbers with the other images."""
    tracer.restart(REFERENCE_RUN)
    tracer.sample(reference_spp)
    progress("reference", reference_spp)
    reference, found = np.mean([tracer.picture(kind) for kind in ("sobol", "blue")], 0), {}
    for seed in range(seeds):
        tracer.restart(seed)
        for count in COUNTS:
            tracer.sample(count)
            for kind in SAMPLERS:
                found.setdefault((kind, count), []).append(tracer.picture(kind))
        progress(f"seed {seed + 1}", reference_spp + (seed + 1) * COUNTS[-1])
    return found, reference


def table(errors):
    return md_table(["error over padded Sobol'", *map(str, COUNTS)], [
        [name, *("{:.2f} ({:.2f})".format(*errors[kind, count] / errors["sobol", count]) for count in COUNTS)]
        for kind, name in SAMPLERS.items() if kind != "sobol"])


def run(arguments):
    parser = Parser("web", __doc__)
    parser.number("--width", 360, "width of the images; their height is two thirds of it")
    parser.number("--seeds", 4, "number of images per sampler")
    parser.number("--reference-spp", 64, "samples per pixel of each of the two reference images")
    parser.add_argument("--picture", metavar="FILE", help=f"path to the image (default {PICTURE}; none with --print)")
    parser.table("examples/web/package/README.md")
    options = parser.parse_args(arguments)
    program = chromium()
    if program is None:
        raise CommandError("Chromium is not installed; run apt-get install chromium, or set BN_CHROMIUM")
    with (Progress(options.reference_spp + options.seeds * COUNTS[-1], "samples") as progress,
          tempfile.TemporaryDirectory(prefix="libbn-chromium-", ignore_cleanup_errors=True) as folder,
          contextlib.closing(Browser(program, Path(folder), seconds=300)) as browser):
        found, reference = measure(Tracer(browser, options.width), options.seeds, options.reference_spp, progress)
    if options.picture or not options.print:
        write_picture(Path(options.picture or PICTURE), {name: found[kind, PICTURE_SPP][0] for kind, name in SAMPLERS.items()}, reference, PICTURE_PART)
    write_or_print(options, COMMAND, table({key: shown_and_raw(pictures, reference) for key, pictures in found.items()}))
