#!/usr/bin/env python3
"""Writes the generated parts of docs/bayes_filters.md: lines of examples/08_bayes_filters.cpp, and
what the program prints.

  scripts/bayes_filters_docs.py PROGRAM            writes; PROGRAM is
                                                   build/release/bin/example_08_bayes_filters
  scripts/bayes_filters_docs.py PROGRAM --check    tells whether the page is up to date (exit 1: no)
"""
import pathlib
import re
import subprocess
import sys
import textwrap

from doc_blocks import read_block, write_block

ROOT = pathlib.Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs/bayes_filters.md"
SOURCE = ROOT / "examples/08_bayes_filters.cpp"


def code_block(name):
    """The lines between `// [name]` and `// [end]`."""
    found = re.search(
        rf"^ *// \[{name}\]\n(.*?)^ *// \[end\]", SOURCE.read_text(encoding="utf-8"), re.M | re.S
    )
    if not found:
        sys.exit(f"{SOURCE.relative_to(ROOT)}: has no part '// [{name}]'")
    return f"```cpp\n{textwrap.dedent(found.group(1)).rstrip()}\n```"


def main():
    check = sys.argv[2:] == ["--check"]
    if len(sys.argv) != 2 and not check:
        sys.exit(__doc__)
    printed = subprocess.run([sys.argv[1]], check=True, stdout=subprocess.PIPE).stdout.decode()
    blocks = {name: code_block(name) for name in ("histogram filter", "particle filter")}
    blocks["output"] = f"```text\n{printed.rstrip()}\n```"
    stale = []
    for name, text in blocks.items():
        if not check:
            write_block(PAGE, name, text)
        elif (read_block(PAGE, name) or "").rstrip() != text:
            stale.append(name)
    if stale:
        sys.exit(
            f"{PAGE.relative_to(ROOT)}: out of date: {', '.join(stale)}. Run"
            " scripts/bayes_filters_docs.py PROGRAM"
        )


if __name__ == "__main__":
    main()
