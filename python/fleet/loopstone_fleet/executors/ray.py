"""Logs on Ray: a cluster that runs, or one on this machine."""

from __future__ import annotations

import os
import signal
import threading
from typing import Any

os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")  # nothing is told to anybody

import ray

from loopstone_fleet.errors import FleetError
from loopstone_fleet.executors import Place, Workers
from loopstone_fleet.job import Job, failed_row, run_job
from loopstone_fleet.result_store import Row


class RayExecutor:
    """A log takes one processor and the memory that it is allowed."""

    def __init__(self, place: Place) -> None:
        options: dict[str, Any] = {"log_to_driver": False, "logging_level": "ERROR"}
        if place.address:
            options["address"] = place.address
        else:
            options |= {"num_cpus": place.workers, "include_dashboard": False}
            # What workers hold is limited log by log, so that all of it is promised here.
            options["_memory"] = place.workers * place.max_memory_bytes
            options["object_store_memory"] = 100 << 20
        terminated = signal.getsignal(signal.SIGTERM)
        try:
            ray.init(**options)
        except Exception as error:
            raise FleetError(f"Ray cannot be used: {error}") from None
        if threading.current_thread() is threading.main_thread():
            signal.signal(signal.SIGTERM, terminated)  # Ray puts its own in place, which only ends
        self._workers = Workers(lambda: int(ray.cluster_resources().get("CPU", 1)))
        # Ray itself starts nothing anew: each try is counted, and ends in a row.
        task = ray.remote(run_job)
        self._task = task.options(num_cpus=1, max_retries=0, memory=place.max_memory_bytes)
        self._jobs: dict[Any, Job] = {}

    @property
    def workers(self) -> int:
        return self._workers.count()

    def submit(self, job: Job) -> None:
        self._jobs[self._task.remote(job)] = job

    def next_end(self, timeout_s: float) -> tuple[Job, Row] | None:
        ended, _ = ray.wait(list(self._jobs), num_returns=1, timeout=timeout_s)
        if not ended:
            return None
        job = self._jobs.pop(ended[0])
        try:
            row: Row = ray.get(ended[0])
        except Exception as error:  # WorkerCrashedError, NodeDiedError, OutOfMemoryError
            text = str(error).splitlines()[0] if str(error) else ""
            return job, failed_row(job, f"{type(error).__name__}: {text}")
        return job, row

    def close(self) -> None:
        for reference in self._jobs:
            ray.cancel(reference, force=False)
        if self._jobs:
            ray.wait(list(self._jobs), num_returns=len(self._jobs), timeout=5)
        ray.shutdown()
