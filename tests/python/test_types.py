# SPDX-License-Identifier: Apache-2.0
"""The type annotations that editors and type checkers use: literal types for names, typed options and typed results."""

import inspect
import typing
from pathlib import Path

import pytest

import bluenoise
from bluenoise import _core, _points

ROOT = Path(__file__).resolve().parents[2]

PROGRAM = '''
import numpy as np
import numpy.typing as npt
import bluenoise
from typing_extensions import assert_type

bluenoise.void_and_cluster((8, 8), sigma=1.9, initial_fraction=0.2, seed=None)
bluenoise.relax((8,), threads=1, seed=np.random.default_rng())
bluenoise.anneal((8, 8), channels=3, sweeps=1)
assert_type(bluenoise.points(8, method="mask", jitter=False), npt.NDArray[np.float64])
bluenoise.points(8, candidates=2)
bluenoise.neural((8, 8), model=b"", progress=print)
assert_type(bluenoise.mask((8, 8), channels=2), npt.NDArray[np.uint32])
found = bluenoise.measure(np.zeros((8, 8)))
assert_type(found.dithering_error[1], float)
assert_type(found.exact, bool)
assert_type(found.low_frequency, dict[float, float])
bluenoise.measure(np.zeros((8, 8)), progress=print)
keys = bluenoise.domain(np.arange(3))
assert_type(bluenoise.domain(1, 2), int)
bluenoise.Sampler().sample(1, 2, 3, pair=1)
ray = bluenoise.PathSampler(bluenoise.Sampler(), np.arange(3), 0, 0, stream=1).ray(0)
assert_type(ray.next_1d(), npt.NDArray[np.float32])
assert_type([branch for branch in ray.next_split(2)], list[bluenoise.PathSampler])
assert_type(ray.next_loop(), bluenoise.LoopSampler)
bluenoise.builtin((8, 8), out=np.zeros((8, 8), np.uint32))
assert_type(bluenoise.dither(np.zeros((8, 8), np.uint16)), npt.NDArray[np.uint16])
kind: bluenoise.SamplerType = bluenoise.Sampler("zorder", seed=None).type
'''

WRONG = '''
bluenoise.anneal((8, 8), sweep=3)
bluenoise.void_and_cluster((8, 8), sigma="1")
bluenoise.mask((8, 8), method="relax")
bluenoise.points(8, jitter=1.5)
bluenoise.Sampler("red")
bluenoise.Sampler().sample(1, 2, 3, pair=4)
bluenoise.PathSampler("blue", 0, 0, 0)
bluenoise.measure(np.zeros((8, 8))).e_3
'''


@pytest.mark.slow
def test_type_checker_accepts_valid_and_rejects_invalid_calls(tmp_path):
    api = pytest.importorskip("mypy.api")
    program = tmp_path / "program.py"
    program.write_text(PROGRAM + WRONG)
    options = [f"--cache-dir={ROOT / 'out/mypy'}", f"--config-file={ROOT / 'pyproject.toml'}"]
    out, _, _ = api.run([*options, str(ROOT / "bindings/bluenoise"), str(program)])
    first = PROGRAM.count("\n") + 2
    errors = [line.split(":") for line in out.splitlines() if ": error:" in line]
    assert all("program.py" in name for name, *_ in errors), out
    assert {int(line) for _, line, *_ in errors} == set(range(first, first + WRONG.count("\n") - 1)), out


def test_signature_lists_every_option():
    """Editors and IPython complete option names from inspect.signature."""
    parameters = inspect.signature(bluenoise.points).parameters
    assert all(value.kind is not value.VAR_KEYWORD and value.annotation != "Any" for value in parameters.values())
    for options in _points.METHODS.values():
        assert set(options) <= set(parameters)


def test_literals_match_the_implementation():
    assert set(typing.get_args(bluenoise.PointsMethod)) == set(_points.METHODS)
    assert set(typing.get_args(bluenoise.SamplerType)) == set(_core.sampler_types)
