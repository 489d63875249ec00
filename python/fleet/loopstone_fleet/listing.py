"""Makes a manifest of the logs that lie in a folder or under a prefix of a store."""

from __future__ import annotations

import csv
import os
import re
from collections.abc import Iterator
from typing import TextIO

import fsspec

from loopstone_fleet.errors import FleetError
from loopstone_fleet.manifest import COLUMNS
from loopstone_fleet.store import is_remote

_FILE = re.compile(r".*\.(clf|log|carmen|mcap|bag|rawlog)(\.gz|\.bz2)?", re.IGNORECASE)
_RECORDING = re.compile(r".*\.db3(\.zstd)?", re.IGNORECASE)
_SET = re.compile(r"Hokuyo(\d+)\.npz")


def logs_in(folder: str) -> Iterator[str]:
    """Every log below a folder: files by their names' ends, rosbag2 and UCSD folders as wholes."""
    for where, names in _folders(folder):
        if any(_RECORDING.fullmatch(name) for name in names) or "metadata.yaml" in names:
            yield where
            continue
        sets = sorted(int(match[1]) for name in names if (match := _SET.fullmatch(name)))
        if len(sets) == 1:
            yield where
        else:
            yield from (f"{where}#{number}" for number in sets)
        yield from (f"{where}/{name}" for name in names if _FILE.fullmatch(name))


def write_listing(folder: str, levels: list[str], target: TextIO) -> int:
    """Writes a manifest as CSV, and returns how many logs it has.

    `levels` tells what the names of the first folders below are: robot, site, or - for neither.
    """
    wrong = [level for level in levels if level not in ("robot", "site", "-")]
    if wrong:
        raise FleetError(f"--levels has '{wrong[0]}'; a level is robot, site or -")
    folder = folder.rstrip("/") if is_remote(folder) else os.path.abspath(folder)
    writer = csv.DictWriter(target, COLUMNS, lineterminator="\n")
    writer.writeheader()
    count = 0
    for log in logs_in(folder):
        parts = log[len(folder) :].strip("/").split("/")[:-1]
        labels = {level: part for level, part in zip(levels, parts) if level != "-"}
        writer.writerow({"log": log, **labels})
        count += 1
    if count == 0:
        raise FleetError(f"{folder}: holds no log that its name tells of (.mcap, .bag, .clf, ...)")
    return count


def _folders(folder: str) -> Iterator[tuple[str, list[str]]]:
    try:
        filesystem, root = fsspec.url_to_fs(folder)
        if not filesystem.isdir(root):
            raise FleetError(f"{folder}: there is no such folder")
        for where, _, names in sorted(filesystem.walk(root)):
            tail = str(where)[len(root.rstrip("/")) :]
            yield folder.rstrip("/") + tail, sorted(names)
    except FleetError:
        raise
    except Exception as error:  # of a store, of whatever class
        raise FleetError(f"{folder}: cannot be listed: {error}") from None
