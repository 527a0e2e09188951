# SPDX-License-Identifier: Apache-2.0
"""Ctrl-C during work without a progress callback: the caller does not wait for the end of the work."""

import signal
import threading

import numpy as np
import pytest

import bluenoise
from bluenoise._interrupt import interruptible

RANKS = np.arange(700 * 701, dtype=np.uint32).reshape(700, 701)


@pytest.fixture
def interrupts():
    # A process started in the background of a script ignores interrupts until it is told not to.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.parametrize("work", [bluenoise.power_spectrum, bluenoise.measure, bluenoise.radial_power,
                                  lambda ranks: bluenoise.anisotropy([ranks] * 4)])
def test_measures_are_left_at_once(work, interrupts, monkeypatch):
    """Replacements for the C functions return only after the interrupt, so the test does not depend on timing."""
    arrived = threading.Event()

    def slow(ranks, *sigma):
        assert threading.current_thread() is not threading.main_thread(), "a C function would keep Ctrl-C waiting here"
        signal.pthread_kill(threading.main_thread().ident, signal.SIGINT)
        assert arrived.wait(60), "the caller waited for the end of the work"
        raise ValueError("the work ends in the background")

    monkeypatch.setattr(bluenoise._core, "power_spectrum", slow)
    monkeypatch.setattr(bluenoise._core, "mask_error", slow)
    with pytest.raises(KeyboardInterrupt):
        work(RANKS)
    arrived.set()


def test_results_and_errors_come_through():
    before = set(threading.enumerate())
    assert interruptible(lambda a, b: a + b, 1, 2) == 3
    with pytest.raises(ZeroDivisionError):
        interruptible(lambda: 1 // 0)
    assert set(threading.enumerate()) <= before


def test_other_threads_work_in_place():
    names = []
    thread = threading.Thread(target=lambda: interruptible(lambda: names.append(threading.current_thread().name)))
    thread.start()
    thread.join()
    assert names == [thread.name]
