# SPDX-License-Identifier: Apache-2.0
"""Which pages of the site a search shows first: those that say how to use libbn, before what was measured. Standard library."""

# A page's relevance is multiplied by that of its section in mkdocs.yml.
SECTIONS = {"Guides": 8, "C and C++": 6, "Python": 6, "GPUs": 3, "Programs": 2, "Reports": 0.2, "Project": 0.1}
HOME, OTHERS = 4, 0.05  # others are listings of linked files


def pages(nav):
    """The paths in a part of the navigation."""
    for entry in nav if isinstance(nav, list) else nav.values() if isinstance(nav, dict) else [nav]:
        if isinstance(entry, str):
            yield entry
        else:
            yield from pages(entry)


def boost(path, nav):
    """The factor of a page; nav: the navigation as mkdocs.yml has it."""
    for entry in nav:
        for title, inside in entry.items():
            if path in pages(inside):
                return HOME if isinstance(inside, str) else SECTIONS[title]
    return OTHERS
