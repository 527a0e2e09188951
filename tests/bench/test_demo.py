# SPDX-License-Identifier: Apache-2.0
"""The demo's contact sheets, table and page, from small pictures."""

import csv
import json
import re

import numpy as np
import pytest
from PIL import Image
from report.base.contact_sheet import enlarged_part, sheet
from report.pages import demo, page


def test_zoom_repeats_pixels():
    image = Image.fromarray(np.arange(16, dtype=np.uint8).reshape(4, 4))
    part = np.asarray(enlarged_part(image, (1, 2, 2, 2), 3))
    np.testing.assert_array_equal(part[::3, ::3], [[9, 10], [13, 14]])
    np.testing.assert_array_equal(part[:3, :3], 9)


def test_sheet_shows_every_picture_as_it_is():
    rng = np.random.default_rng(3)
    images = [[[Image.fromarray(rng.integers(0, 255, (40, 32, 3), dtype=np.uint8)) for _ in range(2)]
               for _ in range(3)] for _ in range(2)]
    result = np.asarray(sheet(images, ("first", "second"), ("a", "b", "c"), "title"))
    windows = np.lib.stride_tricks.sliding_window_view(result, (40, 32, 3))[:, :, 0]
    for row in images:
        for cell in row:
            for image in cell:
                first = np.asarray(image)
                assert np.sum(np.all(windows[..., 0, 0, :] == first[0, 0], -1) &
                              np.all(windows[..., -1, -1, :] == first[-1, -1], -1)) == 1


ERRORS = {"white": 0.4, "sobol": 0.2, "blue": 0.1}


def runs():
    """Errors that fall with every sample and differ a little between seeds."""
    return {(sampler, seed): [{"spp": spp, "seconds": 0.1 * spp, **{str(sigma): error / spp * (1 + seed / 100) for sigma in demo.SIGMAS}}
                              for spp in demo.counts_of(seed)]
            for sampler, error in ERRORS.items() for seed in range(demo.SEEDS)}


def test_every_count_to_16_is_a_step_of_one_run():
    assert demo.COUNTS[:16] == tuple(range(1, 17))
    rows = demo.measure(runs())
    assert [(row["sampler"], row["spp"]) for row in rows] == [(s, n) for n in demo.COUNTS for s in demo.SAMPLERS]
    for row in rows:
        assert len(row["each"]["blurred"]) == demo.seeds_at(row["spp"]) >= 4
        assert row["rmse"][2] == pytest.approx(ERRORS[row["sampler"]] / row["spp"], rel=0.1)
        assert row["than_white"][2] == pytest.approx(0.4 / ERRORS[row["sampler"]])


def test_table_has_a_line_for_every_sampler_and_shown_count():
    lines = [line.split() for line in demo.printed_table(demo.measure(runs())).splitlines()[1:] if line]
    assert [(line[0], int(line[1])) for line in lines] == [(s, n) for n in demo.TABLE_COUNTS for s in demo.SAMPLERS]
    assert set(demo.TABLE_COUNTS) <= set(demo.COUNTS) and {1, 2, 3, 4, 6, 16} <= set(demo.TABLE_COUNTS)
    assert lines[2][5:] == ["0.10", "4.00", "x", "2.00", "x", "2.00", "x"]
    assert {len(cell.partition(".")[2]) for line in lines for cell in line[2:5]} == {5}


def test_it_renders_less_than_minutes():
    """A core renders about 14 samples per pixel a second: two cores are done in about two minutes."""
    samples = demo.REFERENCE_SPP + len(demo.SAMPLERS) * sum(demo.counts_of(seed)[-1] for seed in range(demo.SEEDS))
    assert samples < 4000


@pytest.fixture
def small_demo(monkeypatch):
    for name, value in {"SIZE": 32, "PART": (8, 8, 16, 16), "REFERENCE_SPP": 64, "PARTS": 4, "SEEDS": 4, "LATE_SEEDS": 3,
                        "COUNTS": (*range(1, 17), 18)}.items():
        monkeypatch.setattr(demo, name, value)
    monkeypatch.setattr(demo, "TABLE_COUNTS", (1, 2, 16, 18))


def test_a_small_run_grows_from_pictures_to_the_whole_page(pathtracer, tmp_path, small_demo, monkeypatch, capsys):
    renderer, early, rendered = demo.Renderer(pathtracer, tmp_path, threads=1), [], []
    reference = renderer.reference
    monkeypatch.setattr(renderer, "reference", lambda *a: early.append((tmp_path / "report.html").read_text()) or reference(*a))
    rows, notes = demo.render_all(renderer)

    # Before the reference, the page shows all pictures, loads itself again, and promises no figure.
    assert "id=compare>" in early[0] and "location.reload()" in early[0] and "Still to come" in early[0]
    assert len(data(early[0], "compare")["counts"]) == 17
    assert "Error after" not in early[0].split("<script>")[0]
    whole = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "location.reload()" not in whole and "<svg" in whole
    assert str(tmp_path / "report.html") in capsys.readouterr().out

    # The pictures are those of the path tracer at each count, and the errors theirs.
    truth, _ = demo.read_exr(tmp_path / "reference.exr")
    for spp in (1, 3, 16):
        path = renderer.render(demo.Request("blue", spp, 0, demo.SCENE, 32, 32), f"whole_{spp}.exr")
        image = demo.read_exr(tmp_path / f"cornell_blue_{spp}.exr")[0]
        np.testing.assert_allclose(image, demo.read_exr(path)[0], rtol=1e-4, atol=1e-5)
        own = next(row for row in rows if (row["sampler"], row["spp"]) == ("blue", spp))
        assert own["each"]["blurred"][0] == pytest.approx(demo.rmse(image, truth, 2.1), rel=1e-5)
        assert len(own["each"]["blurred"]) == 4
    with open(tmp_path / "table.csv", newline="", encoding="utf-8") as file:
        assert [int(row["spp"]) for row in csv.DictReader(file) if row["sampler"] == "blue"] == [*range(1, 17), 18]

    # A second run renders nothing, and one that has lost a picture makes it again.
    lost = tmp_path / "cornell_blue_3.png"
    with monkeypatch.context() as patch:
        patch.setattr("report.renderer.run_pathtracer", lambda *arguments: rendered.append(arguments))
        assert demo.render_all(demo.Renderer(pathtracer, tmp_path, threads=1)) == (rows, notes) and rendered == []
    before = lost.read_bytes()
    lost.unlink()
    demo.render_all(demo.Renderer(pathtracer, tmp_path, threads=1))
    assert lost.read_bytes() == before


def test_page_asks_nothing_of_the_network():
    black = Image.new("RGB", (3, 2))
    text = page.page("a < b", [("one", [page.table(("x", "y"), [("<1>", 2)]), page.paragraph("p & q"),
                                        page.pictures([[black]], ("row",), ("column",))])], "so < what")
    assert "a &lt; b" in text and "&lt;1&gt;" in text and "p &amp; q" in text
    assert "so &lt; what" in text
    assert re.findall(r'(?:src|href)="(?!data:|#)[^"]*"', text) == []
    assert "http" not in text


def data(text, name):
    return json.loads(re.search(rf"<script type=.application/json. id={name}-data>(.*?)</script>", text)[1])


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    """The page of the demo with noise for pictures."""
    folder, rng = tmp_path_factory.mktemp("report"), np.random.default_rng(4)
    reference = np.full((256, 256, 3), 0.5, np.float32)
    pictures = {(s, n): (reference + rng.normal(0, e / n, (256, 256, 1))).astype(np.float32)
                for s, e in ERRORS.items() for n in demo.COUNTS}
    images = {key: demo.preview(picture) for key, picture in pictures.items()}
    demo.write_report(folder, demo.measure(runs()), pictures, images, reference, 0.0, ("a note",))
    return (folder / "report.html").read_text(encoding="utf-8")


def test_pages_go_from_pictures_to_plots_to_tables(report):
    order = [report.index(mark) for mark in ("<div class=facts", "id=compare>", "id=steps>", "class=errors", "<table class=pictures>",
                                             "Error reduction", "<table><thead>")]
    assert order == sorted(order)
    assert "The error of blue is 4.00 times smaller" in report
    assert "1 sample per pixel" in report and not re.search(r"\b1 samples", report) and "4 samples per pixel" in report


def test_the_page_opens_where_the_difference_is_seen(report):
    """After a blur and between powers of two, with the errors at every count, evenly rounded."""
    compare, steps = data(report, "compare"), data(report, "steps")
    assert compare["start"] == {"left": "white", "right": "blue", "spp": "3", "blur": "2.1"}
    assert steps["counts"] == list(demo.COUNTS) == [int(count) for count in compare["counts"]]
    assert len(steps["places"]) == len(demo.COUNTS) and steps["places"] == sorted(steps["places"])
    for i, count in enumerate(demo.COUNTS):
        shown = [steps["errors"][sampler][i] for sampler in demo.SAMPLERS]
        assert len({len(text.partition(".")[2]) for text in shown}) == 1
        assert [float(text) for text in shown] == pytest.approx([e / count for e in ERRORS.values()], rel=0.1)
    facts = re.findall(r"<div class=fact><b>(.*?)</b><span>(.*?)</span>", report)
    assert [value for value, _ in facts] == ["4.00 \u00d7"] * 2 + ["2.00 \u00d7"] * 2
    assert "less error than white at 3 samples per pixel" in facts[0][1]
    assert report.count("<tr><th>error, blurred</th>") == len(demo.GALLERY_COUNTS)


def test_the_page_is_small(report):
    """Pictures of pure noise are the largest there are."""
    assert len(report) < 6_000_000


def test_grids_have_full_rows():
    for count, columns in ((1, 1), (2, 2), (3, 3), (4, 2), (6, 3)):
        assert f"--columns:{columns}" in page.grid(["x"] * count)


def test_reference_shares_no_sample_with_the_pictures():
    assert demo.REFERENCE_SEED > demo.SEEDS
    assert demo.REFERENCE_SPP >= 32 * demo.COUNTS[-1] and demo.REFERENCE_SPP % demo.PARTS == 0
