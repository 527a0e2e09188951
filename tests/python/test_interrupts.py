# SPDX-License-Identifier: Apache-2.0
"""Ctrl-C interrupts long calls, and the process exits cleanly whatever its threads are doing."""

import signal

import numpy as np
import pytest
from helpers import assert_interrupted, run_python
from reference import white

import bluenoise
from bluenoise import _core


@pytest.mark.parametrize("work", [
    _core.power_spectrum, lambda ranks: _core.mask_error(ranks, 1.0), lambda ranks: bluenoise.mask(ranks.shape)])
def test_signals_interrupt_long_calls(work):
    """Signal handlers run during a call, so two signals are handled separately. If handlers ran only after the call, both signals would
    be handled together. A call that is not interrupted returns its result."""
    ranks = white((2048, 2048))
    assert_interrupted(lambda: work(ranks), signals=2)
    small = ranks[:200, :200].argsort(axis=None).reshape(200, 200).astype(np.uint32)
    assert np.isfinite(work(small)).all()


PROGRAM = """
import signal, sys, threading, time
import numpy as np
import bluenoise
signal.signal(signal.SIGINT, signal.default_int_handler)


class Late:
    def __del__(self, sleep=time.sleep):  # when Python exits and no longer grants the GIL to threads
        sleep(1.5)


late = Late()
ranks = np.random.default_rng(1).permutation(90000).reshape(300, 300)
threading.Thread(target=lambda: (time.sleep(0.2), signal.raise_signal(signal.SIGINT)), daemon=True).start()
while True:
    bluenoise.measure(ranks)
"""


def test_interrupted_program_exits_with_a_traceback():
    """No thread is still inside the library when Python exits; a thread inside it could abort the process."""
    done = run_python(PROGRAM)
    assert done.stderr.splitlines()[-1] == "KeyboardInterrupt" and "terminate" not in done.stderr
    assert done.returncode == -signal.SIGINT, done.stderr


def test_import_keeps_signal_handlers():
    check = ("import signal, sys\nsys.argv = ['bluenoise']\nsignal.signal(signal.SIGINT, print)\n"
             "import bluenoise, bluenoise._cli\nassert signal.getsignal(signal.SIGINT) is print\n")
    assert run_python(check).returncode == 0
