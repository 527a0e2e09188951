# SPDX-License-Identifier: Apache-2.0
"""Ctrl-C during the imports of the command, of which NumPy's take longest."""

from __future__ import annotations

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
