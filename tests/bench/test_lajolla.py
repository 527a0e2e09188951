# SPDX-License-Identifier: Apache-2.0
"""The comparison in lajolla: what is changed in a scene, and what the table divides."""

import numpy as np
import pytest
from report import lajolla

SCENE = '<integer name="sampleCount" value="4"/><integer name="width" value="512"/><integer name="height" value="384"/>'


def test_a_scene_is_copied_beside_itself(tmp_path):
    source = tmp_path / "scene.xml"
    source.write_text(SCENE)
    copy = lajolla.write_scene(source, 96, 16)
    assert copy.parent == tmp_path and copy.read_text() == SCENE.replace("512", "96").replace("384", "96").replace('"4"', '"16"')
    assert source.read_text() == SCENE


def test_a_scene_without_a_count_is_refused(tmp_path):
    (tmp_path / "scene.xml").write_text(SCENE.replace("sampleCount", "samples"))
    with pytest.raises(SystemExit, match="sampleCount"):
        lajolla.write_scene(tmp_path / "scene.xml", 96, 16)


def test_the_table_divides():
    text = lajolla.table({("box", 4): {None: np.array([0.8, 0.6]), "sobol": np.array([0.4, 0.6]), "blue": np.array([0.2, 0.2])}})
    assert text.splitlines()[2] == "| box | 4 | 2.00 (1.00) | 4.00 (3.00) | 2.00 (3.00) |"
