# SPDX-License-Identifier: Apache-2.0
"""FLIP as used in the reports."""

import numpy as np
import pytest

pytest.importorskip("flip_evaluator")

from report.measure.flip import mean_flip


def pictures():
    rng = np.random.default_rng(5)
    reference = np.full((32, 40, 3), 0.4) + 0.3 * rng.random((32, 40, 1))
    return reference, rng.standard_normal(reference.shape)


def test_identical_pictures_do_not_differ():
    reference, _ = pictures()
    assert mean_flip(reference, reference) == 0


def test_more_noise_is_more_difference():
    reference, noise = pictures()
    found = [mean_flip(reference + amount * noise, reference) for amount in (0.02, 0.1, 0.3)]
    assert 0 < found[0] < found[1] < found[2] < 1


def test_one_call_does_not_change_the_next():
    # The package keeps what it found out about the exposure of a reference in its arguments.
    reference, noise = pictures()
    alone = mean_flip(reference + 0.1 * noise, reference)
    mean_flip(500 * reference, 1000 * reference)
    assert mean_flip(reference + 0.1 * noise, reference) == alone


def test_other_shapes_are_refused():
    reference, _ = pictures()
    with pytest.raises(ValueError, match="shape"):
        mean_flip(reference[:-1], reference)
