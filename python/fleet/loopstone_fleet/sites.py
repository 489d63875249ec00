"""Joins what was mapped to sites: one worker a site, its logs one after the other, by time.

    OUT/sites/SITE.sqlite    the site, which the program keeps
    OUT/sites/SITE.json      which logs it has, so that none is added twice
"""

from __future__ import annotations

import json
from collections import Counter, defaultdict
from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import NamedTuple

from loopstone_fleet.child import Limits, run_child
from loopstone_fleet.errors import LogTooLargeError, MissingLogError, StoreError
from loopstone_fleet.job import Settings, stop, words_of
from loopstone_fleet.manifest import Entry
from loopstone_fleet.result_store import ResultStore, Row, read_json, write_whole
from loopstone_fleet.status import DONE, is_curable, verdict_of
from loopstone_fleet.store import FetchLimits, at_hand

JOINED, PENDING, FAILED = "joined", "pending", "failed"


def join_sites(
    entries: Iterable[Entry],
    store: ResultStore,
    settings: Settings,
    workers: int,
    flags: Sequence[str],
) -> Counter[str]:
    """Adds every log with a site that was mapped to its site; how many are joined, pending, failed.

    What a site has from an earlier run is not added again. Rows tell in `site_status` and
    `site_reason`. `flags` are of the program's `site add`, for all logs.
    """
    by_site: dict[str, list[Row]] = defaultdict(list)
    for entry in entries:
        row = store.row(entry.id) if entry.site else None
        if row is not None and row["status"] == DONE:
            by_site[entry.site].append(row)
    (store.out / "sites").mkdir(exist_ok=True)
    with ThreadPoolExecutor(workers) as pool:
        futures = [
            pool.submit(_join_site, site, rows, store, settings, flags)
            for site, rows in by_site.items()
        ]
        try:
            counts = [future.result() for future in futures]
        except BaseException:
            stop(settings)
            raise
    return sum(counts, Counter())


class Joined(NamedTuple):
    """What became of one log at its site."""

    status: str
    reason: str
    is_final: bool
    """Whether the same call would end the same."""
    wall_s: float

    def row(self, row: Row) -> Row:
        told = {"site_status": self.status, "site_reason": self.reason, "site_wall_s": self.wall_s}
        return {**row, **told}


def _join_site(
    site: str, rows: list[Row], store: ResultStore, settings: Settings, flags: Sequence[str]
) -> Counter[str]:
    book = store.out / "sites" / f"{site}.json"
    known = read_json(book) or {}
    counts: Counter[str] = Counter()
    # A log without a time of its own goes last.
    for row in sorted(rows, key=lambda row: (row["starts_at_s"] is None, row["starts_at_s"] or 0)):
        if Path(settings.stop_file).exists():
            break
        name = f"{row['log_digest']} {row['recipe']}"
        if name in known:
            joined = Joined(*known[name])
        else:
            joined = _join(site, row, store, settings, flags)
            if joined.is_final:
                known[name] = list(joined)
                write_whole(book, json.dumps(known, ensure_ascii=False, indent=1).encode())
        if joined.row(row) != row:
            store.write_row(joined.row(row))
        counts[joined.status] += 1
    return counts


def _join(
    site: str, row: Row, store: ResultStore, settings: Settings, flags: Sequence[str]
) -> Joined:
    limits = Limits(settings.timeout_s, settings.max_memory_bytes)
    fetch = FetchLimits(settings.max_log_bytes, settings.timeout_s)
    scratch = Path(settings.scratch or store.out / "work")
    target = str(store.out / "sites" / f"{site}.sqlite")
    try:
        with at_hand(row["log"], scratch, fetch) as log:
            options = tuple(json.loads(row["options"] or "{}").items())
            command = [settings.program, "site", "add", target, log.path, "--json", *flags]
            command += words_of(row["robot"], options, settings)
            end = run_child(command, limits, Path(settings.stop_file))
    except (MissingLogError, LogTooLargeError, StoreError, OSError) as error:
        return Joined(FAILED, str(error), False, 0.0)
    status, reason = verdict_of(end)
    if end.killed_for or status != DONE:
        is_final = not end.killed_for and not is_curable(status)
        return Joined(FAILED, reason, is_final, end.wall_s)
    try:
        told = json.loads(end.stdout)
    except ValueError:
        return Joined(FAILED, "ended with 0, but told nothing to be read", True, end.wall_s)
    is_pending = isinstance(told, dict) and told.get("status") == PENDING
    reason = str(told.get("reason") or "") if isinstance(told, dict) else ""
    return Joined(PENDING if is_pending else JOINED, reason, True, end.wall_s)
