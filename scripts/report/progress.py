# SPDX-License-Identifier: Apache-2.0
"""How far a long run is: one line on a terminal, nothing in a pipe."""

import sys
import time


def duration(seconds):
    minutes = int(seconds + 0.5) // 60
    return f"{seconds:.0f} s" if minutes == 0 else f"{minutes} min {int(seconds + 0.5) % 60:02d} s"


class Progress:
    """Told what is done of `total` units, it shows the share, the rate and the time left.

    What was found from before costs no time and does not count in the rate: it is known by its being done at once,
    or from `found` where several things are done at the same time.
    """

    def __init__(self, total, unit="spp", stream=None):
        self.total, self.unit, self.stream = total, unit, stream or sys.stderr
        self.shown = self.stream.isatty()
        self.last_done, self.last_time = 0.0, time.monotonic()
        self.made, self.busy = 0.0, 0.0  # what was really made now, and its seconds

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
