#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Translates the GLSL code of the draws, paths and choices to WGSL.

WGSL has no preprocessor, so it cannot include bn_draw.glsl and its relatives as the other languages do. This program
translates them line by line, relying on clang-format's layout, and keeps the first comment of each WGSL file.
"""

import argparse
import re
import sys
from pathlib import Path

INCLUDE = Path(__file__).resolve().parents[1] / "include" / "bn"
COLUMNS = 100
SOURCES = {"bn_draw.glsl": ["bn_draw.wgsl"], "bn_path.glsl": ["bn_path.wgsl"],
           "bn_choose.glsl": ["bn_choose.wgsl", "bn_choose_cdf.wgsl"]}

# The macros that count as defined, as in bn_draw.hlsl or bn_choose.h.
DEFINED = {"BN_FUNCTION", "BN_TABLE", "BN_ANY", "BN_REVERSE_BITS", "bn_uint4", "BN_FLOAT4", "BN_FLOAT_BITS", "BN_TO_UINT", "BN_CHOOSE_U",
           "BN_CHOOSE_LIMIT"}
TYPES = {"BN_UINT": "u32", "BN_FLOAT2": "vec2f", "BN_FLOAT4": "vec4f", "bn_uint2": "vec2u", "bn_uint4": "vec4u",
         "float": "f32", "BN_BOOL": "bool", "bn_blue_pixel": "bn_blue_pixel", "bn_path": "bn_path", "bn_ray": "bn_ray",
         "bn_split": "bn_split", "bn_loop": "bn_loop", "bn_pan": "bn_pan"}
REPLACEMENTS = {
    r"\b(BN_FUNCTION|BN_TABLE|BN_PASS_TABLE) ": "", r"\bBN_CHOOSE_TABLE ": "BN_UINT first, ", r"\bBN_FALSE\b": "false",
    r"\bbn_draw_domain_child\b": "bn_domain_child", r"\bBN_REVERSE_BITS\(": "reverseBits(", r"\bBN_TO_UINT\(": "u32(",
    r"\bBN_FLOAT_BITS\(": "bitcast<u32>(", r"\bBN_TO_FLOAT\(": "f32(", r"\bBN_CHOOSE_GET_U\b": "*u",
    r"\bBN_WORD\(([^()]*)\)": r"bn_words[\1]",
    r"\bBN_CHOOSE_LIMIT\(([^()]*)\)": r"bn_cdf[first + \1]", r"\bBN_ANY\((\w+)\)": r"\1 != 0u",
    # A conditional expression, in parentheses or as the whole assigned or returned value.
    r"\(([^()?]+) \? ([^()]+) : ([^()]+)\)": r"select(\3, \2, \1)",
    r"(?<==|n) ([^=?;]+) \? ([^?]+) : ([^;]+);": r" select(\3, \2, \1);"}

# WGSL defines no precedence between bit operations and others, so these need parentheses.
NESTED = r"\((?:[^()]|\((?:[^()]|\([^()]*\))*\))*\)"
OPERAND = rf"(?:[\w.]+(?:{NESTED}|\[[^]]*\])?|{NESTED})"
OPERATION = rf"{OPERAND} (?:<<|>>|/|\*) {OPERAND}"
MIXED = re.compile(rf"(?<= [&|^] )({OPERATION})|({OPERATION})(?= [&|^] )")


def preprocess(text: str) -> str:
    """Resolves conditions, converts constants, and replaces macros that only rename functions."""
    kept, conditions, functions = [], [], {}
    for line in text.split("\n"):
        name, rest = re.match(r"(?:#(\w+))?\s*(.*)", line).groups()
        if name in ("if", "ifdef", "ifndef"):
            conditions.append((rest.split()[0] in DEFINED) == (name == "ifdef"))
        elif name == "else":
            conditions[-1] = not conditions[-1]
        elif name == "endif":
            conditions.pop()
        elif all(conditions) and name is None:
            kept.append(line)
        elif all(conditions) and "(" in rest.split()[0]:
            macro, function = re.match(r"(\w+)\(.*?\) (\w+)\(", rest).groups()
            functions[rf"\b{macro}\b"] = function
        elif all(conditions) and " " in rest:
            kept.append(re.sub(r"(\w+) (\w+)", r"const \1 = \2;", rest, count=1))
    return substitute("\n".join(kept), functions)


def substitute(text: str, replacements: dict) -> str:
    for pattern, replacement in replacements.items():
        text = re.sub(pattern, replacement, text)
    return text


def wrap(line: str) -> str:
    if len(line) <= COLUMNS or line.lstrip().startswith(("*", "/*")):
        return line
    cut = max(line.rfind(mark, 0, COLUMNS) for mark in (", ", "+ ")) + 1
    indent = len(line) - len(line.lstrip()) + 4
    return line[:cut] + "\n" + wrap(" " * indent + line[cut + 1:]) if cut else line


def variables(line: str, assigned: set) -> str:
    """A declaration of one or several variables, with `let` for variables that are not assigned later."""
    found = re.match(rf"( *)({'|'.join(TYPES)}) (\w+(?: = .*)?;)( /\*.*)?$", line)
    if not found:
        return line
    indent, kind, names, comment = found.groups()
    declared = []
    for each in re.split(r", (?=\w+ = )", names[:-1]):
        name = each.split()[0]
        declared.append(f"{indent}{'let' if '=' in each and name not in assigned else 'var'} {each}"
                        f"{'' if '=' in each else ': ' + TYPES[kind]};")
    return "\n".join(declared) + (comment or "")


def function(head: str, body: str) -> str:
    """`head` is the text before the brace, `body` the text between the braces, both with GLSL types."""
    kind, name, listed = re.match(r"(\w+) (\w+)\((.*)\)", head).groups()
    assigned = set(re.findall(r"^ *(?:for \()?(\w+)(?:\.\w+)* [-+*^&|<>]*= ", body, re.M))
    parameters, first = [], []
    for each in listed.split(", "):
        if each == "BN_CHOOSE_U":
            parameters.append("u: ptr<function, f32>")
            continue
        of, parameter = each.split()
        if parameter in assigned:
            first.append(f"    var {parameter} = {parameter}_in;\n")
            parameter += "_in"
        parameters.append(f"{parameter}: {TYPES[of]}")
    lines = [variables(line, assigned) for line in body.split("\n")]
    return f"fn {name}({', '.join(parameters)}) -> {TYPES[kind]} {{\n{''.join(first)}" + "\n".join(lines) + "\n}"


def structure(found: re.Match) -> str:
    """Writes one member per line, followed by its type."""
    lines = []
    for kind, names, comment in re.findall(r"^ *(\w+) (.*?);(?: +(/\*.*))?$", found[2], re.M):
        lines += [f"    {name}: {TYPES[kind]}," for name in names.split(", ")]
        lines[-1] += f" {comment}" if comment else ""
    return found[1] + "\n".join(lines) + "\n}"


def translate(name: str) -> dict:
    """The WGSL files made from a GLSL file, {name: text}."""
    text = preprocess((INCLUDE / name).read_text(encoding="utf-8")).split("*/", maxsplit=1)[1]
    # Put each statement, comments excepted, on one line, and conditional statements in braces.
    text = re.sub(r"(?<=\()\n +", "", text)
    text = re.sub(r"(?<![;{}/\n])\n +(?![ *])", " ", text)
    text = re.sub(r"^( *)((?:if|while) \(.*\)) (\w.*;)$", r"\1\2 {\n\1    \3\n\1}", text, flags=re.M)
    text = MIXED.sub(lambda each: f"({each[0]})", substitute(text, REPLACEMENTS))
    text = re.sub(r"^(struct \w+ \{\n)(.*?)^\};", structure, text, flags=re.M | re.S)
    text = re.sub(r"^(\w+ \w+\([^\n]*\)) \{\n(.*?)\n\}", lambda each: function(each[1], each[2]), text, flags=re.M | re.S)
    text = re.sub(r"\bfloat\(", "f32(", re.sub(r"\bBN_FLOAT(\d)\(", r"vec\1f(", text))
    left = re.search(r"\b(?:BN_[A-Z_]+\(|BN_UINT\b|float\b).*|.*[?~#].*", re.sub(r"/\*.*?\*/", "", text, flags=re.S))
    if left:
        raise SystemExit(f"make_wgsl: {name}: cannot translate {left[0].strip()}")
    text = "\n".join(wrap(line) for line in re.sub(r"\n{3,}", "\n\n", text).strip("\n").split("\n"))
    bodies = re.split(r"\n\n(?=fn bn_choose_cdf\()", text)
    return {file: (INCLUDE / file).read_text(encoding="utf-8").split("*/", maxsplit=1)[0] + f"*/\n\n{body}\n"
            for file, body in zip(SOURCES[name], bodies, strict=True)}


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--check", action="store_true", help="write nothing; fail if a file is not up to date")
    check = parser.parse_args().check
    for name in SOURCES:
        for file, text in translate(name).items():
            if not check:
                (INCLUDE / file).write_text(text, encoding="utf-8")
            elif (INCLUDE / file).read_text(encoding="utf-8") != text:
                print(f"make_wgsl: {file} is not up to date; run libbn/tools/make_wgsl.py", file=sys.stderr)
                return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
