# SPDX-License-Identifier: Apache-2.0
"""The programs behind scripts/bench samplers."""

import subprocess

import numpy as np
import pytest
from conftest import ROOT

from evidence.base import peers
from evidence.samplers import samplers, screen_space


@pytest.fixture
def program(pathtracer):
    folder = pathtracer.parents[2] / "evidence" / "programs"
    if not (folder / "bench_samplers").is_file():
        pytest.skip(f"no benchmarks in {folder}; run scripts/setup")
    return folder / "bench_samplers"


def test_every_figure_is_measured(program):
    rows = samplers.measure_all(program, ("sobol", "zorder", "blue"), (1, 2), 2)
    assert {row["figure"] for row in rows} == set(samplers.FIGURES) and {row["spp"] for row in rows} == {1, 2}
    for figure in samplers.FIGURES:
        # In the pixel blue is about as good as sobol, or a little better.
        assert 0.9 < samplers.ratios(rows, "blue", figure, 0.0)[2] < 1.03
        for name, most in (("blue", 0.8), ("zorder", 0.95)):
            blurred = samplers.ratios(rows, name, figure, 2.1)
            assert all(0.1 < ratio < most for ratio in blurred.values()), (figure, name)


def test_samples_are_uniform_and_differ(program, pathtracer):
    drawn = []
    for name in ("white", "sobol", "sobol4d", "zorder", *peers.listed(pathtracer)):
        for samples in screen_space.draws(program, name, 2):
            assert samples.min() >= 0 and samples.max() < 1
            # Of 2 * 16384 independent numbers the mean scatters by 0.0016; there are 16 domains and 6 places with 4 dimensions.
            np.testing.assert_allclose(samples.mean(axis=(2, 3, 4)), 0.5, atol=0.0075)
            drawn.append(samples[:2].tobytes())
    assert len(set(drawn)) == len(drawn)


@pytest.mark.parametrize(("words", "said"), [(["--openqmc"], "needs a folder"),
                                             (["--openqmc", "nowhere"], "nowhere/include/oqmc/oqmc.h does not exist")])
def test_bench_refuses_what_is_no_checkout(tmp_path, words, said):
    done = subprocess.run([ROOT / "scripts" / "bench", "samplers", *words], cwd=tmp_path, check=False,
                          capture_output=True, text=True)
    assert done.returncode == 1 and done.stdout == ""
    assert said in done.stderr and done.stderr.count("\n") == 1
