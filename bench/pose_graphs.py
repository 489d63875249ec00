#!/usr/bin/env python3
"""Measures pose-graph optimisation beside its peers and writes the tables of docs/benchmarks.md.

The graphs are looked for in $LOOPSTONE_DATA/graphs, else in ../shared/data/graphs. Peers (g2o,
GTSAM, Ceres) are compared when they are in build/bench/peers; bench/peers/install.sh puts them
there, and nothing into the system. All of them start from the same file, the poses of the spanning
tree, and are compared at the same cost. What was measured is kept in build/bench/pose_graphs.json.

  bench/pose_graphs.py                      everything, with the peers that are there (some minutes)
  bench/pose_graphs.py --peers              the same, after installing the peers
  bench/pose_graphs.py --only speed         some sections
  bench/pose_graphs.py --quick              one run each and small grids; to look at, writes nothing
                                            into docs/
  bench/pose_graphs.py --only               no measurement: writes the tables from pose_graphs.json
                                            again
"""
import argparse
import json
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "scripts"))

import pose_graph_online as online  # noqa: E402
import pose_graph_starts as starts  # noqa: E402
import pose_graph_tables as tables  # noqa: E402
from doc_blocks import write_block  # noqa: E402
from program import Failed, Loopstone, run, say  # noqa: E402
from provenance import circumstances  # noqa: E402
from recorded import data_folder  # noqa: E402

SECTIONS = ["speed", "certificate", "scaling", "online"]
PAGE = "docs/benchmarks.md"
GRID_SIZES = [1000, 2000, 5000, 10000, 20000, 50000, 100000, 200000]
SCALING_PICTURE = ROOT / "docs/images/pose_graph_scaling.svg"


def peer_commands(peers):
    """name -> command of each peer that is installed; versions; what is missing."""
    python = peers / "venv/bin/python"
    script = ROOT / "bench/peers/pose_graph_peers.py"
    commands, versions, missing = {}, [], []
    for package, module, names in [
        ("g2o", "g2opy", ["g2o_gauss_newton"]),
        ("GTSAM", "gtsam", ["gtsam_gauss_newton", "gtsam_levenberg_marquardt"]),
    ]:
        version = None
        if python.exists():
            code = f"import {module}, importlib.metadata as m; print(m.version('{module}'))"
            answer = subprocess.run(
                [python, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, check=False
            )
            version = answer.stdout.decode().strip() if answer.returncode == 0 else None
        if version is None:
            missing.append(package)
            continue
        versions.append(f"{package} {version}")
        for name in names:
            commands[name] = [python, script, name]
    ceres = peers / "ceres_pose_graph"
    note = peers / "ceres_pose_graph.version"  # of one that runs
    if ceres.exists() and note.exists():
        commands["ceres_levenberg_marquardt"] = [ceres]
        versions.append(note.read_text().strip())
    else:
        missing.append("Ceres")
    return commands, versions, missing


def graphs_of(data):
    found = [(name, data / "graphs" / f"{name}.g2o") for name in tables.OPTIMA]
    for name, path in found:
        if not path.exists():
            say(f"  {path}: not there, skipped")
    return [(name, path) for name, path in found if path.exists()]


def best_of(repeats, measure_once):
    """The fastest of some runs: other work on the machine only ever adds."""
    rows = [measure_once() for _ in range(repeats)]
    best = min(rows, key=lambda row: row["seconds"])
    return {
        **best,
        "cpu_s": min(row["cpu_s"] for row in rows),
        "wall_s": min(row["wall_s"] for row in rows),
    }


def ours(loopstone, path, *flags):
    output, cost = run([loopstone.program, "optimize", path, "--json", "--quiet", *flags])
    result = json.loads(output)
    return {
        **cost,
        "cost": result["cost"],
        "seconds": result["cpu_time_s"],
        "steps": result["iterations"],
        "result": result,
    }


def peer(command, path, optimum, steps=None):
    words = [*command, path]
    if "python" in str(command[0]):
        words += [repr(optimum), *([str(steps)] if steps else [])]
    output, cost = run(words)
    return {**cost, **json.loads(output.strip().splitlines()[-1])}


def best_of_peer(repeats, system, command, path, optimum):
    # g2o is told how many steps it needs; finding that out is in no time that counts.
    steps = peer(command, path, optimum)["steps"] if system.startswith("g2o") else None
    return best_of(repeats, lambda: peer(command, path, optimum, steps))


def speed(loopstone, data, work, peers, repeats):
    rows = []
    for name, path in graphs_of(data):
        _, edges = starts.read_graph(path)
        start = work / f"{name}-tree.g2o"
        starts.write_graph(start, starts.spanning_tree(edges), edges)
        optimum = tables.OPTIMA[name]["chi2"]
        row = {"name": name, "edges": len(edges), "systems": {}}
        own = best_of(repeats, lambda: ours(loopstone, start, "--initial", "file"))
        row["poses"] = own.pop("result")["poses"]
        row["systems"]["loopstone"] = own
        scratch = best_of(repeats, lambda: ours(loopstone, path, "--certify"))
        result = scratch["result"]
        del scratch["result"]
        row["systems"]["loopstone_certified"] = {**scratch, "seconds": result["cpu_time_s"]}
        for system, command in peers.items():
            try:
                row["systems"][system] = best_of_peer(repeats, system, command, start, optimum)
            except (Failed, ValueError) as failure:
                say(f"  {name}, {system}: FAILED {str(failure).splitlines()[-1]}")
        say(
            f"  {name}: "
            + ", ".join(
                f"{system} {1e3 * figures['seconds']:.1f} ms"
                for system, figures in row["systems"].items()
            )
        )
        rows.append(row)
    return rows


def certificate(loopstone, data, repeats):
    rows = []
    for name, path in graphs_of(data):
        for start in ["best", "file"]:
            if start == "file" and not starts.read_graph(path)[0]:
                continue
            runs = []
            for _ in range(repeats):
                runs.append(ours(loopstone, path, "--certify", "--initial", start)["result"])
            best = min(runs, key=lambda result: result["cpu_time_s"])
            rows.append(
                {
                    "name": name,
                    "start": best["initial"] if start == "best" else "file",
                    "poses": best["poses"],
                    "cost": best["cost"],
                    "certified": best["certified"],
                    "certificate": best["certificate"],
                    "min_eigenvalue": best["min_eigenvalue"],
                    "gap": best["optimality_gap"],
                    "cpu_s": best["cpu_time_s"],
                }
            )
            say(
                f"  {name} from {start}: certified {best['certified']},"
                f" {1e3 * rows[-1]['cpu_s']:.1f} ms"
            )
    return rows


def scaling(loopstone, work, repeats, sizes):
    rows = []
    for nodes in sizes:
        path = work / f"grid-{nodes}.g2o"
        if not path.exists():
            starts.write_grid(path, nodes)
        best = best_of(max(1, repeats // 2), lambda p=path: ours(loopstone, p, "--initial", "file"))
        result = best.pop("result")
        rows.append(
            {
                "nodes": nodes,
                "edges": result["edges"],
                "steps": best["steps"],
                "seconds": best["seconds"],
                "peak_mb": best["peak_mb"],
                "status": result["status"],
            }
        )
        say(
            f"  {nodes} poses: {best['seconds']:.3f} s in {best['steps']} steps,"
            f" {best['peak_mb']:.0f} MB"
        )
    return rows


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--programs", type=pathlib.Path, default=ROOT / "build/release/bin")
    parser.add_argument("--data", type=pathlib.Path, default=data_folder(ROOT))
    parser.add_argument("--work", type=pathlib.Path, default=ROOT / "build/bench")
    parser.add_argument("--only", nargs="*", choices=SECTIONS, default=SECTIONS)
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument(
        "--sizes", nargs="+", type=int, default=GRID_SIZES, help="poses of the grids of `scaling`"
    )
    parser.add_argument(
        "--peers", action="store_true", help="install the peers into build/bench/peers first"
    )
    parser.add_argument("--quick", action="store_true")
    arguments = parser.parse_args()
    if arguments.quick:
        arguments.repeats, arguments.sizes = 1, GRID_SIZES[:3]

    work = arguments.work / "pose_graphs"
    work.mkdir(parents=True, exist_ok=True)
    if arguments.peers:
        subprocess.run(["bash", str(ROOT / "bench/peers/install.sh")], check=False)
    peers, versions, missing = peer_commands(arguments.work / "peers")
    if missing:
        say(f"peers not installed: {', '.join(missing)} (bench/peers/install.sh); going on without")
    loopstone = Loopstone(arguments.programs / "loopstone", arguments.work)
    kept = arguments.work / ("pose_graphs-quick.json" if arguments.quick else "pose_graphs.json")
    sections = json.loads(kept.read_text()) if kept.exists() else {}
    for name in arguments.only:
        say(f"{name}:")
        when = {
            **circumstances(loopstone.version()),
            "peers": versions,
            "missing": missing,
            "repeats": arguments.repeats,
        }
        if name == "speed":
            figures = speed(loopstone, arguments.data, work, peers, arguments.repeats)
        elif name == "certificate":
            figures = certificate(loopstone, arguments.data, arguments.repeats)
        elif name == "online":
            figures = online.measure(arguments.programs, arguments.data, arguments.repeats)
        else:
            figures = scaling(loopstone, work, arguments.repeats, arguments.sizes)
        if figures:
            sections[name] = {**when, "figures": figures}
            kept.write_text(json.dumps(sections, indent=1))
    for block, text in tables.blocks_of(sections):
        if arguments.quick:
            print(f"\n{PAGE}: {block}\n{text}")
        else:
            write_block(ROOT / PAGE, block, text)
    if "scaling" in sections and not arguments.quick:
        SCALING_PICTURE.write_text(tables.scaling_picture(sections["scaling"]), encoding="utf-8")
    print(tables.summary(sections))
    return 0


if __name__ == "__main__":
    sys.exit(main())
