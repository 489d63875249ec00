#!/usr/bin/env python3
"""Plants false loop closures in public pose graphs, counts which of them --robust gnc throws out,
and writes the table of docs/pose_graphs.md.

The graphs are looked for in $LOOPSTONE_DATA/graphs, else in ../shared/data/graphs. Percentages are
of the number of the graph's own closures: 60 means 60 false ones to 100 genuine ones, 150 that 60 %
of all are false. Other kernels solve the same files for comparison. What was measured is kept in
build/bench/outliers.json.

  bench/outliers.py                                    everything
  bench/outliers.py --graphs ring --percent 20 40 --seeds 2
  bench/outliers.py --resume                           the graphs that have no figures yet
  bench/outliers.py --graphs                           no measurement: writes the table from
                                                       outliers.json again
"""
import argparse
import concurrent.futures
import csv
import json
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "scripts"))

import outlier_graphs as graphs  # noqa: E402
import outlier_tables as tables  # noqa: E402
import pose_graph_starts as starts  # noqa: E402
from doc_blocks import write_block  # noqa: E402
from program import Loopstone, run, say  # noqa: E402
from recorded import data_folder  # noqa: E402
from sections import measure_sections  # noqa: E402

PAGE, BLOCK = ROOT / "docs/pose_graphs.md", "pose-graph-outliers"
GRAPHS = ["ring", "intel", "manhattan"]
PERCENT = [10, 20, 30, 40, 50, 60, 70, 80, 150, 400]
# Kernels take up to a minute a graph, since false closures fill the factor.
KERNEL_PERCENT = [20, 60]
PARTS = ["gnc", "kernels"]
TRUTH = {"ring": "ring_poses.txt"}
# gnc makes its own start. Kernels have two, one that no closure has bent, and what is nearer the
# truth in the end counts.
KERNEL_STARTS = ["odometry", "best"]
SET_ASIDE_BELOW = 0.5


def solve(loopstone, path, work, robust, initial):
    """Poses, every edge's final weight, and the program's result."""
    solved = work / f"{path.stem}-{robust}.g2o"
    weights = work / f"{path.stem}-{robust}.csv"
    output, _ = run(
        [
            loopstone.program,
            "optimize",
            path,
            "--robust",
            robust,
            "--initial",
            initial,
            "-o",
            solved,
            "--edges",
            weights,
            "--force",
            "--json",
            "--quiet",
        ]
    )
    poses, _ = starts.read_graph(solved)
    with open(weights, encoding="utf-8", newline="") as file:
        kept = [float(row["weight"]) >= SET_ASIDE_BELOW for row in csv.DictReader(file)]
    solved.unlink()
    weights.unlink()
    return poses, kept, json.loads(output)


class Clean:
    """A graph as it came, and what it is compared with."""

    def __init__(self, loopstone, name, data, work):
        self.name, self.path = name, data / "graphs" / f"{name}.g2o"
        _, self.edges = starts.read_graph(self.path)
        solved = work / f"{name}-clean.g2o"
        output, _ = run(
            [
                loopstone.program,
                "optimize",
                self.path,
                "--certify",
                "-o",
                solved,
                "--force",
                "--json",
                "--quiet",
            ]
        )
        self.result = json.loads(output)
        self.optimum, _ = starts.read_graph(solved)
        self.closures = len(graphs.closures_of(self.edges))
        self.odometry_m = graphs.distance_m(graphs.odometry(self.edges), self.optimum)
        self.truth = (
            graphs.read_truth(data / "graphs/truth" / TRUTH[name]) if name in TRUTH else None
        )
        self.truth_m = graphs.distance_m(self.optimum, self.truth) if self.truth else None


def spoilt(clean, work, percent, seed):
    """A file with false closures in it, and how many."""
    count = round(clean.closures * percent / 100)
    path = work / f"{clean.name}-{percent}-{seed}.g2o"
    graphs.write_spoilt(path, clean.path, graphs.planted(clean.optimum, clean.edges, count, seed))
    return path, count


def gnc_run(loopstone, clean, work, percent, seed):
    path, count = spoilt(clean, work, percent, seed)
    poses, kept, result = solve(loopstone, path, work, "gnc", "best")
    path.unlink()
    genuine = len(clean.edges)
    return {
        "percent": percent,
        "seed": seed,
        "planted": count,
        "false_out": kept[genuine:].count(False),
        "genuine_out": kept[:genuine].count(False),
        "cpu_s": result["cpu_time_s"],
        "cost": result["cost"],
        "truth_m": graphs.distance_m(poses, clean.truth) if clean.truth else None,
        "off_m": graphs.distance_m(poses, clean.optimum),
    }


def kernel_run(loopstone, clean, work, percent, seed):
    path, _ = spoilt(clean, work, percent, seed)
    row = {"percent": percent, "seed": seed, "off_m": {}, "cpu_s": {}}
    for kernel in tables.KERNELS:
        ends = []
        for start in KERNEL_STARTS:
            poses, _, result = solve(loopstone, path, work, kernel, start)
            ends.append((graphs.distance_m(poses, clean.optimum), result["cpu_time_s"]))
        row["off_m"][kernel], row["cpu_s"][kernel] = min(ends)
    path.unlink()
    return row


def measure_graph(section, arguments, loopstone):
    name, part = section.split("-")
    work = arguments.work / "outliers"
    clean = Clean(loopstone, name, arguments.data, work)
    if part == "gnc":
        once, percents, seeds = gnc_run, arguments.percent, arguments.seeds
    else:
        once, percents, seeds = kernel_run, arguments.kernel_percent, arguments.kernel_seeds
    jobs = [(percent, seed) for percent in percents for seed in range(seeds)]
    with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
        rows = list(pool.map(lambda job: once(loopstone, clean, work, *job), jobs))
    figures = {
        "name": name,
        "poses": len(clean.optimum),
        "closures": clean.closures,
        "cost": clean.result["cost"],
        "certified": clean.result["certified"],
        "odometry_m": clean.odometry_m,
        "truth_m": clean.truth_m,
        "extent_m": graphs.extent_m(clean.optimum),
        "seeds": seeds,
        "runs": rows,
    }
    for line in tables.progress(figures) if part == "gnc" else []:
        say(f"  {line}")
    return figures


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--programs", type=pathlib.Path, default=ROOT / "build/release/bin")
    parser.add_argument("--data", type=pathlib.Path, default=data_folder(ROOT))
    parser.add_argument("--work", type=pathlib.Path, default=ROOT / "build/bench")
    parser.add_argument("--graphs", nargs="*", choices=GRAPHS, default=GRAPHS)
    parser.add_argument("--parts", nargs="+", choices=PARTS, default=PARTS)
    parser.add_argument("--percent", nargs="+", type=int, default=PERCENT)
    parser.add_argument("--seeds", type=int, default=10, help="seeds 0 to N - 1")
    parser.add_argument("--kernel-percent", nargs="+", type=int, default=KERNEL_PERCENT)
    parser.add_argument("--kernel-seeds", type=int, default=3)
    parser.add_argument(
        "--jobs", type=int, default=2, help="graphs solved at a time, each with one thread"
    )
    parser.add_argument(
        "--quick", action="store_true", help="to look at, writes nothing into docs/"
    )
    parser.add_argument("--resume", action="store_true", help="leave out what has been measured")
    arguments = parser.parse_args()
    arguments.only = [f"{name}-{part}" for part in arguments.parts for name in arguments.graphs]

    (arguments.work / "outliers").mkdir(parents=True, exist_ok=True)
    loopstone = Loopstone(arguments.programs / "loopstone", arguments.work)
    sections, failed = measure_sections(
        "outliers",
        arguments,
        loopstone,
        lambda name: measure_graph(name, arguments, loopstone),
        leave_out=lambda name, sections: arguments.resume and name in sections,
    )
    text = tables.text_of(GRAPHS, sections)
    if arguments.quick:
        print(text)
    else:
        write_block(PAGE, BLOCK, text)
    print(tables.summary(GRAPHS, sections))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
