# SPDX-License-Identifier: Apache-2.0
"""Other libraries' samplers, which `scripts/bench PART --openqmc DIR` adds to a build and its tables for comparison."""

import subprocess
import sys

# The path tracer's names for OpenQMC's blue-noise samplers.
PEERS = ("openqmc-pmjbn", "openqmc-sobolbn", "openqmc-latticebn")


def samplers(program):
    """The samplers that the path tracer lists with --list; none if it cannot be run."""
    try:
        listing = subprocess.run([program, "--list"], check=False, capture_output=True, text=True).stdout
    except OSError:
        return set()
    return {line.split()[0] for line in listing.splitlines() if line.startswith("  ")}


def listed(program):
    """The listed samplers that are in PEERS."""
    return tuple(name for name in PEERS if name in samplers(program))


def commit(openqmc):
    """A checkout's commit and date, for a report; "unknown" if it is not a git checkout, empty if there is none."""
    if not openqmc:
        return ""
    try:
        return subprocess.run(["git", "-C", openqmc, "log", "-1", "--format=%h of %cs"], check=True, capture_output=True,
                              text=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return "unknown"


def chosen(openqmc, program):
    """The peers to compare with: all of them with --openqmc, otherwise none. Exits with a one-line message if the build lacks them."""
    if not openqmc:
        return ()
    if listed(program) != PEERS:
        sys.exit(f"bench: {program} was built without OpenQMC; build it with scripts/setup -DBN_OPENQMC={openqmc}")
    return PEERS
