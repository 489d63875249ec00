"""A run: every log is given to a worker, tried again where that may help, and ends with one row."""

from __future__ import annotations

import heapq
import time
from collections import Counter, deque
from collections.abc import Callable, Iterable, Iterator
from itertools import islice
from typing import NamedTuple

from loopstone_fleet.executors import Executor
from loopstone_fleet.job import STOPPED, Job, Settings
from loopstone_fleet.plan import Task
from loopstone_fleet.progress import Progress
from loopstone_fleet.result_store import ResultStore, Row
from loopstone_fleet.status import DONE, is_curable

LONGEST_PAUSE_S = 60.0
LOOK_EVERY_S = 0.2


class Retries(NamedTuple):
    """How often and when what may be cured is tried again."""

    most: int
    first_pause_s: float

    def pause_s(self, attempt: int) -> float:
        """After this try: twice as long each time."""
        return min(LONGEST_PAUSE_S, self.first_pause_s * 2.0 ** (attempt - 1))


class Run:
    """The books of one run."""

    def __init__(
        self,
        store: ResultStore,
        settings: Settings,
        executor: Executor,
        retries: Retries,
        progress: Progress,
        on_row: Callable[[], None] = lambda: None,
    ) -> None:
        self._store, self._settings, self._executor = store, settings, executor
        self._retries, self._progress, self._on_row = retries, progress, on_row
        self._tasks: Iterator[Task] = iter(())
        self._waiting: deque[tuple[Task, int]] = deque()
        self._delayed: list[tuple[float, int, Task, int]] = []
        self._running: dict[str, Task] = {}
        self._unwritten: list[Row] = []
        self._paused_until = 0.0
        self._refused = 0
        self.statuses: Counter[str] = Counter()

    def run(self, tasks: Iterable[Task]) -> None:
        """Until every task has its row. Tasks are taken as workers become free."""
        self._tasks = iter(tasks)
        while self._has_more() or self._delayed or self._running:
            self._give_out()
            ended = self._next_end()
            if ended is not None:
                self._take(*ended)
            self._write_again()
            self._progress.tell(len(self._running), self._reason())
        for _ in range(self._retries.most):
            if self._unwritten:
                time.sleep(self._retries.pause_s(1))
                self._write_again()

    @property
    def rows_lost(self) -> int:
        """Rows that no disk would take; the next run makes them from the results."""
        return len(self._unwritten)

    @property
    def worth_another_run(self) -> bool:
        return self.rows_lost > 0 or any(is_curable(status) for status in self.statuses)

    def _has_more(self) -> bool:
        """Whether one waits that may begin now."""
        if not self._waiting:
            self._waiting.extend((task, 1) for task in islice(self._tasks, 1))
        return bool(self._waiting)

    def _give_out(self) -> None:
        now = time.monotonic()
        while self._delayed and self._delayed[0][0] <= now:
            _, _, task, attempt = heapq.heappop(self._delayed)
            self._waiting.append((task, attempt))
        if now < self._paused_until:
            return
        while len(self._running) < self._executor.workers and self._has_more():
            task, attempt = self._waiting.popleft()
            self._running[task.entry.id] = task
            self._executor.submit(Job(task.entry, self._settings, attempt))

    def _next_end(self) -> tuple[Job, Row] | None:
        if self._running:
            return self._executor.next_end(LOOK_EVERY_S)
        until = self._delayed[0][0] if self._delayed else self._paused_until
        time.sleep(min(LOOK_EVERY_S, max(0.0, until - time.monotonic())))
        return None

    def _take(self, job: Job, row: Row) -> None:
        task = self._running.pop(job.entry.id)
        status = row["status"]
        if status == STOPPED:
            return
        if is_curable(status) and job.attempt <= self._retries.most:
            self._put_off(task, job.attempt, status)
            return
        row["log_stamp"] = task.stamp
        self.statuses[status] += 1
        if status == DONE:
            self._progress.done += 1
        else:
            self._progress.failed += 1
            self._progress.say(f"{row['log']}: {status}: {row['reason']}")
        self._unwritten.append(row)

    def _put_off(self, task: Task, attempt: int, status: str) -> None:
        at = time.monotonic() + self._retries.pause_s(attempt)
        if status == "disk_full":
            # Whatever else began now would meet the same; time is what it takes.
            self._paused_until = max(self._paused_until, at)
        heapq.heappush(self._delayed, (at, task.entry.line, task, attempt + 1))

    def _write_again(self) -> None:
        """Rows wait in memory where the disk takes none, and for some time work with them."""
        kept: list[Row] = []
        for row in self._unwritten:
            try:
                self._store.write_row(row)
                self._refused = 0
                self._on_row()
            except OSError:
                kept.append(row)
        self._unwritten = kept
        now = time.monotonic()
        if kept and now >= self._paused_until and self._refused < self._retries.most:
            self._refused += 1
            self._paused_until = now + self._retries.pause_s(self._refused)

    def _reason(self) -> str:
        if time.monotonic() < self._paused_until:
            return "waiting for space on the disk"
        return f"{len(self._delayed)} to be tried again" if self._delayed else ""
