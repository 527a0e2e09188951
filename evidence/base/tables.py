# SPDX-License-Identifier: Apache-2.0
"""Tables that a command keeps up to date between two markers in a guide."""

from .command import CommandError
from .files import write_text

END = "<!-- end of the table -->\n"


def series(words):
    """"a, b and c"."""
    return " and ".join(filter(None, [", ".join(words[:-1]), *words[-1:]]))


def md_table(header, rows, texts=0):
    """A Markdown table from rows of strings. The first column and the last `texts` columns are left-aligned."""
    numbers = len(header) - 1 - texts
    lines = ["| " + " | ".join(header) + " |", "| --- |" + " ---: |" * numbers + " --- |" * texts]
    return "\n".join([*lines, *("| " + " | ".join(row) + " |" for row in rows)])


def begin(command):
    return f"<!-- table: {command} -->\n"


def update_table(path, command, text):
    """Replaces the text between the markers of `command` in the file at `path`."""
    old = path.read_text(encoding="utf-8")
    if old.count(begin(command)) != 1 or END not in old.split(begin(command))[1]:
        raise CommandError(f"{path} must contain the markers {begin(command).strip()} and {END.strip()}")
    before, rest = old.split(begin(command))
    write_text(path, f"{before}{begin(command)}\n{text}\n\n{END}{rest.split(END, 1)[1]}")


def write_or_print(options, command, text):
    """Prints the table, and also updates the guide unless --print was given."""
    if not options.print:
        update_table(options.guide, command, text)
    print(text)
