# SPDX-License-Identifier: Apache-2.0
"""The listing of docs/masks.md, compiled and linked against the installed library."""

import re
from pathlib import Path

from conftest import run

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = """
#include <stdio.h>
int main(void) {
    static uint32_t ranks[64 * 64];
    bn_sampler sampler = bn_sampler_make(1);
    const int made = sampler_of_model("/nowhere.onnx", 1, ranks, &sampler);
    printf("%d %d\\n", made, sampler.type == BN_SAMPLER_BLUE);
}
"""


def test_the_listing_compiles_and_leaves_a_sampler_without_a_model(static_library, tmp_path):
    (listing,) = re.findall(r"```c\n(.*?)```", (ROOT / "docs" / "masks.md").read_text(encoding="utf-8"), re.DOTALL)
    (tmp_path / "main.c").write_text(listing + PROGRAM)
    static_library.compile(tmp_path / "main.c", tmp_path / "program")
    assert run(tmp_path / "program") == "0 1\n"
