# SPDX-License-Identifier: Apache-2.0
"""Ctrl-C during long work that has no progress callback."""

from __future__ import annotations

import threading
from typing import Any, Callable, TypeVar

_T = TypeVar("_T")
_SECONDS = 0.1  # how often the main thread wakes up for signals


def interruptible(work: Callable[..., _T], *arguments: Any) -> _T:
    """Returns work(*arguments). In the main thread, Ctrl-C interrupts the wait; the work then ends in the background."""
    if threading.current_thread() is not threading.main_thread():
        return work(*arguments)  # only the main thread receives signals
    results: list[_T] = []
    errors: list[BaseException] = []

    def run() -> None:
        try:
            results.append(work(*arguments))
        except BaseException as error:
            errors.append(error)

    thread = threading.Thread(target=run, name="bluenoise", daemon=True)
    thread.start()
    while thread.is_alive():
        thread.join(_SECONDS)
    if errors:
        try:
            raise errors[0]
        finally:
            errors.clear()  # the traceback refers to this frame
    return results[0]
