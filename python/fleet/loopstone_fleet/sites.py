"""Joins what was mapped to sites: one worker a site, its logs one after the other, by time.

    OUT/sites/SITE.sqlite    the site, which the program keeps
    OUT/sites/SITE.json      which logs it has, so that none is added twice
"""

from __future__ import annotations

import json
from collections import Counter, defaultdict
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from loopstone_fleet.child import Limits, run_child
from loopstone_fleet.errors import LogTooLargeError, MissingLogError, StoreError
from loopstone_fleet.job import Settings
from loopstone_fleet.manifest import Entry
from loopstone_fleet.result_store import ResultStore, Row, read_json, write_whole
from loopstone_fleet.status import DONE, is_curable, verdict_of
from loopstone_fleet.store import FetchLimits, at_hand

JOINED, PENDING, FAILED = "joined", "pending", "failed"


def join_sites(
    entries: Iterable[Entry], store: ResultStore, settings: Settings, workers: int
) -> Counter[str]:
    """Adds every log with a site that was mapped to its site; how many are joined, pending, failed.

    What a site has from an earlier run is not added again. Rows tell in `site_status` and
    `site_reason`.
    """
    by_site: dict[str, list[Row]] = defaultdict(list)
    for entry in entries:
        row = store.row(entry.id) if entry.site else None
        if row is not None and row["status"] == DONE:
            by_site[entry.site].append(row)
    (store.out / "sites").mkdir(exist_ok=True)
    with ThreadPoolExecutor(workers) as pool:
        futures = [
            pool.submit(_join_site, site, rows, store, settings) for site, rows in by_site.items()
        ]
        try:
            counts = [future.result() for future in futures]
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    return sum(counts, Counter())


def _join_site(site: str, rows: list[Row], store: ResultStore, settings: Settings) -> Counter[str]:
    book = store.out / "sites" / f"{site}.json"
    known = read_json(book) or {}
    counts: Counter[str] = Counter()
    # A log without a time of its own goes last.
    for row in sorted(rows, key=lambda row: (row["starts_at_s"] is None, row["starts_at_s"] or 0)):
        if Path(settings.stop_file).exists():
            break
        name = f"{row['log_digest']} {row['recipe']}"
        if name not in known:
            status, reason, is_final = _join(site, row, store, settings)
            store.write_row({**row, "site_status": status, "site_reason": reason})
            if is_final:
                known[name] = {"log": row["log"], "status": status, "reason": reason}
                write_whole(book, json.dumps(known, ensure_ascii=False, indent=1).encode())
            counts[status] += 1
        else:
            counts[known[name]["status"]] += 1
            if "site_status" not in row:  # it was mapped again to the same result
                told = known[name]
                store.write_row(
                    {**row, "site_status": told["status"], "site_reason": told["reason"]}
                )
    return counts


def _join(site: str, row: Row, store: ResultStore, settings: Settings) -> tuple[str, str, bool]:
    """Status, reason, and whether the same call would end the same."""
    limits = Limits(settings.timeout_s, settings.max_memory_bytes)
    fetch = FetchLimits(settings.max_log_bytes, settings.timeout_s)
    scratch = Path(settings.scratch or store.out / "work")
    target = str(store.out / "sites" / f"{site}.sqlite")
    try:
        with at_hand(row["log"], scratch, fetch) as log:
            command = [settings.program, "site", "add", target, log.path, "--json"]
            end = run_child(command, limits, Path(settings.stop_file))
    except (MissingLogError, LogTooLargeError, StoreError, OSError) as error:
        return FAILED, str(error), False
    verdict = verdict_of(end)
    if end.killed_for == "stopped" or verdict.status != DONE:
        return (FAILED, verdict.reason, not end.killed_for and not is_curable(verdict.status))
    try:
        told = json.loads(end.stdout)
    except ValueError:
        return FAILED, "ended with 0, but told nothing that can be read", True
    pending = isinstance(told, dict) and told.get("status") == PENDING
    return (PENDING if pending else JOINED), str(told.get("reason") or ""), True
