"""All rows as one Parquet table: a column for every figure, by its name in the summary."""

from __future__ import annotations

import json
import os
import uuid
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as parquet

from loopstone_fleet.result_store import Row

# Of one row group, which is in memory as a whole.
ROWS_A_GROUP = 1000


def flat(row: Row) -> Row:
    """A row without nesting: `quality.verdict`. A list becomes JSON and, beside it, its length."""
    out: Row = {}
    _flatten(row, "", out)
    return out


def _flatten(table: dict[str, Any], prefix: str, out: Row) -> None:
    for key, value in table.items():
        name = prefix + key
        if isinstance(value, dict):
            _flatten(value, name + ".", out)
        elif isinstance(value, list):
            out[name] = json.dumps(value, ensure_ascii=False)
            out[name + ".count"] = len(value)
        else:
            out[name] = value


def list_of(value: Any) -> list[Any]:
    """A list again, of what `flat` made of one."""
    if isinstance(value, str):
        value = json.loads(value)
    return value if isinstance(value, list) else []


def write_table(rows: Callable[[], Iterable[Row]], path: Path) -> int:
    """Writes all rows, and returns how many there are.

    `rows` is called twice, first for the columns: two runs of a program may know different figures.
    """
    kinds: dict[str, set[type]] = {}
    for row in rows():
        for name, value in flat(row).items():
            kind = kinds.setdefault(name, set())
            if value is not None:
                kind.add(type(value))
    schema = pa.schema([(name, _type_of(kind)) for name, kind in kinds.items()])
    partial = path.with_name(f".{path.name}.{os.getpid()}-{uuid.uuid4().hex[:8]}.partial")
    count = 0
    try:
        with parquet.ParquetWriter(partial, schema, compression="zstd") as writer:
            for group in _groups(rows()):
                flats = [flat(row) for row in group]
                columns = [
                    pa.array([_fit(row.get(field.name), field.type) for row in flats], field.type)
                    for field in schema
                ]
                writer.write_table(pa.table(columns, schema=schema))
                count += len(group)
        os.replace(partial, path)
    except BaseException:
        partial.unlink(missing_ok=True)
        raise
    return count


def read_table(path: Path) -> Iterator[Row]:
    """The rows of a table, flat, without what they do not have."""
    for batch in parquet.ParquetFile(path).iter_batches(batch_size=1000):
        for row in batch.to_pylist():
            yield {name: value for name, value in row.items() if value is not None}


def _type_of(kinds: set[type]) -> Any:
    if kinds == {bool}:
        return pa.bool_()
    if kinds == {int}:
        return pa.int64()
    if kinds <= {int, float}:  # a figure that nobody had is one all the same
        return pa.float64()
    return pa.string()


def _fit(value: Any, kind: Any) -> Any:
    if value is None:
        return None
    if kind == pa.string():
        return value if isinstance(value, str) else json.dumps(value)
    if kind == pa.int64():
        # A row that came between the two passes is not worth failing for.
        return value if isinstance(value, int) else None
    if kind == pa.float64():
        return float(value) if isinstance(value, (int, float)) else None
    return value if isinstance(value, bool) else None


def _groups(rows: Iterable[Row]) -> Iterator[list[Row]]:
    group: list[Row] = []
    for row in rows:
        group.append(row)
        if len(group) == ROWS_A_GROUP:
            yield group
            group = []
    if group:
        yield group
