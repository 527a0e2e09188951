# SPDX-License-Identifier: Apache-2.0
"""The lock files pin every package that scripts/requirements*.txt ask for, by version and hash, and name no host."""

import re
from pathlib import Path

import pytest

SCRIPTS = Path(__file__).resolve().parents[2] / "scripts"
LOCKS = {path.stem: path.read_text(encoding="utf-8") for path in SCRIPTS.glob("requirements*.lock")}


@pytest.mark.parametrize("name", LOCKS)
def test_the_lock_pins_what_is_asked_for(name):
    asked, pinned = (set(re.sub(r"[-_.]+", "-", "\n".join(re.findall(pattern, text, re.M))).lower().split()) for pattern, text in (
        (r"^([\w.-]+)", (SCRIPTS / f"{name}.txt").read_text(encoding="utf-8")),
        (r"^([\w.-]+)==\S+.* --hash=sha256:[0-9a-f]{64}\b", LOCKS[name])))
    assert asked and asked <= pinned and len(pinned) == len(re.findall(r"^[A-Za-z]", LOCKS[name], re.M))
    assert not re.search(r"\w+://|^-", LOCKS[name], re.M)
