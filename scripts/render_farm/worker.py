# SPDX-License-Identifier: Apache-2.0
"""The functions that run on workers. Dask sends them with each task, so workers do not need this folder.

They use only the standard library and no other module of this package.
"""

import hashlib
import os
import re
import shutil
import subprocess
import tempfile


class WorkerError(Exception):
    """One line for the user."""


def program_here(program):
    """The path tracer on this machine: $BN_PATHTRACER, or the same path as on the client."""
    return os.environ.get("BN_PATHTRACER") or program


def _remembered(make, path):
    """Returns make(path), which is called once per worker and file version."""
    status = os.stat(path)
    try:
        from distributed import get_worker

        # Each task brings its own copies of these functions, but the worker persists.
        results = get_worker().__dict__.setdefault("_libbn_results", {})
    except (ImportError, ValueError):
        results = {}  # this code does not run in a task
    key = make.__name__, path, status.st_size, status.st_mtime_ns
    if key not in results:
        results[key] = make(path)
    return results[key]


def _sha256(path):
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _libraries(program):
    """The libraries of a program whose arithmetic affects its images."""
    try:
        listed = subprocess.run(["ldd", program], capture_output=True, text=True, check=False).stdout
    except OSError:
        return []  # not Linux
    return re.findall(r"=> (\S*/lib(?:embree|m\.)\S*)", listed)


def fingerprint(program, inputs):
    """SHA-256 hashes, by name, of the program, its arithmetic libraries and the files it reads."""
    program = program_here(program)
    found, path = {}, program
    try:
        found["the path tracer"] = _remembered(_sha256, path)
        for path in _remembered(_libraries, program):
            found[os.path.basename(path)] = _remembered(_sha256, path)
        for path in inputs:
            found[path] = _remembered(_sha256, path)
    except OSError as error:
        raise WorkerError(f"cannot read {path} ({error.strerror})") from None
    return found


def complaint(program, wanted, inputs):
    """How this machine's program, libraries and inputs differ from `wanted`, or an empty string."""
    try:
        found = fingerprint(program, inputs)
    except WorkerError as error:
        return str(error)
    for name in sorted(wanted.keys() | found.keys()):
        if found.get(name) != wanted.get(name):
            where = f" ({program_here(program)})" if name == "the path tracer" else ""
            return f"{name} is another file there" if name in inputs else f"another build of {name}{where} there"
    return ""


def render(program, wanted, inputs, arguments):
    """The bytes of the EXR that the path tracer renders with these arguments."""
    # A worker may have joined after the check.
    if wrong := complaint(program, wanted, inputs):
        raise WorkerError(wrong)
    with tempfile.TemporaryDirectory(prefix="libbn-") as folder:
        output = os.path.join(folder, "part.exr")
        command = [program_here(program), *arguments, "--quiet", "-o", output]
        # On Linux, the program exits if its worker is killed.
        if setpriv := shutil.which("setpriv"):
            command = [setpriv, "--pdeathsig", "KILL", *command]
        # In its own session, so that Ctrl-C in the worker's terminal does not interrupt a part.
        done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False,
                              start_new_session=True)
        if done.returncode:
            said = done.stderr.strip().removeprefix("pathtracer: ")
            raise WorkerError(said or f"the path tracer failed with exit status {done.returncode}")
        with open(output, "rb") as file:
            return file.read()
