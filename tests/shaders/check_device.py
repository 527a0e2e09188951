# SPDX-License-Identifier: Apache-2.0
"""Runs the cases from shader_cases on each GPU, through every driver that wgpu finds and through CUDA. Prints one line per driver: green if
all bits match the CPU's, otherwise red. The exit status is 1 if any line is red."""

import functools
import hashlib
import sys
import tempfile
from pathlib import Path

import devices
import numpy as np
from conftest import HERE, write_cases
from test_device_code import compile_with_nvrtc
from test_shaders import wgsl


def run_cuda(number, architecture, *given) -> bytes:
    return devices.run_cuda(compile_with_nvrtc((HERE / "draw.cu").read_bytes(), architecture, "CUBIN"), *given, number)


def found():
    """Yields (name, run) for each GPU and driver. `run` is a function of devices.py with its code already bound."""
    import wgpu

    for adapter in wgpu.gpu.enumerate_adapters_sync():
        way = adapter.info["backend_type"] + (", in software" if adapter.info["adapter_type"] == "CPU" else "")
        yield f"{adapter.info['device']} ({way})", functools.partial(devices.run_wgpu, wgsl(), adapter=adapter)
    for number, name, architecture in devices.cuda_devices():
        yield f"{name} (CUDA, {architecture})", functools.partial(run_cuda, number, architecture)


def verdict(run, cases) -> tuple:
    """Returns whether all bits are correct, and a sentence that states the result."""
    buffers = [cases.words.tobytes(), cases.cdf.tobytes()]
    drawn = b"".join(run([*buffers, asked.tobytes()], asked.nbytes, len(asked)) for asked in cases.asked)
    own, wanted = (hashlib.sha256(words).hexdigest()[:8] for words in (drawn, cases.expected.tobytes()))
    if own == wanted:
        return True, f"all bits match the CPU's (hash {own})"
    wrong = np.any(np.frombuffer(drawn, "<u4").reshape(cases.expected.shape) != cases.expected, axis=2)
    return False, f"bits differ from the CPU's in {wrong.sum():,} of {wrong.size:,} cases (hash {own}, not {wanted})"


def main():
    with tempfile.TemporaryDirectory() as folder:
        cases = write_cases(Path(folder))
    results = []
    for name, run in found():
        try:
            right, text = verdict(run, cases)
        except Exception as error:  # if one driver fails, the next may work
            right, text = False, str(error)
        results.append(right)
        colours = (f"\x1b[{32 if right else 31}m", "\x1b[0m") if sys.stdout.isatty() else ("", "")
        print(f"{name}: {text}".join(colours), flush=True)
    return int(not all(results)) if results else "shaders: found no driver; install your GPU's driver"


if __name__ == "__main__":
    sys.exit(main())
