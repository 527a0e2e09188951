# SPDX-License-Identifier: Apache-2.0
"""Progress of a long run: one line on a terminal, nothing in a pipe."""

import sys
import time
from concurrent.futures import ThreadPoolExecutor, as_completed


def duration(seconds):
    minutes = int(seconds + 0.5) // 60
    if seconds < 9.95:
        return f"{seconds:.1f} s"
    return f"{seconds:.0f} s" if minutes == 0 else f"{minutes} min {int(seconds + 0.5) % 60:02d} s"


class Progress:
    """Shows the share done of `total` units, the rate and the time left.

    Results from the cache do not count towards the rate. They are recognised by taking no time, or by `found` where
    several things run at once.
    """

    def __init__(self, total, unit="spp", stream=None):
        self.total, self.unit, self.stream = total, unit, stream or sys.stderr
        self.shown = self.stream.isatty()
        self.last_done, self.last_time = 0.0, time.monotonic()
        self.made, self.busy = 0.0, 0.0  # units done in this run, and the seconds they took

    def __call__(self, what, done, found=None):
        now = time.monotonic()
        if found is False or found is None and now - self.last_time > 0.05:
            self.made += done - self.last_done
            self.busy += now - self.last_time
        self.last_done, self.last_time = done, now
        if self.shown:
            rate = self.made / self.busy if self.made and self.busy else 0
            left = f"{rate:.3g} {self.unit}/s, {duration((self.total - done) / rate)} left" if rate else ""
            print(f"\r{100 * done / self.total:5.1f} %  {what}  {left}\033[K", end="", file=self.stream, flush=True)

    def close(self):
        if self.shown:
            print("\r\033[K", end="", file=self.stream, flush=True)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()


def in_parallel(jobs, make, items):
    """Yields (item, make(item)) as they are done, `jobs` at a time. After an error or an interrupt, none begins that has not begun."""
    pool = ThreadPoolExecutor(jobs)
    try:
        running = {pool.submit(make, item): item for item in items}
        for future in as_completed(running):
            yield running[future], future.result()
    finally:
        pool.shutdown(cancel_futures=True)
