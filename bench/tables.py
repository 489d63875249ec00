"""From measured figures to Markdown. Nothing is measured here, and no figure is typed here."""
import targets
from doc_blocks import table
from provenance import provenance


def targets_table(rows):
    return table(
        ["figure", "target", "measured", ""],
        [[name, target, measured, targets.verdict(met)] for name, target, measured, met in rows],
    )


def plus_minus(statistics, digits):
    return f"{statistics['mean']:.{digits}f} +- {statistics['std']:.{digits}f}"


def cost_cells(row):
    if "cpu_s" not in row:
        return ["", "", "", ""]
    return [
        f"{row['cpu_s']:.1f}",
        f"{row['wall_s']:.1f}",
        f"{row['duration_s'] / row['wall_s']:.0f}",
        f"{row['peak_mb']:.0f}",
    ]


COST_HEADER = ["CPU [s]>", "wall [s]>", "times real time>", "peak memory [MB]>"]


def real_tables(section):
    parts = [provenance(section), ""]
    for log in section["figures"]:
        rows = []
        with_relations = "translation_m" in log["rows"][-1]
        for row in log["rows"]:
            cells = [row["system"]]
            if with_relations:
                cells += [
                    plus_minus(row["translation_m"], 3),
                    f"{row['translation_m']['median']:.3f}",
                    plus_minus(row["rotation_deg"], 2),
                ]
            rows.append(cells + [str(row.get("closures", ""))] + cost_cells(row))
        header = ["system"]
        if with_relations:
            header += ["translation [m]>", "median [m]>", "rotation [deg]>"]
        mapped = log["rows"][-1]
        intro = f"**{log['title']}**: {mapped['scans']} scans, {mapped['duration_s']:.0f} s."
        if with_relations:
            intro += f" {mapped['pairs']} relations compared, {mapped['pairs_missing']} missing."
        else:
            intro += " No independent relations exist for this log, so only what it took is stated."
        if "corrected" in log:
            other = log["corrected"]
            intro += (
                f" The same log as another system corrected it has poses for {other['of']} scans:"
                f" Loopstone's are {other['ate_m']:.3f} m and {57.29578 * other['ate_rad']:.2f} deg"
                " (rms, after the best rigid alignment) off them."
            )
        parts += [intro, "", table(header + ["loop closures>"] + COST_HEADER, rows), ""]
    parts += [targets_table(targets.of_real(section["figures"]))]
    return "\n".join(parts)


def spread_of(runs):
    if len(runs) < 2:
        return ""
    errors = sorted(run["ate_m"] for run in runs)
    middle = (
        errors[len(errors) // 2] if len(errors) % 2 else sum(errors[len(errors) // 2 - 1 :][:2]) / 2
    )
    return f"Median {1000 * middle:.1f} mm, largest {1000 * errors[-1]:.1f} mm."


def simulated_tables(section):
    parts = [provenance(section), ""]
    for case in section["figures"]:
        good = [run for run in case["runs"] if not run.get("failed")]
        baseline = any("baseline_m" in run for run in good)
        header = ["seed>", "path [m]>", "odometry ATE [m]>"] + (
            ["scan to scan ATE [m]>"] if baseline else []
        )
        header += [
            "without adjustment ATE [m]>",
            "Loopstone ATE [m]>",
            "largest error [m]>",
            "heading [deg]>",
            "map F1>",
            "loop closures>",
            "times real time>",
            "peak memory [MB]>",
        ]
        rows = []
        for run in case["runs"]:
            if run.get("failed"):
                rows.append([str(run["seed"]), "failed"] + [""] * (len(header) - 2))
                continue
            cells = [str(run["seed"]), f"{run['path_m']:.0f}", f"{run['odometry_m']:.2f}"]
            if baseline:
                cells += [f"{run['baseline_m']:.3f}" if "baseline_m" in run else ""]
            cells += [
                f"{run['unadjusted_m']:.4f}",
                f"{run['ate_m']:.4f}",
                f"{run['max_m']:.3f}",
                f"{57.29578 * run['ate_rad']:.3f}",
                f"{run['f1']:.3f}",
                str(run["closures"]),
                f"{run['duration_s'] / run['wall_s']:.0f}",
                f"{run['peak_mb']:.0f}",
            ]
            rows.append(cells)
        command = " ".join(["loopstone simulate", case["world"], *case["flags"], "--seed N"])
        parts += [
            f"**{case['name']}** (`{command}`). {spread_of(good)}".rstrip(),
            "",
            table(header, rows),
            "",
        ]
    parts += [targets_table(targets.of_simulated(section["figures"]))]
    return "\n".join(parts)


def speed_tables(section):
    speed = section["figures"]
    rows = []
    for run in speed["variants"]:
        rows.append(
            [
                run["name"],
                f"{run['wall_s']:.1f}",
                f"{run['fastest_wall_s']:.1f}",
                f"{run['cpu_s']:.1f}",
                f"{run['duration_s'] / run['wall_s']:.0f}",
                f"{run['peak_mb']:.0f}",
            ]
        )
    parts = [
        provenance(section),
        "",
        (
            "Intel, from the file to the written map and report; medians of"
            f" {speed['repeats']} whole processes."
        ),
        "",
        table(
            [
                "",
                "wall [s]>",
                "fastest wall [s]>",
                "CPU [s]>",
                "times real time>",
                "peak memory [MB]>",
            ],
            rows,
        ),
        "",
        targets_table(targets.of_speed(speed)),
    ]
    return "\n".join(parts)


def laps_table(section):
    rows = [
        [
            run["drive"],
            f"{run['path_m']:.0f}",
            f"{run['scans']}",
            f"{run['keys'] - run['thinned']} of {run['keys']}",
            f"{run['wall_s']:.1f}",
            f"{run['cpu_s']:.1f}",
            f"{run['duration_s'] / run['wall_s']:.0f}",
            f"{run['peak_mb']:.0f}",
            f"{1e3 * run['ate_m']:.1f}",
        ]
        for run in section["figures"]
    ]
    return "\n".join(
        [
            provenance(section),
            "",
            table(
                [
                    "drive",
                    "path [m]>",
                    "scans>",
                    "key scans kept>",
                    "wall [s]>",
                    "CPU [s]>",
                    "times real time>",
                    "peak memory [MB]>",
                    "ATE rmse [mm]>",
                ],
                rows,
            ),
            "",
            targets_table(targets.of_laps(section["figures"])),
        ]
    )


def peers_table(section):
    rows = []
    for row in section["figures"]:
        ours, theirs = row["ours"], row["theirs"]
        rows.append(
            [
                row["log"],
                f"{ours['wall_s']:.1f}",
                f"{theirs['wall_s']:.1f}",
                f"{ours['cpu_s']:.1f}",
                f"{theirs['cpu_s']:.1f}",
                f"{theirs['cpu_s'] / ours['cpu_s']:.2f}",
                f"{ours['peak_mb']:.0f}",
                f"{theirs['peak_mb']:.0f}",
            ]
        )
    return "\n".join(
        [
            provenance(section),
            "",
            table(
                [
                    "log",
                    "Loopstone, wall [s]>",
                    "icp-slam, wall [s]>",
                    "Loopstone, CPU [s]>",
                    "icp-slam, CPU [s]>",
                    "CPU, icp-slam / Loopstone>",
                    "Loopstone, peak [MB]>",
                    "icp-slam, peak [MB]>",
                ],
                rows,
            ),
        ]
    )


def online_table(section):
    rows = []
    for row in section["figures"]:
        times = [
            f"{1e3 * row[f'{which}_{what}_s']:.{digits}f}"
            for what, digits in (("latency", 1), ("computing", 2))
            for which in ("median", "p99", "worst")
        ]
        rows.append(
            [
                row["log"],
                f"{row['speed']:.0f} x",
                "one" if row["threads"] == 1 else "two",
                f"{row['scans']}",
                f"{row['submaps']}",
                *times,
            ]
        )
    header = [
        "log",
        "pace>",
        "processors>",
        "scans>",
        "submaps>",
        "pose after: median [ms]>",
        "99 % [ms]>",
        "worst [ms]>",
        "of it computing: median [ms]>",
        "99 % [ms]>",
        "worst [ms]>",
    ]
    return "\n".join(
        [
            provenance(section),
            "",
            table(header, rows),
            "",
            targets_table(targets.of_online(section["figures"])),
        ]
    )


def live_map_table(section):
    rows = [
        [
            row["log"],
            f"{row['scans']}",
            f"{row['refreshes']}",
            f"{row['tiles']}",
            f"{1e3 * row['refresh_median_s']:.1f}",
            f"{1e3 * row['refresh_worst_s']:.0f}",
            f"{100.0 * row['equal_share']:.2f} %",
            f"{100.0 * row['opposite_share']:.2f} %",
        ]
        for row in section["figures"]
    ]
    header = [
        "log",
        "scans>",
        "refreshed>",
        "tiles>",
        "refresh: median [ms]>",
        "worst [ms]>",
        "cells the same>",
        "cells the opposite>",
    ]
    return "\n".join([provenance(section), "", table(header, rows)])


STAGES = [
    ("front_end_wall_s", "front end: filter, predict, align, insert"),
    ("loop_closing_wall_s", "loop closing: search and refinement"),
    ("optimisation_wall_s", "pose graph"),
    ("adjustment_wall_s", "adjustment of all key scans to the surfaces they share"),
    ("rendering_wall_s", "final occupancy map"),
    ("judging_wall_s", "how good the map is"),
]


def stage_table(section):
    run = section["figures"]["variants"][-1]  # one thread: the stages follow each other
    whole_s = run["fastest_wall_s"]
    known = [(title, run["fastest_stages"][key]) for key, title in STAGES]
    known.append(
        (
            "the rest: reading, writing, pictures, report",
            whole_s - sum(seconds for _, seconds in known),
        )
    )
    rows = [
        [title, f"{seconds:.2f}", f"{100 * seconds / whole_s:.0f} %"] for title, seconds in known
    ]
    return "\n".join(
        [
            provenance(section),
            "",
            f"Intel with one thread, the fastest of {section['figures']['repeats']} runs.",
            "",
            table(["stage", "wall [s]>", "share>"], rows),
        ]
    )


def overview(sections, names):
    """What a page begins with: every figure that was asked for, in one table."""
    rows = targets.of_sections(sections, names)
    met = sum(row[3] for row in rows)
    return "\n".join(
        [
            f"{met} of {len(rows)} targets met.",
            "",
            targets_table(rows),
            "",
            provenance(*(sections[name] for name in names if name in sections)),
        ]
    )


def headline(sections):
    rows = []
    if "real" in sections:
        for log in sections["real"]["figures"]:
            row = log["rows"][-1]
            if "translation_m" in row:
                before = log["rows"][0]["translation_m"]["mean"]
                rows.append(
                    [
                        f"{log['title']} (recorded, {row['duration_s']:.0f} s)",
                        "relations, mean",
                        f"{before:.2f} m",
                        f"{row['translation_m']['mean']:.3f} m",
                        f"{row['wall_s']:.1f} s",
                    ]
                )
    if "simulated" in sections:
        for case in sections["simulated"]["figures"]:
            good = [run for run in case["runs"] if not run.get("failed")]
            if case["name"] in ("office", "campus") and good:
                worst = max(good, key=lambda run: run["ate_m"])
                rows.append(
                    [
                        f"{case['name']} (simulated, worst of {len(case['runs'])} seeds)",
                        "ATE rmse",
                        f"{worst['odometry_m']:.2f} m",
                        f"{worst['ate_m']:.3f} m",
                        f"{worst['wall_s']:.1f} s",
                    ]
                )
    shown = [sections[name] for name in ("real", "simulated") if name in sections]
    return (
        table(["log", "error", "odometry>", "Loopstone>", "time to map>"], rows)
        + "\n\n"
        + provenance(*shown)
    )


def session(section):
    lines = ["```text"]
    for command, output in section["figures"]:
        lines += ["$ " + command, *[line.rstrip() for line in output.rstrip().splitlines()], ""]
    lines[-1] = "```"
    return "\n".join([*lines, "", provenance(section)])
