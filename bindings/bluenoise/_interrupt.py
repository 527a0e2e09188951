# SPDX-License-Identifier: Apache-2.0
"""What comes before the imports: Ctrl-C during those of the command, of which NumPy's take longest, and interpreters that cannot
import the extension."""

from __future__ import annotations

import importlib
import os
import signal
import sys
import threading
from typing import Callable


def quiet_imports() -> Callable[[], object]:
    """If this is the command, lets Ctrl-C end the process without a traceback, until the returned function is called. While
    ``python -m`` imports a package, the program's name is ``-m``."""
    program = (getattr(sys, "argv", None) or [""])[0]
    main = os.path.join(os.path.dirname(__file__), "__main__.py")
    command = os.path.basename(program) in ("-m", "bluenoise", "bluenoise.exe") or program == main
    usual = signal.getsignal(signal.SIGINT) is signal.default_int_handler
    if not (command and usual and threading.current_thread() is threading.main_thread()):
        return lambda: None
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return lambda: signal.signal(signal.SIGINT, signal.default_int_handler)


def refuse_subinterpreters() -> None:
    """Raises ``ImportError`` in one, where the extension would wait for itself for ever."""
    for name in ("_interpreters", "_xxsubinterpreters"):  # from Python 3.13 on, and before
        try:
            interpreters = importlib.import_module(name)
        except ImportError:
            continue
        if interpreters.get_current() != interpreters.get_main():
            raise ImportError("bluenoise cannot be imported in a subinterpreter; use threads or processes")
        return
