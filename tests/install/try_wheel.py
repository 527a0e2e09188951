# SPDX-License-Identifier: Apache-2.0
"""Tries the installed bluenoise package as a user with only NumPy would: python try_wheel.py [--neural].

Prints one line and exits with status 0, or stops at the first error. --neural requires ONNX Runtime."""

import importlib.metadata
import json
import subprocess
import sys
import sysconfig
import tempfile
from pathlib import Path

import numpy as np

import bluenoise

ROOT = Path(__file__).resolve().parents[2]
NOT_BLUE = 0.06  # white noise has an e_1 of 0.115


def check(condition, what):
    if not condition:
        sys.exit(f"try_wheel: {what}")


def try_package():
    installed = Path(bluenoise.__file__).resolve().parent
    check(ROOT / "bindings" not in installed.parents, f"{installed} is the checkout, not an installed package")
    for name in ("py.typed", "_core.pyi"):
        check((installed / name).is_file(), f"{name} is missing")
    notices = [file for file in importlib.metadata.files("libbn") if file.name in ("LICENSE", "THIRD-PARTY.md")]
    check(len(notices) == 3, f"expected two licences and the third-party notices, not {notices}")
    check(bluenoise.__version__ == importlib.metadata.version("libbn"), "the package and its metadata have different versions")


def try_draws():
    sampler = bluenoise.Sampler("blue", seed=1)
    domain = bluenoise.domain(2)
    u = sampler.block(5, 6, 8, 4, 0, 16, domain)
    check(u.shape == (4, 8, 16, 4) and u.dtype == np.float32, f"a block has shape {u.shape} and type {u.dtype}")
    strata = np.sort((u * 16).astype(int), axis=2)
    check((strata == np.arange(16)[None, None, :, None]).all(), "not every sixteenth of [0, 1) contains one of a pixel's 16 samples")
    single = sampler.sample(6, 8, 3, domain)
    check((single == u[2, 1, 3]).all(), "a single draw differs from the block")


def try_masks():
    mask = bluenoise.mask((32, 32), seed=3)
    check((np.sort(mask, axis=None) == np.arange(1024)).all(), "a rank is missing")
    error = bluenoise.dithering_error(mask)
    check(error < NOT_BLUE, f"the dithering error is {error}: not blue")
    grey = bluenoise.dither(np.full((32, 32), 0.25), 2, mask=mask)
    check(abs(grey.mean() - 0.25) < 1e-3, f"a quarter is dithered to {grey.mean()}")


def try_command():
    scripts = Path(sysconfig.get_path("scripts"))
    command = next(iter(scripts.glob("bluenoise*")), None)
    check(command is not None, f"{scripts} contains no bluenoise command")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "mask.npy")
        subprocess.run([str(command), "mask", "--size", "32", "--seed", "3", "-o", str(path)], check=True)
        check((np.load(path) == bluenoise.mask((32, 32), seed=3)).all(), "the command generates a different mask")
        out = subprocess.run([str(command), "measure", "--json", str(path)], check=True, capture_output=True, text=True).stdout
        check(json.loads(out)["dithering_error"]["1.0"] < NOT_BLUE, f"the command measures a mask that is not blue: {out}")


def try_network():
    generator = bluenoise.NeuralGenerator()
    mask = generator.mask((48, 64), seed=3)
    check((np.sort(mask, axis=None) == np.arange(48 * 64)).all(), "a rank is missing from a neural mask")
    error = bluenoise.dithering_error(mask)
    check(error < NOT_BLUE, f"the dithering error is {error}: the neural mask is not blue")


if __name__ == "__main__":
    check(sys.argv[1:] in ([], ["--neural"]), __doc__)
    parts = [try_package, try_draws, try_masks, try_command] + ([try_network] if sys.argv[1:] else [])
    for part in parts:
        part()
    names = ", ".join(part.__name__[len("try_"):] for part in parts)
    print(f"bluenoise {bluenoise.__version__}, Python {sys.version.split()[0]}, NumPy {np.__version__}: {names}")
