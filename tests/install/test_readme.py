# SPDX-License-Identifier: Apache-2.0
"""The README's examples work unchanged, in C++ with the installed library and in Python with the installed package."""

import re
import sys

import numpy as np
import pytest
from conftest import ROOT, listing, run

README = (ROOT / "README.md").read_text(encoding="utf-8")


def examples(language, text=README):
    return re.findall(rf"^```{language}\n(.*?)^```", text, re.MULTILINE | re.DOTALL)


RENDERER = "static float shade(float u, float v, float s, float t, float a, float b) { return u * v * s * t * a * b; }\n"
MAIN = """
#include <cstdio>
int main() {
    for (unsigned index = 0; index < 4; ++index) std::printf("%g\\n", double(trace(17, 4, index)));
}
"""


def program():
    (text,) = examples("cpp")
    return RENDERER + text + MAIN


def test_program(static_library, tmp_path):
    (tmp_path / "main.cpp").write_text(program())
    lines = run(static_library.compile_cpp(tmp_path / "main", tmp_path / "main.cpp")).splitlines()
    assert len(set(lines)) == 4 and all(0 <= float(number) < 4 for number in lines)


@pytest.mark.parametrize("text", examples("python") + examples("python", (ROOT / "bindings" / "README.md").read_text(encoding="utf-8")))
def test_python(tmp_path, text):
    pytest.importorskip("bluenoise")
    (tmp_path / "example.py").write_text(text)
    run(sys.executable, "-W", "error", "example.py", cwd=tmp_path)


def check_shadow(image):
    """After averaging blocks of 8 x 8 pixels, white noise (the lower half) has at least twice the error of `blue` (the upper half)."""
    edge = 1.3 * np.arange(256) / 256
    truth = np.mean(np.clip(edge[:, None] - 0.3 * (np.arange(1000) + 0.5) / 1000, 0, 1), axis=1)
    assert image.shape == (256, 256) and len(np.unique(image)) == 5
    errors = (image - truth).reshape(32, 8, 32, 8).mean(axis=(1, 3))
    blue, white = (np.sqrt((half**2).mean()) for half in (errors[:16], errors[16:]))
    assert 2 * blue < white < 0.03


def test_quick_start_in_cpp_and_python(static_library, tmp_path):
    """Both programs compute the same image, except where a sample lies on the edge within single precision."""
    pytest.importorskip("bluenoise")
    (tmp_path / "shadow.cpp").write_text(listing("quickstart.md", "shadow.cpp"))
    run(static_library.compile_cpp(tmp_path / "shadow", tmp_path / "shadow.cpp"), cwd=tmp_path)
    data = (tmp_path / "shadow.pgm").read_bytes()
    assert data.startswith(b"P5 256 256 255\n")
    (tmp_path / "shadow.py").write_text(listing("quickstart.md", "shadow.py"))
    run(sys.executable, "-W", "error", "shadow.py", cwd=tmp_path)
    image = np.load(tmp_path / "shadow.npy")
    check_shadow(image)
    assert np.count_nonzero(np.floor(255 * image) != np.frombuffer(data[15:], np.uint8).reshape(256, 256)) <= 3
