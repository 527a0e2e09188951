# SPDX-License-Identifier: Apache-2.0
"""What the tests share: the yardstick masks where they are at hand."""

import os
from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def reference_masks() -> Path:
    """A folder of published masks named peters_SIZE_N.png: BN_REFERENCE_MASKS, or one beside the checkout."""
    beside = Path(__file__).resolve().parents[3] / "shared" / "reference" / "masks"
    folder = Path(os.environ.get("BN_REFERENCE_MASKS", beside))
    if not folder.is_dir():
        pytest.skip("no published masks at hand; set BN_REFERENCE_MASKS to a folder of them")
    return folder
