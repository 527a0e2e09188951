# SPDX-License-Identifier: Apache-2.0
"""The samplers that are compared, each in its intended use."""

import dataclasses

from ..base.command import names_of
from ..base.peers import PEERS

# A few seeds suffice for samplers that no headline figure depends on.
SIDE_SEEDS = 4


@dataclasses.dataclass(frozen=True)
class Variant:
    """declare: the sampler must be told the sample count, so each count is a run of its own."""

    sampler: str
    declare: bool = False
    most_seeds: int | None = None

    @property
    def key(self):
        """For caches, of which those of earlier versions had one field more."""
        return [self.sampler, self.declare, "", self.most_seeds]


VARIANTS = {
    "white": Variant("white"),
    "pcg": Variant("pcg"),
    "sobol": Variant("sobol"),
    "zorder": Variant("zorder", declare=True),
    # The mask provides the first sample; from 4 samples on this is nearly the same as sobol.
    "mask": Variant("mask", most_seeds=SIDE_SEEDS),
    "sobol-global": Variant("sobol-global"),  # in builds with Boost
    **{name: Variant(name) for name in PEERS},
    "blue": Variant("blue"),
}
ALWAYS = ("white", "sobol", "blue")  # headlines say how much less error blue has than the others
OWN = tuple(name for name in VARIANTS if name not in PEERS)


def add_option(parser, default=OWN):
    """Adds --samplers; chosen(options.samplers, peers) gives the labels."""
    parser.add_argument("--samplers", type=names_of("sampler", OWN), default=default, metavar="A,B,...",
                        help=f"samplers out of {', '.join(OWN)} (default {','.join(default)}); {', '.join(ALWAYS)} are always included")


def of(labels):
    """{label: Variant}."""
    return {label: VARIANTS[label] for label in labels}


def chosen(labels, peers=()):
    """Labels in the order of VARIANTS, including those that ratios need and the peers in the build."""
    return tuple(label for label in VARIANTS if label in labels or label in ALWAYS or label in peers)
