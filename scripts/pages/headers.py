# SPDX-License-Identifier: Apache-2.0
"""Markdown pages from the public headers, whose comments are the manual. Needs the standard library alone.

A header is read as it is laid out: the comment at its top, sections between `/* ---- Name */`, and declarations, each under its
comment. A comment with an empty line after it belongs to the section. Declarations in one block share their comment.
Structures, enumerations and classes are shown as in the header, functions without bodies.
"""

import re
from dataclasses import dataclass, field

TOKEN = re.compile(
    r"(?P<blank>(?:[ \t]*\n)+)|(?P<space>[ \t]+)|(?P<comment>/\*.*?\*/|(?://[^\n]*\n[ \t]*)+)"
    r"|(?P<directive>\#(?:[^\n\\]|\\.|\\\n)*)|(?P<scope>extern \"C\" \{|namespace \w+ \{|\})", re.S)
INSIDE = re.compile(r"/\*.*?\*/|//[^\n]*|\"(?:\\.|[^\"\\])*\"|[{}()\[\];#]", re.S)
NAME = re.compile(r"(?:struct|class|enum)\s+(\w+)\s*(?:;|[:{])|(\w+)\s*(?:\(|;|\[|=)")


@dataclass
class Item:
    """Declarations under one comment, as Markdown sees them: a heading, code, text."""

    names: list
    code: list
    comment: str = ""
    constants: list = field(default_factory=list)


@dataclass
class Section:
    title: str
    texts: list = field(default_factory=list)
    items: list = field(default_factory=list)


def plain(comment):
    """The text of a comment, without its marks."""
    if comment.startswith("/*"):
        lines = comment[2:-2].rstrip().split("\n")
        lines = [lines[0].strip()] + [re.sub(r"^\s*\*? ?", "", line) for line in lines[1:]]
    else:
        lines = [re.sub(r"^\s*// ?", "", line) for line in comment.rstrip().split("\n")]
    lines = [line.rstrip() for line in lines if not line.startswith("SPDX-License-Identifier")]
    return "\n".join(lines).strip("\n")


# ---- Reading


def declaration_end(text, start):
    """(end, start of a function's body or None); end is None if a directive cuts the declaration in two."""
    depth, brace = 0, None
    for mark in INSIDE.finditer(text, start):
        sign = mark[0]
        if sign == "#" and depth == 0:
            return None, None
        if sign in "([{":
            if sign == "{" and depth == 0:
                brace = mark.start()
            depth += 1
        elif sign in ")]}":
            depth -= 1
            if depth == 0 and sign == "}" and is_function(text[start:brace]):
                return mark.end(), brace
        elif sign == ";" and depth == 0:
            return mark.end(), None
    raise ValueError(f"a declaration does not end: {text[start:start + 60]!r}")


def is_function(head):
    return bool(re.search(r"\)\s*(?:const)?\s*(?:noexcept)?\s*$", without_initialisers(head)))


def without_initialisers(head):
    """The head of a constructor without `: member_(value)`."""
    depth = 0
    for i, sign in enumerate(head):
        depth += (sign in "([") - (sign in ")]")
        if sign == ":" and depth == 0 and ")" in head[:i] and "::" not in (head[i - 1 : i + 1], head[i : i + 2]):
            return head[:i]
    return head


def without_bodies(text):
    """A class as its users see it: no private part, no bodies, nothing deleted."""
    opening = text.index("{") + 1
    out, at = [text[:opening]], opening
    closing = text.rindex("}")
    private = re.compile(r"^\s*private:.*\Z", re.S | re.M)
    inner = private.sub("\n", text[opening:closing])
    at = 0
    while at < len(inner):
        mark = re.compile(r"\s+|//[^\n]*|\w+:(?!:)").match(inner, at)
        if mark:
            out.append(mark[0])
            at = mark.end()
            continue
        end, body = declaration_end(inner, at)
        head = inner[at:body] if body else inner[at:end]
        if "= delete" not in head:
            out.append(without_initialisers(head).rstrip() + ";" if body else head)
        at = end
    result = "".join(out) + text[closing:]
    return re.sub(r"[ \t]*\n(?:[ \t]*\n)+", "\n\n", re.sub(r"\s+\};$", "\n};", result))


def name_of(code):
    """The name that a declaration introduces; None for an enumeration without one."""
    head = re.sub(r"/\*.*?\*/|//[^\n]*", "", code, flags=re.S)
    head = re.sub(r"template\s*<[^{};]*?>\s*\n", "", head)
    define = re.match(r"#\s*define\s+(\w+)", head)
    if define:
        return define[1]
    pointer = re.search(r"\(\*(\w+)\)\(", head)
    if pointer:
        return pointer[1]
    if head.startswith("typedef"):
        return re.search(r"(\w+)\s*;\s*$", head)[1]
    match = NAME.search(head)
    return next(filter(None, match.groups()), None) if match and not re.match(r"enum\s*\{", head) else None


def read(text):
    """The comment at the top of a header, and its sections."""
    sections = [Section("")]
    intro = pending = None
    scope = ""
    joined = False  # whether nothing but a line end lies between the last declaration and here
    at = 0

    def add(code):
        nonlocal pending, joined
        items = sections[-1].items
        name = scope + name_of(code) if name_of(code) else None
        bare = pending is None
        before = items[-1] if items else None
        if bare and before and (joined or name is None or name == f"{before.names[-1]}_default"):
            before.code.append(("" if joined else "\n") + code)
            before.names += [name] if name and name not in before.names else []
        elif not bare or re.match(r"typedef|struct|class|enum", code):
            items.append(Item([name] if name else [], [code], plain(pending or "")))
        elif "BN_API" in code:
            raise ValueError(f"{name} has no comment")
        if items and re.match(r"(?:typedef )?enum|#", code):
            items[-1].constants += re.findall(r"\bBN_[A-Z0-9_]+\b(?=[^*]*?[=,\n])", re.sub(r"/\*.*?\*/", "", code, flags=re.S))
        pending, joined = None, True

    while at < len(text):
        token = TOKEN.match(text, at)
        kind = token.lastgroup if token else None
        if token:
            at = token.end()
        if kind == "blank":
            if token[0].count("\n") > 1:
                joined = False
                if pending is not None:
                    sections[-1].texts.append(plain(pending))
                    pending = None
        elif kind == "comment":
            banner = re.match(r"/\* -{4,} (.*?)\s*\*/", token[0])
            if intro is None:
                intro = plain(token[0])
            elif banner:
                sections.append(Section(banner[1]))
            else:
                pending = token[0]
            joined = False
            if token[0].startswith("//") and re.match(r"[ \t]*\n", text[at:]) and pending is not None:
                sections[-1].texts.append(plain(pending))
                pending = None
        elif kind == "directive":
            macro = re.match(r"#\s*define\s+(?!BN_API|BN_SHARED)\w+(?: +\S.*)?$", token[0])
            # A `#define` without a comment is part of the block before it or of the machinery.
            if macro and (pending is not None or joined):
                add(re.sub(r"\s*/\*.*", "", token[0]))
            else:
                pending, joined = None, False
        elif kind == "scope":
            opened = re.match(r"namespace (\w+)", token[0])
            if opened:
                scope = f"{opened[1]}::"
            if token[0] == "}":
                at = text.index("\n", at)
            pending, joined = None, False
        elif kind is None:
            end, body = declaration_end(text, at)
            if end is None:
                at = text.index("#", at)
                pending, joined = None, False
                continue
            code = text[at:body].rstrip() + ";" if body else text[at:end]
            rest = re.compile(r"[ \t]*(/\*[^\n]*\*/)?").match(text, end)
            at = rest.end()
            if re.fullmatch(r"class \w+;", code.strip()):  # the class itself comes later
                pending, joined = None, False
                continue
            add(without_bodies(code) if code.startswith("class") else code)
    return intro or "", [section for section in sections if section.texts or section.items]


# ---- Markdown


def heading(line, text):
    """A heading in capitals as the text writes it, or else as a sentence with the words that the text has in capitals."""
    rest = re.sub(r"^[A-Z ]+$", "", text, flags=re.M)
    written = re.search(rf"\b{line}\b", rest, re.I)
    if written:
        return written[0][0].upper() + written[0][1:]
    usual = set(re.findall(r"\b[A-Z]{2,}\b", rest))
    words = [word if word in usual else word.lower() for word in line.split()]
    return " ".join([words[0] if words[0] in usual else words[0].capitalize(), *words[1:]])


# What is code in a comment: backticks, files, qualified names and calls, elements of arrays, names with underscores.
CODE = re.compile(
    r"`[^`]+`"
    r"|\b(?:docs|libbn|scripts|tests)/[\w./]*\w|\b(?:bn\w*|neural)\.(?:hpp|h|glsl)\b|\b[A-Z]+\.md\b"
    r"|\b(?:\w+::)+\w+(?:\((?:[^()]|\([^()]*\))*\))?"
    r"|\bBN_\w+=\w+|\bbn_[\w*]+\(\)|\b\w[\w.]*\(\)"
    r"|\b\w+(?:\[[^\[\]]*\])+|(?<![^\s(])\*\w+"
    r"|\b[A-Za-z]\w*(?:_\w+)+"
    r"|\b[A-Z]{2,}\b")


def escaped(text):
    text = text.replace("&", "&amp;").replace("<", "&lt;")
    return re.sub(r"([\\`*_{}\[\]>#])", r"\\\1", text)


def inline(text, link):
    """Text with names as code, which link to what they name where `link` knows it."""
    out, at = [], 0
    for match in CODE.finditer(text):
        word = match[0].strip("`")
        target = link(re.sub(r"\(.*", "", word)) or link(f"BN_ERROR_{word}")
        out.append(escaped(text[at : match.start()]))
        if re.fullmatch("[A-Z]+", word) and not target:
            out.append(word)
        else:
            out.append(f"[`{word}`]({target})" if target else f"`{word}`")
        at = match.end()
    return "".join(out) + escaped(text[at:])


def rows(lines, link):
    """Lines set in by two: a numbered list, or names with what they mean."""
    entries = []
    for line in lines:
        entry = re.match(r"  (\d+\.|[\w.]+)(?: +(.*))?$", line)
        if entry and not line.startswith("   "):
            entries.append([entry[1], entry[2] or ""])
        else:
            entries[-1][1] += " " + line.strip()
    out = []
    for mark, text in entries:
        if re.fullmatch(r"\d+\.", mark):
            out.append(f"{mark} {inline(text, link)}")
        else:
            out.append(f"- `{mark}`" + (f": {inline(text, link)}" if text else ""))
    return "\n".join(out)


def prose(text, link, level=2, whole="", language="c"):
    """The Markdown of a comment."""
    out = []
    text = re.sub(r"(?<=[^\n])(?:\n| )Errors: ?", "\n\nErrors: ", text)
    for block in re.split(r"\n\n", text):
        lines = block.split("\n")
        if len(lines) == 1 and re.fullmatch(r"[A-Z][A-Z ]+", block):
            out.append("#" * level + " " + heading(block, whole or text))
        elif all(line.startswith("    ") for line in lines):
            code = "\n".join(line[4:] for line in lines)
            # A listing with empty lines in it is one.
            if out and out[-1].startswith("```"):
                out[-1] = out[-1][:-3] + "\n" + code + "\n```"
            else:
                out.append(f"```{language}\n{code}\n```")
        elif lines[0].startswith("  "):
            out.append(rows(lines, link))
        else:
            sentence = " ".join(line.strip() for line in lines)
            lead = re.match(r"((?:[A-Z][a-z]*(?: [a-z]+){0,3})\.|Errors:)(?: |$)", sentence) if out else None
            if lead:
                out.append(f"**{lead[1]}** {inline(sentence[lead.end() :], link)}".rstrip())
            else:
                out.append(inline(sentence, link))
    return "\n\n".join(out)


def anchor_of(item):
    return item.names[0].lower().replace("::", "-")


def names(text, internal=()):
    """Every name of a header that has a place on its page -> the anchor."""
    found = {}
    for section in read(text)[1]:
        if section.title not in internal:
            for item in section.items:
                for name in [*item.names, *item.constants]:
                    found.setdefault(name, anchor_of(item))
    return found


def without_api(code):
    """Declarations without BN_API, continued lines moved with them."""
    out, by = [], 0
    for line in code.split("\n"):
        if line[:1].strip():
            by = 7 if line.startswith("BN_API ") else 0
        out.append(line[by:])
    return "\n".join(out)


def page(title, text, link=lambda name: None, internal=(), language="c"):
    """The page of a header. `link` gives the address of a name or None; `internal` names sections to leave out."""
    intro, sections = read(text)
    out = [f"# {title}", prose(intro, link, whole=intro, language=language)]
    for section in sections:
        if section.title in internal:
            continue
        if section.title:
            out.append(f"## {escaped(section.title)}")
        out += [prose(comment, link, 3, intro) for comment in section.texts]
        level = "###" if section.title else "##"
        for item in section.items:
            title_names = [name for name in item.names if not name.endswith("_options_default")] or item.names
            out.append(f"{level} {', '.join(f'`{name}`' for name in title_names)} {{ #{anchor_of(item)} }}")
            out.append(f"```{language}\n{without_api(chr(10).join(item.code))}\n```")
            if item.comment:
                out.append(prose(item.comment, lambda name, own=item.names: None if name in own else link(name), 4, intro))
    return "\n\n".join(part for part in out if part) + "\n"


def source_page(title, text, link=lambda name: None, language="glsl"):
    """The page of a shader: the comment at its top as text, the rest as it is."""
    top = re.match(r"/\*.*?\*/\n*|(?://[^\n]*\n)+\n*", text, re.S)
    intro = plain(top[0].rstrip("\n"))
    return f"# {title}\n\n{prose(intro, link, language=language)}\n\n## Source\n\n```{language}\n{text[top.end():].rstrip()}\n```\n"
