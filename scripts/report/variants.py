# SPDX-License-Identifier: Apache-2.0
"""The samplers that are compared, each in its intended use."""

import argparse
import dataclasses

from .peers import PEERS

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
    **{name: Variant(name) for name in PEERS},
    "blue": Variant("blue"),
}
ALWAYS = ("white", "sobol", "blue")  # headlines say how much less error blue has than the others
DEFAULT = ("white", "sobol", "zorder", "mask", "blue")
# Names on the command line contain no comma.
OPTION_NAMES = {name.replace(", ", "-"): name for name in VARIANTS if name not in PEERS}


def parse_samplers(text):
    words = [word for word in text.split(",") if word]
    unknown = [word for word in words if word not in OPTION_NAMES]
    if unknown or not words:
        raise argparse.ArgumentTypeError(f"unknown sampler '{', '.join(unknown)}'; choose from {', '.join(OPTION_NAMES)}")
    return tuple(OPTION_NAMES[word] for word in words)


def add_option(parser, default=DEFAULT):
    """Adds --samplers; chosen(options.samplers, peers) gives the labels."""
    names = {label: name for name, label in OPTION_NAMES.items()}
    parser.add_argument("--samplers", type=parse_samplers, default=default, metavar="A,B,...",
                        help=f"samplers out of {', '.join(OPTION_NAMES)} (default {','.join(names[label] for label in default)}); "
                             f"{', '.join(ALWAYS)} are always included")


def chosen(labels, peers=()):
    """Labels in the order of VARIANTS, including those that ratios need and the peers in the build."""
    return tuple(label for label in VARIANTS if label in labels or label in ALWAYS or label in peers)
