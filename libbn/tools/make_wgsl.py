#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes the WGSL form of the draws, paths and choices from their GLSL text.

WGSL has no preprocessor, so it cannot include bn_draw.glsl and its relatives as the other languages do. This
translates the subset of C in which they are written, statement by statement, with their comments, and refuses what
it does not know. `--check` writes nothing, and fails if a file is not up to date.
"""

import argparse
import re
import sys
from pathlib import Path

INCLUDE = Path(__file__).resolve().parents[1] / "include" / "bn"
COLUMNS = 100

HEADERS = {
    "bn_draw.wgsl": """\
/* SPDX-License-Identifier: Apache-2.0
 * The draws of BLUE, SOBOL and WHITE in WGSL: bn_draw.glsl, translated by libbn/tools/make_wgsl.py.
 * Put this text in front of yours or behind it, and declare the words of bn_tables(), in the group and
 * binding of your choice. The seed is that of bn_sampler_seed():
 *
 *     @group(0) @binding(0) var<storage, read> bn_words: array<u32>;
 *
 *     let u: vec4f = bn_draw_blue(seed, u32(pixel.x), u32(pixel.y), index, bn_domain_child(0u, ray));
 *
 * Coordinates are signed integers reinterpreted as unsigned: u32(-1i) is the column left of zero.
 * bn_draw_blue_bits() and its relatives give all 32 bits of each number. Names that begin with bn_
 * and BN_ are reserved. bn_draw.h explains how BLUE works. */
""",
    "bn_path.wgsl": """\
/* SPDX-License-Identifier: Apache-2.0
 * Which domain each decision of a path draws from, in WGSL: bn_path.glsl, translated by
 * libbn/tools/make_wgsl.py. Put this text beside that of bn_draw.wgsl. bn_path.h explains the layout.
 *
 *     let path = bn_path_start(u32(pixel.x), u32(pixel.y), index, 0u);
 *     let ray = bn_path_ray_domain(path, depth);
 *     let u: vec4f = bn_draw_blue(seed, path.x, path.y, path.index, ray); */
""",
    "bn_choose.wgsl": """\
/* SPDX-License-Identifier: Apache-2.0
 * bn_choose() and bn_choose_u32() in WGSL: bn_choose.glsl, translated by libbn/tools/make_wgsl.py. Put
 * this text in front of yours or behind it, with bn_draw.wgsl or without. bn_choose.h is the manual.
 *
 *     var u = draw.x;
 *     let light = bn_choose_u32(light_count, &u); // u is now what is left of the number
 *
 * WGSL compilers may take subnormal numbers as 0, and NaN as anything. */
""",
    "bn_choose_cdf.wgsl": """\
/* SPDX-License-Identifier: Apache-2.0
 * bn_choose_cdf() in WGSL, for shaders that also contain bn_choose.wgsl and say where their tables are.
 * `first` is where a table begins. Translated from bn_choose.glsl by libbn/tools/make_wgsl.py.
 *
 *     @group(0) @binding(1) var<storage, read> bn_cdf: array<f32>;
 *
 *     let light = bn_choose_cdf(first, light_count, &u); */
""",
}
SOURCES = {"bn_draw.glsl": ["bn_draw.wgsl"], "bn_path.glsl": ["bn_path.wgsl"],
           "bn_choose.glsl": ["bn_choose.wgsl", "bn_choose_cdf.wgsl"]}

# What the texts find defined, as they would in bn_draw.hlsl or bn_choose.h.
DEFINED = {"BN_FUNCTION", "BN_TABLE", "BN_ANY", "BN_REVERSE_BITS", "bn_uint4", "BN_FLOAT4", "BN_CHOOSE_U", "BN_CHOOSE_LIMIT"}
TOKENS = {"BN_FUNCTION": [], "BN_TABLE": [], "BN_PASS_TABLE": [], "BN_CHOOSE_TABLE": ["BN_UINT", "first", ","],
          "BN_FALSE": ["false"], "bn_draw_domain_child": ["bn_domain_child"]}
TYPES = {"BN_UINT": "u32", "BN_FLOAT2": "vec2f", "BN_FLOAT4": "vec4f", "bn_uint2": "vec2u", "bn_uint4": "vec4u",
         "float": "f32", "BN_BOOL": "bool", "bn_blue_pixel": "bn_blue_pixel", "bn_path": "bn_path"}
CALLS = {"BN_REVERSE_BITS": "reverseBits", "BN_TO_UINT": "u32", "BN_TO_FLOAT": "f32"}

LEVELS = [["||"], ["&&"], ["|"], ["^"], ["&"], ["==", "!="], ["<", ">", "<=", ">="], ["<<", ">>"], ["+", "-"],
          ["*", "/", "%"]]
LEVEL = {operator: level for level, operators in enumerate(LEVELS) for operator in operators}
ARITHMETIC = LEVEL["+"]
# Macros, as pairs of their text and its level.
MACROS = {"BN_WORD": ("bn_words[{}]", len(LEVELS)), "BN_CHOOSE_LIMIT": ("bn_cdf[first + {}]", len(LEVELS)),
          "BN_ANY": ("{} != 0u", LEVEL["!="])}
ASSIGNMENTS = {"=", "+=", "-=", "*=", "^=", "&=", "|=", "<<=", ">>="}
TOKEN = re.compile(r"""(?P<comment>/\*.*?\*/)|(?P<raw>^const\ [^;]*;[ ]*(?:/\*.*?\*/)?)|(?P<space>\s+)
    |(?P<number>0x[0-9a-f]+u|[0-9]+u|[0-9]+\.[0-9]+f|[0-9]+e-?[0-9]+f)|(?P<name>[A-Za-z_]\w*)
    |(?P<symbol><<=|>>=|[-+*^&|]=|==|!=|<=|>=|<<|>>|&&|\|\||[-+*/%^&|<>=!?:;,.(){}])""", re.X | re.S | re.M)


class Untranslatable(Exception):
    pass


# ---- The preprocessor

def preprocess(text: str, calls: dict) -> str:
    """Resolves conditions, turns constants into WGSL's, and adds macros that only rename a function to `calls`."""
    kept, conditions, defined = [], [], set(DEFINED)
    for line in text.split("\n"):
        directive = re.match(r"#(\w+)\s*(.*)", line)
        if not directive:
            if all(conditions):
                kept.append(line)
            continue
        name, rest = directive.groups()
        rest_alone = re.sub(r"/\*.*", "", rest).strip()
        if name in ("if", "ifdef", "ifndef"):
            names = [rest_alone] if name != "if" else re.findall(r"defined\((\w+)\)", rest_alone)
            plain = re.fullmatch(r"defined\(\w+\)( \|\| defined\(\w+\))*" if name == "if" else r"\w+", rest_alone)
            if not plain and all(conditions):
                raise Untranslatable(line)
            conditions.append(any(each in defined for each in names) != (name == "ifndef"))
        elif name == "else":
            conditions[-1] = not conditions[-1]
        elif name == "endif":
            conditions.pop()
        elif name != "define":
            raise Untranslatable(line)
        elif all(conditions):
            macro, arguments, value = re.match(r"(\w+)(\([\w, ]*\))?\s*(.*)", rest).groups()
            defined.add(macro)
            if arguments is not None:
                value = value.replace("BN_PASS_TABLE ", "")
                if not value.endswith(arguments):
                    raise Untranslatable(line)
                calls[macro] = value[:-len(arguments)]
            elif value:
                number, after = re.match(r"(\S+)(.*)", value).groups()
                kept.append(f"const {macro} = {number};{after}")
    return "\n".join(kept)


def tokenize(text: str) -> list:
    """Triples (margin, kind, token): what stands before a token, comments and numbers of line ends. The last token is None."""
    found, margin, at = [], [], 0
    while at < len(text):
        match = TOKEN.match(text, at)
        if not match:
            raise Untranslatable(text[at:at + 40])
        at = match.end()
        if match.lastgroup == "comment":
            margin.append(match[0])
        elif match.lastgroup == "space":
            margin += [match[0].count("\n")] if "\n" in match[0] else []
        else:
            for token in TOKENS.get(match[0], [match[0]]):
                found.append((margin, match.lastgroup, token))
                margin = []
    return [*found, (margin, "end", None)]


# ---- Expressions: a pair of their text and the level of their outermost operator

def wrapped(operand: tuple, operator: str, left: bool) -> str:
    """WGSL has no order between bit operations, shifts and others: these need parentheses."""
    text, level = operand
    own = LEVEL[operator]
    same_chain = left and level == own and operator not in ("<<", ">>", "<", ">", "<=", ">=", "==", "!=")
    free = level > own and (level >= ARITHMETIC if own >= LEVEL["<"] and operator not in ("<<", ">>")
                            else own <= LEVEL["&&"] and level in (LEVEL["=="], LEVEL["<"]))
    return text if level == len(LEVELS) or same_chain or free else f"({text})"


class Translator:
    def __init__(self, text: str, calls: dict):
        self.tokens, self.at, self.calls, self.lines = tokenize(text), 0, calls, []

    # Tokens

    def peek(self, ahead: int = 0):
        return self.tokens[min(self.at + ahead, len(self.tokens) - 1)][2]

    def take(self, wanted=None):
        margin, _, token = self.tokens[self.at]
        comments = [part for part in margin if isinstance(part, str)]
        if comments:
            raise Untranslatable(f"a comment inside a statement: {comments[0]}")
        if wanted is not None and token != wanted:
            raise Untranslatable(f"'{wanted}' expected at '{token}' after {self.lines[-1:]}")
        self.at += 1
        return token

    def margin(self, indent: int):
        """Comments and empty lines before a statement or a declaration; a comment behind the last one joins its line."""
        margin = self.tokens[self.at][0]
        for i, part in enumerate(margin):
            if isinstance(part, str) and i == 0 and self.lines:
                self.lines[-1] += " " + part
            elif isinstance(part, str):
                self.lines += [" " * indent + re.sub(r"\n\s*", "\n" + " " * (indent + 1), part)]
            elif part > 1 and self.lines and self.lines[-1] != "" and not self.lines[-1].endswith("{"):
                self.lines.append("")
        margin.clear()

    # Expressions

    def expression(self, level: int = -1) -> tuple:
        if level < 0:
            condition = self.expression(0)
            if self.peek() != "?":
                return condition
            self.take("?")
            yes = self.expression()
            self.take(":")
            return f"select({self.expression()[0]}, {yes[0]}, {condition[0]})", len(LEVELS)
        if level == len(LEVELS):
            return self.unary()
        left = self.expression(level + 1)
        while self.peek() in LEVELS[level]:
            operator = self.take()
            right = self.expression(level + 1)
            left = f"{wrapped(left, operator, True)} {operator} {wrapped(right, operator, False)}", level
        return left

    def unary(self) -> tuple:
        token = self.take()
        if token == "!":
            text, level = self.unary()
            return (f"!{text}" if level == len(LEVELS) else f"!({text})"), len(LEVELS)
        if token == "(":
            inside = self.expression()
            self.take(")")
            return inside
        if token == "BN_CHOOSE_GET_U":
            return "*u", len(LEVELS)
        if self.peek() == "(":
            self.take("(")
            arguments = []
            while self.peek() != ")":
                arguments.append(self.expression()[0])
                if self.peek() == ",":
                    self.take(",")
            self.take(")")
            if token in MACROS:
                return MACROS[token][0].format(*arguments), MACROS[token][1]
            return f"{self.calls.get(token) or TYPES.get(token, token)}({', '.join(arguments)})", len(LEVELS)
        while self.peek() == ".":
            token += self.take(".") + self.take()
        if not re.match(r"[\w.]+$|\d+e-\d+f$", token):
            raise Untranslatable(f"'{token}' in an expression")
        return token, len(LEVELS)

    # Statements

    def put(self, indent: int, text: str):
        line = " " * indent + text
        while len(line) > COLUMNS:
            # After the operator or comma that is in the fewest parentheses, and the last of these.
            cut = max((match.end() for match in re.finditer(r"(?:,| [-^|&+*])(?= )", line[:COLUMNS])),
                      key=lambda end, line=line: (line.count(")", 0, end) - line.count("(", 0, end)
                                                  + line.count("]", 0, end) - line.count("[", 0, end), end))
            self.lines.append(line[:cut])
            line = " " * (indent + 4) + line[cut + 1:]
        self.lines.append(line)

    def simple(self) -> str:
        target = self.unary()[0]
        operator = self.take()
        if operator not in ASSIGNMENTS:
            raise Untranslatable(f"'{target} {operator}'")
        return f"{target} {operator} {self.expression()[0]}"

    def block(self, indent: int, assigned: set):
        if self.peek() != "{":
            self.statement(indent, assigned)
            return
        self.take("{")
        self.margin(indent)
        while self.peek() != "}":
            self.statement(indent, assigned)
            self.margin(indent)
        self.take("}")

    def statement(self, indent: int, assigned: set):
        self.margin(indent)
        token = self.peek()
        if token in TYPES and self.peek(1) != "(":
            kind = TYPES[self.take()]
            while True:
                name = self.take()
                if self.peek() == "=":
                    self.take("=")
                    self.put(indent, f"{'var' if name in assigned else 'let'} {name} = {self.expression()[0]};")
                else:
                    self.put(indent, f"var {name}: {kind};")
                if self.take() == ";":
                    return
        elif token == "return":
            self.take()
            self.put(indent, f"return {self.expression()[0]};")
            self.take(";")
        elif token in ("if", "while", "for"):
            self.take()
            self.take("(")
            head = self.expression()[0] if token != "for" else "; ".join(
                [self.simple(), (self.take(";"), self.expression()[0])[1], (self.take(";"), self.simple())[1]])
            self.take(")")
            self.put(indent, f"{token} ({head}) {{")
            self.block(indent + 4, assigned)
            if self.peek() == "else":
                self.take()
                self.put(indent, "} else {")
                self.block(indent + 4, assigned)
            self.put(indent, "}")
        else:
            self.put(indent, self.simple() + ";")
            self.take(";")

    # Declarations

    def parameters(self) -> list:
        found = []
        while self.peek() != ")":
            kind = self.take()
            found.append(("u", "ptr<function, f32>") if kind == "BN_CHOOSE_U" else (self.take(), TYPES[kind]))
            if self.peek() == ",":
                self.take(",")
        self.take(")")
        return found

    def assigned_names(self) -> set:
        """Names that the function whose body is next assigns to: WGSL tells constants and variables apart."""
        depth, names, code = 0, set(), [token for _, _, token in self.tokens[self.at:]]
        for i, token in enumerate(code):
            depth += (token == "{") - (token == "}")
            if token in ASSIGNMENTS:
                start = i - 1
                while code[start - 1] == ".":
                    start -= 2
                if code[start - 1] not in TYPES and code[start - 1] != ",":
                    names.add(code[start])
            if depth == 0:
                return names
        raise Untranslatable("a function without an end")

    def function(self):
        kind, name = TYPES[self.take()], self.take()
        self.take("(")
        parameters, assigned = self.parameters(), self.assigned_names()
        changed = [each for each, _ in parameters if each in assigned]
        listed = ", ".join(f"{each}{'_in' if each in changed else ''}: {of}" for each, of in parameters)
        self.put(0, f"fn {name}({listed}) -> {kind} {{")
        for each in changed:
            self.put(4, f"var {each} = {each}_in;")
        self.block(4, assigned)
        self.put(0, "}")

    def structure(self):
        self.take("struct")
        self.put(0, f"struct {self.take()} {{")
        self.take("{")
        while self.peek() != "}":
            self.margin(4)
            kind = TYPES[self.take()]
            self.put(4, f"{self.take()}: {kind},")
            while self.take() == ",":
                self.put(4, f"{self.take()}: {kind},")
            self.margin(4)
        self.take("}")
        self.take(";")
        self.put(0, "}")

    def file(self) -> list:
        """The texts of the declarations, with the comments above them."""
        groups = []
        top = self.tokens[0][0]
        while top and isinstance(top.pop(0), int):  # the translation has a comment of its own
            pass
        self.margin(0)
        while self.peek() is not None:
            _, kind, token = self.tokens[self.at]
            if kind == "raw":
                self.put(0, token) if "\n" not in token else self.lines.append(token)
                self.at += 1
            elif token == "struct":
                self.structure()
            else:
                self.function()
            groups.append("\n".join(self.lines).lstrip("\n"))
            self.lines = []
            self.margin(0)
        return groups


def translate(name: str) -> dict:
    """The WGSL files of a GLSL file, {name: text}."""
    calls = dict(CALLS)
    declarations = Translator(preprocess((INCLUDE / name).read_text(encoding="utf-8"), calls), calls).file()
    cdf = [each for each in declarations if "fn bn_choose_cdf(" in each]
    texts = {}
    for file in SOURCES[name]:
        body = ""
        for each in cdf if file == "bn_choose_cdf.wgsl" else [each for each in declarations if each not in cdf]:
            constants = each.startswith("const ") and body.split("\n\n")[-1].find("const ") >= 0
            body += ("" if not body else "\n" if constants else "\n\n") + each
        texts[file] = HEADERS[file] + "\n" + body + "\n"
    return texts


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--check", action="store_true", help="write nothing; fail if a file is not up to date")
    check = parser.parse_args().check
    for name in SOURCES:
        try:
            texts = translate(name)
        except Untranslatable as error:
            print(f"make_wgsl: {name}: cannot translate {error}", file=sys.stderr)
            return 1
        for file, text in texts.items():
            path = INCLUDE / file
            if check and (not path.exists() or path.read_text(encoding="utf-8") != text):
                print(f"make_wgsl: {file} is not up to date; run libbn/tools/make_wgsl.py", file=sys.stderr)
                return 1
            if not check:
                path.write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
