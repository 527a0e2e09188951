# SPDX-License-Identifier: Apache-2.0
"""The demo's page in Chromium, from disk: its steps, and galleries and tables on a phone."""

import numpy as np
import pytest
from report.base.contact_sheet import preview
from report.pages import convergence

ERRORS = {"white": 0.4, "sobol": 0.2, "blue": 0.1}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The page with noise for pictures, whole and as it is before the reference."""
    folder, rng = tmp_path_factory.mktemp("report"), np.random.default_rng(4)
    reference = np.full((256, 256, 3), 0.5, np.float32)
    options = convergence.parse_options(["cornell", "--demo", "--out", str(folder)])
    pictures = {(s, n): (reference + rng.normal(0, e / n, (256, 256, 1))).astype(np.float32)
                for s, e in ERRORS.items() for n in options.counts}
    images = {key: preview(picture) for key, picture in pictures.items()}
    rows = [row for s, e in ERRORS.items() for row in convergence.over_seeds(s, [
        [{"spp": n, "seconds": 0.1 * n, **{name: e / n * (1 + seed / 100) for name in convergence.ERRORS[:-1]}} for n in options.counts]
        for seed in range(options.seeds)])]
    convergence.write_page(options, images)
    (folder / "report.html").rename(folder / "early.html")
    convergence.write_page(options, images, rows, pictures, reference, 0.0, ("a note",))
    return folder


def open_page(browser, path, width, height, ratio=1):
    browser.open(path.as_uri(), width, height, ratio=ratio)
    browser.wait("document.querySelector('[data-part=left-image]').width === 256")
    assert browser.happened("Runtime.exceptionThrown") == []


COUNT = "document.querySelector('#steps .count').textContent"
LABEL = "document.querySelector('[data-part=left-image]').getAttribute('aria-label')"
STEP = "document.querySelector('#steps [data-step=\"{}\"]')"


def test_steps_change_pictures_errors_and_the_line(browser, folder):
    open_page(browser, folder / "report.html", 1280, 800)
    line = "Number(document.querySelector('.found .now').getAttribute('x1'))"
    errors = "[...document.querySelectorAll('[data-error]')].map(e => e.textContent)"
    assert browser.value("document.querySelector('[data-part=blur]').value") == "2.1"
    seen = {3: (browser.value(errors), browser.value(line))}
    for _ in range(2):
        browser.value(f"{STEP.format(-1)}.click()")
    assert browser.value(f"{STEP.format(-1)}.disabled") is True
    for count in range(1, 17):
        assert browser.value(LABEL) == f"cornell, white, {count} sample{'s' if count > 1 else ''} per pixel"
        assert browser.value(COUNT) == f"{count} sample{'s' if count > 1 else ''} per pixel"
        now = (browser.value(errors), browser.value(line))
        assert seen.setdefault(count, now) == now
        browser.value(f"{STEP.format(1)}.click()")
    assert browser.value(LABEL).startswith("cornell, white, 64") and browser.value(f"{STEP.format(1)}.disabled") is True
    places = [place for _, (_, place) in sorted(seen.items())]
    assert places == sorted(set(places)) and len({tuple(texts) for texts, _ in seen.values()}) == 16
    # The line is where the plot has that count, and a click there chooses it.
    box = browser.value("(e => { e.scrollIntoView(); const b = e.getBoundingClientRect(); return [b.left, b.top, b.width, b.height]; })"
                        "(document.querySelector('.found svg'))")
    wide = browser.value("document.querySelector('.found svg').viewBox.baseVal.width")
    click = {"x": box[0] + seen[4][1] / wide * box[2], "y": box[1] + box[3] / 2, "button": "left", "clickCount": 1}
    for kind in ("mousePressed", "mouseReleased"):
        browser.call("Input.dispatchMouseEvent", type=kind, **click)
    assert browser.value(COUNT) == "4 samples per pixel"
    assert browser.value("document.querySelector('.found .now').getBoundingClientRect().left") == pytest.approx(click["x"], abs=1)
    assert browser.happened("Runtime.exceptionThrown") == []


def test_the_first_screen_shows_headlines_and_pictures(browser, folder):
    open_page(browser, folder / "report.html", 1280, 800)
    tops = browser.value("['.fact b', '[data-part=stage]', '.errors td'].map(s => document.querySelector(s).getBoundingClientRect())"
                         ".map(b => [b.top, b.height])")
    assert all(top < 800 for top, _ in tops), tops
    assert float(browser.value("parseFloat(getComputedStyle(document.querySelector('.fact b')).fontSize)")) >= 24
    assert tops[1][0] + tops[1][1] / 2 < 800  # more than half of the pictures


WIDE = "[...document.querySelectorAll('.wide')].filter(e => e.clientWidth)"


def test_on_a_phone_galleries_are_stacked_and_tables_say_that_they_scroll(browser, folder):
    open_page(browser, folder / "report.html", 390, 844, ratio=2)
    browser.value("document.querySelectorAll('details').forEach(e => e.open = true)")
    assert browser.value("document.documentElement.scrollWidth") == 390
    # Every picture of the galleries lies whole in the window, under the name of its sampler.
    boxes = browser.value("[...document.querySelectorAll('.pictures img')].map(e => e.getBoundingClientRect()).map(b => [b.left, b.right])")
    assert len(boxes) == 12 * len(convergence.DEMO["galleries"]) and all(0 <= left < right <= 390 for left, right in boxes)
    names = browser.value("[...document.querySelectorAll('.pictures td')].map(e => getComputedStyle(e, '::before').content)")
    assert set(names) == {'"white"', '"sobol"', '"blue"'}
    # A table that is wider than the window says so, fades where it is cut off, and keeps the names of its rows.
    browser.wait(f"{WIDE}.some(e => e.classList.contains('hides'))")
    (table,) = browser.value(f"{WIDE}.filter(e => e.scrollWidth > e.clientWidth).map(e => [getComputedStyle(e).maskImage,"
                             " getComputedStyle(e.previousElementSibling).display, e.previousElementSibling.textContent])")
    assert "gradient" in table[0] and table[1] == "block" and "Scroll sideways" in table[2]
    browser.value(f"{WIDE}.forEach(e => e.scrollLeft = 9999)")
    browser.wait(f"{WIDE}.every(e => !e.classList.contains('hides')) && {WIDE}.some(e => e.classList.contains('scrolled'))")
    last = f"(e => [e.querySelector('td'), e.querySelector('td:last-child')].map(c => c.getBoundingClientRect()))({WIDE}.pop())"
    first, end = browser.value(f"{last}.map(b => [b.left, b.right])")
    assert 0 <= first[0] and end[1] <= 390


def test_nothing_scrolls_sideways_on_a_screen(browser, folder):
    open_page(browser, folder / "report.html", 1280, 800)
    assert browser.value(f"{WIDE}.filter(e => e.scrollWidth > e.clientWidth).length") == 0
    assert browser.value("getComputedStyle(document.querySelector('.cue')).display") == "none"


def test_the_early_page_loads_itself_until_it_is_used(browser, folder):
    open_page(browser, folder / "early.html", 390, 844)
    browser.value(f"(document.body.dataset.first = 1, {STEP.format(1)}.click())")
    assert browser.value(COUNT) == "4 samples per pixel" and browser.value(LABEL) == "cornell, white, 4 samples per pixel"
    assert browser.value("[...document.querySelector('[data-part=left]').options].map(o => o.value)") == ["white", "sobol", "blue"]
    browser.wait("document.readyState === 'complete' && !document.body.dataset.first")  # it was only clicked by a script
    browser.wait("document.querySelector('.growing button').hidden")
    browser.press("Tab")
    assert browser.value("document.querySelector('.growing button').hidden") is False
