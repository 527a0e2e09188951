# SPDX-License-Identifier: Apache-2.0
"""The documentation site, opened from disk in Chromium: the position of the live page beside or above the text.

The test is skipped without Doxygen or MkDocs, which scripts/docs installs.
"""

import importlib.util
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    if any(importlib.util.find_spec(name) is None for name in ("mkdocs", "material", "mkdocstrings")):
        pytest.skip("no MkDocs; scripts/docs installs it")
    if not shutil.which("doxygen"):
        pytest.skip("Doxygen is not installed")
    folder = tmp_path_factory.mktemp("site")
    done = subprocess.run([sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--site-dir", folder], cwd=ROOT, check=False,
                          capture_output=True, text=True, env={**os.environ, "NO_MKDOCS_2_WARNING": "1"})
    assert done.returncode == 0, done.stderr
    return folder


BOX = "(e => { const b = e.getBoundingClientRect(); return [b.left, b.top, b.right, b.bottom]; })"


@pytest.mark.parametrize(("width", "beside"), [(1280, True), (390, False)])
def test_home_page_shows_the_live_page_at_the_top(browser, site, width, beside):
    browser.open((site / "index.html").as_uri(), width, 844)
    # The live page determines the height of its frame.
    browser.wait("document.querySelector('.live iframe').style.height !== ''")
    assert browser.value("document.documentElement.scrollWidth") == width
    live = browser.value(f"{BOX}(document.querySelector('.live iframe'))")
    text = browser.value(f"{BOX}(document.querySelector('.live ~ p'))")
    heading = browser.value(f"{BOX}(document.querySelector('h1'))")
    assert heading[3] <= live[1] < 300 and 0 <= live[0] < live[2] <= width  # at the top
    overlap = browser.value("(p => { const r = document.createRange(); r.selectNodeContents(p); const b = r.getBoundingClientRect();"
                            " return [b.left, b.top, b.right, b.bottom]; })(document.querySelector('.live ~ p'))")
    if beside:
        assert overlap[2] <= live[0] and text[1] < live[1] + 40 and live[2] - live[0] > 0.5 * width
    else:
        assert overlap[1] >= live[3] and live[2] - live[0] > 0.85 * width
    assert browser.happened("Runtime.exceptionThrown") == []
