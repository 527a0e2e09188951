# SPDX-License-Identifier: Apache-2.0
"""Error of the renderer lajolla with libbn's samplers, relative to its own random numbers: the table in docs/porting.md

    PYTHONPATH=scripts .venv/bin/python -m report.lajolla CHECKOUT

CHECKOUT is a clone of github.com/BachiLi/lajolla_public with the change that docs/porting.md shows, built in CHECKOUT/build. The
environment variables SAMPLER (`blue`, `sobol`, or unset for its own) and SEED are that change's.
"""

import argparse
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from .command import positive, run_or_say_why
from .files import read_exr
from .image_error import displayed_rmse, rmse
from .tables import add_options, md_table, write_or_print

COMMAND = "report.lajolla"
SCENES = {"Cornell box": "cbox/cbox.xml", "Veach's plates": "veach_mi/mi.xml"}
SAMPLERS = (None, "sobol", "blue")
COUNTS = (1, 4, 16)
SIGMA = 2.1


def write_scene(source, size, spp):
    """Writes a copy of a scene next to it, with another size and sample count; returns its path."""
    text = source.read_text(encoding="utf-8")
    for name, value in (("width", size), ("height", size), ("sampleCount", spp)):
        text, found = re.subn(rf'(name="{name}" value=)"\d+"', rf'\1"{value}"', text)
        if not found:
            sys.exit(f"bench: {source} has no {name}")
    with tempfile.NamedTemporaryFile("w", suffix=".xml", prefix=".libbn-", dir=source.parent, delete=False) as file:
        file.write(text)
    return Path(file.name)


def render(checkout, scene, size, spp, sampler, seed):
    environment = {key: value for key, value in os.environ.items() if key != "SAMPLER"} | {"SEED": str(seed)}
    if sampler:
        environment["SAMPLER"] = sampler
    path = write_scene(checkout / "scenes" / scene, size, spp)
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "out.exr"
        try:
            subprocess.run([checkout / "build" / "lajolla", "-t", str(os.cpu_count()), "-o", out, path.resolve()],
                           env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=True)
        except subprocess.CalledProcessError as error:
            sys.exit(f"bench: {error}")
        finally:
            path.unlink()
        return read_exr(out)[0].astype(np.float64)


def measure(checkout, size, seeds, reference_spp):
    """{(scene, spp): {sampler: (error as displayed, raw)}}, both after the blur."""
    result = {}
    for name, scene in SCENES.items():
        reference = render(checkout, scene, size, reference_spp, None, 1000)
        for spp in COUNTS:
            for sampler in SAMPLERS:
                errors = []
                for seed in range(seeds):
                    picture = render(checkout, scene, size, spp, sampler, seed)
                    errors.append((displayed_rmse(picture, reference, sigma=SIGMA), rmse(picture, reference, SIGMA)))
                result.setdefault((name, spp), {})[sampler] = np.sqrt(np.mean(np.square(errors), 0))
    return result


def table(result):
    """How many times smaller the error is: as displayed, and raw in brackets."""
    def text(row, than, with_sampler="blue"):
        times = row[than] / row[with_sampler]
        return f"{times[0]:.2f} ({times[1]:.2f})"

    return md_table(["scene", "spp", "`sobol` over its own", "`blue` over its own", "`blue` over `sobol`"],
                    [[name, str(spp), text(row, None, "sobol"), text(row, None), text(row, "sobol")]
                     for (name, spp), row in result.items()])


def main(arguments):
    parser = argparse.ArgumentParser(prog="report.lajolla", description=__doc__.splitlines()[0])
    parser.add_argument("checkout", type=Path)
    parser.add_argument("--size", type=positive, default=96, metavar="N", help="side of the pictures (default 96)")
    parser.add_argument("--seeds", type=positive, default=6, metavar="N", help="pictures of each sampler (default 6)")
    parser.add_argument("--reference-spp", type=positive, default=1024, metavar="N", help="samples per pixel of references (default 1024)")
    add_options(parser, "docs/porting.md")
    options = parser.parse_args(arguments)
    write_or_print(options, COMMAND, table(measure(options.checkout, options.size, options.seeds, options.reference_spp)))


if __name__ == "__main__":
    run_or_say_why(main)
