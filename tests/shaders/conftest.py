# SPDX-License-Identifier: Apache-2.0
"""Generates the cases and skips tests whose tools are missing. scripts/shaders installs all tools and sets BN_SHADERS_REQUIRED."""

import ctypes.util
import importlib.util
import os
import shutil
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
HERE = ROOT / "tests" / "shaders"
INCLUDE = ROOT / "libbn" / "include"
sys.path.append(str(ROOT / "scripts"))  # for chromium.py
PACKAGE = ROOT / "examples" / "web" / "package"
GLSLANG = shutil.which("glslangValidator") or shutil.which("glslang")


def run(*command) -> str:
    """Runs a command and returns its output. If it fails, the error message is the whole output."""
    done = subprocess.run([str(part) for part in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          stdin=subprocess.DEVNULL, check=False)
    assert done.returncode == 0, f"{' '.join(map(str, command))}\n{done.stdout}"
    return done.stdout


def compile_text(folder, name: str, text: str, *options) -> None:
    """Compiles the text of a file as C or C++, depending on the file name."""
    (folder / name).write_text(text)
    compiler = [os.environ.get("CC", "cc"), "-std=c99"] if name.endswith(".c") else [os.environ.get("CXX", "c++"), "-std=c++17"]
    run(*compiler, "-Wall", "-Wextra", "-Werror", "-I", INCLUDE, *options, "-c", folder / name, "-o", folder / "out.o")


def need(there, what: str) -> None:
    """Skips a test if its tool is missing, or fails it if BN_SHADERS_REQUIRED is set."""
    if not there:
        reason = f"no {what}; scripts/shaders installs it"
        (pytest.fail if os.environ.get("BN_SHADERS_REQUIRED") else pytest.skip)(reason)


def need_module(name: str) -> None:
    need(importlib.util.find_spec(name), f"Python package {name}")


def need_wgpu() -> None:
    need_module("wgpu")
    import wgpu

    need(wgpu.gpu.enumerate_adapters_sync(), "Vulkan driver")


def need_opengl() -> None:
    need(ctypes.util.find_library("EGL"), "EGL")
    need_module("moderngl")


def write_cases(folder) -> SimpleNamespace:
    """Runs shader_cases. Returns its output folder and the files' contents as arrays, in which the cases have one row per seed."""
    program = ROOT / "build" / "tests" / "shaders" / "shader_cases"
    assert program.exists(), f"{program} is missing; run scripts/setup"
    run(program, folder)
    words, cdf, asked, expected = (np.fromfile(folder / f"{name}.bin", "<u4") for name in (
        "words", "cdf", "cases", "expected"))
    asked = asked.reshape(3, -1, 16)
    return SimpleNamespace(folder=folder, words=words, cdf=cdf, asked=asked,
                           expected=expected.reshape(asked.shape))


@pytest.fixture(scope="session")
def cases(tmp_path_factory):
    return write_cases(tmp_path_factory.mktemp("cases"))


@pytest.fixture(scope="session", autouse=True)
def texts():
    """The source distribution has no examples."""
    if PACKAGE.is_dir():
        run(sys.executable, PACKAGE / "make_texts.py")
