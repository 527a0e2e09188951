# SPDX-License-Identifier: Apache-2.0
"""Links and headings of Markdown pages, as interpreted by code hosts."""

import posixpath
import re

from markdown_it import MarkdownIt

PARSER = MarkdownIt("commonmark").enable("table")


def links(text):
    """The targets of all links and images."""
    inline = (child for token in PARSER.parse(text) for child in token.children or ())
    return [str(token.attrs.get("href") or token.attrs.get("src")) for token in inline if token.type in ("link_open", "image")]


def is_external(target):
    return bool(re.match(r"[a-z][a-z0-9+.-]*:|//", target, re.I))


def resolve(page, target):
    """Resolves a relative link on a page to a path from the repository's root, and an anchor."""
    path, _, anchor = target.partition("#")
    return posixpath.normpath(posixpath.join(posixpath.dirname(page), path)) if path else page, anchor
