# SPDX-License-Identifier: Apache-2.0
"""Rejects subinterpreters, in which importing the extension would deadlock. NumPy only warns about them up to Python 3.11."""

import importlib


def refuse() -> None:
    """Raises ``ImportError`` in a subinterpreter."""
    for name in ("_interpreters", "_xxsubinterpreters"):  # from Python 3.13 on, and before
        try:
            interpreters = importlib.import_module(name)
        except ImportError:
            continue
        if interpreters.get_current() != interpreters.get_main():
            raise ImportError("bluenoise cannot be imported in a subinterpreter; use threads or processes")
        return
