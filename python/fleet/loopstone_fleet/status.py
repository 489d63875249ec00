"""How a log can end, and what of it is worth another try."""

from __future__ import annotations

from typing import NamedTuple

from loopstone_fleet.child import ChildEnd


class Status(NamedTuple):
    """One word of the column `status`."""

    meaning: str
    curable: bool
    """Whether the same log may end otherwise when it is tried again."""


DONE = "done"
STATUSES: dict[str, Status] = {
    DONE: Status("mapped and judged", False),
    "bad_data": Status("the program found that nothing can be made of the log", False),
    "bad_call": Status("the program refused the options of this row", False),
    "timeout": Status("took longer than --timeout", False),
    "out_of_memory": Status("needed more memory than --max-memory", False),
    "crashed": Status("the program ended by a signal, or without a result", False),
    "killed": Status("somebody else ended the program: a shut-down, an operator", True),
    "disk_full": Status("no space was left for the result, or for the fetched log", True),
    "store_failed": Status("the store did not hand out the log", True),
    "worker_failed": Status("the worker that had the log died or lost its connection", True),
}

FULL_DISK_WORDS = ("No space left on device", "Disk quota exceeded")
NO_MEMORY_WORDS = ("out of memory", "Cannot allocate memory", "Resource temporarily unavailable")
INTERRUPTED = 130
SIGKILL, SIGINT, SIGTERM = 9, 2, 15


class Verdict(NamedTuple):
    """What an ended process means."""

    status: str
    reason: str


def last_words(text: str) -> str:
    """What a program said at its end, without its name and earlier warnings."""
    lines = [line for line in text.strip().splitlines() if line.strip()]
    return lines[-1].removeprefix("loopstone: ") if lines else ""


def is_curable(status: str) -> bool:
    return STATUSES[status].curable


def verdict_of(end: ChildEnd) -> Verdict:
    """The status of a process that has ended, with a reason that a person can use."""
    said = last_words(end.stderr_tail)
    if end.killed_for == "timeout":
        return Verdict("timeout", f"was not done after {end.limits.timeout_s:g} s and was ended")
    if end.killed_for == "memory":
        held, allowed = end.peak_memory_bytes / 1e6, end.limits.max_memory_bytes / 1e6
        return Verdict("out_of_memory", f"held {held:.0f} MB where {allowed:.0f} MB are allowed")
    if end.killed_for == "chatter":
        return Verdict("crashed", "wrote messages without end and was ended")
    if end.exit_code == 0:
        return Verdict(DONE, "")
    if end.signal is not None:
        return _verdict_of_signal(end)
    if end.exit_code == 2:
        return Verdict("bad_call", said or "the program refused its call")
    if end.exit_code == INTERRUPTED:
        return Verdict("killed", "was interrupted from outside")
    if any(word in end.stderr_tail for word in FULL_DISK_WORDS):
        return Verdict("disk_full", said)
    if any(word in end.stderr_tail for word in NO_MEMORY_WORDS):
        return Verdict("out_of_memory", said)
    if end.exit_code == 1:
        return Verdict("bad_data", said or "the program gave no reason")
    return Verdict("crashed", f"ended with {end.exit_code}: {said or 'no reason given'}")


def _verdict_of_signal(end: ChildEnd) -> Verdict:
    if end.signal == SIGKILL and end.kernel_out_of_memory:
        return Verdict("out_of_memory", "the kernel ended it: the machine had no memory left")
    if end.signal in (SIGKILL, SIGINT, SIGTERM):
        return Verdict("killed", f"was ended from outside by signal {end.signal}")
    said = last_words(end.stderr_tail)
    return Verdict("crashed", f"signal {end.signal}" + (f"; it last said: {said}" if said else ""))
