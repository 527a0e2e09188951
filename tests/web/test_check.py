# SPDX-License-Identifier: Apache-2.0
"""examples/web/check.html, opened from disk and from a server in Chromium with software rendering."""

import functools
import http.server
import threading
from pathlib import Path

import numpy as np
import pytest

import bluenoise

WEB = Path(__file__).resolve().parents[2] / "examples" / "web"


class Quiet(http.server.SimpleHTTPRequestHandler):
    def log_message(self, *_):
        pass


def open_check(browser, address, timing):
    """Opens the page with nanoseconds(), which takes most of the time, replaced. The original remains available as `timed`. onWebGl2() runs
    once, and later calls return its first result."""
    source = f"""window.setTimeout = (set => (run, ...rest) => set(() => {{
        window.timed ??= nanoseconds; nanoseconds = {timing};
        window.once ??= (first => {{ let kept; return () => kept ??= first(); }})(onWebGl2); onWebGl2 = once;
        run(); }}, ...rest))(window.setTimeout);"""
    added = browser.call("Page.addScriptToEvaluateOnNewDocument", source=source)
    browser.open(address, 800, 600)
    browser.call("Page.removeScriptToEvaluateOnNewDocument", identifier=added["identifier"])


@pytest.fixture(scope="module")
def page(browser):
    """The page opened from disk. Each timed function runs only once."""
    open_check(browser, (WEB / "check.html").as_uri(), "async run => (await run(1), 1.5)")
    return browser


def lines(page):
    page.wait("element('report').value !== ''")
    return {name: page.value(f"[element('{name}').className, element('{name}').textContent]") for name in ("webgpu", "webgl2")}


def check_right(page):
    for name, (kind, text) in lines(page).items():
        assert kind == "verdict right" and "1.50 ns per draw of four numbers, 1.50 ns per texture fetch" in text, text
        assert page.value(f"element('report').value.includes(element('{name}').textContent)")
    assert page.happened("Runtime.exceptionThrown") == []


def test_all_bits_match(page):
    check_right(page)


def test_time_is_the_minimum_of_three_runs_of_at_least_30_ms(page):
    lines(page)
    page.value("(clock => { performance.now = () => clock; window.wait = ms => { clock += ms; }; })(0)")
    took = page.value("(async (calls, slow) => [await timed(async n => { calls.push(n); wait(n * 10 + slow.pop()); }), calls])"
                      "([], [0, 4, 12, 0, 0, 0])")
    assert took == [pytest.approx(1e6 * 10 / (8 * 2**20)), [1, 1, 2, 4, 4, 4]]


def test_draws_are_those_of_c(page):
    """The hash contains all bits, on drivers that tests/shaders compares with the library; these are the bits that floats keep."""
    lines(page)
    at = 997 * np.arange(1000, dtype=np.uint32)
    index, domain = at * np.uint32(0x9e3779b1) >> 12, at * np.uint32(0x85ebca6b) >> 22 << 22
    some = "({drawn}) => Array.from({length: 4000}, (_, k) => drawn[4 * 997 * (k >> 2) + (k & 3)])"
    words = np.array(page.value(f"onWebGl2().then({some})"), np.uint32)
    expected = bluenoise.Sampler(seed=1).sample(at % 1024, at // 1024, index, domain)
    assert np.array_equal((words.reshape(-1, 4) >> 8) * np.float32(2.0**-24), expected)


def test_single_wrong_bit_is_reported(page):
    lines(page)
    found = page.value("verdict('WebGL 2', {drawn: new Uint32Array(4 * COUNT).fill(1, 9, 10), name: '', draw: 1, fetch: 1})")
    assert found[0] == "wrong" and "bits differ from the library's (hash 00000013, not " in found[1]


def test_missing_api_has_no_verdict(page):
    assert page.value("verdict('WebGPU', null)[0]") == "nothing"


@pytest.fixture
def port():
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Quiet, directory=WEB)) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield server.server_port
        server.shutdown()


def test_all_bits_match_from_a_server(browser, port):
    open_check(browser, f"http://127.0.0.1:{port}/check.html", "async () => 1.5")
    check_right(browser)


def test_insecure_server_runs_webgl_and_copies_the_report(browser, port):
    open_check(browser, f"http://0.0.0.0:{port}/check.html", "async () => 1.5")  # 127.0.0.1 would be trusted
    found = lines(browser)
    assert found["webgpu"] == ["verdict nothing", "WebGPU: not in this browser, or only over HTTPS or from disk."]
    assert found["webgl2"][0] == "verdict right"
    x, y = browser.value("(({x, y}) => [x + 5, y + 5])(element('copy').getBoundingClientRect())")
    browser.value("document.addEventListener('copy', () => { window.copied = getSelection().toString(); }), 0")
    for kind in ("mousePressed", "mouseReleased"):
        browser.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", clickCount=1)
    assert browser.value("copied") == browser.value("element('report').value")
