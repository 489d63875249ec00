"""The program: ``python -m loopstone map LOG -o OUT`` is ``loopstone map LOG -o OUT``."""

from __future__ import annotations

import os
import sys


def program() -> str:
    """Where the program is that came with this package."""
    return os.path.join(os.path.dirname(os.path.abspath(__file__)), "bin", "loopstone")


def main() -> None:
    path = program()
    if not os.path.exists(path):  # of a build in place
        sys.exit(f"loopstone: the program is not where it should be: {path}")
    os.execv(path, [path, *sys.argv[1:]])


if __name__ == "__main__":
    main()
