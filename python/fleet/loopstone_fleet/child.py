"""One run of a program, within limits of time and memory, that can neither hang nor harm us."""

from __future__ import annotations

import os
import select
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import BinaryIO, NamedTuple

LAUNCHER = Path(__file__).with_name("launch.py")
CHECKED_EVERY_S = 0.1
# Between SIGTERM, on which the program ends tidily, and SIGKILL.
GRACE_S = 2.0
TAIL_BYTES = 4096
# Of stdout, where a summary is some 10 kB, and stderr together; they are kept in memory, so that a
# full disk does not swallow what was said about it.
CHATTER_BYTES = 16 << 20


class Limits(NamedTuple):
    """Of one process."""

    timeout_s: float
    max_memory_bytes: int
    """Of memory of its own; files that it maps do not count."""


class ChildEnd(NamedTuple):
    """How a process ended and what it took."""

    limits: Limits
    exit_code: int | None
    signal: int | None
    killed_for: str
    """timeout, memory, chatter or stopped where we ended it; else empty."""
    kernel_out_of_memory: bool
    """Whether the kernel ended some process for lack of memory meanwhile."""
    wall_s: float
    cpu_s: float
    peak_memory_bytes: int
    stdout: bytes
    stderr_tail: str


def run_child(command: Sequence[str], limits: Limits, stop_file: Path | None = None) -> ChildEnd:
    """Runs a command, a full path and its arguments, to its end.

    It is ended when it passes a limit or when `stop_file` appears. OSError when no process can be
    made.
    """
    kernel_kills = _kernel_kills()
    started = time.monotonic()
    launcher = [sys.executable, "-I", "-S", str(LAUNCHER)]
    # The watched limit comes first; the net catches what asks for all at once.
    net_bytes = 2 * limits.max_memory_bytes + (1 << 30)
    with _memory_file("stdout") as out, _memory_file("stderr") as err:
        process = subprocess.Popen(
            [*launcher, str(os.getpid()), str(net_bytes), *command],
            stdin=subprocess.DEVNULL,
            stdout=out,
            stderr=err,
            start_new_session=True,  # Ctrl-C is ours; we end it
            env={**os.environ, "LC_ALL": "C.UTF-8"},
        )
        try:
            status, cpu_s, killed_for, peak = _watch(process, out, err, limits, stop_file)
        except BaseException:
            _end(process, signal.SIGKILL)
            process.wait()
            raise
        code = os.waitstatus_to_exitcode(status)
        process.returncode = code
        _end(process, signal.SIGKILL)  # what it started and left
        return ChildEnd(
            limits,
            code if code >= 0 else None,
            -code if code < 0 else None,
            killed_for,
            _kernel_kills() > kernel_kills,
            time.monotonic() - started,
            cpu_s,
            peak,
            _tail(out, CHATTER_BYTES),
            _tail(err, TAIL_BYTES).decode("utf-8", errors="replace"),
        )


def _watch(
    process: subprocess.Popen[bytes],
    out: BinaryIO,
    err: BinaryIO,
    limits: Limits,
    stop_file: Path | None,
) -> tuple[int, float, str, int]:
    """Waits for the end: the status of waitpid, CPU seconds, why we ended it, peak memory."""
    killed_for, kill_at, peak = "", 0.0, 0
    started = time.monotonic()
    with _EndOf(process.pid) as end:
        while True:
            pid, status, usage = os.wait4(process.pid, os.WNOHANG)
            if pid:
                return status, usage.ru_utime + usage.ru_stime, killed_for, peak
            held, most = _memory(process.pid)
            peak = max(peak, most)
            now = time.monotonic()
            if killed_for:
                if now > kill_at:
                    _end(process, signal.SIGKILL)
            else:
                said = _size(out) + _size(err)
                killed_for = _fault(limits, now - started, held, said, stop_file)
                if killed_for:
                    # What is too large may be asking for more right now.
                    mild = killed_for in ("timeout", "stopped")
                    _end(process, signal.SIGTERM if mild else signal.SIGKILL)
                    kill_at = now + GRACE_S
            # What is short is looked at more often, for the most memory that it held.
            end.wait(min(CHECKED_EVERY_S, 0.01 + (now - started) / 10))


def _fault(limits: Limits, wall_s: float, held: int, said: int, stop_file: Path | None) -> str:
    if stop_file is not None and stop_file.exists():
        return "stopped"
    if wall_s > limits.timeout_s:
        return "timeout"
    if held > limits.max_memory_bytes:
        return "memory"
    return "chatter" if said > CHATTER_BYTES else ""


class _EndOf:
    """Waits for the end of a process, without looking again and again where the kernel can tell."""

    def __init__(self, pid: int) -> None:
        try:
            self._descriptor = os.pidfd_open(pid)
        except OSError:
            self._descriptor = -1

    def __enter__(self) -> _EndOf:
        return self

    def __exit__(self, *_: object) -> None:
        if self._descriptor >= 0:
            os.close(self._descriptor)

    def wait(self, seconds: float) -> None:
        if self._descriptor < 0:
            time.sleep(seconds / 4)
            return
        poll = select.poll()
        poll.register(self._descriptor, select.POLLIN)
        poll.poll(seconds * 1e3)


def _memory(pid: int) -> tuple[int, int]:
    """Memory of its own that a process holds, and the most that it held, with files [bytes]."""
    figures = {"RssAnon:": 0, "RssShmem:": 0, "VmHWM:": 0}
    try:
        with open(f"/proc/{pid}/status", encoding="ascii", errors="replace") as status:
            for line in status:
                words = line.split()
                if words and words[0] in figures:
                    figures[words[0]] = int(words[1]) * 1024
    except OSError:  # it has just ended
        pass
    return figures["RssAnon:"] + figures["RssShmem:"], figures["VmHWM:"]


def _kernel_kills() -> int:
    """How often this machine's kernel has ended a process for lack of memory."""
    try:
        with open("/proc/vmstat", encoding="ascii") as figures:
            return sum(int(line.split()[1]) for line in figures if line.startswith("oom_kill "))
    except OSError:
        return 0


def _end(process: subprocess.Popen[bytes], number: int) -> None:
    try:
        os.killpg(process.pid, number)
    except (ProcessLookupError, PermissionError):
        pass


def _memory_file(name: str) -> BinaryIO:
    return os.fdopen(os.memfd_create(name), "r+b", buffering=0)


def _size(file: BinaryIO) -> int:
    return os.fstat(file.fileno()).st_size


def _tail(file: BinaryIO, size: int) -> bytes:
    file.seek(max(0, _size(file) - size))
    return file.read(size)
