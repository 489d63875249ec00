#!/usr/bin/env python3
"""Compares two builds of the program on this machine, in turn, in one run: the front end, a match,
the solution of a graph.

  bench/compare_speed.py BASE HEAD       two programs; scripts/compare_speed.sh BASE_COMMIT builds
                                         them

CPU times of whole processes with one thread, of the front end the wall time that the run tells, on
inputs that HEAD's program makes. Base and head take turns (B H H B ...), so that a busy moment
meets both. Ends with 1 when the median of head is more than MARGIN times that of base and most
pairs say the same.
"""
import argparse
import json
import pathlib
import statistics
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "scripts"))

import pose_graph_starts  # noqa: E402
from doc_blocks import table  # noqa: E402
from program import Loopstone, run  # noqa: E402

# With other work on both of two cores the medians of nine runs of one program differ by up to 6 %,
# half of the pairs by up to 14 %. What a change costs by mistake (a copy in an inner loop, a lost
# early end) is more.
MARGIN = 1.25
# So many of the pairs have to agree.
PAIRS_SHARE = 0.75
ROUNDS = 9
GRID_POSES = 20000


def cases(loopstone):
    """name -> words after the program, and where the run tells its time, as a file and a key; or
    nothing."""
    log = loopstone.simulate("office", 1, ["--beams", "361"])
    graph = loopstone.work / f"grid-{GRID_POSES}.g2o"
    if not graph.exists():
        pose_graph_starts.write_grid(graph, GRID_POSES)
    out = loopstone.work / "compared"
    return {
        "front end": (
            [
                "map",
                log,
                "-o",
                out,
                "--no-loop-closure",
                "--no-texture",
                "--set",
                "adjustment.enabled=false",
                "--threads",
                "1",
                "--force",
                "--quiet",
            ],
            (out / "summary.json", "front_end_wall_s"),
        ),
        "match of a scan on a map": (
            ["match", f"{log}#120", log / "map.yaml", "--global", "--threads", "1", "--quiet"],
            None,
        ),
        "solution of a graph": (["optimize", graph, "--initial", "file", "--quiet"], None),
    }


def compare(base, head, words, told, rounds):
    """Times [s] of both; the same program twice shows the noise."""
    base_s, head_s = [], []
    for number in range(rounds):
        turns = [(base, base_s), (head, head_s)]
        for program, times in turns if number % 2 == 0 else reversed(turns):
            _, cost = run([program, *words])
            times.append(json.loads(told[0].read_text())[told[1]] if told else cost["cpu_s"])
    return base_s, head_s


def judge(base_s, head_s):
    """Ratio of medians, quartiles of the pairs' ratios, and whether head is slower beyond doubt."""
    ratio = statistics.median(head_s) / statistics.median(base_s)
    pairs = [head / base for base, head in zip(base_s, head_s)]
    low, _, high = statistics.quantiles(pairs, n=4)
    slower = ratio > MARGIN and sum(pair > MARGIN for pair in pairs) >= PAIRS_SHARE * len(pairs)
    return ratio, low, high, slower


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("base", type=pathlib.Path)
    parser.add_argument("head", type=pathlib.Path)
    parser.add_argument("--rounds", type=int, default=ROUNDS)
    parser.add_argument("--work", type=pathlib.Path, default=ROOT / "build/compare")
    arguments = parser.parse_args()
    base, head = arguments.base.resolve(), arguments.head.resolve()
    arguments.work.mkdir(parents=True, exist_ok=True)
    rows, slow = [], []
    for name, (words, told) in cases(Loopstone(head, arguments.work)).items():
        base_s, head_s = compare(base, head, words, told, arguments.rounds)
        ratio, low, high, slower = judge(base_s, head_s)
        rows.append(
            [
                name,
                f"{statistics.median(base_s):.3f}",
                f"{statistics.median(head_s):.3f}",
                f"{ratio:.3f}",
                f"{low:.3f} to {high:.3f}",
                "**slower**" if slower else "as fast",
            ]
        )
        slow += [name] if slower else []
    print(table(["", "base [s]>", "head [s]>", "head / base>", "half of the pairs", ""], rows))
    return 1 if slow else 0


if __name__ == "__main__":
    sys.exit(main())
