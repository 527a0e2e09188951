# SPDX-License-Identifier: Apache-2.0
"""The samplers to compare, each used as intended: libbn's, and plug-ins (plugins.py). `scripts/bench PART --sampler NAME=FILE` adds anyone's,
--openqmc DIR OpenQMC's, and --heitz FOLDER the one with the tables of Heitz et al. 2019."""

import subprocess

from ..base.cache import cache_folder
from ..base.command import CommandError
from . import heitz, plugins

# OpenQMC's blue-noise samplers.
PEERS = ("openqmc-pmjbn", "openqmc-sobolbn", "openqmc-latticebn")
# sobol-global is a plug-in, which needs Boost.
SAMPLERS = ("white", "sobol", "zorder", "mask", "sobol-global", "heitz", *PEERS, "blue")
NAMES = {"white": "white noise", "sobol": "padded Sobol'", "sobol-global": "global Sobol'", "zorder": "Z-order, tuned for N", "mask": "a mask",
         "blue": "`blue`", "heitz": "Heitz et al. 2019, tuned for N", "openqmc-sobolbn": "OpenQMC sobolbn", "openqmc-pmjbn": "OpenQMC pmjbn", "openqmc-latticebn": "OpenQMC latticebn"}
OWN = tuple(name for name in SAMPLERS if name not in (*PEERS, "heitz"))
ALWAYS = ("white", "sobol", "blue")  # the headline figures compare blue with the others
PLUGINS = {}  # {name: plugins.Plugin} of chosen()


def is_tuned(label):
    """Whether a sampler differs for each sample count, so that each takes a separate run."""
    return label == "zorder" or (label in PLUGINS and PLUGINS[label].tuned)


def program_name(label):
    """The path tracer's name of a sampler."""
    return PLUGINS[label].file if label in PLUGINS else label


def commit(openqmc):
    """A checkout's commit and date, for a report; "unknown" if it is not a git checkout, empty if there is none."""
    if not openqmc:
        return ""
    done = subprocess.run(["git", "-C", openqmc, "log", "-1", "--format=%h of %cs"], check=False, capture_output=True, text=True)
    return done.stdout.strip() or "unknown"


def files_of(options):
    """{name: file of a plug-in} for the options: those of --sampler, --openqmc and --heitz."""
    found = dict(options.sampler)
    if taken := set(found) & set(SAMPLERS):
        raise CommandError(f"--sampler {taken.pop()}=...: the name is taken; choose another one")
    if options.openqmc:
        found.update({name: f"{plugins.FOLDER}/openqmc.so:{name.partition('-')[2]}" for name in PEERS})
    if options.heitz:
        found["heitz"] = f"{plugins.FOLDER}/heitz.so:{heitz.Tables(options.heitz).write(cache_folder() / 'heitz')}"
    return found


def chosen(labels, options):
    """Labels in the order of SAMPLERS, including the samplers that ratios need; plug-ins of others come before blue. Fills PLUGINS."""
    files = files_of(options)
    if "sobol-global" in labels:
        files["sobol-global"] = plugins.FOLDER / "sobol_global.so"
        if not files["sobol-global"].is_file():
            raise CommandError("sobol-global needs Boost (Debian: libboost-dev) when scripts/setup builds; install it, or leave it out of --samplers")
    PLUGINS.clear()
    PLUGINS.update({name: plugins.load(file) for name, file in files.items()})
    for name, plugin in PLUGINS.items():
        if plugin.function:
            raise CommandError(f"--sampler {name}=...: the path tracer needs a shared library; Python functions are for samplers and realtime")
    wanted = {*labels, *ALWAYS, *files}
    return tuple(label for label in (*SAMPLERS[:-1], *dict(options.sampler), "blue") if label in wanted)
