# SPDX-License-Identifier: Apache-2.0
"""The lock files pin every package that scripts/requirements*.txt ask for, by version and hash, and name no host."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
requirements = pytest.importorskip("packaging.requirements")
utils = pytest.importorskip("packaging.utils")


def asked_for(text):
    lines = (line.split("#")[0].strip() for line in text.splitlines())
    return [requirements.Requirement(line) for line in lines if line]


def problems(asked, lock):
    blocks = re.split(r"^(?=[A-Za-z])", lock, flags=re.M)[1:]
    pinned, found = {}, []
    for block in blocks:
        name, version = re.match(r"([A-Za-z0-9._-]+)==(\S+)", block).groups()
        pinned[utils.canonicalize_name(name)] = version
        if not re.search(r"--hash=sha256:[0-9a-f]{64}\b", block):
            found.append(f"{name} has no hash")
    for requirement in asked:
        version = pinned.get(utils.canonicalize_name(requirement.name))
        if version is None:
            found.append(f"{requirement.name} is not locked")
        elif version not in requirement.specifier:
            found.append(f"{requirement.name} {version} is not in {requirement.specifier}")
    return found + [f"it names {match}" for match in re.findall(r"\w+://\S+|^-\S+.*$", lock, re.M)]


@pytest.mark.parametrize("name, least", [("requirements", 6), ("requirements-docs", 4), ("requirements-farm", 2)])
def test_the_lock_pins_what_is_asked_for(name, least):
    asked = asked_for((ROOT / f"scripts/{name}.txt").read_text(encoding="utf-8"))
    assert len(asked) >= least
    assert problems(asked, (ROOT / f"scripts/{name}.lock").read_text(encoding="utf-8")) == []


@pytest.mark.parametrize("one, other", [("requirements", "requirements-docs"), ("requirements", "requirements-farm"),
                                        ("requirements-docs", "requirements-farm")])
def test_two_locks_pin_the_same_versions(one, other):
    pins = [dict(re.findall(r"^([A-Za-z0-9._-]+)==(\S+)", (ROOT / f"scripts/{name}.lock").read_text(encoding="utf-8"), re.M))
            for name in (one, other)]
    shared = pins[0].keys() & pins[1].keys()
    assert shared and {name: pins[0][name] for name in shared} == {name: pins[1][name] for name in shared}


def test_torch_is_pinned_in_one_place():
    pin = re.compile(r"torch==\d")
    files = [path for pattern in ("*.toml", "scripts/*", "trainer/**/*.toml") for path in ROOT.glob(pattern) if path.is_file()]
    found = {path.relative_to(ROOT).as_posix() for path in files if pin.search(path.read_text(encoding="utf-8"))}
    assert found == {"trainer/pyproject.toml"}
