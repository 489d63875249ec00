#!/usr/bin/env python3
"""Sums gcov's JSON over a build directory: coverage_report.py BUILD_DIR. Prints percent and lines
of each source file."""

import collections
import gzip
import json
import pathlib
import subprocess
import sys
import tempfile

FOLDERS = ("include/", "src/", "apps/")


def reports(build):
    notes = [str(path.resolve()) for path in sorted(build.rglob("*.gcno"))]
    with tempfile.TemporaryDirectory() as folder:
        for start in range(0, len(notes), 50):
            subprocess.run(
                ["gcov", "--json-format", "--hash-filenames", *notes[start : start + 50]],
                cwd=folder,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                check=True,
            )
        for path in pathlib.Path(folder).glob("*.gcov.json.gz"):
            with gzip.open(path, "rt", encoding="utf-8") as file:
                yield json.load(file)


def main():
    root = pathlib.Path.cwd().resolve()
    hits = collections.defaultdict(lambda: collections.defaultdict(int))
    for report in reports(pathlib.Path(sys.argv[1])):
        for entry in report["files"]:
            path = pathlib.Path(report["current_working_directory"], entry["file"]).resolve()
            if path.is_relative_to(root) and str(path.relative_to(root)).startswith(FOLDERS):
                for line in entry["lines"]:
                    hits[str(path.relative_to(root))][line["line_number"]] += line["count"]
    total = covered = 0
    for name in sorted(hits):
        lines = hits[name]
        hit = sum(1 for count in lines.values() if count)
        total += len(lines)
        covered += hit
        print(f"{100.0 * hit / len(lines):6.1f} %  {hit:5d} of {len(lines):5d}  {name}")
    print(f"{100.0 * covered / max(total, 1):6.1f} %  {covered:5d} of {total:5d}  all lines")


if __name__ == "__main__":
    main()
