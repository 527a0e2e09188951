# SPDX-License-Identifier: Apache-2.0
"""Shared fixtures: published reference masks, if available."""

import os
from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def reference_masks() -> Path:
    """A folder with published masks named peters_SIZE_N.png: BN_REFERENCE_MASKS, or one beside the checkout."""
    beside = Path(__file__).resolve().parents[3] / "shared" / "reference" / "masks"
    folder = Path(os.environ.get("BN_REFERENCE_MASKS", beside))
    if not folder.is_dir():
        pytest.skip("no published masks found; set BN_REFERENCE_MASKS to a folder that contains them")
    return folder
