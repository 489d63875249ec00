"""The tables of docs/sites.md, from what bench/sites.py measured."""
import tables
from doc_blocks import table


def with_targets(section, text, targets):
    return "\n".join([tables.provenance(section), "", text, "", tables.targets_table(targets)])


def joining_targets(rows):
    usable = sum(row["usable"] for row in rows)
    joined = sum(row["joined"] for row in rows)
    false = sum(row["false"] + row["strangers_joined"] for row in rows)
    worst = max(rows, key=lambda row: row["ate_m"] / row["long_m"])
    return [
        (
            "of sessions with 20 % of their way where others were, joined",
            ">= 99 %",
            f"{100.0 * joined / usable:.1f} % ({joined} of {usable})",
            joined >= 0.99 * usable,
        ),
        ("sessions joined falsely, and of another building", "0", str(false), false == 0),
        (
            "error of all sessions / of one long drive, at most",
            "<= 1.5",
            f"{worst['ate_m'] / worst['long_m']:.2f} ({worst['world']} {worst['seed']})",
            worst["ate_m"] <= 1.5 * worst["long_m"],
        ),
    ]


def joining_table(section):
    rows = section["figures"]
    header = [
        "building",
        "sessions>",
        "own map bad>",
        "overlap 20 %>",
        "joined>",
        "falsely>",
        "strangers joined>",
        "error [m]>",
        "one long drive [m]>",
        "looked for in [s]>",
        "map [s]>",
        "file [MB]>",
        "verdict",
    ]
    cells = [
        [
            f"{row['world']} {row['seed']}",
            str(row["sessions"]),
            str(row["refused"]),
            str(row["usable"]),
            str(row["joined"]),
            str(row["false"]),
            f"{row['strangers_joined']} of {row['strangers']}",
            f"{row['ate_m']:.3f}",
            f"{row['long_m']:.3f}",
            f"{row['join_s']:.1f}",
            f"{row['map_s']:.1f}",
            f"{row['bytes'] / 1e6:.1f}",
            row["verdict"],
        ]
        for row in rows
    ]
    return with_targets(section, table(header, cells), joining_targets(rows))


def halves_targets(rows):
    return [
        (
            f"{row['title']}: translation error of the relations, in two sessions less at once",
            "<= 0.02 m",
            f"{row['site_m'] - row['whole_m']:+.4f} m",
            row["status"] == "joined" and row["site_m"] - row["whole_m"] <= 0.02,
        )
        for row in rows
    ]


def halves_table(section):
    rows = section["figures"]
    header = [
        "log",
        "second half",
        "closures>",
        "translation, at once [m]>",
        "two sessions [m]>",
        "rotation, at once [deg]>",
        "two sessions [deg]>",
    ]
    cells = [
        [
            row["title"],
            row["status"],
            str(row["closures"]),
            f"{row['whole_m']:.4f}",
            f"{row['site_m']:.4f}",
            f"{row['whole_deg']:.3f}",
            f"{row['site_deg']:.3f}",
        ]
        for row in rows
    ]
    return with_targets(section, table(header, cells), halves_targets(rows))


def days_targets(figures):
    first, last = figures["checkpoints"][0], figures["checkpoints"][-1]
    return [
        (
            f"size of the file, day {last['day']} / day {first['day']}",
            "<= 1.3",
            f"{last['bytes'] / first['bytes']:.2f}",
            last["bytes"] <= 1.3 * first["bytes"],
        ),
        (
            f"time to join a day, day {last['day']} / day {first['day']}",
            "<= 1.5",
            f"{last['join_s'] / first['join_s']:.2f}",
            last["join_s"] <= 1.5 * first["join_s"],
        ),
        (
            "of the wall's new place, on the map",
            "100 %",
            f"{100.0 * figures['new_wall_there']:.0f} %",
            figures["new_wall_there"] >= 1.0,
        ),
        (
            "of the wall's old place, on the map",
            "0 %",
            f"{100.0 * figures['old_wall_there']:.0f} %",
            figures["old_wall_there"] <= 0.0,
        ),
    ]


def days_table(section):
    figures = section["figures"]
    cells = [
        [
            str(row["day"]),
            f"{row['bytes'] / 1e6:.2f}",
            str(row["joined"]),
            str(row["retired"]),
            f"{row['join_s']:.2f}",
        ]
        for row in figures["checkpoints"]
    ]
    judged = figures["map"]
    header = ["day>", "file [MB]>", "sessions kept>", "retired>", "to join a day [s]>"]
    told = (
        f"On day {figures['days']} {100.0 * judged['precision']:.1f} % of the occupied cells are "
        f"true, {1000.0 * judged['mean_distance_m']:.1f} mm from the truth on average."
    )
    return with_targets(section, f"{table(header, cells)}\n\n{told}", days_targets(figures))


TABLES = {"joining": joining_table, "halves": halves_table, "days": days_table}
TARGETS = {"joining": joining_targets, "halves": halves_targets, "days": days_targets}


def all_targets(sections):
    return [
        row
        for name in TARGETS
        if name in sections
        for row in TARGETS[name](sections[name]["figures"])
    ]
