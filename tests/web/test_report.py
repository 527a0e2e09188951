# SPDX-License-Identifier: Apache-2.0
"""The demo's page, opened from disk in Chromium: its steps and its layout on a desktop and on a phone."""

import numpy as np
import pytest
from own_scene import convergence

from evidence.renders.judge import Reference

ERRORS = {"white": 0.4, "sobol": 0.2, "blue": 0.1}


@pytest.fixture(scope="module")
def address(tmp_path_factory):
    """The address of a page that shows noise as its images."""
    folder, rng = tmp_path_factory.mktemp("report"), np.random.default_rng(4)
    reference = Reference(np.full((256, 256, 3), 0.5, np.float32), dict.fromkeys(convergence.MEASURES, 0.0), 64, 1.0)
    options = convergence.parse_options(["--out", str(folder)])
    pictures = {(s, n): (reference.picture + rng.normal(0, e / n, (256, 256, 1))).astype(np.float32)
                for s, e in ERRORS.items() for n in options.counts}
    rows = {s: {n: {"seconds": 0.1 * n, **dict.fromkeys(convergence.MEASURES, e / n),
                    "each": [e / n * (1 + seed / 100) for seed in range(6)]} for n in options.counts} for s, e in ERRORS.items()}
    (folder / "report.html").write_text(convergence.page(options, rows, pictures, reference, ("a note",), ()), encoding="utf-8")
    return (folder / "report.html").as_uri()


STEP = "document.querySelector('[data-step=\"{}\"]')"


@pytest.mark.parametrize("width, height", [(1280, 800), (390, 844)])
def test_page_fits_the_window(browser, address, width, height):
    browser.open(address, width, height, ratio=2 if width < 500 else 1)
    browser.value("document.querySelectorAll('details').forEach(e => e.open = true)")
    assert browser.value("document.documentElement.scrollWidth") == width
    assert browser.value("document.getElementById('stage').getBoundingClientRect().bottom") < 1.3 * height
    assert browser.happened("Runtime.exceptionThrown") == []


def test_steps_change_images_errors_and_notes(browser, address):
    browser.open(address, 1280, 800)
    seen = []
    for _ in range(2):
        browser.value(f"{STEP.format(-1)}.click()")
    assert browser.value(f"{STEP.format(-1)}.disabled") is True
    for count in (*range(1, 17), 64):
        said = f"{count} sample{'s' if count > 1 else ''} per pixel"
        assert browser.value("document.getElementById('left-image').alt") == f"cornell, white, {said}"
        assert browser.value("document.getElementById('count').textContent") == said
        seen.append(tuple(browser.value(f"document.getElementById('{name}').{what}")
                          for name, what in (("errors", "textContent"), ("left-image", "src"), ("right-image", "src"))))
        assert "blue is 4.00 times smaller" in browser.value("document.getElementById('note').textContent")
        browser.value(f"{STEP.format(1)}.click()")
    assert len(set(seen)) == 17 and browser.value(f"{STEP.format(1)}.disabled") is True
    assert browser.happened("Runtime.exceptionThrown") == []
