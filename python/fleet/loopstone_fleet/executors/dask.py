"""Logs on Dask: a cluster that runs, or one of processes on this machine."""

from __future__ import annotations

import queue
import signal
import threading
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import dask.config
from distributed import Client, LocalCluster

from loopstone_fleet.errors import FleetError
from loopstone_fleet.executors import Place, Workers
from loopstone_fleet.job import Job, failed_row, run_job
from loopstone_fleet.result_store import Row

CONNECT_S = 10


class DaskExecutor:
    """One task a worker: what a worker of several threads takes, counts as so many workers."""

    def __init__(self, place: Place) -> None:
        self._cluster: Any = None
        if place.address:
            try:
                self._client = Client(place.address, timeout=CONNECT_S, set_as_default=False)
            except (OSError, ValueError) as error:
                raise FleetError(f"{place.address}: no Dask scheduler answers: {error}") from None
        else:
            self._cluster = _cluster_here(place.workers)
            self._client = Client(self._cluster, set_as_default=False)
        self._workers = Workers(lambda: sum(self._client.nthreads().values()))
        self._futures: dict[str, tuple[Any, Job]] = {}
        self._ends: queue.SimpleQueue[str] = queue.SimpleQueue()

    @property
    def workers(self) -> int:
        return self._workers.count()

    def submit(self, job: Job) -> None:
        # Not pure: the same log may have to be tried again.
        name = f"map-{job.entry.id}-{uuid.uuid4().hex[:8]}"
        try:
            future = self._client.submit(run_job, job, key=name, pure=False, retries=0)
        except Exception as error:
            raise FleetError(
                f"the Dask scheduler is gone ({error}); run again: what is done is skipped"
            ) from None
        self._futures[name] = (future, job)
        future.add_done_callback(lambda _: self._ends.put(name))

    def next_end(self, timeout_s: float) -> tuple[Job, Row] | None:
        try:
            name = self._ends.get(timeout=timeout_s)
        except queue.Empty:
            return None
        future, job = self._futures.pop(name)
        try:
            row: Row = future.result()
        except Exception as error:  # KilledWorker, CancelledError, what could not be sent
            text = str(error).splitlines()[0] if str(error) else ""
            return job, failed_row(job, f"{type(error).__name__}: {text}")
        return job, row

    def close(self) -> None:
        with dask.config.set({"distributed.comm.timeouts.connect": "5s"}):
            if self._futures:
                self._client.cancel([future for future, _ in self._futures.values()], force=True)
            self._client.close()
            if self._cluster is not None:
                self._cluster.close()


def _cluster_here(workers: int) -> Any:
    """Processes of this machine."""
    # A nanny that counts memory would end the worker for what its child holds: we do that.
    # A log that waits at a worker that dies is blamed with the one that runs there, so once is
    # forgiven; beyond, tries are counted here.
    with dask.config.set({"distributed.scheduler.allowed-failures": 1}), _ctrl_c_is_ours():
        return LocalCluster(
            n_workers=workers,
            threads_per_worker=1,
            processes=True,
            memory_limit=0,
            dashboard_address=None,
            host="127.0.0.1",
            silence_logs=50,
        )


@contextmanager
def _ctrl_c_is_ours() -> Iterator[None]:
    """Processes that are begun within do not end by Ctrl-C: they are told to."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
