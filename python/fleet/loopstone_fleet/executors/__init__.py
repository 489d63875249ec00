"""Where logs are mapped: on this machine, on Dask, on Ray. All of them take jobs and tell ends."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import NamedTuple, Protocol

from loopstone_fleet.errors import FleetError
from loopstone_fleet.job import Job
from loopstone_fleet.result_store import Row


ASKED_EVERY_S = 5.0


class Place(NamedTuple):
    """What is asked of an executor."""

    workers: int
    address: str
    """Of a cluster that runs; empty for one on this machine."""
    max_memory_bytes: int
    """Of one log."""


class Workers:
    """How many workers a cluster has, which come and go; at least one is hoped for."""

    def __init__(self, ask: Callable[[], int]) -> None:
        self._ask = ask
        self._count, self._asked = 1, float("-inf")

    def count(self) -> int:
        if time.monotonic() - self._asked > ASKED_EVERY_S:
            self._count = max(1, self._ask())
            self._asked = time.monotonic()
        return self._count


class Executor(Protocol):
    """Runs jobs. One thread talks to it."""

    @property
    def workers(self) -> int:
        """Logs that are mapped at the same time: so many are given at once, and no more."""

    def submit(self, job: Job) -> None:
        ...

    def next_end(self, timeout_s: float) -> tuple[Job, Row] | None:
        """A job that has ended with its row; None when none ends in this time.

        Where a worker was lost, the row says so.
        """

    def close(self) -> None:
        """Drops what waits, and ends once workers have seen the stop file or are done."""


def local_executor(place: Place) -> Executor:
    from loopstone_fleet.executors.local import LocalExecutor

    return LocalExecutor(place)


def dask_executor(place: Place) -> Executor:
    try:
        from loopstone_fleet.executors.dask import DaskExecutor
    except ImportError as error:
        raise FleetError(
            f"--executor dask needs Dask ({error}): install loopstone-fleet with its extra [dask]"
        ) from None
    return DaskExecutor(place)


def ray_executor(place: Place) -> Executor:
    try:
        from loopstone_fleet.executors.ray import RayExecutor
    except ImportError as error:
        raise FleetError(
            f"--executor ray needs Ray ({error}): install loopstone-fleet with its extra [ray]"
        ) from None
    return RayExecutor(place)


EXECUTORS: dict[str, Callable[[Place], Executor]] = {
    "local": local_executor,
    "dask": dask_executor,
    "ray": ray_executor,
}
