# SPDX-License-Identifier: Apache-2.0
"""The samplers that are compared, each in its intended use."""

from ..base.command import names_of
from ..base.peers import PEERS

# sobol-global is in builds with Boost.
SAMPLERS = ("white", "sobol", "zorder", "mask", "sobol-global", *PEERS, "blue")
OWN = tuple(name for name in SAMPLERS if name not in PEERS)
ALWAYS = ("white", "sobol", "blue")  # headlines say how much less error blue has than the others
DECLARED = ("zorder",)  # must be told the sample count, so each count is a run of its own


def add_option(parser, default=OWN):
    """Adds --samplers; chosen(options.samplers, peers) gives the labels."""
    parser.add_argument("--samplers", type=names_of("sampler", OWN), default=default, metavar="A,B,...",
                        help=f"samplers out of {', '.join(OWN)} (default {','.join(default)}); {', '.join(ALWAYS)} are always included")


def chosen(labels, peers=()):
    """Labels in the order of SAMPLERS, including those that ratios need and the peers in the build."""
    return tuple(label for label in SAMPLERS if label in labels or label in ALWAYS or label in peers)
