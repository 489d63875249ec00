#!/usr/bin/env python3
"""Measures how fast particles are weighed by the likelihood field, beside a form of beluga's update
in the same run, and how fast and how rightly a robot is found on a map by one scan, and writes the
tables of docs/benchmarks.md.

The programs are built by `make bench` (-DLOOPSTONE_BENCH=ON). What was measured is kept in
build/bench/localization_speed.json and relocalize.json.

  bench/localization_speed.py            about five minutes
  bench/localization_speed.py --only relocalize
  bench/localization_speed.py --quick    one repetition; to look at, writes nothing into docs/
  bench/localization_speed.py --write    no measurement: writes the table from what was kept
"""
import argparse
import json
import pathlib
import statistics
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "scripts"))

import relocalize_tables  # noqa: E402
import tables  # noqa: E402
from doc_blocks import table, write_block  # noqa: E402
from program import Loopstone, say  # noqa: E402
from provenance import circumstances  # noqa: E402
from sections import verdicts  # noqa: E402

PAGE, BLOCK = "docs/benchmarks.md", "localization-field"
OURS, SKIPPING, PEER = "loopstone_field", "loopstone_field_skipping", "form_of_beluga"
# Particles and beams, and the time that weighing may take on one core.
TARGET_MS = {(2000, 60): 0.29, (10000, 60): 1.4, (10000, 1081): 14.5}
TARGET_RATIO = 4.0
UNIT_MS = {"ns": 1e-6, "us": 1e-3, "ms": 1.0, "s": 1e3}


def measure(program, work, quick):
    """One row a case: medians of CPU times; the programs of a case take turns, so that a busy
    moment meets both."""
    output = work / "bench_likelihood_field.json"
    subprocess.run(
        [
            str(program),
            f"--benchmark_out={output}",
            "--benchmark_out_format=json",
            "--benchmark_min_time=0.1",
            f"--benchmark_repetitions={1 if quick else 9}",
            "--benchmark_enable_random_interleaving=true",
        ],
        check=True,
        stdout=subprocess.DEVNULL,
    )
    times, counters = {}, {}
    for run in json.loads(output.read_text())["benchmarks"]:
        if run.get("run_type", "iteration") != "iteration":
            continue
        name, *numbers = run["run_name"].split("/")
        key = (name, *[int(number) for number in numbers])
        times.setdefault(key, []).append(run["cpu_time"] * UNIT_MS[run["time_unit"]])
        counters[key] = {"columns": int(run["columns"]), "rows": int(run["rows"])}
    ms = {key: statistics.median(values) for key, values in times.items()}
    rows = []
    for key in ms:
        if key[0] == OURS:
            case = key[1:]
            rows.append(
                {
                    "particles": case[0],
                    "beams": case[1],
                    "everywhere": case[2] != 0,
                    "large": case[3] != 0,
                    **counters[key],
                    "ms": ms[key],
                    "skipping_ms": ms[(SKIPPING, *case)],
                    "peer_ms": ms[(PEER, *case)],
                }
            )
    rows.sort(key=lambda row: (row["large"], row["everywhere"], row["particles"], row["beams"]))
    building = [{**counters[key], "ms": ms[key]} for key in sorted(ms) if key[0] == "build_field"]
    return {"rows": rows, "building": building}


def title(row):
    place = "all over the map" if row["everywhere"] else "in a cloud of 2 m"
    return f"{row['particles']:,} particles x {row['beams']} beams {place}"


def map_of(row):
    return f"{row['columns']} x {row['rows']} cells"


def targets_of(figures):
    found = []
    for row in figures["rows"]:
        limit = TARGET_MS.get((row["particles"], row["beams"]))
        if limit is not None and not row["everywhere"]:
            found.append(
                (
                    f"{title(row)}, {map_of(row)}",
                    f"<= {limit:g} ms",
                    f"{row['ms']:.3f} ms",
                    row["ms"] <= limit,
                )
            )
    ratio = min(row["peer_ms"] / row["ms"] for row in figures["rows"])
    found.append(
        (
            "times as fast as the form of beluga's update, the least of all rows",
            f">= {TARGET_RATIO:g}",
            f"{ratio:.1f}",
            ratio >= TARGET_RATIO,
        )
    )
    return found


def text_of(section):
    figures = section["figures"]
    rows = [
        [
            title(row),
            map_of(row),
            f"{row['ms']:.3f}",
            f"{1e6 * row['ms'] / row['particles'] / row['beams']:.2f}",
            f"{row['skipping_ms']:.3f}",
            f"{row['peer_ms']:.2f}",
            f"{row['peer_ms'] / row['ms']:.1f}",
        ]
        for row in figures["rows"]
    ]
    header = [
        "",
        "map",
        "Loopstone [ms]>",
        "a look-up [ns]>",
        "with beam skipping [ms]>",
        "form of beluga's update [ms]>",
        "times as fast>",
    ]
    building = ", ".join(f"{map_of(row)} {row['ms']:.0f} ms" for row in figures["building"])
    return "\n".join(
        [
            tables.provenance(section),
            "",
            table(header, rows),
            "",
            f"Building the field from an occupancy grid, one thread: {building}.",
            "",
            tables.targets_table(targets_of(figures)),
        ]
    )


def measure_field(arguments):
    return measure(arguments.programs / "bench_likelihood_field", arguments.work, arguments.quick)


def measure_relocalize(arguments):
    return relocalize_tables.measure(arguments.programs / "measure_relocalize", arguments.quick)


# By what --only says: the name of what is kept, the block, and how it is measured, told, judged.
SECTIONS = {
    "field": ("localization_speed", BLOCK, measure_field, text_of, targets_of),
    "relocalize": (
        "relocalize",
        "relocalize",
        measure_relocalize,
        relocalize_tables.text_of,
        relocalize_tables.targets_of,
    ),
}


def do_section(name, arguments):
    name, block, measured, told, judged = SECTIONS[name]
    kept = arguments.work / f"{name}{'-quick' if arguments.quick else ''}.json"
    if arguments.write:
        section = json.loads(kept.read_text())
    else:
        section = circumstances(
            Loopstone(arguments.programs / "loopstone", arguments.work).version()
        )
        section["figures"] = measured(arguments)
        kept.write_text(json.dumps(section, indent=1))
    text = told(section)
    if arguments.quick:
        print(text)
    elif write_block(ROOT / PAGE, block, text):
        say(f"wrote {PAGE}: {block}")
    print(verdicts(judged(section["figures"])))


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--programs", type=pathlib.Path, default=ROOT / "build/release/bin")
    parser.add_argument("--work", type=pathlib.Path, default=ROOT / "build/bench")
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--only", nargs="*", choices=SECTIONS, default=list(SECTIONS))
    parser.add_argument("--write", action="store_true", help="measure nothing, write what was kept")
    arguments = parser.parse_args()

    arguments.work.mkdir(parents=True, exist_ok=True)
    for name in arguments.only:
        do_section(name, arguments)


if __name__ == "__main__":
    main()
