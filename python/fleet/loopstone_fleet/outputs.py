"""The table and the page of a run, from its rows; and those of several runs in one."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

from loopstone_fleet.errors import FleetError
from loopstone_fleet.overview import overview_of
from loopstone_fleet.page import State, page_of
from loopstone_fleet.result_store import ResultStore, Row, write_whole
from loopstone_fleet.status import DONE
from loopstone_fleet.table import read_table, write_table

TABLE, PAGE = "fleet.parquet", "fleet.html"
# A run is not slowed by more than this share, and the page is not older than that.
SHARE_OF_TIME = 0.03
RENEWED_EVERY_S = 60.0


def write_outputs(
    folder: Path, rows: Callable[[], Iterable[Row]], state: State, name: str = "fleet"
) -> int:
    """Writes NAME.parquet and NAME.html, and returns how many rows they have."""
    count = write_table(rows, folder / f"{name}.parquet")
    page = page_of(overview_of(rows()), state._replace(table=f"{name}.parquet"))
    write_whole(folder / f"{name}.html", page.encode())
    return count


class Renewal:
    """Writes the outputs now and then, as long as that takes little of the time."""

    def __init__(self, write: Callable[[], object], every_s: float = RENEWED_EVERY_S) -> None:
        self._write, self._every_s = write, every_s
        self._next = time.monotonic() + every_s

    def __call__(self) -> None:
        began = time.monotonic()
        if began < self._next:
            return
        try:
            self._write()
        except OSError:  # a full disk; the run itself deals with that
            pass
        took = time.monotonic() - began
        self._next = time.monotonic() + max(self._every_s, took / SHARE_OF_TIME)


# ---- several in one


class Source(NamedTuple):
    """The rows of one OUT."""

    out: Path
    rows: Callable[[], Iterable[Row]]


def source_of(out: Path) -> Source:
    """Rows as they are, or the table where only that was brought along."""
    store = ResultStore(out)
    if (out / "rows").is_dir():
        return Source(out, store.rows)
    if (out / TABLE).is_file():
        return Source(out, lambda: read_table(out / TABLE))
    raise FleetError(f"{out}: holds no results of loopstone-fleet: neither rows/ nor {TABLE}")


def merge(outs: list[Path], target: Path) -> int:
    """One table and one page of several; of a log that several have, the row that ended best.

    Returns how many rows there are. Maps stay where they are; the page leads there.
    """
    sources = [source_of(out) for out in outs]
    chosen: dict[str, tuple[tuple[bool, str], int]] = {}
    for index, source in enumerate(sources):
        for row in source.rows():
            rank = (row["status"] == DONE, str(row.get("tried_at", "")))
            if row["id"] not in chosen or rank > chosen[row["id"]][0]:
                chosen[row["id"]] = (rank, index)

    def rows() -> Iterator[Row]:
        for index, source in enumerate(sources):
            for row in source.rows():
                if chosen.get(row["id"], (None, -1))[1] == index:
                    yield _seen_from(target, source.out, row)

    target.mkdir(parents=True, exist_ok=True)
    return write_outputs(target, rows, State(False, len(chosen)))


def _seen_from(target: Path, out: Path, row: Row) -> Row:
    if not row.get("result") or out.resolve() == target.resolve():
        return row
    return {**row, "result": os.path.relpath((out / row["result"]).resolve(), target.resolve())}
