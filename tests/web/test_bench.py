# SPDX-License-Identifier: Apache-2.0
"""`scripts/bench web`: the pictures are the page's, and the table has ratios."""

import numpy as np
import pytest
from report.measure.image_error import displayed_rmse, rmse
from report.others import web


@pytest.fixture(scope="module")
def tracer(browser):
    return web.Tracer(browser, 150)


def test_pictures_are_the_means_of_samples_from_the_top_down(tracer):
    tracer.restart(3)
    tracer.sample(4)
    picture = tracer.picture("blue")
    sums = np.array(tracer.browser.value("Array.from(tracer.read('blue'))")).reshape(100, 150, 4)
    assert np.allclose(picture, sums[::-1, :, :3] / 4)
    assert picture[:20].max() > 10 > picture[80:].max()  # the lamp is on the ceiling
    tracer.restart(3)
    tracer.sample(4)
    assert np.array_equal(tracer.picture("blue"), picture)


def test_errors(tracer, tmp_path):
    done = []
    errors, shown, reference = web.measure(tracer, 1, 32, lambda label, units: done.append(units))
    assert list(shown) == list(web.SAMPLERS.values()) and reference.shape == (100, 150, 3)
    assert done == [8, 16, 24, 32, 48]
    tracer.restart(0)
    tracer.sample(web.PICTURE_SPP)
    for kind, name in web.SAMPLERS.items():
        assert np.array_equal(tracer.picture(kind), shown[name])
        assert errors[kind, web.PICTURE_SPP] == pytest.approx(
            [displayed_rmse(shown[name], reference, sigma=2.1), rmse(shown[name], reference, 2.1)])
    assert errors["white", 1][0] > errors["blue", 1][0] > errors["blue", 16][0]


def test_the_table_has_ratios():
    errors = {(kind, count): np.array([scale / count, 2 * scale / count]) for count in web.COUNTS
              for kind, scale in (("white", 3.0), ("sobol", 1.5), ("blue", 1.0))}
    assert "| padded Sobol' |" + " 1.50 (1.50) |" * len(web.COUNTS) in web.table(errors)
