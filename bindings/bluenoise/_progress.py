# SPDX-License-Identifier: Apache-2.0
"""Progress of work that is done in Python; the extension reports that of the library."""

from __future__ import annotations

from typing import Optional

from . import _core
from ._arguments import Progress


def report(progress: Optional[Progress], fraction: float) -> None:
    """Calls a callback, if there is one. Raises CancelledError if it returns a true value."""
    if progress is not None and progress(fraction):
        raise _core.CancelledError(f"progress asked to stop at {fraction:.3f}")
