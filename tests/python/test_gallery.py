# SPDX-License-Identifier: Apache-2.0
"""The listings of docs/gallery.md and docs/arrays.md run, and make the pictures that the gallery shows."""

import re
import shutil
from pathlib import Path

import numpy as np
import pytest

DOCS = Path(__file__).resolve().parents[2] / "docs"
GALLERY, ARRAYS = DOCS / "gallery.md", DOCS / "arrays.md"
pytestmark = pytest.mark.skipif(not GALLERY.exists(), reason="the source distribution has no guides")


def listings(page):
    return re.findall(r"^```python\n(.*?)^```", page.read_text(encoding="utf-8"), re.M | re.S)


@pytest.mark.slow
def test_gallery_listings_make_the_pictures(tmp_path, monkeypatch):
    pytest.importorskip("scipy")
    Image = pytest.importorskip("PIL.Image")
    shutil.copy(DOCS / "gallery" / "coffee.jpg", tmp_path)
    monkeypatch.chdir(tmp_path)
    space = {}
    for listing in listings(GALLERY):
        exec(listing, space)
    shown = set(re.findall(r"gallery/([\w.]+)", GALLERY.read_text(encoding="utf-8")))
    assert {file.name for file in tmp_path.iterdir()} == {file.name for file in (DOCS / "gallery").iterdir()}
    assert shown == {file.name for file in tmp_path.iterdir()} - {"coffee.jpg"}
    for name in shown:
        with Image.open(name) as made, Image.open(DOCS / "gallery" / name) as kept:
            pairs = [(made, kept)] if name != "pan.webp" else [(made, kept) for k in range(16) if made.seek(k) is kept.seek(k)]
            for new, old in pairs:
                a, b = (np.asarray(each.convert("RGB"), np.int32) for each in (new, old))
                # Other versions of Pillow decode JPEG, and of SciPy round, slightly differently.
                assert a.shape == b.shape and (abs(a - b).max(-1) > 16).mean() < 0.05, name
    # The figures of the page, within a tenth.
    for name, limits in {"diffusion": (0.0093, 0.0318), "mask": (0.0172, 0.0443), "white": (0.0616, 0.1261)}.items():
        from scipy.ndimage import gaussian_filter

        error = space["ways"][name]() - space["grey"]
        found = [np.sqrt((gaussian_filter(error, sigma, mode="wrap") ** 2).mean()) for sigma in (2.1, 1)]
        np.testing.assert_allclose(found, limits, rtol=0.1)
        assert all(f"{limit:.4f}" in GALLERY.read_text(encoding="utf-8") for limit in limits)


@pytest.mark.slow
def test_arrays_listings_run():
    pytest.importorskip("torch")
    first, second = listings(ARRAYS)
    space = {}
    exec(first, space)
    volume, truth, render = (space[name] for name in ("volume", "truth", "render"))
    error = (render(volume, 0.7, 99) - render(truth, 0.7, 99)).square().mean()
    before = (render(volume.detach() * 0 + 1, 0.7, 99) - render(truth, 0.7, 99)).square().mean()
    assert float(error.detach()) < 0.2 * float(before)
    pytest.importorskip("jax")
    exec(second, space)
    found = space["sampler"].sample(np.arange(64), 5, 0)
    assert np.array_equal(np.asarray(space["jax_u"]), found)
