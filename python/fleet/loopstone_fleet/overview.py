"""What a fleet's rows come to: counts, robots that need service, and the logs to look at."""

from __future__ import annotations

import heapq
from collections import Counter, defaultdict
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

from loopstone_fleet.result_store import Row
from loopstone_fleet.status import DONE
from loopstone_fleet.table import flat, list_of

FAILED_SHOWN = 200
SUSPECTS_SHOWN = 50
SLOWEST_SHOWN = 20
# One log may have met a wet floor; what comes again is the robot's.
SERVICE_LOGS, SERVICE_SHARE = 2, 0.25


@dataclass
class Robot:
    """What all logs of a robot say of it."""

    name: str
    logs: int = 0
    failed: int = 0
    odometry_logs: int = 0
    """Logs in which odometry was found wrong."""
    laser_logs: int = 0
    mount_logs: int = 0
    """Logs by which the laser does not sit where the robot's file says."""
    faults: Counter[str] = field(default_factory=Counter)
    """By kind: the number of logs."""
    distrusted_s: float = 0.0
    recorded_s: float = 0.0

    @property
    def faulty_logs(self) -> int:
        """At least; one log may have both."""
        return max(self.odometry_logs, self.laser_logs)

    @property
    def verdict(self) -> str:
        """service: faults come again; watch: there was one, or the laser sits elsewhere; fine.

        A mount that is off was bumped into, or nobody ever measured it: maps make up for it.
        """
        if self.faulty_logs >= max(SERVICE_LOGS, SERVICE_SHARE * self.logs):
            return "service"
        return "watch" if self.faulty_logs or self.mount_logs else "fine"

    def add(self, row: Row) -> None:
        if row["status"] != DONE:
            self.failed += 1
            return
        self.logs += 1
        self.recorded_s += number(row, "duration_s")
        self.distrusted_s += number(row, "odometry_distrusted_s")
        kinds = {f"odometry {fault}" for fault in _kinds(row, "odometry_faults")}
        self.odometry_logs += bool(kinds)
        laser = {f"laser {fault}" for fault in _kinds(row, "laser_faults")}
        self.laser_logs += bool(laser)
        keys = ("calibration.lidar.yaw_is_off", "calibration.lidar.place_is_off")
        mount = {"laser mount off"} if any(row.get(key) is True for key in keys) else set()
        self.mount_logs += bool(mount)
        self.faults.update(kinds | laser | mount)


@dataclass
class Overview:
    """Of all rows, in one pass and in little memory."""

    statuses: Counter[str] = field(default_factory=Counter)
    verdicts: Counter[str] = field(default_factory=Counter)
    versions: Counter[str] = field(default_factory=Counter)
    robots: dict[str, Robot] = field(default_factory=dict)
    sites: dict[str, Counter[str]] = field(default_factory=lambda: defaultdict(Counter))
    sums: Counter[str] = field(default_factory=Counter)
    most: dict[str, float] = field(default_factory=lambda: defaultdict(float))
    failed: list[Row] = field(default_factory=list)
    suspects: list[Row] = field(default_factory=list)
    slowest: list[Row] = field(default_factory=list)
    folder: str = ""
    """In which all logs lie."""

    @property
    def logs(self) -> int:
        return sum(self.statuses.values())


SUMMED = ("duration_s", "path_length_m", "process_cpu_s", "process_wall_s", "log_bytes")


def number(row: Row, name: str) -> float:
    """A figure of a row; 0 where it has none."""
    value = row.get(name)
    return float(value) if isinstance(value, (int, float)) else 0.0


def overview_of(rows: Iterable[Row]) -> Overview:
    over = Overview()
    failed: Counter[str] = Counter()
    suspects = _Best(SUSPECTS_SHOWN)
    slowest = _Best(SLOWEST_SHOWN)
    for nested in rows:
        row = flat(nested)
        status = row["status"]
        over.folder = _common_folder(over.folder, row["log"], not over.statuses)
        over.statuses[status] += 1
        over.versions[row["program_version"]] += 1
        robot = row.get("robot") or ""
        over.robots.setdefault(robot, Robot(robot)).add(row)
        if row.get("site"):
            word = row.get("site_status") or ("mapped" if status == DONE else "no map")
            over.sites[row["site"]][word] += 1
        for name in SUMMED:
            over.sums[name] += number(row, name)  # type: ignore[assignment]
        over.most["memory"] = max(over.most["memory"], number(row, "process_peak_memory_bytes"))
        slowest.add(number(row, "process_wall_s"), row)
        if status != DONE:
            failed[status] += 1
            if failed[status] <= FAILED_SHOWN:
                over.failed.append(row)
            continue
        verdict = row.get("quality.verdict") or "unknown"
        over.verdicts[verdict] += 1
        if verdict in ("bad", "doubtful"):
            error = number(row, "quality.possible_error_m")
            suspects.add((1e9 if verdict == "bad" else 0.0) + error, row)
    over.suspects, over.slowest = suspects.in_order(), slowest.in_order()
    over.failed.sort(key=lambda row: (row["status"], row["log"]))
    return over


class _Best:
    """The rows with the largest figures."""

    def __init__(self, count: int) -> None:
        self._count = count
        self._heap: list[tuple[float, str, Row]] = []

    def add(self, figure: float, row: Row) -> None:
        item = (figure, row["id"], row)
        if len(self._heap) < self._count:
            heapq.heappush(self._heap, item)
        elif item[:2] > self._heap[0][:2]:
            heapq.heapreplace(self._heap, item)

    def in_order(self) -> list[Row]:
        return [row for _, _, row in sorted(self._heap, key=lambda item: item[:2], reverse=True)]


def _kinds(row: Row, name: str) -> set[str]:
    faults: list[Any] = list_of(row.get(name))
    return {str(fault.get("fault", "wrong")) for fault in faults if isinstance(fault, dict)}


def _common_folder(folder: str, log: str, is_first: bool) -> str:
    """The longest part up to a slash that both begin with."""
    here = log[: log.rfind("/") + 1]
    if is_first:
        return here
    while folder and not here.startswith(folder):
        folder = folder[: folder.rstrip("/").rfind("/") + 1]
    return folder
