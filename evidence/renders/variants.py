# SPDX-License-Identifier: Apache-2.0
"""The samplers to compare, each used as intended."""

from ..base.command import names_of
from ..base.peers import PEERS

# Only builds with Boost include sobol-global.
SAMPLERS = ("white", "sobol", "zorder", "mask", "sobol-global", *PEERS, "blue")
OWN = tuple(name for name in SAMPLERS if name not in PEERS)
ALWAYS = ("white", "sobol", "blue")  # the headline figures compare blue with the others
DECLARED = ("zorder",)  # must know the sample count, so each sample count takes a separate run


def add_option(parser, default=OWN):
    """Adds --samplers; chosen(options.samplers, peers) gives the labels."""
    parser.add_argument("--samplers", type=names_of("sampler", OWN), default=default, metavar="A,B,...",
                        help=f"samplers from {', '.join(OWN)} (default {','.join(default)}); {', '.join(ALWAYS)} are always included")


def chosen(labels, peers=()):
    """Labels in the order of SAMPLERS, including the samplers that ratios need and the peers in the build."""
    return tuple(label for label in SAMPLERS if label in labels or label in ALWAYS or label in peers)
