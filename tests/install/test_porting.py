# SPDX-License-Identifier: Apache-2.0
"""The listings of docs/porting.md draw the same numbers as the library, and examples/check detects integration mistakes."""

import functools
import os
import re

import pytest
from conftest import ROOT, listing, run

GUIDE = (ROOT / "docs" / "porting.md").read_text(encoding="utf-8")

# Values of MISTAKE, and their descriptions in the guide.
MISTAKES = {
    "none": "none",
    "index from 1": "the index starts at 1",
    "index from 1000": "the index starts at 1000",
    "index over the image": "the index counts the samples of the image",
    "index stuck at 0": "the index stays at 0",
    "index drawn twice": "every index is drawn twice",
    "threads": "four threads share a pixel's samples, and each counts its own",
    "seed per tile": "a different seed for each 16 x 16 tile",
    "domain per sample": "a domain counter that is not reset for each sample",
    "domain or seed per pixel": "a seed or a domain hashed from the pixel",
    "pixel number": "x is the linear pixel index, y is 0",
    "tile coordinates": "x, y relative to 16 x 16 tiles",
    "exchanged in tiles": "x and y swapped inside 16 x 16 tiles",
    "shared domain": "two decisions share a domain",
    "pair first": "`f(Get1D(), Get2D())`: the pair is drawn before the number that belongs to it",
    "lens first": "`f(Get2D(), Get2D())`: the lens is drawn before the position",
    "one by one": "three `Get1D()` in place of `Get1D()` and `Get2D()`",
    "sobol": "`BN_SAMPLER_SOBOL` in place of `BLUE`",
    "white": "`BN_SAMPLER_WHITE`",
}


@pytest.fixture(scope="module")
def build(static_library, tmp_path_factory):
    """Compiles a C++ program that may include listing.hpp. Returns its path."""
    def build(main, listing=""):
        folder = tmp_path_factory.mktemp("listing")
        (folder / "listing.hpp").write_text(listing)
        (folder / "main.cpp").write_text(main)
        return static_library.compile_cpp(folder / "program", folder / "main.cpp")

    return build


@pytest.fixture(scope="module")
def check(static_library, tmp_path_factory):
    program = tmp_path_factory.mktemp("check") / "check"
    static_library.compile(ROOT / "examples/check/check.c", program, "-std=c99", "-Wall", "-Wextra", "-Werror", "-O1",
                           ROOT / "tests/install/porting_mistakes.c")

    @functools.cache
    def check(mistake, **settings):
        printed = run(program, env={**os.environ, "MISTAKE": mistake, **settings})
        return re.findall(r"-?[\d.]+$", printed, re.MULTILINE)

    return check


def test_table_matches_the_check_output(check):
    rows = ["| mistake | 1 spp | 4 spp | 16 spp | repeats | shared | first | apart |", "| --- |" + " ---: |" * 7]
    rows += [f"| {name} | {' | '.join(check(mistake)).replace('-0.00', '0.00')} |" for mistake, name in MISTAKES.items()]
    table = GUIDE.split("<!-- table: tests/install/test_porting.py -->\n\n")[1].split("\n\n<!--")[0]
    assert table == "\n".join(rows)


def limits():
    """The acceptable range that the guide states for each figure: three errors, repeats, shared, first and apart."""
    good = re.findall(r"^\| (?:\d+ spp|repeats|shared|first|apart) \| ([^|]+) \|", GUIDE, re.MULTILINE)
    assert len(good) == 7
    return [(float(least), float(most)) for least, most in ((cell.split(" to ") * 2)[:2] for cell in good)]


@pytest.mark.parametrize("layout", ["next ray", "second pair", "grandchild", "stream"])
def test_correct_integrations_are_within_the_limits(check, layout):
    """With BN_SEEDS=100 and -s, prints the extremes stated in the guide."""
    seeds = range(int(os.environ.get("BN_SEEDS", "4")))
    figures = list(zip(*([float(number) for number in check("none", SEED=str(seed), LAYOUT=layout)] for seed in seeds)))
    print(f"\n{layout}: " + ", ".join(f"{min(found) + 0:g} to {max(found) + 0:g}" for found in figures))
    assert all(least <= min(found) and max(found) <= most for (least, most), found in zip(limits(), figures)), figures


@pytest.mark.parametrize("mistake", [mistake for mistake in MISTAKES if mistake != "none"])
def test_check_detects_the_mistake(check, mistake):
    assert any(not least <= float(found) <= most for found, (least, most) in zip(check(mistake), limits()))


TILE = """
#include <cstdio>
#include <vector>
struct Color { float values[12]; };
struct Ray {};
struct Camera { Ray ray(float, float) const { return {}; } };
struct Scene { Camera camera; };
struct Tile { int x0, y0, x1, y1; };
struct Film {
    std::vector<Color> colors;
    void add(int, int, Color color) { colors.push_back(color); }
};
constexpr unsigned max_depth = 2;
// The listing, completed with the omitted code.
TEXT
int main() {
    const bn::Sampler sampler(4);
    Film film;
    render_tile(Scene{}, sampler, {-2, 5, 3, 8}, 4, film);
    int wrong = 0, at = 0;
    for (int y = 5; y < 8; ++y)
        for (int x = -2; x < 3; ++x)
            for (unsigned i = 0; i < 4; ++i, ++at)
                for (uint32_t key = 0; key < 3; ++key) {
                    float own[4];
                    bn_sample_4d(sampler.get(), x, y, i, bn_domain_child(BN_DOMAIN_ROOT, key), own);
                    for (int d = 0; d < 4; ++d) wrong += film.colors[at].values[4 * key + d] != own[d];
                }
    std::printf("%d\\n", wrong + (at != 60));
}
"""


def test_tile_listing(build):
    """Each pixel of the image stores the numbers it drew."""
    text = listing("porting.md", "tile.hpp")
    for before, after in (
            ("    // ...\n    for", "    Color color{{px, py, s, t}};\n    (void)ray, (void)scene;\n    for"),
            ("        // ...\n        light[0]", "        const float more[] = {direction[0], direction[1], next_s, next_t};\n"
             "        for (int d = 0; d < 4; ++d) color.values[4 * depth + d] = more[d];\n        light[0]"),
            ("next_t;\n    }\n}", "next_t;\n    }\n    (void)light;\n    return color;\n}")):
        assert text.count(before) == 1
        text = text.replace(before, after)
    assert run(build(TILE.replace("TEXT", text))) == "0\n"


# Requests numbers in the order that its argument specifies.
ORDER = """
#include "listing.hpp"
int main(int, char **arguments) {
    const bn::Sampler shared(9);
    bn::SequentialSampler numbers(shared);
    BlueSampler listed(shared);
    numbers.expect("22", "121");
    numbers.start(1, 2, 3);
    listed.StartPixelSample(1, 2, 3);
    int wrong = 0;
    for (const char *request = arguments[1]; *request; ++request) {
        if (*request == '1') wrong += numbers.next_1d() != listed.Get1D();
        else if (*request == '2') wrong += numbers.next_2d() != listed.Get2D();
        else numbers.start_ray(unsigned(*request - 'a')), listed.StartRay(unsigned(*request - 'a'));
    }
    return wrong;
}
"""


@pytest.mark.parametrize("right", ["", "22b1211", "2b12121c121221", "221b1d1", "22bb121"])
def test_expected_request_orders(order, right):
    run(order, right)


@pytest.mark.parametrize("wrong", ["1", "21", "22b2", "22b11", "22b122", "22b121c21", "22c121b"])
def test_debug_builds_abort_on_unexpected_orders(order, wrong):
    with pytest.raises(AssertionError, match="Assertion"):
        run(order, wrong)


@pytest.fixture(scope="module")
def order(build):
    return build(ORDER, listing("porting.md", "counted.hpp"))


WAVEFRONT = """
#include <cstdio>
#include "listing.hpp"
int main() {
    const bn_sampler sampler = bn_sampler_make(0);
    Lanes lanes;
    int wrong = !draw_stage(&sampler, lanes);
    for (int lane = 0; lane < 101; ++lane) {
        lanes.x.push_back(lane * 7 % 40 - 9);
        lanes.y.push_back(lane / 3);
        lanes.index.push_back(uint32_t(lane * lane));
        lanes.depth.push_back(uint32_t(lane % 5));
    }
    wrong += !draw_stage(&sampler, lanes) || lanes.u[3].size() != 101;
    for (size_t lane = 0; lane < 101; ++lane) {
        float own[4];
        bn_sample_4d(&sampler, lanes.x[lane], lanes.y[lane], lanes.index[lane],
                     bn_domain_child(BN_DOMAIN_ROOT, lanes.depth[lane] + (lanes.depth[lane] > 2)), own);
        for (size_t d = 0; d < 4; ++d) wrong += lanes.u[d][lane] != own[d];
    }
    std::printf("%d\\n", wrong);
    return 0;
}
"""


def test_wavefront_listing(build):
    assert run(build(WAVEFRONT, listing("porting.md", "wavefront.hpp"))) == "0\n"
