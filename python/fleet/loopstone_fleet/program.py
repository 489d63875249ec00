"""The program `loopstone`: where it is, its version, and whether it takes a manifest's options."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from collections.abc import Sequence

from loopstone_fleet.errors import FleetError
from loopstone_fleet.manifest import Entry
from loopstone_fleet.options import Options

# Each costs a call of some milliseconds; a manifest with more different ones learns row by row.
OPTION_SETS_CHECKED = 200
CALL_S = 60


def find_program(given: str) -> str:
    """The full path: as given, on PATH, or that of the package loopstone."""
    if given:
        found = shutil.which(given)
        if found is None:
            raise FleetError(f"--program {given}: there is no such program")
        return os.path.abspath(found)
    found = shutil.which("loopstone")
    if found is not None:
        return os.path.abspath(found)
    try:
        from loopstone.__main__ import program
    except ImportError:
        raise FleetError(
            "the program loopstone is not on PATH: install it, or give --program PATH"
        ) from None
    return str(program())


def version_of(program: str) -> str:
    done = _call([program, "--version"])
    words = done.stdout.split()
    if done.returncode != 0 or not words:
        raise FleetError(f"{program}: does not tell its version: {done.stderr.strip()}")
    return words[-1]


def site_options(program: str) -> frozenset[str] | None:
    """The names of what `site add` takes; None where this version can't join logs to sites."""
    told = _call([program, "site", "add", "--help"])
    return frozenset(re.findall(r"--[a-z-]+", told.stdout)) if told.returncode == 0 else None


def known_flags(flags: Sequence[str], names: frozenset[str]) -> list[str]:
    """Those of some flags that have one of these names, with their values."""
    known: list[str] = []
    is_known = False
    for word in flags:
        if re.match(r"-\D", word):
            is_known = word.split("=")[0] in names
        if is_known:
            known.append(word)
    return known


def check_options(program: str, entries: list[Entry]) -> list[str]:
    """What the program has against the options of a manifest, with the line of the first."""
    first: dict[Options, int] = {}
    for entry in entries:
        if entry.options:
            first.setdefault(entry.options, entry.line)
    problems = []
    for options, line in list(first.items())[:OPTION_SETS_CHECKED]:
        words = [word for key, value in options for word in ("--set", f"{key}={value}")]
        done = _call([program, "config", *words])
        if done.returncode == 2:
            text = done.stderr.strip().replace("loopstone: --set: ", "").replace("\n", "; ")
            problems.append(f"line {line}: options: {text}")
    return problems


def _call(command: list[str]) -> subprocess.CompletedProcess[str]:
    try:
        return subprocess.run(
            command, capture_output=True, text=True, timeout=CALL_S, stdin=subprocess.DEVNULL
        )
    except OSError as error:
        raise FleetError(f"{command[0]}: cannot be run: {error.strerror}") from None
    except subprocess.TimeoutExpired:
        raise FleetError(f"{' '.join(command)}: gives no answer") from None
