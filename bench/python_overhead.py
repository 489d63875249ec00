#!/usr/bin/env python3
"""What calling the library from Python costs over the program: the Intel log, mapped and saved by
both in turn. Writes the table of docs/python.md.

    bench/python_overhead.py            needs build/python/venv (scripts/test_python.sh)
    bench/python_overhead.py --quick    one round, prints the table
"""
import json
import pathlib
import shutil
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "scripts"))

import tables  # noqa: E402
from doc_blocks import table, write_block  # noqa: E402
from program import Loopstone, median, run, say  # noqa: E402
from provenance import circumstances  # noqa: E402
from sections import plain_parser, verdicts  # noqa: E402

PAGE = "docs/python.md"
BLOCK = "python-overhead"
TARGET = 0.02
ROUNDS = 7
SCRIPT = "import sys, loopstone as ls; ls.map(sys.argv[1]).save(sys.argv[2])"


def measure(loopstone, python, log, rounds):
    """Median CPU time, wall time and peak memory of each way; each round runs both in turn."""
    out = loopstone.work / "python-overhead"
    ways = {
        "program": [loopstone.program, "map", log, "-o", out, "--quiet"],
        "Python": [python, "-c", SCRIPT, log, out],
    }
    costs = {way: [] for way in ways}
    for i in range(rounds):
        for way, command in ways.items():
            shutil.rmtree(out, ignore_errors=True)
            costs[way].append(run(command)[1])
        say(
            f"  round {i + 1}: "
            + ", ".join(f"{w} {c[-1]['cpu_s']:.2f} s" for w, c in costs.items())
        )
    return {
        way: {key: median([cost[key] for cost in runs]) for key in runs[0]}
        for way, runs in costs.items()
    }


def text_of(section):
    figures = section["figures"]
    rows = [
        [way, f"{c['cpu_s']:.2f}", f"{c['wall_s']:.2f}", f"{c['peak_mb']:.0f}"]
        for way, c in figures.items()
    ]
    header = ["Intel log, by the", "CPU [s]>", "wall [s]>", "peak memory [MB]>"]
    return "\n".join([tables.provenance(section), "", table(header, rows)])


def main():
    arguments = plain_parser(__doc__, ROOT).parse_args()
    arguments.work.mkdir(parents=True, exist_ok=True)
    loopstone = Loopstone(arguments.programs / "loopstone", arguments.work)
    python = ROOT / "build/python/venv/bin/python"
    section = circumstances(loopstone.version())
    log = arguments.data / "carmen" / "intel.clf"
    rounds = 1 if arguments.quick else ROUNDS
    section["figures"] = measure(loopstone, python, log, rounds)
    (arguments.work / "python_overhead.json").write_text(json.dumps(section, indent=1))
    text = text_of(section)
    if arguments.quick:
        print(text)
    elif write_block(ROOT / PAGE, BLOCK, text):
        say(f"wrote {PAGE}: {BLOCK}")
    costs = section["figures"]
    share = costs["Python"]["cpu_s"] / costs["program"]["cpu_s"] - 1.0
    name = "CPU time over the program's"
    print(verdicts([(name, f"{TARGET:.0%}", f"{share:.1%}", share <= TARGET)]))


if __name__ == "__main__":
    main()
