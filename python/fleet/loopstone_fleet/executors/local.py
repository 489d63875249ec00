"""Logs on this machine: a thread for each worker, which waits for one process after the other."""

from __future__ import annotations

import queue
import threading

from loopstone_fleet.executors import Place
from loopstone_fleet.job import Job, run_job
from loopstone_fleet.result_store import Row


class LocalExecutor:
    """Threads, since all work is done in the processes that they start."""

    def __init__(self, place: Place) -> None:
        self._workers = place.workers
        self._jobs: queue.SimpleQueue[Job | None] = queue.SimpleQueue()
        self._ends: queue.SimpleQueue[tuple[Job, Row]] = queue.SimpleQueue()
        self._threads = [
            threading.Thread(target=self._work, name=f"worker {number}", daemon=True)
            for number in range(place.workers)
        ]
        for thread in self._threads:
            thread.start()

    @property
    def workers(self) -> int:
        return self._workers

    def submit(self, job: Job) -> None:
        self._jobs.put(job)

    def next_end(self, timeout_s: float) -> tuple[Job, Row] | None:
        try:
            return self._ends.get(timeout=timeout_s)
        except queue.Empty:
            return None

    def close(self) -> None:
        try:
            while True:
                self._jobs.get_nowait()
        except queue.Empty:
            pass
        for _ in self._threads:
            self._jobs.put(None)
        for thread in self._threads:
            thread.join()

    def _work(self) -> None:
        while (job := self._jobs.get()) is not None:
            self._ends.put((job, run_job(job)))
