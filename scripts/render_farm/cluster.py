# SPDX-License-Identifier: Apache-2.0
"""The Dask cluster. All calls to distributed are here."""

import asyncio
import contextlib
import logging
import platform
import queue
import signal
import time
import uuid

from . import worker
from .parts import FarmError

TIMEOUT = 30  # seconds to wait for a scheduler, and for its first worker
ATTEMPTS = 3  # attempts per part: its worker may die or fail


class Sent:
    """A function of worker.py, pickled by value, so that schedulers and workers do not need this folder."""

    def __init__(self, function):
        self.function = function

    def __call__(self, *arguments):
        return self.function(*arguments)

    def __reduce__(self):
        import cloudpickle

        return cloudpickle.loads, (cloudpickle.dumps(self.function),)


def _quiet():
    """Silences Dask, which would log every lost connection; this program reports errors in one line."""
    for name in ("distributed", "tornado", "asyncio"):
        logging.getLogger(name).setLevel(logging.CRITICAL + 1)


@contextlib.contextmanager
def connect(address, workers, threads=1):
    """A client of the cluster at `address`, or of a local cluster with the given number of processes: by default, one for each
    `threads` CPUs that this process may use."""
    try:
        import cloudpickle
        import dask
        import distributed
    except ImportError as error:
        raise FarmError(f"{error.name} is not installed; run scripts/farm, which installs it") from None
    # Needed by Sent.
    cloudpickle.register_pickle_by_value(worker)
    dask.config.set({"distributed.scheduler.allowed-failures": ATTEMPTS, "distributed.comm.timeouts.connect": TIMEOUT})
    _quiet()
    with contextlib.ExitStack() as stack:
        if not address:
            # Processes started now ignore Ctrl-C; this process handles it and ends them.
            before = signal.signal(signal.SIGINT, signal.SIG_IGN)
            try:
                address = stack.enter_context(distributed.LocalCluster(
                    n_workers=workers or max(1, dask.system.CPU_COUNT // threads), threads_per_worker=1,
                    dashboard_address=None, security=True, silence_logs=logging.CRITICAL + 1))
            finally:
                signal.signal(signal.SIGINT, before)
        try:
            client = stack.enter_context(distributed.Client(address, timeout=TIMEOUT))
        except (OSError, ValueError) as error:
            raise FarmError(f"no scheduler answers at {address} ({type(error).__name__}); start one with dask scheduler") from None
        _quiet()
        try:
            client.wait_for_workers(1, timeout=TIMEOUT)
        except TimeoutError:
            raise FarmError(f"the scheduler at {address} has no workers; start some with dask worker {address}") from None
        yield client


def workers(client):
    """The addresses of the workers."""
    return set(client.scheduler_info(n_workers=-1)["workers"])


def check_workers(client, program, wanted, inputs):
    """Raises FarmError unless all workers have the same Python, Dask, program and files as this machine."""
    versions = client.get_versions()
    here = versions["client"]
    for address, there in versions["workers"].items():
        for what, of in [("Python", lambda v: ".".join(v["host"]["python"].split(".")[:2])),
                         ("distributed", lambda v: v["packages"]["distributed"])]:
            if of(there) != of(here):
                raise FarmError(f"worker {address} has {what} {of(there)}, but this is {of(here)}; install the same there")
    complaints = client.run(Sent(worker.complaint), program, wanted, inputs)
    for address, complaint in complaints.items():
        if complaint:
            raise FarmError(f"worker {address}: {complaint}; copy it from {platform.node() or 'this machine'}, to the same path or to "
                            "where BN_PATHTRACER of the worker leads")


def render(client, program, wanted, inputs, tasks):
    """Yields (part, bytes of its EXR) for tasks = {part: arguments}, in order of completion. Also yields (None, None) after each
    second without a result, and (address, None) for each lost worker, whose tasks run elsewhere."""
    from distributed.scheduler import KilledWorker

    results, run = queue.SimpleQueue(), uuid.uuid4().hex
    futures = {}
    for part, arguments in tasks.items():
        future = client.submit(Sent(worker.render), program, wanted, inputs, arguments, key=f"{part.file_name}-{run}", pure=False,
                               retries=ATTEMPTS - 1)
        futures[future.key] = part, future
        future.add_done_callback(results.put)
    known, looked = workers(client), time.monotonic()
    while futures:
        if time.monotonic() - looked > 1:
            now = workers(client)
            yield from ((address, None) for address in sorted(known - now))
            known, looked = now, time.monotonic()
        try:
            future = results.get(timeout=1)
        except queue.Empty:
            yield None, None
            continue
        # Without a reference to the future, the cluster would drop its result.
        part, _ = futures.pop(future.key)
        try:
            data = future.result()
        except worker.WorkerError as error:
            raise FarmError(f"part {part.file_name} failed on a worker: {error}") from None
        except KilledWorker:
            raise FarmError(f"part {part.file_name} failed: {ATTEMPTS} workers died with it (out of memory?)") from None
        except (Exception, asyncio.CancelledError) as error:  # an error from Dask, for example because the scheduler is gone
            reason = str(error).partition("\n")[0] or type(error).__name__
            raise FarmError(f"part {part.file_name} was lost: {reason}") from None
        yield part, data
