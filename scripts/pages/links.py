# SPDX-License-Identifier: Apache-2.0
"""Links and headings of Markdown pages, as a code host sees them. Needs the standard library alone."""

import re
from pathlib import PurePosixPath

LINK = re.compile(r"(?<!\\)\[(?:[^\[\]]|!?\[[^\[\]]*\](?:\([^()]*\))?)*\]\(\s*<?([^()\s<>]+)>?(?:\s+\"[^\"]*\")?\s*\)")
FENCE = re.compile(r"^ *(`{3,}|~{3,})")


def without_code(text):
    """The text with code and HTML comments blanked out, so that places in it stay what they were."""
    lines, fence = [], None
    for line in text.splitlines(keepends=True):
        mark = FENCE.match(line)
        if fence is None and mark:
            fence = mark[1]
        elif fence is not None:
            if mark and mark[1].startswith(fence) and not line.strip().strip(fence[0]):
                fence = None
        else:
            lines.append(line)
            continue
        lines.append(blank(line))
    found = re.compile(r"<!--.*?-->|(?<!`)(`+)(?!`).+?(?<!`)\1(?!`)", re.S)
    return found.sub(lambda match: blank(match[0]), "".join(lines))


def blank(text):
    return re.sub(r"[^\n]", " ", text)


def links(text):
    """(start, end, target) of each link and picture that is not code, without those in the text of other links."""
    shown = without_code(text)
    found = [(match.start(1), match.end(1), match[1]) for match in LINK.finditer(shown)]
    # A picture that is a link: the inner target.
    inner = re.compile(r"\[!\[[^\[\]]*\]\(([^()\s]+)\)\]")
    return sorted(found + [(match.start(1), match.end(1), match[1]) for match in inner.finditer(shown)])


def is_external(target):
    return bool(re.match(r"[a-z][a-z0-9+.-]*:|//", target, re.I))


def resolve(page, target):
    """The path from the root of the repository, and the anchor, that a relative link of a page means."""
    path, _, anchor = target.partition("#")
    if not path:
        return page, anchor
    parts = []
    for part in (PurePosixPath(page).parent / path).parts:
        if part == ".." and parts and parts[-1] != "..":
            parts.pop()
        elif part != ".":
            parts.append(part)
    return "/".join(parts), anchor


def slug(heading):
    """The anchor that code hosts give a heading."""
    text = re.sub(r"!?\[([^\[\]]*)\]\([^()]*\)", r"\1", heading).replace("`", "")
    return re.sub(r"[^\w\- ]", "", text.strip().lower()).replace(" ", "-")


def anchors(text):
    seen, found = {}, set()
    fence = None
    for line in text.splitlines():
        mark = FENCE.match(line)
        if mark and (fence is None or mark[1].startswith(fence)):
            fence = None if fence else mark[1]
        match = None if fence or mark else re.match(r"#{1,6} +(.*?)(?: +#+)?\s*$", line)
        if match:
            name = slug(match[1])
            count = seen.get(name, 0)
            seen[name] = count + 1
            found.add(f"{name}-{count}" if count else name)
    return found
