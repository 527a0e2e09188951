# SPDX-License-Identifier: Apache-2.0
"""The demo's contact sheets, table and page, from small pictures."""

import re

import numpy as np
import pytest
from PIL import Image
from report import demo, page
from report.contact_sheet import sheet, zoomed


def test_zoom_repeats_pixels():
    image = Image.fromarray(np.arange(16, dtype=np.uint8).reshape(4, 4))
    part = np.asarray(zoomed(image, (1, 2, 2, 2), 6))
    np.testing.assert_array_equal(part[::3, ::3], [[9, 10], [13, 14]])
    np.testing.assert_array_equal(part[:3, :3], 9)
    with pytest.raises(ValueError):
        zoomed(image, (0, 0, 3, 3), 8)


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


def rows():
    errors = {"white": 0.4, "sobol": 0.2, "blue": 0.1}
    return [{"sampler": sampler, "spp": spp, "rmse": [error / spp] * 3, "seconds": 0.5,
             "each": {"plain": [error / spp] * 3, "blurred": [error / spp * (1 + seed / 100) for seed in range(3)]},
             "than_white": [0.4 / error] * 3, "than_sobol": [0.2 / error] * 3}
            for spp in demo.COUNTS for sampler, error in errors.items()]


def test_table_has_a_line_for_every_sampler_and_count():
    lines = [line.split() for line in demo.text_table(rows()).splitlines()[1:] if line]
    assert [(line[0], int(line[1])) for line in lines] == [(s, n) for n in demo.COUNTS for s in demo.SAMPLERS]
    assert lines[2][2:] == ["0.10000", "0.10000", "0.10000", "0.50", "4.00", "x", "2.00", "x", "2.00", "x"]


def test_readme_picture_shows_a_difference_that_a_step_back_keeps(pathtracer, tmp_path):
    """The picture shows white and blue noise, and after the blur blue noise is much closer to the reference."""
    renderer = demo.Renderer(pathtracer, tmp_path)
    assert demo.readme_picture(renderer).width <= 840  # what a README's column shows without resampling
    left, top, width, height = demo.PICTURE_PART
    assert left + width <= demo.PICTURE_SIZE[0] and top + height <= demo.PICTURE_SIZE[1]
    truth = renderer.render(demo.Request("sobol", 64, 9, demo.PICTURE_SCENE, *demo.PICTURE_SIZE), "truth.exr")

    def seen(path):
        part = np.clip(demo.read_exr(path)[0], 0, 1)[top:top + height, left:left + width]
        return demo.blurred(part, demo.PICTURE_BLUR)

    errors = {sampler: np.sqrt(np.mean((seen(tmp_path / f"readme/{sampler}.exr") - seen(truth)) ** 2))
              for sampler in demo.SAMPLERS}
    assert errors["blue"] < 0.75 * errors["white"] and errors["blue"] < 0.75 * errors["sobol"]


def test_the_readme_shows_its_picture():
    root = demo.Path(demo.__file__).resolve().parents[2]
    assert f"docs/{demo.PICTURE_FILE}" in (root / "README.md").read_text(encoding="utf-8")
    picture = root / "docs" / demo.PICTURE_FILE
    Image.open(picture).verify()
    assert picture.stat().st_size < 250_000


def test_page_asks_nothing_of_the_network():
    black = Image.new("RGB", (3, 2))
    text = page.page("a < b", [("one", [page.table(("x", "y"), [("<1>", 2)]), page.paragraph("p & q"),
                                        page.pictures([[black]], ("row",), ("column",))])], "so < what")
    assert "a &lt; b" in text and "&lt;1&gt;" in text and "p &amp; q" in text
    assert "so &lt; what" in text
    assert re.findall(r'(?:src|href)="(?!data:|#)[^"]*"', text) == []
    assert "http" not in text


def test_pages_go_from_pictures_to_plots_to_tables(tmp_path):
    rng = np.random.default_rng(4)

    class Cell:
        error = rng.standard_normal((64, 64))
        whole = part = difference = Image.new("RGB", (64, 64))

    cells = {(sampler, spp): Cell for sampler in demo.SAMPLERS for spp in demo.COUNTS}
    demo.write_report(tmp_path, rows(), cells, np.full((64, 64, 3), 0.5, np.float32), 0.0, ("a note",))
    text = (tmp_path / "report.html").read_text(encoding="utf-8")
    order = [text.index(mark) for mark in ("id=compare>", "<table class=pictures>", "<svg", "<table><thead>")]
    assert order == sorted(order)
    assert "The error of blue is 4.00 times smaller" in text
    assert "1 sample per pixel" in text and "1 samples" not in text and "4 samples per pixel" in text


def test_grids_have_full_rows():
    for count, columns in ((1, 1), (2, 2), (3, 3), (4, 2), (6, 3)):
        assert f"--columns:{columns}" in page.grid(["x"] * count)


def test_reference_shares_no_sample_with_the_pictures():
    assert demo.REFERENCE_SEED > max(demo.SEEDS.values())
    assert demo.REFERENCE_SPP >= 4096 and demo.REFERENCE_SPP % demo.PARTS == 0
