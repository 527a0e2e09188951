# SPDX-License-Identifier: Apache-2.0
"""examples/web, opened from disk in Chromium: its results are correct, and its controls work."""

import re
from pathlib import Path

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

import bluenoise

ROOT = Path(__file__).resolve().parents[2]
WEB = ROOT / "examples" / "web"
PAGE = (WEB / "index.html").as_uri()


def open_page(browser, *size, **options):
    browser.open(PAGE, *size, **options)
    browser.wait("!element('problem').hidden || tracer.count >= 1")
    assert browser.value("element('problem').textContent") == ""


@pytest.fixture(scope="module")
def small(browser):
    """The page with a small image, shared by the tests because it takes longer to start than most of them."""
    open_page(browser, 120, 300)
    # The page is idle, so that it draws only what the tests request.
    browser.value("limitTo(1)")
    browser.wait("errors.done && tracer.count === 1")
    return browser


def one_sample(browser, run):
    """The images that white, sobol and blue render at one sample per pixel."""
    browser.value(f"(tracer.restart({run}), tracer.sample())")
    width, height = browser.value("[tracer.width, tracer.height]")
    sums = [browser.value(f"Array.from(tracer.read('{kind}'))") for kind in ("white", "sobol", "blue")]
    return np.array(sums).reshape(3, height, width, 4)[..., :3]


def test_seed_matches_the_library():
    words = re.search(r"^const BN_SEED = \[(\w+), (\w+)\]", (WEB / "shaders.js").read_text(encoding="utf-8"), re.M).groups()
    assert [int(word, 16) for word in words] == list(bluenoise.Sampler(seed=1).seed_words())


def test_no_external_resources_are_loaded():
    """Checks all files, including code that no test runs."""
    for path in (path for path in WEB.iterdir() if path.is_file()):
        text = path.read_text(encoding="utf-8")
        assert not re.search(r"https?://|\bfetch\(|XMLHttpRequest|\bimport\b.*\bfrom\b['\" ]", text) or path.suffix == ".py", path
        assert not re.search(r"(?:src|href)=\"(?!data:,|(?:package/)?\w+\.(?:js|css|html)\")", text), path


def test_blue_has_the_lowest_error_after_a_blur(small):
    """Measures images as displayed at one sample per pixel. The error is the deviation from the mean of all images. The samplers' mean
    values agree, so all render the same scene. The runs are fixed; over other runs, the ratio is 0.83 +- 0.03."""
    pictures = np.array([one_sample(small, run) for run in range(6)]).swapaxes(0, 1)
    assert len(np.unique(pictures.mean((2, 3, 4)))) == 18  # all images differ
    means = pictures.mean((1, 2, 3))
    assert np.all(means > 0.1) and np.all(np.abs(means / means.mean(0) - 1) < 0.05), means
    shown = np.clip(pictures, 0, 1)
    noise = gaussian_filter(shown - shown.mean((0, 1)), (0, 0, 2.1, 2.1, 0))
    white, sobol, blue = np.sqrt((noise**2).mean((1, 2, 3, 4)))
    assert blue < 0.92 * min(white, sobol), (white, sobol, blue)


def test_divider_moves_by_keys_and_pointer(small):
    # Reads the colour of a canvas pixel, which is only possible in the frame that draws it.
    show = ("(place => { frame(); const p = new Uint8Array(4); tracer.gl.readPixels(Math.floor(tracer.width * enlarged * place),"
            " 9, 1, 1, tracer.gl.RGBA, tracer.gl.UNSIGNED_BYTE, p); return Array.from(p.slice(0, 3)); })")
    small.value("element('split').focus()")
    small.press("Home")
    small.wait("element('split').value === '0'")
    right = small.value(f"{show}(0.3)")
    small.press("End")
    small.wait("element('split').value === '100'")
    left = small.value(f"{show}(0.3)")
    assert left != right  # white, then blue
    small.press("ArrowLeft")
    small.wait("element('split').value === '99' && element('handle').getBoundingClientRect().left > 0")
    box = small.value("(b => [b.left, b.top, b.width, b.height])(element('stage').getBoundingClientRect())")
    place = {"x": box[0] + 0.25 * box[2], "y": box[1] + 0.5 * box[3], "button": "left", "clickCount": 1}
    small.call("Input.dispatchMouseEvent", type="mousePressed", **place)
    small.wait("element('split').value === '25'")
    small.call("Input.dispatchMouseEvent", type="mouseMoved", **{**place, "x": box[0] + 0.75 * box[2], "buttons": 1})
    small.wait("element('split').value === '75'")
    small.call("Input.dispatchMouseEvent", type="mouseReleased", **place)
    small.value("frame()")
    handle, stage = small.value("['handle', 'stage'].map(id => element(id).getBoundingClientRect().left)")
    assert abs(handle + 1 - stage - 0.75 * box[2]) < 1


def test_paused_page_shows_an_image(small):
    small.value("limitTo(16)")
    small.value("(element('restart').click(), frame(), element('pause').click())")
    count = small.value("(frame(), frame(), tracer.count)")
    assert 1 <= count < 16 and small.value("element('pause').textContent") == "Resume"
    small.value("(element('restart').click(), frame(), frame())")
    assert small.value("tracer.count") == 1 and small.value("element('status').textContent").endswith(", 1 sample per pixel")
    small.value("element('pause').click()")
    small.wait("tracer.count === 16")


def show_rows(browser):
    """The bytes of the canvas's lowest rows, read in the frame that draws them."""
    return browser.value("(() => { frame(); const w = tracer.width, p = new Uint8Array(4 * w * 8);"
                         " tracer.gl.readPixels(0, 0, w, 8, tracer.gl.RGBA, tracer.gl.UNSIGNED_BYTE, p); return Array.from(p).join(); })()")


def test_controls_step_through_sample_counts(small):
    """The button steps forwards, and the slider goes backwards. The same sample count shows the same image."""
    small.value("limitTo(1)")
    small.wait("errors.done")
    shown = {}
    for count in range(1, 17):
        small.wait(f"(frame(), tracer.count) === {count} && element('shown').textContent === '{count}'")
        shown[count] = show_rows(small)
        assert small.value("element('more').disabled") == (count == 16)
        small.value("element('more').click()")
    assert len(set(shown.values())) == 16
    for count in (15, 3, 1):
        small.value(f"(i => {{ i.value = {count}; i.dispatchEvent(new Event('input')); }})(element('limit'))")
        small.wait(f"(frame(), tracer.count) === {count}")
        assert show_rows(small) == shown[count], count
    assert small.value("element('less').disabled")
    small.value("element('endless').click()")
    small.wait("(frame(), tracer.count) > 16")
    small.value("element('endless').click()")
    small.wait("(frame(), tracer.count) === 16 && element('shown').textContent === '16'")


def test_errors_are_measured_and_plotted_for_all_sample_counts(small):
    """Compares the page's errors with the deviation of six images from their mean. Over six runs, which are fixed, the two estimates
    differ by 1 to 5%."""
    small.value("limitTo(3)")
    small.wait("errors.done && tracer.count === 3")
    found = small.value("errors.values")
    assert all(len(found[kind]) == 16 for kind in ("white", "sobol", "blue"))
    pictures, measured = [], []
    for run in range(20, 26):
        small.value(f"(tracer.restart({run}), tracer.sample(), tracer.sample(), tracer.sample())")
        width, height = small.value("[tracer.width, tracer.height]")
        pictures.append([small.value(f"Array.from(tracer.read('{kind}'))") for kind in found])
        measured.append([small.value(f"(run => {{ run.next(); run.next(); const error = run.next().value; run.return(); return error; }})"
                                     f"(tracer.errors('{kind}', 2.1))") for kind in found])
    shown = np.clip(np.array(pictures).reshape(6, 3, height, width, 4)[..., :3] / 3, 0, 1)
    blurred = gaussian_filter(shown, (0, 0, 2.1, 2.1, 0), mode="nearest", truncate=7 / 2.1)  # the page's radius, 7 pixels
    expected = np.sqrt(blurred.var(0, ddof=1).mean((1, 2, 3)))
    measured = np.sqrt(np.mean(np.square(measured), 0))
    assert np.all(np.abs(measured / expected - 1) < 0.1), (measured, expected)
    white, sobol, blue = measured
    assert blue < 0.9 * min(white, sobol)
    # The error of white noise falls with the square root of the sample count.
    assert 0.75 < found["white"][15] * 4 / found["white"][0] < 1.25

    small.value("(limitTo(5), frame())")
    assert small.value("[...document.querySelectorAll('#plot circle')].length") == 48
    values = [float(text) for text in small.value("[...document.querySelectorAll('#values dd')].map(e => e.textContent)")]
    assert values == pytest.approx([found[kind][4] for kind in found], rel=0.01)
    texts = small.value("[0.03, 0.0188, 0.0996].map((v, i, all) => evenly(all)[i])")
    assert texts == ["0.0300", "0.0188", "0.0996"]
    # Clicking the plot selects the nearest sample count, which a line marks.
    small.value("element('plot').scrollIntoView()")
    box = small.value("(b => [b.left, b.top, b.width, b.height])(element('plot').getBoundingClientRect())")
    at = small.value("Number(document.querySelectorAll('#plot line')[1].getAttribute('x1'))")  # of 2 samples
    click = {"x": box[0] + at + 1, "y": box[1] + 50, "button": "left", "clickCount": 1}
    for kind in ("mousePressed", "mouseReleased"):
        small.call("Input.dispatchMouseEvent", type=kind, **click)
    small.wait("(frame(), tracer.count) === 2 && element('shown').textContent === '2'")
    assert small.value("Number(document.querySelector('#plot .now').getAttribute('x1'))") == pytest.approx(at)


def frames_of(browser, mode, count, kinds=("blue",)):
    """The samplers' images after `count` frames, each of shape (height, width, 3)."""
    # With a limit of 1 and the first sample drawn in the same call, the page's own frames draw nothing in between.
    browser.value(f"(limitTo(1), tracer.restart(7, '{mode}'), tracer.sample(), tracer.gl.finish(), 0)")
    for _ in range(count - 1):  # calls are kept short because rendering is in software
        browser.value("(tracer.sample(), tracer.gl.finish(), 0)")
    width, height = browser.value("[tracer.width, tracer.height]")
    return [np.array(browser.value(f"Array.from(tracer.read('{kind}'))")).reshape(height, width, 4)[..., :3] for kind in kinds]


def test_moving_average_starts_as_the_mean_and_then_decays(small):
    one, two = (frames_of(small, "sum", count)[0] for count in (1, 2))
    assert np.allclose(frames_of(small, "average", 1)[0], one, rtol=1e-6)
    # A pixel's surface may change with the position within it. Where it does not, two frames have equal weights.
    same = np.isclose(frames_of(small, "average", 2)[0], two / 2, rtol=1e-3, atol=1e-4).all(-1)
    assert same.mean() > 0.85
    white, blue = np.clip(frames_of(small, "average", 20, ("white", "blue")), 0, 1)
    reference = np.clip(frames_of(small, "sum", 24)[0] / 24, 0, 1)
    errors = [gaussian_filter(picture - reference, (1, 1, 0)).std() for picture in (white, blue)]
    assert errors[1] < 0.9 * errors[0] and errors[0] < 0.05, errors


def test_page_recovers_from_a_lost_context(small):
    small.value("(gl => { window.device = gl.getExtension('WEBGL_lose_context'); device.loseContext(); })(tracer.gl)")
    small.wait("tracer === null")
    small.value("(frame(), request(), device.restoreContext())")
    small.wait("tracer && tracer.count >= 1")
    assert one_sample(small, 0).mean() > 0.1
    assert small.happened("Runtime.exceptionThrown") == []


@pytest.mark.parametrize(("width", "ratio", "dark"), [(390, 3, False), (1280, 1, True)])
def test_page_fits_the_window(browser, width, ratio, dark):
    open_page(browser, width, 844, ratio=ratio, dark=dark)
    # Placeholders of the same width replace the errors, which take long to measure.
    browser.value("errors.restart(null), document.querySelectorAll('#values dd').forEach(e => { e.textContent = '0.0300'; })")
    assert browser.value("document.documentElement.scrollWidth") == width
    columns, rows, enlarged = browser.value("[tracer.width, tracer.height, enlarged]")
    assert 300 < columns < 500 and abs(rows / columns - 2 / 3) < 0.01
    assert browser.value("[element('picture').width, element('picture').height]") == [columns * enlarged, rows * enlarged]
    assert browser.value("element('blur').textContent") == "1.0 px blur"
    cramped = "[...document.querySelectorAll('fieldset span')].filter(s => s.scrollWidth > s.clientWidth).map(s => s.textContent)"
    assert browser.value(cramped) == []
    ends = "[element('blur'), element('stage')].map(e => { const r = document.createRange(); r.selectNodeContents(e);" \
           " return e.id === 'stage' ? e.getBoundingClientRect().right : r.getBoundingClientRect().right; })"
    inside = "[...document.querySelectorAll('#controls *, #errors *')].filter(e => e.getBoundingClientRect().right > innerWidth)"
    assert browser.value(f"{inside}.map(e => e.id || e.className)") == []
    for distance in (0, 1):
        text, stage = browser.value(f"(element('distance').value = {distance}, frame(), {ends})")
        assert abs(text - stage) < 1, distance
    assert [event["type"] for event in browser.happened("Runtime.consoleAPICalled")] == []
    assert browser.happened("Runtime.exceptionThrown") == []
    loaded = {event["request"]["url"] for event in browser.happened("Network.requestWillBeSent")} - {"data:,"}
    assert loaded and all(url.startswith(WEB.as_uri()) for url in loaded)


def test_page_reports_missing_webgl(browser):
    added = browser.call("Page.addScriptToEvaluateOnNewDocument", source="HTMLCanvasElement.prototype.getContext = () => null;")
    try:
        browser.open(PAGE, 390, 844)
        assert "WebGL 2" in browser.value("element('problem').innerText")
        assert browser.value("element('stage').hidden && element('controls').hidden")
        assert browser.happened("Runtime.exceptionThrown") == []
    finally:
        browser.call("Page.removeScriptToEvaluateOnNewDocument", identifier=added["identifier"])
