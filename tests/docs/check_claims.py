#!/usr/bin/env python3
"""Holds sentences to the tables that they come from.

  tests/docs/check_claims.py             every claim in README.md, CONTRIBUTING.md,
                                         CHANGELOG.md and docs/
  tests/docs/check_claims.py --self-test

A claim stands behind its sentence, which a reader sees without it:

  Ten laps take little more than one.
  <!-- holds: docs/benchmarks.md laps | 10 laps | measured <= 1.5 -->

It names page and generated block, the beginning of a row's first cell (empty: every row), and a
bound on the first number in a column, `measured <= 1.5`, or on the ratio of two, `a / b >= 2`;
several bounds with `and`. Every row that it means has to keep it, in every table of the block that
has the columns; a claim that means no row is wrong, too.
"""
import operator
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "scripts"))

from doc_blocks import read_block  # noqa: E402

PAGES = [
    *(ROOT / name for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md")),
    *sorted((ROOT / "docs").glob("*.md")),
]
CLAIM = re.compile(r"<!-- holds: (\S+) (\S+) \|(.*?)\|(.*?)-->", re.S)
BOUND = re.compile(r"(.+?)(?: / (.+?))? (<=|>=) (-?[\d.]+)")
NUMBER = re.compile(r"-?\d+(?:\.\d+)?")
RELATIONS = {"<=": operator.le, ">=": operator.ge}


def cells(line):
    return [cell.strip() for cell in line.strip().strip("|").split("|")]


def tables_of(text):
    """(header, rows) of each table of a block."""
    for found in re.finditer(r"^(\|.*)\n\|[ :|-]+\|\n((?:\|.*\n?)*)", text, re.M):
        yield cells(found.group(1)), [cells(line) for line in found.group(2).splitlines()]


def number_in(cell):
    found = NUMBER.search(cell)
    return float(found.group()) if found else None


def values_of(text, row_begins, column, divisor):
    """(row's name, value) of every row that is meant and has the figures."""
    for header, rows in tables_of(text):
        if column not in header or divisor and divisor not in header:
            continue
        for row in rows:
            value = number_in(row[header.index(column)])
            below = number_in(row[header.index(divisor)]) if divisor else 1.0
            if row[0].startswith(row_begins) and value is not None and below:
                yield row[0], value / below


def broken(text, row_begins, bounds):
    """What is wrong with a claim about this block."""
    for bound in re.sub(r"\s+", " ", bounds).strip().split(" and "):
        parts = BOUND.fullmatch(bound.strip())
        if not parts:
            yield f"'{bound.strip()}' is no bound"
            continue
        column, divisor, relation, limit = parts.groups()
        found = list(values_of(text, row_begins.strip(), column, divisor))
        if not found:
            yield f"no row begins with '{row_begins.strip()}' and has '{column}'" + (
                f" and '{divisor}'" if divisor else ""
            )
        yield from (
            f"'{bound.strip()}' does not hold: {name} has {value:.4g}"
            for name, value in found
            if not RELATIONS[relation](value, float(limit))
        )


def check():
    problems, count = [], 0
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        for claim in CLAIM.finditer(text):
            count += 1
            where = f"{page.relative_to(ROOT)}:{text.count(chr(10), 0, claim.start()) + 1}"
            target, block, row, bounds = claim.groups()
            of_block = read_block(ROOT / target, block) if (ROOT / target).exists() else None
            if of_block is None:
                problems.append(f"{where}: {target} has no block {block}")
                continue
            problems += [
                f"{where}: {target} ({block}): {problem}"
                for problem in broken(of_block, row, bounds)
            ]
        if text.count("<!-- holds:") != len(CLAIM.findall(text)):
            problems.append(
                f"{page.relative_to(ROOT)}: a claim that can't be read; see"
                " tests/docs/check_claims.py"
            )
    return problems, count


def self_test():
    block = (
        "words\n\n| figure | before [m] | after [m] |\n| --- | ---: | --- |\n| one lap | 0.40 +- 1"
        " | 0.10 |\n| two | 0.9 m | **0.3** |\n\n| other | x |\n|---|---|\n| one | 7 |\n"
    )
    assert not list(broken(block, "", "before [m] / after [m] >= 3 and after [m] <= 0.3"))
    assert list(broken(block, " one ", "before [m] / after [m] <= 3")) == [
        "'before [m] / after [m] <= 3' does not hold: one lap has 4"
    ]
    assert list(broken(block, "two", "x <= 9")) == ["no row begins with 'two' and has 'x'"]
    assert not list(broken(block, "one", "x\n  <= 7"))
    assert list(broken(block, "", "nonsense")) == ["'nonsense' is no bound"]
    assert CLAIM.search("a <!-- holds: p.md b | 10 laps | c <= 1 --> d").groups() == (
        "p.md",
        "b",
        " 10 laps ",
        " c <= 1 ",
    )


def main():
    if sys.argv[1:] == ["--self-test"]:
        self_test()
        return
    if len(sys.argv) > 1:
        sys.exit(__doc__)
    problems, count = check()
    if problems:
        sys.exit("\n".join(problems))
    print(f"{count} claims hold")


if __name__ == "__main__":
    main()
