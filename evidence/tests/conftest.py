# SPDX-License-Identifier: Apache-2.0
"""Makes evidence/ and scripts/ importable, and locates the path tracer."""

import os
import sys
from pathlib import Path

import pytest

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # as in scripts/bench; more threads would wait for each other
ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT), str(ROOT / "scripts")]


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch) -> Path:
    """An empty cache, and few parts of references, because the path tracer starts once per part."""
    from evidence.renders import renderer

    monkeypatch.setattr(renderer, "REFERENCE_PARTS", 4)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path / "cache" / "libbn"


@pytest.fixture
def bench(pathtracer, tmp_path):
    """Runs a part of scripts/bench in small crops of `penumbra`, with the report in tmp_path / "out"."""
    from evidence.__main__ import main

    return lambda part, *more: main([part, "--scenes", "penumbra", "--size", "64x64", "--crop", "17x16", "--spp", "4", "--seeds", "2", "--reference-spp", "64",
                                     "--out", str(tmp_path / "out"), "--pathtracer", str(pathtracer), *map(str, more)])


@pytest.fixture(scope="session")
def pathtracer() -> Path:
    program = Path(os.environ.get("BN_PATHTRACER", ROOT / "build" / "examples" / "pathtracer" / "pathtracer"))
    if not program.is_file():
        pytest.skip("the path tracer is not built; run scripts/setup or set BN_PATHTRACER")
    return program
