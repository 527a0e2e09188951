# SPDX-License-Identifier: Apache-2.0
"""Adaptive sampling, --noise: where blocks stop, and that the images are right.

Statistical tests use fixed seeds; the rates stated are the chances of a false alarm had they been drawn anew.
"""

import numpy as np
import pytest
from pathtracer_driver import assert_same, read_exr, read_layers

SCENE = ["--scene", "penumbra", "--size", "45x37", "--max-depth", 1]
NOISE = ["--noise", 0.1, "--min-spp", 4, "--spp", 64]
BLOCK = 8


def displayed_error(layers, exposure=0.0):
    """As film.h defines it, of one block."""
    mean = np.stack([layers[c] for c in "RGB"]).astype(np.float64) * 2.0**exposure
    variance = np.stack([layers[f"variance.{c}"] for c in "RGB"]).astype(np.float64) * 4.0**exposure
    error = np.sqrt(variance / layers["count"])
    shown = (np.minimum(mean + 2 * error, 1) - np.minimum(mean - 2 * error, 1)) / 4
    return np.sqrt(np.mean(shown**2)) / (np.minimum(mean, 1).mean() + 0.02)


def blocks(layers):
    height, width = layers["count"].shape
    for y in range(0, height, BLOCK):
        for x in range(0, width, BLOCK):
            yield {name: values[y:y + BLOCK, x:x + BLOCK] for name, values in layers.items()}


@pytest.mark.parametrize(("exposure", "least"), [(0, 4), (-2, 4), (2, 8)])
def test_blocks_stop_where_the_error_is_below_the_level(pathtracer, exposure, least):
    """At powers of two from --min-spp on, the first at which it is, or at --spp."""
    options = [*NOISE, "--min-spp", least, "--exposure", exposure]
    layers = read_layers(pathtracer.render(*SCENE, *options))
    prefixes = {n: list(blocks(read_layers(pathtracer.render(*SCENE, "--spp", n)))) for n in (4, 8, 16, 32, 64)}
    counts = []
    for k, block in enumerate(blocks(layers)):
        count = int(block["count"].flat[0])
        assert (block["count"] == count).all()
        wanted = next((n for n in (4, 8, 16, 32) if n >= least and displayed_error(prefixes[n][k], exposure) < 0.1), 64)
        assert count == wanted, k
        assert_same(block, prefixes[count][k])  # the samples are those of a plain image
        counts.append(count)
    assert len(set(counts)) > 2 and (64 in counts or exposure)


def test_adaptive_layers_and_attributes(pathtracer):
    path = pathtracer.folder / "out.exr"
    done = pathtracer.success(*SCENE, *NOISE, "--exposure", 1, "-o", path)
    header, count = read_exr(path)[1], read_layers(path)["count"]
    most = int(count.max())
    assert header["spp"] == header["endSample"] == str(most) and most > 4 and header["min-spp"] == "4"
    assert header["noise"] == "0.1" and header["noise-exposure"] == "1"
    assert f"{count.min()} to {most} spp, {count.mean():.6g} on average" in done.stdout
    plain, level_0 = (pathtracer.render(*SCENE, "--spp", 9, *more) for more in ([], ["--noise", 0]))
    assert_same(read_layers(plain), read_layers(level_0))
    assert read_exr(plain)[1]["noise"] == read_exr(level_0)[1]["noise"] == "0"


def test_means_are_right(pathtracer):
    """Adaptive images against plain ones of other seeds, in dark and in bright pixels: Welch's z over 40 seeds below 4.5, a
    false alarm once in 70,000. With these spreads a bias of one percent of the light is found 99 times in 100."""
    common = ["--scene", "penumbra", "--size", "48x40", "--max-depth", 1]
    images = lambda first, *options: [pathtracer.image(*common, *options, "--seed", first + i) for i in range(40)]
    plain = images(100, "--spp", 16)
    mean = np.mean(plain, axis=0, dtype=np.float64)
    dark = mean.sum(axis=2) < np.median(mean.sum(axis=2))
    for sampler in ("white", "blue"):
        adaptive = images(0, "--noise", 0.25, "--min-spp", 4, "--spp", 64, "--sampler", sampler)
        for where in (dark, ~dark):
            a, b = ([float(picture[where].mean(dtype=np.float64)) for picture in pictures] for pictures in (adaptive, plain))
            spread = np.sqrt((np.var(a, ddof=1) + np.var(b, ddof=1)) / len(a))
            assert (4.5 + 2.33) * spread < 0.01 * np.mean(b), "too weak a test"
            assert abs(np.mean(a) - np.mean(b)) < 4.5 * spread
