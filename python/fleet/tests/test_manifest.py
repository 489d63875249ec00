"""Manifests: all problems at once, with line and remedy."""

from __future__ import annotations

from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as parquet
import pytest

from loopstone_fleet.errors import FleetError
from loopstone_fleet.manifest import Entry, Shard, parse_shard, read_manifest


def written(folder: Path, text: str) -> str:
    path = folder / "logs.csv"
    path.write_text(text, encoding="utf-8")
    return str(path)


def told_of(path: str) -> str:
    with pytest.raises(FleetError) as caught:
        read_manifest(path)
    return str(caught.value)


def test_csv_and_parquet_are_the_same(tmp_path: Path) -> None:
    text = '\ufefflog,robot,site,options\na.bag,r1,hall,"x.y=1 z=2"\n\ns3://b/c.mcap,,,\n'
    of_csv = read_manifest(written(tmp_path, text))
    table = {
        "log": ["a.bag", "s3://b/c.mcap"],
        "robot": ["r1", None],
        "site": ["hall", None],
        "options": ['{"z": 2, "x": {"y": 1}}', None],
    }
    path = tmp_path / "logs.parquet"
    parquet.write_table(pa.table(table), path)
    of_parquet = read_manifest(str(path))
    assert [entry[:4] for entry in of_csv] == [entry[:4] for entry in of_parquet]
    assert of_csv[0] == Entry(
        str(tmp_path / "a.bag"), "r1", "hall", (("x.y", "1"), ("z", "2")), line=2
    )
    assert [entry.line for entry in of_csv] == [2, 4]


def test_parquet_may_hold_options_as_a_structure(tmp_path: Path) -> None:
    path = tmp_path / "logs.parquet"
    parquet.write_table(
        pa.table({"log": ["/a"], "options": [{"map": {"resolution_m": 0.1}}]}), path
    )
    assert read_manifest(str(path))[0].options == (("map.resolution_m", "0.1"),)


def test_every_problem_is_told_with_its_line(tmp_path: Path) -> None:
    lines = ["log,site,options", "a.bag,,", ",x,", "b.bag,../up,", "c.bag,,{", "d.bag", "a.bag,,"]
    path = written(tmp_path, "\n".join(lines))
    told = told_of(path).splitlines()
    assert [line.removeprefix(f"{path}: ").split(":")[0] for line in told] == [
        "line 3",
        "line 4",
        "line 5",
        "line 6",
        "line 7",
    ]
    assert "names no log" in told[0]
    assert "site '../up' becomes a file's name" in told[1]
    assert "no JSON" in told[2]
    assert "has 1 cells where the first line names 3" in told[3]
    assert "is line 2 once more" in told[4]


def test_the_same_log_with_other_options_is_another_row(tmp_path: Path) -> None:
    entries = read_manifest(written(tmp_path, "log,options\na,\na,x=1\na,x=2\n"))
    assert len({entry.id for entry in entries}) == 3


def test_columns_are_known(tmp_path: Path) -> None:
    assert "column 'robt' is not known; did you mean robot?" in told_of(
        written(tmp_path, "log,robt\na,b\n")
    )
    assert "has no column 'log'" in told_of(written(tmp_path, "robot\nr1\n"))
    assert "column twice" in told_of(written(tmp_path, "log,log\na,b\n"))


def test_files_that_are_no_manifest(tmp_path: Path) -> None:
    assert "there is no such manifest" in told_of(str(tmp_path / "none.csv"))
    assert "names no log" in told_of(written(tmp_path, "log\n"))
    (tmp_path / "half.parquet").write_bytes(b"PAR1 and no more")
    assert "no whole Parquet file" in told_of(str(tmp_path / "half.parquet"))
    (tmp_path / "bytes.csv").write_bytes(b"\xff\xfe\x00log")
    assert "neither Parquet nor CSV" in told_of(str(tmp_path / "bytes.csv"))


def test_shards_part_a_manifest_and_keep_sites_whole() -> None:
    entries = [Entry(f"/log{n}", "", f"site{n % 5}" if n % 2 else "", (), n) for n in range(400)]
    shards = [[e for e in entries if Shard(index, 4).has(e)] for index in range(4)]
    assert sorted(entry.line for shard in shards for entry in shard) == list(range(400))
    assert all(len(shard) > 25 for shard in shards)
    sites = [{entry.site for entry in shard if entry.site} for shard in shards]
    assert sum(len(names) for names in sites) == 5


@pytest.mark.parametrize("text", ["2/2", "1", "-1/2", "0/0", "a/b"])
def test_wrong_shards_are_refused(text: str) -> None:
    with pytest.raises(FleetError, match="from 0 to n - 1"):
        parse_shard(text)
