"""What of a manifest is to be done: all but what ended before as it would end again."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from itertools import islice
from pathlib import Path
from typing import NamedTuple

from loopstone_fleet.job import Settings, recipe_of
from loopstone_fleet.manifest import Entry
from loopstone_fleet.result_store import SUMMARY, ResultStore, Row
from loopstone_fleet.status import DONE, STATUSES
from loopstone_fleet.store import stamp_of

# Stores answer slowly, but many at once.
ASKED_AT_ONCE = 16
CHUNK = 1000


class Task(NamedTuple):
    """A log that is to be mapped."""

    entry: Entry
    stamp: str | None
    """Of the log before it was read."""


class Planned(NamedTuple):
    """An entry with what is to be done about it."""

    entry: Entry
    task: Task | None
    """None where its row holds."""


def plan(
    entries: Iterable[Entry], store: ResultStore, settings: Settings, again: frozenset[str]
) -> Iterator[Planned]:
    """Each entry in its order. `again` has statuses that are tried anew whatever the row says."""
    remaining = iter(entries)

    def planned(entry: Entry) -> Planned:
        stamp = stamp_of(entry.log)
        row = store.row(entry.id)
        if row is None or not _holds(row, entry, stamp, store, settings, again):
            return Planned(entry, Task(entry, stamp))
        if (row["robot"], row["site"]) != (entry.robot, entry.site):  # labels alone have changed
            store.write_row({**row, "robot": entry.robot, "site": entry.site})
        return Planned(entry, None)

    with ThreadPoolExecutor(ASKED_AT_ONCE) as pool:
        while chunk := list(islice(remaining, CHUNK)):
            yield from pool.map(planned, chunk)


def _holds(
    row: Row,
    entry: Entry,
    stamp: str | None,
    store: ResultStore,
    settings: Settings,
    again: frozenset[str],
) -> bool:
    status = row.get("status", "")
    if status not in STATUSES or status in again or STATUSES[status].curable:
        return False
    if stamp is None or stamp != row.get("log_stamp"):
        return False
    if row.get("recipe") != recipe_of(entry, settings):
        return False
    if status == "timeout":  # more is allowed now
        return bool(settings.timeout_s <= row["timeout_s"])
    if status == "out_of_memory":
        return bool(settings.max_memory_bytes <= row["max_memory_bytes"])
    return status != DONE or Path(store.out, row["result"], SUMMARY).exists()
