# SPDX-License-Identifier: Apache-2.0
"""The notebook runs as it is and prints what is stored in it, and what its text says of these figures holds."""

import contextlib
import io
import json
import re
from pathlib import Path

import numpy as np
import pytest

NOTEBOOK = Path(__file__).resolve().parents[2] / "examples" / "python" / "tour.ipynb"


@pytest.fixture(scope="module")
def cells():
    if not NOTEBOOK.exists():
        pytest.skip("the source distribution has no examples")
    return json.loads(NOTEBOOK.read_text(encoding="utf-8"))["cells"]


@pytest.fixture(scope="module")
def tour(cells):
    """(the variables of the notebook at its end, what each cell printed)"""
    pytest.importorskip("scipy")
    plt = pytest.importorskip("matplotlib.pyplot")
    variables, printed = {}, {}
    with pytest.MonkeyPatch.context() as patch:
        plt.switch_backend("Agg")
        patch.setattr(plt, "show", lambda: plt.close("all"))
        for cell in cells:
            if cell["cell_type"] == "code":
                with contextlib.redirect_stdout(io.StringIO()) as output:
                    exec(compile("".join(cell["source"]), cell["id"], "exec"), variables)
                printed[cell["id"]] = output.getvalue()
    return variables, printed


def stored(cell):
    return "".join("".join(output["text"]) for output in cell["outputs"] if output["output_type"] == "stream")


def numbers(text):
    """The decimal fractions of a text, with the error that rounding and another arithmetic may add to each."""
    found = re.findall(r"\d+\.(\d+)", text), np.array(re.findall(r"\d+\.\d+", text), float)
    return found[1], np.array([1.1 * 0.1 ** len(digits) for digits in found[0]]) + 0.01 * found[1]


def test_it_prints_what_is_stored(cells, tour):
    _, printed = tour
    assert len(printed) >= 10
    for cell in cells:
        if cell["cell_type"] == "code":
            expected, tolerance = numbers(stored(cell))
            values, _ = numbers(printed[cell["id"]])
            assert re.sub(r"\d+\.\d+", "", printed[cell["id"]]).split() == re.sub(r"\d+\.\d+", "", stored(cell)).split(), cell["id"]
            assert (np.abs(values - expected) <= tolerance).all(), cell["id"]


def test_it_is_small_and_says_nothing_of_the_machine_it_ran_on(cells):
    assert NOTEBOOK.stat().st_size < 200_000
    notebook = json.loads(NOTEBOOK.read_text(encoding="utf-8"))
    assert notebook["metadata"]["language_info"] == {"name": "python"}
    assert not any(cell["metadata"] or cell.get("execution_count") for cell in cells)
    pictures = [output["data"]["image/png"] for cell in cells for output in cell.get("outputs", ()) if "data" in output]
    assert len(pictures) == 3 and max(map(len, pictures)) < 60_000


def test_its_links_lead_somewhere(cells):
    text = "\n".join("".join(cell["source"]) for cell in cells if cell["cell_type"] == "markdown")
    links = re.findall(r"\]\(([^)#]+)", text)
    assert len(links) >= 3 and [link for link in links if not (NOTEBOOK.parent / link).exists()] == []


def test_a_blue_mask_dithers_with_a_third_of_the_error(tour):
    bluenoise, masks = tour[0]["bluenoise"], tour[0]["masks"]
    blue, white = (bluenoise.measure(masks[name])["e_1"] for name in ("void-and-cluster", "white"))
    assert 0.3 * white < blue < 0.36 * white


def test_in_pixels_blue_is_as_good_as_sobol_and_better_after_a_blur(tour):
    ratio = {key: error / tour[0]["pixel_error"][key[0], "SciPy's Sobol'", key[2]]
             for key, error in tour[0]["pixel_error"].items() if key[1] == "blue"}
    assert len(ratio) == 4
    for (title, _, blur), values in ratio.items():
        low, high = {"": (0.9, 1.1), "blurred": (0.4, 0.65) if title.startswith("one") else (0.5, 0.8)}[blur]
        assert ((low < values) & (values < high)).all(), (title, blur, values)


def test_for_one_integral_sobol_is_as_good_and_wins_with_many_points_in_many_dimensions(tour):
    error, counts = tour[0]["error"], tour[0]["counts"]
    ratio = {(title, d): error[title, d, "SciPy's Sobol'"] / error[title, d, "blue"] for title, d, name in error if name == "blue"}
    few = counts <= 256
    for d in (2, 4, 8, 16):
        assert ((0.9 < ratio["steps", d][few]) & (ratio["steps", d][few] < 1.1)).all(), (d, ratio["steps", d])
    assert ratio["steps", 8][-1] < 0.8
    four = ratio["bumps", 4]
    assert four.min() > 0.5 and four.max() < 2.3 and (np.diff(np.sign(four - 1)) != 0).sum() >= 3
    two = ratio["bumps", 2]
    assert 1 / 4 < two[-1] < 1 / 3 and two.max() < 2.3 and (np.diff(np.sign(two - 1)) != 0).sum() >= 3
    for d in (8, 16):
        bumps = ratio["bumps", d]
        assert bumps[counts == 16] > 1.05 and (bumps[counts >= 256] < 0.8).all() and bumps.min() > 1 / 4.5
    assert all((values < error[title, d, "random"]).all() for (title, d, name), values in error.items() if name != "random")


def test_a_domain_knows_of_the_others_of_its_family(tour):
    share = tour[0]["share_of_random"]
    for blur in ("", "blurred"):
        one, family, none = (share[title, blur] for title in ("one domain", "two domains of a family", "two families"))
        assert one < family < 0.9 * none < 0.9


def test_seeds_give_standard_errors_and_pixels_do_not(tour):
    """Two hundred groups of 16: 94 % are expected within twice their standard error; four standard deviations."""
    within = tour[0]["within"]
    assert 0.87 < within["16 seeds"] < 1
    means, errors = tour[0]["mean_and_error"](tour[0]["by_pixels"])
    assert tour[0]["rms"](means - 1) < 0.85 * tour[0]["rms"](errors)
