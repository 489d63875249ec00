"""One log, from the store to its row. It runs on a worker, which may be another machine."""

from __future__ import annotations

import errno
import hashlib
import json
import os
import shutil
import socket
import tempfile
import time
from datetime import datetime, timezone
from pathlib import Path
from typing import NamedTuple

from loopstone_fleet.child import ChildEnd, Limits, run_child
from loopstone_fleet.errors import LogTooLargeError, MissingLogError, StoreError
from loopstone_fleet.manifest import Entry
from loopstone_fleet.options import Options
from loopstone_fleet.result_store import SUMMARY, ResultStore, Row, read_json
from loopstone_fleet.status import DONE, Verdict, verdict_of
from loopstone_fleet.store import FetchLimits, LocalLog, at_hand

# Of a log that was not tried, or not to its end: no row is kept of it.
STOPPED = "stopped"
# A disk with less has no room for a map.
FULL_BYTES = 256 << 10
# Figures that say nothing of the map, or what the row has by itself.
LEFT_OUT = ("log", "command", "version", "result_of", "complete")


class Settings(NamedTuple):
    """What holds for all logs of a run."""

    program: str
    version: str
    """What `--version` says; results of another one are made anew."""
    out: str
    scratch: str
    """Where logs from a store are fetched to; empty for the worker's temporary folder."""
    timeout_s: float
    max_memory_bytes: int
    max_log_bytes: int
    threads: int
    """Of each process; the result is the same with any number."""
    flags: tuple[str, ...]
    """More words for `map`, of all logs."""
    robots: str
    """A folder with ROBOT.toml of each robot, or empty."""
    anew: bool
    """Whether results are made although they are there."""
    stop_file: str
    """Where it appears, work ends."""


class Job(NamedTuple):
    """One try of one log."""

    entry: Entry
    settings: Settings
    attempt: int
    """From 1."""


def robot_file(robot: str, settings: Settings) -> str:
    """The file with a robot's wheels and mounts, or nothing where there is none of it."""
    if not settings.robots or not robot or os.sep in robot:
        return ""
    path = os.path.join(settings.robots, f"{robot}.toml")
    return path if os.path.exists(path) else ""


def words_of(robot: str, options: Options, settings: Settings) -> list[str]:
    """What tells the program of a log's robot and options, and what each process may take."""
    words = ["--max-memory", f"{settings.max_memory_bytes // (1 << 20)}M"]
    words += ["--threads", str(settings.threads)]
    path = robot_file(robot, settings)
    words += ["--robot", path] if path else []
    for key, value in options:
        words += ["--set", f"{key}={value}"]
    return words


def recipe_of(entry: Entry, settings: Settings) -> str:
    """The hash of all that determines a result beside the log."""
    words = [settings.version, *settings.flags]
    words += [f"{key}={value}" for key, value in entry.options]
    robot = robot_file(entry.robot, settings)
    if robot:
        words.append(hashlib.sha256(Path(robot).read_bytes()).hexdigest())
    return hashlib.sha256("\n".join(words).encode()).hexdigest()[:32]


def result_key(log_digest: str, recipe: str) -> str:
    return hashlib.sha256(f"{log_digest} {recipe}".encode()).hexdigest()[:40]


def run_job(job: Job) -> Row:
    """Maps one log and returns its row, whatever happens."""
    started = time.monotonic()
    row = _begun_row(job)
    try:
        verdict = _map(job, row)
    except (MissingLogError, LogTooLargeError) as error:
        verdict = Verdict("bad_data", str(error))
    except StoreError as error:
        verdict = Verdict("store_failed", str(error))
    except OSError as error:
        is_full = error.errno in (errno.ENOSPC, errno.EDQUOT)
        verdict = Verdict("disk_full" if is_full else "worker_failed", str(error))
    except Exception as error:
        verdict = Verdict("worker_failed", f"{type(error).__name__}: {error}")
    row.update(status=verdict.status, reason=verdict.reason)
    row["worker_wall_s"] = time.monotonic() - started
    return row


def stop(settings: Settings) -> None:
    """Ends what runs, wherever it runs."""
    try:
        Path(settings.stop_file).touch()
    except OSError:  # no room even for that; limits will end it
        pass


def failed_row(job: Job, reason: str) -> Row:
    """The row of a log whose worker did not return one."""
    return {**_begun_row(job), "status": "worker_failed", "reason": reason}


def _begun_row(job: Job) -> Row:
    entry, settings = job.entry, job.settings
    return {
        "id": entry.id,
        "log": entry.log,
        "robot": entry.robot,
        "site": entry.site,
        "options": json.dumps(dict(entry.options)) if entry.options else "",
        "status": "",
        "reason": "",
        "attempts": job.attempt,
        "worker": f"{socket.gethostname()}:{os.getpid()}",
        "tried_at": datetime.now(timezone.utc).isoformat(timespec="seconds"),
        "program_version": settings.version,
        "timeout_s": settings.timeout_s,
        "max_memory_bytes": settings.max_memory_bytes,
    }


def _map(job: Job, row: Row) -> Verdict:
    entry, settings = job.entry, job.settings
    store = ResultStore(Path(settings.out))
    stop_file = Path(settings.stop_file)
    if stop_file.exists():
        return Verdict(STOPPED, "the run was interrupted")
    fetching = time.monotonic()
    row["recipe"] = recipe_of(entry, settings)
    limits = FetchLimits(settings.max_log_bytes, settings.timeout_s)
    scratch = Path(settings.scratch or tempfile.gettempdir())
    with at_hand(entry.log, scratch, limits) as log:
        row["fetch_s"] = time.monotonic() - fetching
        row["log_digest"], row["log_bytes"] = log.digest, log.size_bytes
        key = result_key(log.digest, row["recipe"])
        summary = None if settings.anew else store.summary(key)
        row["reused"] = summary is not None
        if summary is None:
            with store.work_folder() as work:
                end = run_child(
                    _command(job, log, work / "map"),
                    Limits(settings.timeout_s, settings.max_memory_bytes),
                    stop_file,
                )
                _note_costs(row, end)
                verdict, summary = _judged(end, work / "map")
                if summary is None:
                    return Verdict(verdict.status, _without_paths(verdict.reason, log, work))
                store.publish(work / "map", key, settings.anew)
    row["result"] = str(store.result(key).relative_to(store.out))
    row["starts_at_s"] = first_stamp(store.result(key) / "trajectory.tum")
    row.update({name: value for name, value in summary.items() if name not in LEFT_OUT})
    return Verdict(DONE, "")


def _without_paths(reason: str, log: LocalLog, work: Path) -> str:
    """A reason without names that mean nothing later; which log it is, the row tells."""
    text = reason.removeprefix(f"{log.path}: ").replace(log.path, os.path.basename(log.path))
    return text.replace(f"{work}{os.sep}", "")


def _command(job: Job, log: LocalLog, out: Path) -> list[str]:
    settings = job.settings
    command = [settings.program, "map", log.path, "-o", str(out), "--quiet", "--json"]
    return [*command, *words_of(job.entry.robot, job.entry.options, settings), *settings.flags]


def _note_costs(row: Row, end: ChildEnd) -> None:
    row["process_wall_s"], row["process_cpu_s"] = end.wall_s, end.cpu_s
    row["process_peak_memory_bytes"] = end.peak_memory_bytes
    row["exit_code"], row["signal"] = end.exit_code, end.signal


def _judged(end: ChildEnd, folder: Path) -> tuple[Verdict, Row | None]:
    if end.killed_for == "stopped":
        return Verdict(STOPPED, "the run was interrupted"), None
    verdict = verdict_of(end)
    if verdict.status != DONE:
        # A program need not be able to say so where nothing can be written.
        is_odd = verdict.status in ("bad_data", "crashed")
        if is_odd and shutil.disk_usage(folder.parent).free < FULL_BYTES:
            return Verdict("disk_full", f"no space was left when it ended: {verdict.reason}"), None
        return verdict, None
    try:
        told = json.loads(end.stdout)
    except ValueError:
        told = None
    if not isinstance(told, dict) or read_json(folder / SUMMARY) is None:
        return (Verdict("crashed", "ended with 0, but left no result that can be read"), None)
    return verdict, told


def first_stamp(path: Path) -> float | None:
    """When a trajectory begins, by the log's clock [s]; None where it tells nothing."""
    try:
        with path.open(encoding="ascii") as lines:
            first = next((line for line in lines if line[:1] not in ("#", "\n")), "")
        return float(first.split()[0])
    except (OSError, ValueError, IndexError):
        return None
