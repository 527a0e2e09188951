# SPDX-License-Identifier: Apache-2.0
"""References are rendered once and re-rendered if anything they depend on changes."""

import dataclasses
import os
import subprocess

import numpy as np
import pytest

from evidence.base.files import read_exr, written_beside
from evidence.renders import renderer
from evidence.renders.renderer import Request, make_reference, run_pathtracer

SMALL = Request("sobol", spp=8, seed=5, width=24, height=16, more=("--light-samples", "1"))


@pytest.fixture
def runs(monkeypatch):
    """Records the commands that are run."""
    commands = []
    real = subprocess.run

    def counted(command, **options):
        commands.append(command)
        return real(command, **options)

    monkeypatch.setattr(renderer.subprocess, "run", counted)
    return commands


@pytest.mark.parametrize(("spoil", "more"), [("image", 5), ("request", 5), ("output", 5), ("program", 1), ("nothing", 1)])
def test_reference_is_rerendered_only_if_its_image_may_differ(pathtracer, cache, tmp_path, runs, spoil, more):
    """A render takes one probe and four parts."""
    program, request = tmp_path / "pathtracer", SMALL
    program.write_text(f'#!/bin/sh\nexec {pathtracer} "$@"\n')
    program.chmod(0o755)
    make_reference(program, SMALL)
    assert len(runs) == 5
    if spoil == "image":
        (path,) = (cache / "references").iterdir()
        path.write_bytes(path.read_bytes()[:-1])
    elif spoil == "request":
        request = dataclasses.replace(SMALL, seed=6)
    elif spoil != "nothing":
        program.write_text(f'#!/bin/sh\n# new\nexec {pathtracer} "$@"{" --seed 77" * (spoil == "output")}\n')
    make_reference(program, request)
    assert len(runs) == 5 + more


def test_reference_matches_a_single_render_with_all_samples(pathtracer, tmp_path):
    merged, half, row = make_reference(pathtracer, SMALL)
    for picture, spp in ((merged, 8), (half, 4)):
        run_pathtracer(pathtracer, [*dataclasses.replace(SMALL, spp=spp).arguments(), "--quiet", "-o", tmp_path / "whole.exr"])
        whole, _ = read_exr(tmp_path / "whole.exr")
        np.testing.assert_allclose(picture, whole, rtol=1e-5, atol=1e-6)
    assert row["seconds"] > 0 and 0 < row["mean_error"] < 0.2 * merged.mean()


def test_temporary_files_are_private_and_synced_before_the_rename(tmp_path, monkeypatch):
    path, names, steps = tmp_path / "a.txt", [], []
    for call in ("fsync", "replace"):
        monkeypatch.setattr(os, call, lambda *given, call=call, real=getattr(os, call): (steps.append(call), real(*given)))
    for _ in range(2):
        with written_beside(path) as beside:
            assert beside.parent.stat().st_mode & 0o077 == 0, "other users could put a link there"
            names.append(beside)
            beside.write_text("new")
    assert names[0] != names[1] and steps == ["fsync", "replace"] * 2
    assert path.read_text() == "new" and list(tmp_path.iterdir()) == [path]
