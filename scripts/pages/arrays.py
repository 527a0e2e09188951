# SPDX-License-Identifier: Apache-2.0
"""Times the draws of bluenoise.arrays on one CPU thread, writes the table of docs/arrays.md, and prints the error of a view rendered by
the page's first listing: .venv/bin/python scripts/pages/arrays.py. Needs PyTorch and JAX."""

import os
import re

os.environ["XLA_FLAGS"] = "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1"

import sys
import time
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import torch
from scipy.ndimage import gaussian_filter

import bluenoise
from bluenoise import arrays

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))
from evidence.base.tables import md_table, update_table

WIDTH, HEIGHT, COUNT = 512, 512, 4
sampler = bluenoise.Sampler("blue", seed=1)
y, x, index = (np.ascontiguousarray(a, np.int32) for a in np.mgrid[:HEIGHT, :WIDTH, :COUNT])


def nanoseconds(call):
    times = []
    for _ in range(5):
        begun = time.process_time()
        call()
        times.append((time.process_time() - begun) / (WIDTH * HEIGHT * COUNT) * 1e9)
    return f"{min(times):.0f}"


def on(xp, wrap=lambda draw: draw):
    given = [xp.asarray(a) for a in (x, y, index)]
    draw = wrap(lambda x, y, index: arrays.sample(xp, sampler, x, y, index))
    assert np.array_equal(np.asarray(draw(*given)), sampler.block(0, 0, WIDTH, HEIGHT, 0, COUNT))
    return lambda: np.asarray(draw(*given))


torch.set_num_threads(1)
rows = [["`Sampler.block`", nanoseconds(lambda: sampler.block(0, 0, WIDTH, HEIGHT, 0, COUNT))],
        ["`Sampler.sample`", nanoseconds(lambda: sampler.sample(x, y, index))],
        ["`arrays.sample`, NumPy", nanoseconds(on(np))],
        ["`arrays.sample`, PyTorch", nanoseconds(on(torch))],
        ["`arrays.sample`, PyTorch with `torch.compile`", nanoseconds(on(torch, torch.compile))],
        ["`arrays.sample`, JAX with `jax.jit`", nanoseconds(on(jnp, jax.jit))]]
table = md_table(["draws", "ns"], rows)
PAGE = ROOT / "docs" / "arrays.md"
update_table(PAGE, "scripts/pages/arrays.py", table)
print(table)

space = {}
exec(re.findall(r"^```python\n(.*?)^```", PAGE.read_text(encoding="utf-8"), re.M | re.S)[0], space)


def views(name, indices, seeds):
    with torch.no_grad():
        samplers = [bluenoise.Sampler(name, seed=seed) for seed in seeds]
        return [space["render"](space["truth"], 0.5, index, sampler).numpy() for sampler in samplers for index in indices]


reference = np.mean(views("blue", range(256), [99]), axis=0)
for name in ("white", "blue"):
    errors = [view - reference for view in views(name, [0], range(16))]
    blurred = [gaussian_filter(error, 2.1) for error in errors]
    print(f"view with {name}: error {np.sqrt(np.mean(np.square(errors))):.4f}, after a blur {np.sqrt(np.mean(np.square(blurred))):.4f}")
