"""The command line of loopstone-fleet."""

from __future__ import annotations

import argparse
import os
import re
import signal
import sys
import uuid
from collections.abc import Sequence
from pathlib import Path
from types import FrameType

from loopstone_fleet import __version__
from loopstone_fleet.errors import FleetError
from loopstone_fleet.executors import EXECUTORS
from loopstone_fleet.fleet import RunCall, run_fleet
from loopstone_fleet.listing import write_listing
from loopstone_fleet.manifest import parse_shard
from loopstone_fleet.outputs import PAGE, TABLE, merge, source_of, write_outputs
from loopstone_fleet.page import State
from loopstone_fleet.run import Retries
from loopstone_fleet.status import STATUSES

INTERRUPTED = 130
DEFAULT_MEMORY = 4 << 30
MEMORY_SHARE = 0.8
# Of the folder, which is written as it is given; the command checks more.
_RESERVED = ("-o", "--out", "--json", "-q", "--quiet", "--max-memory", "--threads", "--set")
_FILES = ("--robot", "-c", "--config", "--continue", "--mcap", "--checkpoint", "--resume", "--view")

EPILOG = """\
A MANIFEST is CSV or Parquet with a column `log` and, if you like, `robot`, `site` and `options`.
Words after -- are given to `map` of every log: loopstone-fleet run logs.csv -o out -- --no-texture

Exit codes: 0 every log has its row, mapped or not; 1 another run would help (a store that failed, a
full disk, lost workers); 2 a wrong call or manifest; 130 interrupted: run again to go on.

Examples:
  loopstone-fleet manifest recordings --levels robot -o logs.csv
  loopstone-fleet run logs.csv -o out --timeout 600 --max-memory 2G
  loopstone-fleet run s3://fleet/logs.parquet -o /shared/out --shard 3/16 && \\
  loopstone-fleet merge /shared/out -o /shared/out
"""


def size(text: str) -> int:
    """Bytes of '512M' or '2G'."""
    match = re.fullmatch(r"(\d+(?:\.\d+)?)([KMGT])i?B?", text.strip(), re.IGNORECASE)
    if match is None or float(match[1]) <= 0:
        raise argparse.ArgumentTypeError(f"'{text}' is no size; write 512M or 2G")
    return int(float(match[1]) * 1024 ** (" KMGT".index(match[2].upper())))


def positive(text: str) -> float:
    value = float(text)
    if not value > 0:
        raise argparse.ArgumentTypeError(f"'{text}' is not above 0")
    return value


def count(text: str) -> int:
    value = int(text)
    if value < 1:
        raise argparse.ArgumentTypeError(f"'{text}' is not 1 or more")
    return value


def not_negative(text: str) -> int:
    value = int(text)
    if value < 0:
        raise argparse.ArgumentTypeError(f"'{text}' is below 0")
    return value


def default_memory(workers: int) -> int:
    """4 GB, or less where so many workers would not fit into this machine."""
    machine = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    return min(DEFAULT_MEMORY, int(MEMORY_SHARE * machine / workers))


def parser() -> argparse.ArgumentParser:
    whole = argparse.ArgumentParser(
        prog="loopstone-fleet",
        description="Maps and judges many logs with Loopstone, on one machine or on many.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    whole.add_argument("--version", action="version", version=f"loopstone-fleet {__version__}")
    commands = whole.add_subparsers(dest="command", required=True, metavar="COMMAND")
    _add_run(commands.add_parser("run", help="map the logs of a manifest"))
    again = commands.add_parser("report", help="write table and page anew from the rows")
    again.add_argument("out", metavar="OUT", type=Path)
    merged = commands.add_parser("merge", help="one table and page of several runs or shards")
    merged.add_argument("outs", metavar="OUT", type=Path, nargs="+")
    merged.add_argument("-o", "--out", metavar="FOLDER", type=Path, required=True)
    made = commands.add_parser("manifest", help="make a manifest of the logs in a folder")
    made.add_argument("folder", metavar="FOLDER", help="a folder, or a prefix such as s3://a/b")
    made.add_argument("-o", "--out", metavar="FILE.csv", help="default: stdout")
    made.add_argument(
        "--levels",
        default="",
        metavar="NAME,...",
        help="what the folders below are named for: robot, site or -, such as site,robot",
    )
    return whole


def _add_run(run: argparse.ArgumentParser) -> None:
    run.add_argument("manifest", metavar="MANIFEST")
    run.add_argument("-o", "--out", metavar="OUT", type=Path, required=True, help="results' folder")
    run.add_argument("--program", default="", help="loopstone (default: on PATH, or the package's)")
    run.add_argument("--executor", choices=sorted(EXECUTORS), default="local")
    run.add_argument("--address", default="", help="of a Dask or Ray cluster that runs")
    run.add_argument(
        "--workers", type=count, metavar="N", help="logs at a time (default: one per processor)"
    )
    run.add_argument("--shard", metavar="i/n", help="only this part of the manifest, from 0/n")
    run.add_argument(
        "--timeout", type=positive, default=3600.0, metavar="S", help="for a log (default: 3600)"
    )
    run.add_argument(
        "--max-memory", type=size, metavar="SIZE", help="for a log (default: 4G, or what there is)"
    )
    run.add_argument(
        "--max-log",
        type=size,
        default=64 << 30,
        metavar="SIZE",
        help="to fetch from a store (default: 64G)",
    )
    run.add_argument(
        "--retries",
        type=not_negative,
        default=3,
        metavar="N",
        help="of what may be cured (default: 3)",
    )
    run.add_argument(
        "--pause",
        type=positive,
        default=2.0,
        metavar="S",
        help="before the first of them; doubled each time, 60 at most (default: 2)",
    )
    run.add_argument(
        "--again",
        default="",
        metavar="STATUS,...",
        help="do these anew whatever their rows say: " + ", ".join(STATUSES) + " or all",
    )
    run.add_argument(
        "--robots", type=Path, metavar="FOLDER", help="with ROBOT.toml of each robot's wheels"
    )
    run.add_argument("--scratch", default="", metavar="FOLDER", help="for logs from a store")
    run.add_argument(
        "--threads", type=count, default=1, metavar="N", help="of each process (default: 1)"
    )
    run.add_argument("-q", "--quiet", action="store_true", help="no progress")


def check_flags(flags: Sequence[str]) -> None:
    """What comes after -- must not be ours, nor a file whose content we would not know of."""
    for word in flags:
        name = word.split("=")[0]
        if name in _RESERVED:
            raise FleetError(f"{name} cannot stand after --: loopstone-fleet gives it by itself")
        if name in _FILES:
            raise FleetError(
                f"{name} cannot stand after --: results are known by options, which go into the"
                " manifest's column, and robots, which go into --robots FOLDER"
            )


def call_of(options: argparse.Namespace, flags: Sequence[str]) -> RunCall:
    check_flags(flags)
    if "://" in str(options.out) or re.match(r"[a-z0-9]+:/", str(options.out)):
        raise FleetError(f"-o {options.out}: results go to a folder, which machines may share")
    if options.robots is not None and not options.robots.is_dir():
        raise FleetError(f"--robots {options.robots}: there is no such folder")
    if options.address and options.executor == "local":
        raise FleetError("--address is of a cluster: give --executor dask or ray, too")
    again = [word for word in options.again.split(",") if word]
    for word in again:
        if word != "all" and word not in STATUSES:
            raise FleetError(f"--again {word}: is no status; they are {', '.join(STATUSES)}, all")
    workers = options.workers or len(os.sched_getaffinity(0))
    return RunCall(
        manifest=options.manifest,
        out=options.out.absolute(),
        program=options.program,
        executor=options.executor,
        address=options.address,
        workers=workers,
        shard=parse_shard(options.shard) if options.shard else None,
        timeout_s=options.timeout,
        max_memory_bytes=options.max_memory or default_memory(workers),
        max_log_bytes=options.max_log,
        retries=Retries(options.retries, options.pause),
        again=frozenset(STATUSES if "all" in again else again),
        robots=str(options.robots.absolute()) if options.robots else "",
        scratch=options.scratch,
        threads=options.threads,
        flags=tuple(flags),
        quiet=options.quiet,
        name=uuid.uuid4().hex[:12],
    )


def run_command(options: argparse.Namespace, flags: Sequence[str]) -> int:
    if options.command == "run":
        return run_fleet(call_of(options, flags))
    if flags:
        raise FleetError("only `run` takes words after --")
    if options.command == "report":
        source = source_of(options.out)
        rows = write_outputs(options.out, source.rows, State(False, 0))
        print(f"{options.out / PAGE} and {TABLE}: {rows} logs")
    elif options.command == "merge":
        rows = merge(options.outs, options.out)
        print(f"{options.out / PAGE} and {TABLE}: {rows} logs")
    else:
        levels = [level for level in options.levels.split(",") if level]
        if options.out is None:
            write_listing(options.folder, levels, sys.stdout)
        else:
            with open(options.out, "w", encoding="utf-8", newline="") as file:
                logs = write_listing(options.folder, levels, file)
            print(f"{options.out}: {logs} logs")
    return 0


def _interrupt(number: int, frame: FrameType | None) -> None:
    raise KeyboardInterrupt


def main(arguments: Sequence[str] | None = None) -> int:
    words = list(sys.argv[1:] if arguments is None else arguments)
    flags: list[str] = []
    if "--" in words:
        at = words.index("--")
        words, flags = words[:at], words[at + 1 :]
    options = parser().parse_args(words)
    # Slurm and Kubernetes say so before they end a process.
    signal.signal(signal.SIGTERM, _interrupt)
    try:
        return run_command(options, flags)
    except FleetError as error:
        for line in str(error).splitlines():
            print(f"loopstone-fleet: {line}", file=sys.stderr)
        return 2
    except OSError as error:
        print(f"loopstone-fleet: {error.filename or 'system'}: {error.strerror}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("loopstone-fleet: interrupted; the same call goes on", file=sys.stderr)
        return INTERRUPTED
