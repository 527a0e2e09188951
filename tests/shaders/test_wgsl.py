# SPDX-License-Identifier: Apache-2.0
"""The committed WGSL is the translation of the GLSL text, and what cannot be translated is refused."""

import importlib.util
import re

import pytest
from conftest import INCLUDE, ROOT

spec = importlib.util.spec_from_file_location("make_wgsl", ROOT / "libbn" / "tools" / "make_wgsl.py")
make_wgsl = importlib.util.module_from_spec(spec)
spec.loader.exec_module(make_wgsl)


@pytest.mark.parametrize("name", make_wgsl.SOURCES)
def test_the_committed_files_are_up_to_date(name):
    for file, text in make_wgsl.translate(name).items():
        assert (INCLUDE / "bn" / file).read_text(encoding="utf-8") == text, "run libbn/tools/make_wgsl.py"


def translated(text):
    calls = dict(make_wgsl.CALLS)
    text = f"/* top */\n#ifndef GUARD\n#define GUARD\n{text}\n#endif\n"
    return "\n".join(make_wgsl.Translator(make_wgsl.preprocess(text, calls), calls).file())


def test_the_precedence_of_c_is_kept():
    body = translated("BN_UINT f(BN_UINT a, BN_UINT b) { return a >> 16u & 1u | b << 2u ^ a * b + 1u - (b - a); }")
    assert "return ((a >> 16u) & 1u) | ((b << 2u) ^ (a * b + 1u - (b - a)));" in body


def test_statements():
    body = translated("#define STEPS 4u /* so many */\n#define TWICE(v) twice(v)\n"
                      "BN_UINT f(BN_UINT a, BN_CHOOSE_U) {\n    BN_UINT n = 1u, m = 2u; /* two */\n    a += STEPS;\n"
                      "    if (!(a > n)) return 0u;\n    BN_CHOOSE_GET_U = float(TWICE(a));\n"
                      "    while (n < a) n = a < m ? 3u : BN_WORD(n + 1u);\n    return n;\n}")
    assert re.sub(r"\s+", " ", body) == (
        "const STEPS = 4u; /* so many */ "
        "fn f(a_in: u32, u: ptr<function, f32>) -> u32 { var a = a_in; var n = 1u; let m = 2u; /* two */ a += STEPS; "
        "if (!(a > n)) { return 0u; } *u = f32(twice(a)); "
        "while (n < a) { n = select(bn_words[n + 1u], 3u, a < m); } return n; }")


@pytest.mark.parametrize("text", [
    "#if 1 + 1\n#endif", "#include <a>", "#define F(a) (a + 1)", "double f(double a) { return a; }",
    "BN_UINT f(BN_UINT a) { return a++; }", "BN_UINT f(BN_UINT a) { goto b; }", "BN_UINT f(BN_UINT a) { return -a; }",
    "BN_UINT f(BN_UINT a) { return ~a; }", "BN_UINT f(BN_UINT a) { return (a /* why */ + 1u); }",
    "BN_UINT f(BN_UINT a) { return a[1u]; }", "BN_UINT f(BN_UINT a) { return a, a; }"])
def test_what_it_does_not_know_is_refused(text):
    with pytest.raises((make_wgsl.Untranslatable, KeyError)):
        translated(text)
