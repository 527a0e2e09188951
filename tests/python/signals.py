# SPDX-License-Identifier: Apache-2.0
"""Signals during library calls."""

import signal

import pytest


def assert_interrupted(call, signals):
    """Signal handlers run one after another during a call, and the call ends when the last handler raises."""
    handled = []

    def handle(*_):
        handled.append(1)
        if len(handled) == signals:
            raise KeyboardInterrupt

    before = signal.signal(signal.SIGALRM, handle)
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.06, 0.06)
        with pytest.raises(KeyboardInterrupt):
            call()
            signal.setitimer(signal.ITIMER_REAL, 0)
        signal.setitimer(signal.ITIMER_REAL, 0)
    finally:
        signal.signal(signal.SIGALRM, before)
