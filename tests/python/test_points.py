# SPDX-License-Identifier: Apache-2.0
"""Point sets are evenly spread, reproducible, and toroidal where documented."""

import sys

import numpy as np
import pytest
from helpers import progress_of
from reference import white

import bluenoise
from bluenoise import _points

pytest.importorskip("scipy")
METHODS = list(_points.METHODS)


def closest(points, toroidal):
    """The smallest distance between two points, divided by the spacing of a square lattice with as many points."""
    apart = np.abs(points[:, None] - points)
    if toroidal:
        apart = np.minimum(apart, 1 - apart)
    distances = np.sqrt((apart**2).sum(2))
    np.fill_diagonal(distances, np.inf)
    return distances.min() * len(points) ** (1 / points.shape[1])


def power(points, low, high):
    """The mean power of points in the unit square at frequencies between low and high, in inverse lattice spacings; white noise
    has 1. A window hides the square's edges."""
    weights = (np.sin(np.pi * points) ** 2).prod(1)
    frequencies = np.stack(np.meshgrid(np.arange(-48, 49), np.arange(49)), -1).reshape(-1, 2)
    size = np.hypot(*frequencies.T)
    frequencies = frequencies[(size > 4) & (size > low * len(points) ** 0.5) & (size < high * len(points) ** 0.5)]
    return (np.abs(np.exp(-2j * np.pi * (frequencies @ points.T)) @ weights) ** 2).mean() / (weights**2).sum()


@pytest.mark.parametrize("options", [{"dims": 2}, {"dims": 3}, {"density": [[1, 2, 0], [3, 1, 7]]}, {"dims": 3, "density": [[[1, 2]]]}])
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("n", [0, 1, 2, 3, 37, 200])
def test_points_have_shape_and_range(method, n, options):
    if method == "best-candidate" and "density" in options:
        pytest.skip("best-candidate has no density")
    found = bluenoise.points(n, method=method, seed=3, **options)
    assert found.shape == (n, options.get("dims", 2)) and found.dtype == np.float64
    assert ((found >= 0) & (found < 1)).all()
    np.testing.assert_array_equal(found, bluenoise.points(n, method=method, seed=3, **options))
    if n:
        assert not np.array_equal(found, bluenoise.points(n, method=method, seed=4, **options))


# White noise reaches 0.03 with 256 points in a square, and 0.15 with 512 in a cube. The limits are half the values of seeds 0 to 9.
@pytest.mark.parametrize("method, least", [("best-candidate", (0.35, 0.4)), ("poisson-disk", (0.39, 0.42)), ("mask", (0.2, 0.15))])
@pytest.mark.parametrize("dims", [2, 3])
@pytest.mark.parametrize("seed", range(2))
def test_no_two_points_are_close(method, least, dims, seed):
    assert closest(bluenoise.points({2: 256, 3: 512}[dims], method=method, seed=seed, dims=dims), True) > least[dims - 2]


@pytest.mark.slow
@pytest.mark.parametrize("method", ["poisson-disk", "mask"])
def test_density_decides_the_number_of_points_and_nothing_else(method):
    """Four patches have the densities 1, 2, 4 and 8, and the numbers and spectra of uniform points. The limit for a count is four
    standard deviations of the points measured, which is 1.3 of random points."""
    density = np.kron([[1, 2], [4, 8]], np.ones((40, 40)))
    found = bluenoise.points(3000, method=method, seed=2, density=density)
    uniform = [power(bluenoise.points(1600, method=method, seed=3), *band) for band in ((0.1, 0.5), (0.8, 1.2))]
    assert uniform[0] < 0.25 and uniform[1] > 1
    for y, x in np.ndindex(2, 2):
        patch = found * 2 - (x, y)
        patch = patch[((patch >= 0) & (patch < 1)).all(1)]
        expected = 200 * density[40 * y, 40 * x]
        assert abs(len(patch) - expected) < 1.3 * expected**0.5
        for band, usual in zip(((0.1, 0.5), (0.8, 1.2)), uniform):
            assert power(patch, *band) == pytest.approx(usual, rel=0.4)


@pytest.mark.parametrize("method", ["poisson-disk", "mask"])
def test_density_is_stretched_over_the_square(method):
    """An image four times as wide as high, white but for a black corner."""
    density = np.ones((50, 200))
    density[:25, :50] = 0
    found = bluenoise.points(2000, method=method, seed=1, density=density) * (200, 50)
    assert not ((found < (50, 25)).all(1)).any()
    inner = found[(found[:, 0] >= 100)] - (100, 0)
    assert len(inner) == pytest.approx(2000 * 5000 / 8750, rel=0.03)
    # The points are as evenly spread along x as along y.
    apart = np.abs(inner[:, None] - inner)
    apart[np.hypot(*apart.T) == 0] = np.inf
    for axis in range(2):
        aligned = apart[..., axis][apart[..., 1 - axis] < 0.2 * apart[..., axis]]
        assert aligned.min() > (0.6 if method == "poisson-disk" else 0.3) * np.sqrt(5000 / len(inner))


def test_expected_counts_and_prefixes():
    density = np.full((5, 7), 0.35)
    counts = [len(bluenoise.points(density=density, method="mask", seed=seed)) for seed in range(200)]
    assert set(counts) == {12, 13} and abs(np.mean(counts) - 12.25) < 0.13  # four standard errors
    ramp = np.linspace(0, 1, 256)[None] ** 2
    whole, part = (bluenoise.points(n, method="mask", mask=white((64, 64), seed=3), density=ramp) for n in (700, 200))
    np.testing.assert_array_equal(whole[:200], part)


def test_density_in_three_dimensions():
    density = np.ones((4, 2, 2))
    density[2:] = 3
    for method in ("poisson-disk", "mask"):
        found = bluenoise.points(2000, method=method, dims=3, density=density, seed=1)
        assert (found[:, 2] >= 0.5).mean() == pytest.approx(0.75, abs=0.02)
        assert abs((found[:, :2] >= 0.5).mean() - 0.5) < 0.02


@pytest.mark.parametrize("dims", [2, 3])
@pytest.mark.parametrize("method", ["best-candidate", "mask"])
def test_smaller_sets_are_prefixes_of_larger_ones(method, dims):
    options = {"mask": bluenoise.void_and_cluster((40, 50, 3)[:dims], seed=2)} if method == "mask" else {}
    options["dims"] = dims
    whole = bluenoise.points(150, method=method, seed=5, **options)
    np.testing.assert_array_equal(bluenoise.points(60, method=method, seed=5, **options), whole[:60])


def test_mask_points_lie_in_the_lowest_ranked_texels():
    mask = white((10, 20), seed=1)
    for jitter in (False, True):
        found = bluenoise.points(30, method="mask", mask=mask, jitter=jitter, seed=1)
        x, y = np.floor(found * (20, 10)).astype(int).T
        np.testing.assert_array_equal(mask[y, x], np.arange(30))
    centres = bluenoise.points(200, method="mask", mask=mask, jitter=False)
    assert np.allclose(centres * (20, 10) % 1, 0.5)


@pytest.mark.parametrize("dims", [2, 3])
def test_best_candidates_match_brute_force(dims):
    """Repeats the definition without a grid or tree."""
    found = bluenoise.points(150, seed=7, candidates=3, dims=dims)
    sampler = bluenoise.Sampler("white", seed=7)
    for k in range(1, 150):
        trials = sampler.block(k, 0, 1, 1, 0, 3 * k)[0, 0, :, :dims].astype(float)
        apart = np.abs(trials[:, None] - found[:k])
        nearest = (np.minimum(apart, 1 - apart) ** 2).sum(2).min(1)
        np.testing.assert_array_equal(found[k], trials[nearest.argmax()])


@pytest.mark.parametrize("method", METHODS)
def test_progress(method):
    found, fractions = progress_of(lambda progress: bluenoise.points(300, method=method, seed=2, progress=progress), cancel_at=1e-9)
    assert len(fractions) > 2
    np.testing.assert_array_equal(found, bluenoise.points(300, method=method, seed=2))


@pytest.mark.parametrize("method", ["best-candidate", "poisson-disk"])
def test_missing_scipy_error_says_what_to_install(method, monkeypatch):
    monkeypatch.setitem(sys.modules, "scipy.spatial", None)
    with pytest.raises(ImportError, match=f"{method}.* pip install scipy"):
        bluenoise.points(4, method=method)
    assert bluenoise.points(4, method="mask").shape == (4, 2)
