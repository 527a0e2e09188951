# SPDX-License-Identifier: Apache-2.0
"""The samplers of other libraries that a build may hold, so that they stand in the same tables as libbn's.

`scripts/bench PART --openqmc DIR` builds with the checkout of OpenQMC in DIR and hands the option on to the part:

    peers.add_option(parser)
    options = parser.parse_args(arguments)
    samplers += peers.chosen(options.openqmc, options.pathtracer)

A report names its command with `--openqmc DIR`, wherever the folder was.
"""

import subprocess
import sys

# The path tracer's names of OpenQMC's blue-noise samplers.
PEERS = ("openqmc-pmjbn", "openqmc-sobolbn", "openqmc-latticebn")


def listed(program):
    """Those of PEERS that the path tracer has, by its own --list; none if it does not run."""
    try:
        listing = subprocess.run([program, "--list"], check=False, capture_output=True, text=True).stdout
    except OSError:
        return ()
    names = {line.split()[0] for line in listing.splitlines() if line.startswith("  ")}
    return tuple(name for name in PEERS if name in names)


def add_option(parser):
    parser.add_argument("--openqmc", metavar="DIR",
                        help="build with the checkout of OpenQMC in DIR, and compare with its samplers too")


def chosen(openqmc, program):
    """The peers to compare with: all with --openqmc, none without. Exits with one line if the build lacks them."""
    if not openqmc:
        return ()
    if listed(program) != PEERS:
        sys.exit(f"bench: {program} has no samplers of OpenQMC; build it with scripts/setup -DBN_OPENQMC={openqmc}")
    return PEERS
