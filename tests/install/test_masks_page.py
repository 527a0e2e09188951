# SPDX-License-Identifier: Apache-2.0
"""The listings of docs/masks.md: the C listing compiles with the installed library, and the Python listings run."""

import re

import pytest
from conftest import ROOT, run

PAGE = (ROOT / "docs" / "masks.md").read_text(encoding="utf-8")
PROGRAM = """
#include <stdio.h>
int main(void) {
    static uint32_t ranks[64 * 64];
    bn_sampler sampler = bn_sampler_make(1);
    const int made = sampler_of_model("/nowhere.onnx", 1, ranks, &sampler);
    printf("%d %d\\n", made, sampler.type == BN_SAMPLER_BLUE);
}
"""


def test_c_listing_keeps_the_sampler_if_the_model_is_missing(static_library, tmp_path):
    (listing,) = re.findall(r"```c\n(.*?)```", PAGE, re.DOTALL)
    (tmp_path / "main.c").write_text(listing + PROGRAM)
    static_library.compile(tmp_path / "main.c", tmp_path / "program")
    assert run(tmp_path / "program") == "0 1\n"


@pytest.mark.parametrize("text", re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL))
def test_python_listings_run(text, tmp_path, monkeypatch):
    bluenoise = pytest.importorskip("bluenoise")
    if "neural(" in text:  # tests/python/test_neural.py runs it
        return
    monkeypatch.chdir(tmp_path)
    exec(text.replace("(64, 64)", "(16, 16)"), {"bluenoise": bluenoise})  # for speed
    for name in re.findall(r'save\("([^"]+)"', text):
        assert bluenoise.load(name, rank=True).shape[-2:] == (16, 16)
