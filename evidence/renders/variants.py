# SPDX-License-Identifier: Apache-2.0
"""The samplers to compare, each used as intended. `scripts/bench PART --openqmc DIR` adds OpenQMC's to a build and its tables, and
--heitz FOLDER adds the tables of Heitz et al. 2019."""

import subprocess
import sys

from ..base.cache import cache_folder
from ..samplers import heitz

# OpenQMC's blue-noise samplers.
PEERS = ("openqmc-pmjbn", "openqmc-sobolbn", "openqmc-latticebn")
# Only builds with Boost include sobol-global.
SAMPLERS = ("white", "sobol", "zorder", "mask", "sobol-global", "heitz", *PEERS, "blue")
OWN = tuple(name for name in SAMPLERS if name not in (*PEERS, "heitz"))
ALWAYS = ("white", "sobol", "blue")  # the headline figures compare blue with the others
DECLARED = ("zorder",)  # are told the sample count
TUNED = (*DECLARED, "heitz")  # differ for each sample count, so each takes a separate run
_tables = []  # heitz.Tables, of chosen()


def program_name(label, count):
    """The path tracer's name of a sampler."""
    if label != "heitz":
        return label
    return f"heitz:{_tables[-1].file(count, cache_folder() / 'heitz')}"


def built(program):
    """The samplers that the path tracer lists with --list; none if it cannot be run."""
    try:
        listing = subprocess.run([program, "--list"], check=False, capture_output=True, text=True).stdout
    except OSError:
        return set()
    return {line.split()[0] for line in listing.splitlines() if line.startswith("  ")}


def commit(openqmc):
    """A checkout's commit and date, for a report; "unknown" if it is not a git checkout, empty if there is none."""
    if not openqmc:
        return ""
    done = subprocess.run(["git", "-C", openqmc, "log", "-1", "--format=%h of %cs"], check=False, capture_output=True, text=True)
    return done.stdout.strip() or "unknown"


def peers(options):
    """The peers to compare with: all of them with --openqmc, otherwise none. Exits with a one-line message if the build lacks them."""
    if options.openqmc and not built(options.pathtracer).issuperset(PEERS):
        sys.exit(f"bench: {options.pathtracer} was built without OpenQMC; build it with scripts/setup -DBN_OPENQMC={options.openqmc}")
    return PEERS if options.openqmc else ()


def chosen(labels, options):
    """Labels in the order of SAMPLERS, including the samplers that ratios need and the peers."""
    wanted = {*labels, *ALWAYS, *peers(options)}
    if options.heitz:
        _tables.append(heitz.Tables(options.heitz))
        wanted.add("heitz")
    return tuple(label for label in SAMPLERS if label in wanted)
