"""A pose graph that grows while it is solved: measured by bench/measure_incremental.cpp, told as
tables. No figure is typed here but the targets."""
import json
import os

import tables
from doc_blocks import table
from program import run, say
from registration_tables import provenance

GRAPHS = ["intel", "manhattan", "city10000"]
ROWS = [
    ("all", "all"),
    ("appends", "without closures"),
    ("closures", "with closures"),
    ("last", "last 1000"),
    ("last_closures", "last 1000, with closures"),
]
QUANTILES = ["mean_ms", "median_ms", "p90_ms", "p99_ms", "max_ms"]
LARGE = "city10000"
MEDIAN_MS, MEAN_MS, P99_MS, EXCESS = 0.5, 1.0, 5.0, 0.05


def measure(programs, data, repeats):
    """Replays of each graph; the smallest of each figure, since other work on the machine only ever
    adds and the rest is the same in each run."""
    program = programs / "measure_incremental"
    if not os.access(program, os.X_OK):
        say(f"  {program}: not built (cmake -DLOOPSTONE_BENCH=ON), skipped")
        return []
    rows = []
    for name in GRAPHS:
        path = data / "graphs" / f"{name}.g2o"
        if not path.exists():
            say(f"  {path}: not there, skipped")
            continue
        runs = [json.loads(run([program, path])[0]) for _ in range(repeats)]
        if len({result["cost"] for result in runs}) != 1:
            raise ValueError(f"{name}: the runs end at different costs")
        best = {"name": name, **runs[0], "solve_ms": min(result["solve_ms"] for result in runs)}
        for key, _ in ROWS:
            best[key] = {
                **runs[0][key],
                **{q: min(result[key][q] for result in runs) for q in QUANTILES},
            }
        say(
            f"  {name}: last 1000 mean {best['last']['mean_ms']:.3f} ms, 99 %"
            f" {best['last']['p99_ms']:.2f} ms"
        )
        rows.append(best)
    return rows


def excess(row, cost):
    return f"{100 * (cost / row['solved_cost'] - 1):.2f} %"


def targets(rows):
    found = []
    for row in rows:
        found.append(
            (
                f"{row['name']}: cost before solve() above the optimum",
                f"<= {100 * EXCESS:g} %",
                excess(row, row["cost"]),
                row["cost"] <= (1 + EXCESS) * row["solved_cost"],
            )
        )
        if row["name"] == LARGE:
            for key, words, limit in [
                ("median_ms", "median", MEDIAN_MS),
                ("mean_ms", "mean", MEAN_MS),
                ("p99_ms", "99 %", P99_MS),
            ]:
                found.append(
                    (
                        f"{row['name']}: {words} of the last 1000 key scans",
                        f"<= {limit:g} ms",
                        f"{row['last'][key]:.3f} ms",
                        row["last"][key] <= limit,
                    )
                )
    return found


def online_tables(section):
    rows = section["figures"]
    body = []
    for row in rows:
        for key, words in ROWS:
            figures = row[key]
            body.append(
                [
                    row["name"],
                    words,
                    f"{figures['count']:.0f}",
                    *[f"{figures[q]:.3f}" for q in QUANTILES],
                    f"{figures['eliminated']:.1f}",
                ]
            )
    costs = [
        [
            row["name"],
            f"{row['cost']:.6f}",
            excess(row, row["cost"]),
            f"{row['solved_cost']:.6f}",
            f"{row['solve_ms']:.1f}",
        ]
        for row in rows
    ]
    return "\n".join(
        [
            provenance(section, with_peers=False),
            "",
            (
                "CPU time of a key scan [ms], its pose and all of its closures in one update; the"
                f" smallest of {section['repeats']} runs."
            ),
            "",
            table(
                [
                    "graph",
                    "key scans",
                    "count>",
                    "mean>",
                    "median>",
                    "90 %>",
                    "99 %>",
                    "largest>",
                    "poses eliminated>",
                ],
                body,
            ),
            "",
            table(
                [
                    "graph",
                    "cost at the end>",
                    "above the optimum>",
                    "cost after solve()>",
                    "solve() [ms]>",
                ],
                costs,
            ),
            "",
            tables.targets_table(targets(rows)),
        ]
    )
