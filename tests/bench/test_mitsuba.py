# SPDX-License-Identifier: Apache-2.0
"""The comparison with Mitsuba's samplers: its table on figures made up, and a small run where Mitsuba is installed."""

import numpy as np
import pytest
from report.base.command import CommandError
from report.others import mitsuba as report


def test_the_table_divides_by_independent():
    text = report.table({("box", 4): {"independent": (0.4, 0.2), "stratified": (0.2, 0.1), "bluenoise": (0.1, 0.4)}})
    cells = [cell.strip() for cell in text.splitlines()[2].strip("|").split("|")]
    assert cells == ["box", "4", "2.00 (2.00)", "", "", "", "4.00 (0.50)"]


@pytest.fixture(scope="module")
def mitsuba():
    pytest.importorskip("mitsuba")
    pytest.importorskip("bluenoise")
    try:
        return report.load_mitsuba()
    except CommandError as error:
        pytest.skip(str(error))


def test_the_sampler_of_references_is_uniform(mitsuba):
    sampler = mitsuba.load_dict({"type": "reference"})
    pairs = []
    for seed in (1, 2):
        sampler.seed(seed, 40_000)
        pairs.append(np.concatenate([np.array(sampler.next_2d()).T, np.array(sampler.next_1d())[:, None]], 1))
    both = np.concatenate(pairs, 1)
    # 40,000 numbers: five standard deviations of the mean are 0.0072, of a correlation 0.025.
    assert both.min() >= 0 and both.max() < 1 and np.all(np.abs(both.mean(0) - 0.5) < 0.0072)
    assert np.all(np.abs(np.corrcoef(both.T) - np.eye(6)) < 0.025)


def test_a_small_run(mitsuba, tmp_path, capsys):
    guide = tmp_path / "guide.md"
    guide.write_text(f"<!-- table: {report.COMMAND} -->\n<!-- end of the table -->\n")
    report.run(["--size", "32", "--seeds", "3", "--reference-spp", "512", "--scenes", "0", "--guide", str(guide)])
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in capsys.readouterr().out.splitlines()[2:]]
    assert [row[1] for row in rows] == ["1", "4", "16"] and "bluenoise" in guide.read_text()
    # Four samples of a lamp's light: more than twice better, far from chance. ldsampler takes no single sample, orthogonal
    # neither 1 nor 16.
    assert float(rows[1][-1].split()[0]) > 1.2
    assert rows[0][4:6] == ["", ""] and rows[2][4] == "" and rows[1][5]


def test_every_scene_loads(mitsuba):
    for make in report.SCENES.values():
        scene, taken = report.with_sampler(mitsuba, make(mitsuba, 8), "bluenoise", 3)
        assert taken == 3 and np.isfinite(report.picture(mitsuba, scene, 1, 1)).all()
