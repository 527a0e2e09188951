# SPDX-License-Identifier: Apache-2.0
"""The documentation site in Chromium, from disk: the live page beside the text, and what a search finds first.

Skipped without MkDocs, which scripts/docs installs.
"""

import importlib.util
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    if any(importlib.util.find_spec(name) is None for name in ("mkdocs", "material", "mkdocstrings")):
        pytest.skip("no MkDocs; scripts/docs installs it")
    folder = tmp_path_factory.mktemp("site")
    done = subprocess.run([sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--site-dir", folder], cwd=ROOT, check=False,
                          capture_output=True, text=True, env={**os.environ, "NO_MKDOCS_2_WARNING": "1"})
    assert done.returncode == 0, done.stderr
    return folder


BOX = "(e => { const b = e.getBoundingClientRect(); return [b.left, b.top, b.right, b.bottom]; })"


@pytest.mark.parametrize(("width", "beside"), [(1280, True), (390, False)])
def test_the_site_opens_with_the_live_page_beside_the_text(browser, site, width, beside):
    browser.open((site / "index.html").as_uri(), width, 844)
    # The frame is as high as the live page says.
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


def test_a_search_finds_guides_and_interfaces_before_reports(browser, site):
    browser.open((site / "index.html").as_uri(), 1280, 844)
    query = "document.querySelector('input[name=query]')"
    found = "[...document.querySelectorAll('.md-search-result__item')].map(e => e.querySelector('a').getAttribute('href').split(/[?#]/)[0])"
    browser.value(f"{query}.focus()")
    for word in ("sampler", "mask"):
        browser.value(f"{query}.value = '{word}', {query}.dispatchEvent(new Event('keyup')), {query}.dispatchEvent(new Event('input'))")
        mark = "document.querySelector('.md-search-result mark').textContent.toLowerCase()"
        browser.wait(f"{found}.length > 8 && {mark}.startsWith('{word}')")
        addresses = browser.value(found)
        sections = ["report" if "/docs/report/" in address else "guide" for address in addresses]
        assert sections[:5] == ["guide"] * 5, addresses
        assert "report" in sections  # still found
        if word == "sampler":
            assert addresses[0].endswith("docs/blue.html") and any(address.endswith("bn.h.html") for address in addresses[:5])
