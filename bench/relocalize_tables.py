"""What single scans on maps are measured by, and its tables: bench/localization_speed.py runs
measure_relocalize and writes them."""
import json

import tables
from doc_blocks import table
from program import run, say

# Title, place, seeds, scans each, and keys of measure_relocalize.
CASES = [
    ("campus", "campus", 4, 100, {"prepared_times": 3}),
    ("eleven campuses", "campus", 1, 110, {"places": 11}),
    ("office", "office", 4, 50, {}),
    ("warehouse", "warehouse", 2, 50, {}),
    ("equal rooms", "rooms", 2, 50, {}),
    ("a corridor of 100 m", "corridor", 2, 50, {}),
    ("office, 40 things gone, 40 new", "office", 4, 50, {"clutter": 40}),
    ("campus, 40 things gone, 40 new", "campus", 2, 50, {"clutter": 40}),
    ("office, on another office's map", "office", 4, 50, {"map_seed": 100}),
    ("campus, on another campus's map", "campus", 2, 50, {"map_seed": 100}),
]
# What a scan may take, its median and its slowest [ms].
TIMED = {"campus": (100.0, 100.0), "eleven campuses": (None, 3000.0)}
BINS = 5


def measure(program, quick):
    """One row a case: all scans of its seeds."""
    cases = []
    for title, place, seeds, scans, keys in CASES:
        row = {"title": title, "another": "map_seed" in keys, "prepare_ms": [], "scans": []}
        for seed in range(1, (1 if quick else seeds) + 1):
            words = [f"{key}={value + seed * (key == 'map_seed')}" for key, value in keys.items()]
            count = scans // 5 if quick else scans
            said = json.loads(run([program, place, f"seed={seed}", f"scans={count}", *words])[0])
            row["prepare_ms"].append(said["prepare_ms"])
            row["scans"] += said["scans"]
            row.setdefault("floor_m2", said["floor_m2"])
        say(f"  {title}: {len(row['scans'])} scans")
        cases.append(row)
    return cases


def best_of(scan):
    """Probability and rightness of the most probable candidate."""
    return scan["stated"][0] if scan["stated"] else [0.0, False]


def share(values):
    values = list(values)
    return sum(values) / max(len(values), 1)


def cells_of(row):
    times = sorted(scan["ms"] for scan in row["scans"])
    scans = row["scans"]
    right = "-" if row["another"] else f"{100 * share(best_of(scan)[1] for scan in scans):.1f}"
    listed = "-" if row["another"] else f"{100 * share(scan['listed'] for scan in scans):.1f}"
    return [
        row["title"],
        f"{row['floor_m2']:,.0f}",
        str(len(scans)),
        f"{sorted(row['prepare_ms'])[len(row['prepare_ms']) // 2]:.0f}",
        f"{times[len(times) // 2]:.1f}",
        f"{times[len(times) * 99 // 100]:.1f}",
        f"{times[-1]:.1f}",
        right,
        listed,
        f"{share(best_of(scan)[0] for scan in scans):.3f}",
        f"{share(scan['none'] for scan in scans):.3f}",
    ]


HEADER = [
    "map",
    "floor [m2]>",
    "scans>",
    "prepared once [ms]>",
    "a scan, median [ms]>",
    "99 of 100 within [ms]>",
    "slowest [ms]>",
    "best is right [%]>",
    "true pose listed [%]>",
    "its probability, mean>",
    "none, mean>",
]


def calibration_rows(cases):
    """Stated probabilities of all candidates listed against the share of them that is right."""
    stated = [pair for row in cases for scan in row["scans"] for pair in scan["stated"]]
    rows = []
    for index in range(BINS):
        low, high = index / BINS, (index + 1) / BINS
        inside = [pair for pair in stated if low <= pair[0] < high or pair[0] == high == 1.0]
        if not inside:
            continue
        rows.append(
            [
                f"{low:.1f} to {high:.1f}",
                f"{share(pair[0] for pair in inside):.3f}",
                f"{share(pair[1] for pair in inside):.3f}",
                f"{len(inside):,}",
            ]
        )
    return rows


def targets_of(cases):
    found = []
    for row in cases:
        if row["title"] not in TIMED:
            continue
        times = sorted(scan["ms"] for scan in row["scans"])
        values = {"the median": times[len(times) // 2], "the slowest": times[-1]}
        for (what, value), limit in zip(values.items(), TIMED[row["title"]]):
            if limit is None:
                continue
            name = (
                f"{row['title']}, {row['floor_m2']:,.0f} m2: {what} of {len(times)} scans, CPU"
                " time on one core"
            )
            found.append((name, f"<= {limit:g} ms", f"{value:.1f} ms", value <= limit))
    return found


def text_of(section):
    cases = section["figures"]
    return "\n".join(
        [
            tables.provenance(section),
            "",
            table(HEADER, [cells_of(row) for row in cases]),
            "",
            table(
                ["stated probability", "its mean>", "share right>", "candidates>"],
                calibration_rows(cases),
            ),
            "",
            tables.targets_table(targets_of(cases)),
        ]
    )
