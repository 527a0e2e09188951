# SPDX-License-Identifier: Apache-2.0
"""The lock files pin every package that scripts/requirements*.txt ask for, by version and hash, and name no host."""

import re
from pathlib import Path

import pytest

SCRIPTS = Path(__file__).resolve().parents[2] / "scripts"
LOCKS = {path.stem: path.read_text(encoding="utf-8") for path in SCRIPTS.glob("requirements*.lock")}


def canonical(names):
    return {re.sub(r"[-_.]+", "-", name).lower() for name in names}


@pytest.mark.parametrize("name", LOCKS)
def test_the_lock_pins_what_is_asked_for(name):
    asked = re.findall(r"^([\w.-]+)", (SCRIPTS / f"{name}.txt").read_text(encoding="utf-8"), re.M)
    pinned = re.findall(r"^([\w.-]+)==\S+.* --hash=sha256:[0-9a-f]{64}\b", LOCKS[name], re.M)
    assert asked and canonical(asked) <= canonical(pinned)
    assert len(pinned) == len(re.findall(r"^[A-Za-z]", LOCKS[name], re.M)), "a package without a hash"
    assert not re.search(r"\w+://|^-", LOCKS[name], re.M)


def test_locks_pin_the_same_versions():
    pins = {pin for lock in LOCKS.values() for pin in re.findall(r"^([\w.-]+)==(\S+)", lock, re.M)}
    assert len(LOCKS) == 3 and len(pins) == len({name for name, _ in pins})
