# SPDX-License-Identifier: Apache-2.0
"""Makes evidence/ and scripts/ importable, and starts one browser for all tests."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT), str(ROOT / "scripts")]

from chromium import Browser, chromium  # noqa: E402


@pytest.fixture(scope="session")
def browser(tmp_path_factory):
    program = chromium()
    if program is None:
        pytest.skip("no Chromium; scripts/shaders installs it (or set BN_CHROMIUM)")
    subprocess.run([sys.executable, ROOT / "examples" / "web" / "package" / "make_texts.py"], check=True)
    browser = Browser(program, tmp_path_factory.mktemp("chromium"))
    yield browser
    browser.close()
