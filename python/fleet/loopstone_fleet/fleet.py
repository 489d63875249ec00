"""The command `run`, step by step: manifest, what is left to do, mapping, sites, table and page."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from itertools import chain
from pathlib import Path
from typing import NamedTuple

from loopstone_fleet.errors import FleetError
from loopstone_fleet.executors import EXECUTORS, Place
from loopstone_fleet.job import Settings, stop
from loopstone_fleet.manifest import Entry, Shard, read_manifest
from loopstone_fleet.outputs import Renewal, write_outputs
from loopstone_fleet.page import State
from loopstone_fleet.plan import Task, plan
from loopstone_fleet.program import (
    check_options,
    find_program,
    known_flags,
    site_options,
    version_of,
)
from loopstone_fleet.progress import Progress
from loopstone_fleet.result_store import ResultStore, Row
from loopstone_fleet.run import Retries, Run
from loopstone_fleet.sites import join_sites
from loopstone_fleet.status import DONE

MIN_MEMORY = 16 << 20
# From the end of an executor to that of its last process.
LAST_WORKER_S = 2.0


class RunCall(NamedTuple):
    """What `run` was asked for."""

    manifest: str
    out: Path
    program: str
    executor: str
    address: str
    workers: int
    shard: Shard | None
    timeout_s: float
    max_memory_bytes: int
    max_log_bytes: int
    retries: Retries
    again: frozenset[str]
    robots: str
    scratch: str
    threads: int
    flags: tuple[str, ...]
    quiet: bool
    name: str
    """Of this run alone."""


def run_fleet(call: RunCall) -> int:
    """Maps what is to be mapped; the exit code. KeyboardInterrupt goes on to the caller, with all
    finished rows in place."""
    store = ResultStore(call.out)
    settings = _settings(call)
    entries = read_manifest(call.manifest)
    problems = check_options(settings.program, entries)
    if problems:
        raise FleetError("\n".join(f"{call.manifest}: {problem}" for problem in problems))
    if call.shard is not None:
        entries = [entry for entry in entries if call.shard.has(entry)]
    store.make()
    store.sweep_work()
    progress = Progress(len(entries), quiet=call.quiet)
    outputs = _Outputs(call, store, entries)
    try:
        tasks = _tasks(call, store, settings, entries, progress)
        helps_again = _map_all(call, store, settings, tasks, progress, outputs)
        _join(call, store, settings, entries, progress)
    except BaseException:
        with suppress(OSError):  # of a full disk; what ended the run is to be told
            outputs.write(is_running=False)
        raise
    finally:
        if not call.address:  # on a cluster of others a worker may still have to see it
            Path(settings.stop_file).unlink(missing_ok=True)
    progress.end()
    outputs.write(is_running=False)
    progress.say(f"{outputs.page}: open it to see what came of it")
    if helps_again:
        progress.say("some logs may end better in another run: the same call tries those again")
    return 1 if helps_again else 0


def _settings(call: RunCall) -> Settings:
    if call.max_memory_bytes < MIN_MEMORY:
        raise FleetError("--max-memory: a log needs at least 16M")
    program = find_program(call.program)
    return Settings(
        program=program,
        version=version_of(program),
        out=str(call.out),
        scratch=call.scratch,
        timeout_s=call.timeout_s,
        max_memory_bytes=call.max_memory_bytes,
        max_log_bytes=call.max_log_bytes,
        threads=call.threads,
        flags=call.flags,
        robots=call.robots,
        anew=DONE in call.again,
        stop_file=str(call.out / "work" / f"stop-{call.name}"),
    )


def _tasks(
    call: RunCall, store: ResultStore, settings: Settings, entries: list[Entry], progress: Progress
) -> Iterator[Task]:
    for planned in plan(entries, store, settings, call.again):
        if planned.task is not None:
            yield planned.task
        else:
            progress.skipped += 1
            progress.tell(0)


def _map_all(
    call: RunCall,
    store: ResultStore,
    settings: Settings,
    tasks: Iterator[Task],
    progress: Progress,
    outputs: _Outputs,
) -> bool:
    """Whether another run would help."""
    first = next(tasks, None)
    if first is None:
        return False
    place = Place(call.workers, call.address, call.max_memory_bytes)
    executor = EXECUTORS[call.executor](place)
    run = Run(store, settings, executor, call.retries, progress, Renewal(outputs.write))
    try:
        run.run(chain([first], tasks))
    except BaseException:
        stop(settings)
        executor.close()
        # A signal to the whole group ends a cluster's workers, too, before they could tidy up.
        store.sweep_work(LAST_WORKER_S)
        raise
    executor.close()
    if run.rows_lost:
        progress.say(
            f"{run.rows_lost} rows could not be written for lack of space; their maps are kept:"
            " make room and run again"
        )
    return run.worth_another_run


def _join(
    call: RunCall, store: ResultStore, settings: Settings, entries: list[Entry], progress: Progress
) -> None:
    with_site = sum(1 for entry in entries if entry.site)
    if not with_site:
        progress.say("no row of the manifest names a site, so none was joined")
        return
    names = site_options(settings.program)
    if names is None:
        progress.say(
            f"loopstone {settings.version} has no command to join sites, so {with_site} logs that"
            " name one were mapped and not joined"
        )
        return
    counts = join_sites(entries, store, settings, call.workers, known_flags(settings.flags, names))
    told = ", ".join(f"{count} {word}" for word, count in sorted(counts.items())) or "nothing"
    progress.say(f"logs at their sites: {told}")


class _Outputs:
    """Table and page of a run: of all that OUT has, or of this shard."""

    def __init__(self, call: RunCall, store: ResultStore, entries: list[Entry]) -> None:
        shard = call.shard
        self._name = f"fleet-{shard.number}-of-{shard.of}" if shard else "fleet"
        self._ids = [entry.id for entry in entries] if shard else None
        self._store, self._of = store, len(entries)

    @property
    def page(self) -> Path:
        return self._store.out / f"{self._name}.html"

    def write(self, is_running: bool = True) -> None:
        write_outputs(self._store.out, self._rows, State(is_running, self._of), self._name)

    def _rows(self) -> Iterator[Row]:
        if self._ids is None:
            yield from self._store.rows()
            return
        for each in self._ids:
            row = self._store.row(each)
            if row is not None:
                yield row
