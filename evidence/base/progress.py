# SPDX-License-Identifier: Apache-2.0
"""Shows the progress of a long run: one line on a terminal, nothing in a pipe."""

from concurrent.futures import ThreadPoolExecutor, as_completed

from tqdm import tqdm


class Progress(tqdm):
    """Shows how many of `total` units are done, the rate and the time left; `found` of them were in the cache."""

    def __init__(self, total, unit="spp", found=0):
        super().__init__(total=total, unit=f" {unit}", unit_scale=True, initial=found, disable=None, leave=False)

    def __call__(self, what, done):
        self.set_description(what, refresh=False)
        self.update(done - self.n)


def in_parallel(jobs, make, items):
    """Yields (item, make(item)) pairs as they finish, running `jobs` at a time. After an error or an interrupt, starts no further item."""
    pool = ThreadPoolExecutor(jobs)
    try:
        running = {pool.submit(make, item): item for item in items}
        for future in as_completed(running):
            yield running[future], future.result()
    finally:
        pool.shutdown(cancel_futures=True)
