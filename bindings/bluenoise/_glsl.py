# SPDX-License-Identifier: Apache-2.0
"""The text of the draws that shaders and C share, bn_draw.glsl and bn_path.glsl, as Python functions over arrays."""

from __future__ import annotations

import re
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Callable

TEXTS = Path(__file__).parent / "pack"

_TYPES = r"(?:BN_UINT|bn_uint2|bn_uint4|bn_blue_pixel|bn_path)"
# What a body consists of: a loop over the digits of an index, a choice, the end of a loop, or a statement.
_STATEMENT = re.compile(
    r"\s*(?:for \((?P<start>[^;]+); BN_ANY\(\w+\); (?P<step>[^;]+)\) \{|if \((?P<condition>[^;]*?)\) (?P<then>[^;]+);|"
    r"(?P<end>\})|(?P<other>[^;{}]+);)"
)


def functions(uint: Callable[[int], Any], select: Callable[[Any, Any, Any], Any], reverse_bits: Callable[[Any], Any]) -> SimpleNamespace:
    """The functions of both texts that draw nothing but numbers of 32 bits, for a type of arrays of them, which wraps around. Where
    the text has the tables, they take an object first: its `word(at)` is one of theirs, and `rounds` says how many groups of four bits
    of an index to look at beyond the lowest eight."""
    text = "".join((TEXTS / name).read_text(encoding="utf-8") for name in ("bn_draw.glsl", "bn_path.glsl"))
    text = re.sub(r"/\*.*?\*/", "", text, flags=re.DOTALL)
    constants = re.findall(r"^#define (BN_\w+) (0x[0-9a-f]+|\d+)u\s", text, re.M)
    for name, value in constants:
        text = re.sub(rf"\b{name}\b", f"{value}u", text)
    text = text.replace("BN_TABLE ", "tables, ").replace("BN_PASS_TABLE ", "tables, ")
    space: dict[str, Any] = {"uint": uint, "select": select, "BN_REVERSE_BITS": reverse_bits, "Struct": SimpleNamespace}
    for name, parameters, body in re.findall(rf"^BN_FUNCTION {_TYPES} (\w+)\(([^)]*)\) \{{\n(.*?)^\}}", text, re.M | re.DOTALL):
        if re.search(r"if \([^;]*\{", body):
            continue  # branches of a split
        names = [parameter.split()[-1] for parameter in parameters.split(",")]
        exec(f"def {name}({', '.join(names)}):\n{_body(body)}", space)
    return SimpleNamespace(**space)


def _body(text: str) -> str:
    lines: list[str] = []
    steps: list[str] = []  # of the loops that are open
    for found in _STATEMENT.finditer(text):
        indent = "    " * (1 + len(steps))
        if found["start"]:
            lines += [indent + _assigned(found["start"]), f"{indent}for _ in range(tables.rounds):"]
            steps.append(found["step"])
        elif found["end"]:
            lines.append(indent + _assigned(steps.pop()))
        elif found["condition"]:
            condition, then = _expression(found["condition"]), " ".join(found["then"].split())
            if then.startswith("return "):
                lines.append(f"{indent}return select({condition}, {_expression(then[7:])}, @)")
            else:
                target = then.split()[0]
                lines.append(f"{indent}{target} = select({condition}, {_assigned(then).split(' = ', 1)[1]}, {target})")
        else:
            statement = " ".join(found["other"].split())
            declared = re.fullmatch(rf"{_TYPES} (.*)", statement)
            if statement.startswith("return "):
                value = _expression(statement[7:])
                if lines and lines[-1].endswith("@)"):
                    lines[-1] = lines[-1].replace("@", value)
                else:
                    lines.append(f"{indent}return {value}")
            else:
                lines += [indent + _assigned(part) for part in (_parts(declared[1]) if declared else [statement])]
    return "\n".join(lines) + "\n"


def _parts(declared: str) -> list[str]:
    """The names of a declaration, which stand between commas outside of brackets."""
    return re.findall(r"(?:[^,(]|\((?:[^()]|\((?:[^()]|\([^()]*\))*\))*\))+", declared)


def _assigned(statement: str) -> str:
    """An assignment without changing arrays in place, as two names may have one."""
    found = re.fullmatch(r"\s*([\w.]+)\s*(?:(<<|>>|[-+*^|&]?)=\s*(.*))?", statement)
    assert found, statement
    target, operator, value = found.groups()
    if value is None:
        return f"{target} = Struct()"
    return f"{target} = {target} {operator} ({_expression(value)})" if operator else f"{target} = {_expression(value)}"


def _expression(text: str) -> str:
    text = text.replace("BN_HALF_ROW(", "bn_draw_half_row(tables, ").replace("BN_ROW(", "bn_draw_row(tables, ")
    text = text.replace("BN_WORD(", "tables.word(").replace("BN_KEY_FACTOR(", "bn_draw_key_factor(").replace(" / ", " // ")
    return re.sub(r"\b(0x[0-9a-f]+|\d+)u\b", r"uint(\1)", text)
