#!/usr/bin/env python3
"""Tells which tests were skipped, and why: scripts/skipped_tests.py FILE

FILE has a line `program<TAB>test<TAB>reason` for each (tests/main/main.cpp writes it); without a
file none was skipped.
"""
import pathlib
import re
import sys

RECORDED = re.compile(r"recorded|/\S* is not here")


def why(reason):
    if RECORDED.search(reason):
        return "they need recorded data (LOOPSTONE_DATA)"
    return reason or "no reason given"


def lines_of(text):
    """A line for each reason, with its tests by program."""
    tests = {}
    for line in dict.fromkeys(text.splitlines()):
        program, test, reason = line.split("\t")
        tests.setdefault(why(reason), {}).setdefault(program, []).append(test)
    for reason, programs in sorted(tests.items()):
        count = sum(map(len, programs.values()))
        names = "; ".join(
            f"{program} {', '.join(sorted(names))}" for program, names in sorted(programs.items())
        )
        yield f"{count} test{'s' if count > 1 else ''} skipped, {reason}: {names}"


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    path = pathlib.Path(sys.argv[1])
    text = path.read_text(encoding="utf-8", errors="replace") if path.exists() else ""
    print("\n".join(lines_of(text)) or "no test skipped")


if __name__ == "__main__":
    main()
