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
    mask: str = ""
    most_seeds: int | None = None


VARIANTS = {
    "white": Variant("white"),
    "sobol": Variant("sobol"),
    "zorder": Variant("zorder", declare=True),
    # The mask provides the first sample; from 4 samples on this is nearly the same as sobol.
    "mask": Variant("mask", most_seeds=SIDE_SEEDS),
    "mask, neural": Variant("mask", mask="neural", most_seeds=SIDE_SEEDS),
    "sobol-global": Variant("sobol-global"),  # in builds with Boost
    **{name: Variant(name) for name in PEERS},
    "blue": Variant("blue"),
}
ALWAYS = ("white", "sobol", "blue")  # headlines say how much less error blue has than the others
DEFAULT = ("white", "sobol", "sobol-global", "zorder", "mask", "blue")
# Names on the command line contain no comma.
OPTION_NAMES = {name.replace(", ", "-"): name for name in VARIANTS if name not in PEERS}


def add_option(parser, default=DEFAULT):
    """Adds --samplers; chosen(options.samplers, peers) gives the labels."""
    names = {label: name for name, label in OPTION_NAMES.items()}
    parse = names_of("sampler", OPTION_NAMES)
    parser.add_argument("--samplers", type=lambda text: [OPTION_NAMES[name] for name in parse(text)], default=default, metavar="A,B,...",
                        help=f"samplers out of {', '.join(OPTION_NAMES)} (default {','.join(names[label] for label in default)}); "
                             f"{', '.join(ALWAYS)} are always included")


def of(labels):
    """{label: Variant}."""
    return {label: VARIANTS[label] for label in labels}


def chosen(labels, peers=()):
    """Labels in the order of VARIANTS, including those that ratios need and the peers in the build."""
    return tuple(label for label in VARIANTS if label in labels or label in ALWAYS or label in peers)
