"""The list of logs that are to be mapped: CSV or Parquet, read and checked as a whole."""

from __future__ import annotations

import csv
import difflib
import hashlib
import io
import os
import re
from collections.abc import Iterator
from typing import Any, NamedTuple

import fsspec
import pyarrow.parquet as parquet

from loopstone_fleet.errors import FleetError
from loopstone_fleet.options import Options, parse_options

COLUMNS = ("log", "robot", "site", "options")
PROBLEMS_TOLD = 20
_SITE = re.compile(r"[\w][\w .@+-]*")


class Entry(NamedTuple):
    """One log that is to be mapped."""

    log: str
    """A path from the root, or an address such as s3://bucket/key."""
    robot: str
    site: str
    options: Options
    line: int
    """Of the manifest, from 1: the line of a CSV, the row of a Parquet file."""

    @property
    def id(self) -> str:
        """Of its row: the same as long as log and options are."""
        text = "\n".join([self.log, *(f"{key}={value}" for key, value in self.options)])
        return hashlib.sha256(text.encode()).hexdigest()[:24]


class Shard(NamedTuple):
    """The part of a manifest that one of several machines takes."""

    number: int
    of: int

    def has(self, entry: Entry) -> bool:
        """A log without a site goes by its id, one with a site to where all of its site go."""
        name = hashlib.sha256((entry.site or entry.id).encode()).digest()
        return int.from_bytes(name[:8], "big") % self.of == self.number


def parse_shard(text: str) -> Shard:
    match = re.fullmatch(r"(\d+)/(\d+)", text)
    if match is None or not int(match[1]) < int(match[2]):
        raise FleetError(
            f"--shard '{text}' is no part of a whole; write i/n with i from 0 to n - 1, such as 0/8"
        )
    return Shard(int(match[1]), int(match[2]))


def read_manifest(path: str) -> list[Entry]:
    """All entries of a manifest. FleetError with every problem, line by line."""
    try:
        with fsspec.open(path, "rb") as file:
            data = file.read()
    except FileNotFoundError:
        raise FleetError(f"{path}: there is no such manifest") from None
    except Exception as error:  # of a store, of whatever class
        raise FleetError(f"{path}: cannot be read: {error}") from None
    problems: list[str] = []
    rows = _parquet_rows if data[:4] == b"PAR1" else _csv_rows
    entries = list(_entries(rows(path, data), _folder_of(path), problems))
    problems += _repeated(entries)
    if problems:
        told = problems[:PROBLEMS_TOLD]
        more = len(problems) - len(told)
        rest = [f"and {more} more"] if more > 0 else []
        raise FleetError("\n".join(f"{path}: {problem}" for problem in [*told, *rest]))
    if not entries:
        raise FleetError(f"{path}: names no log; `loopstone-fleet manifest FOLDER` makes one")
    return entries


def _folder_of(path: str) -> str:
    return path.rpartition("/")[0] if "://" in path else os.path.dirname(os.path.abspath(path))


def _check_columns(path: str, names: list[str]) -> None:
    problems = []
    for name in names:
        if name not in COLUMNS:
            near = difflib.get_close_matches(name, COLUMNS, 1)
            hint = f"did you mean {near[0]}?" if near else f"known are {', '.join(COLUMNS)}"
            problems.append(f"{path}: column '{name}' is not known; {hint}")
    if "log" not in names:
        problems.append(f"{path}: has no column 'log'; its first line must name the columns")
    if len(set(names)) < len(names):
        problems.append(f"{path}: has a column twice")
    if problems:
        raise FleetError("\n".join(problems))


def _csv_rows(path: str, data: bytes) -> Iterator[tuple[int, dict[str, Any] | str]]:
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise FleetError(f"{path}: is neither Parquet nor CSV in UTF-8: {error}") from None
    reader = csv.reader(io.StringIO(text, newline=""))
    names = [name.strip() for name in next(reader, [])]
    _check_columns(path, names)
    before = reader.line_num
    for cells in reader:
        line, before = before + 1, reader.line_num
        if not any(cell.strip() for cell in cells):
            continue
        if len(cells) != len(names):
            yield line, (
                f"has {len(cells)} cells where the first line names {len(names)} columns;"
                ' a cell with commas stands in quotes: "a,b"'
            )
            continue
        yield line, dict(zip(names, cells))


def _parquet_rows(path: str, data: bytes) -> Iterator[tuple[int, dict[str, Any] | str]]:
    try:
        file = parquet.ParquetFile(io.BytesIO(data))
    except Exception as error:
        raise FleetError(f"{path}: is no whole Parquet file: {error}") from None
    _check_columns(path, list(file.schema_arrow.names))
    number = 0
    for batch in file.iter_batches():
        for row in batch.to_pylist():
            number += 1
            yield number, row


def _entries(
    rows: Iterator[tuple[int, dict[str, Any] | str]], folder: str, problems: list[str]
) -> Iterator[Entry]:
    for line, row in rows:
        if isinstance(row, str):
            problems.append(f"line {line}: {row}")
            continue
        cells = {key: row[key] for key in row if row[key] is not None}
        log, robot, site = (str(cells.get(key, "")).strip() for key in ("log", "robot", "site"))
        if not log:
            problems.append(f"line {line}: names no log")
        if site and not _SITE.fullmatch(site):
            problems.append(
                f"line {line}: site '{site}' becomes a file's name: it may have letters, digits,"
                " blanks and .@+-_ only"
            )
        try:
            options = parse_options(cells.get("options"))
        except ValueError as error:
            problems.append(f"line {line}: options '{cells['options']}' {error}")
            continue
        yield Entry(_resolved(log, folder), robot, site, options, line)


def _resolved(log: str, folder: str) -> str:
    """Logs that are named without a root lie beside the manifest."""
    if "://" in log:
        return log
    if "://" in folder and not log.startswith("/"):
        return f"{folder}/{log}"
    return os.path.normpath(os.path.join(folder, log))


def _repeated(entries: list[Entry]) -> Iterator[str]:
    lines: dict[str, int] = {}
    for entry in entries:
        first = lines.setdefault(entry.id, entry.line)
        if first != entry.line:
            yield (
                f"line {entry.line}: is line {first} once more: the same log with the same"
                " options; remove one"
            )
