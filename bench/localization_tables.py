"""From measured figures of localisation to Markdown. Nothing is measured here, and no figure is
typed here but the targets."""
import math
import statistics

import tables
from doc_blocks import table
from localization_measure import CARRIED_M

RMSE_M = 0.02
START_SHARE = 0.99
SEARCH_S = 1.0
RECOVERY_M, RECOVERY_SHARE = 5.0, 0.95
FREE_SHARE, EXPLAINED_SHARE = 0.99, 0.7
# A wrong pose is one farther than this from the truth: 0.2 m or 5 deg (measure_localization.cpp).


def percent(share, digits=1):
    return f"{100 * share:.{digits}f}"


def good(case):
    return [run for run in case["runs"] if not run.get("failed")]


def mean(runs, key):
    return statistics.fmean(run[key] for run in runs)


def weighed_mean(runs, key):
    """Over all scans of the runs."""
    return sum(run[key] * run["scans"] for run in runs) / sum(run["scans"] for run in runs)


def root_mean(runs, key):
    return math.sqrt(
        sum(run[key] ** 2 * run["scans"] for run in runs) / sum(run["scans"] for run in runs)
    )


def failures(case):
    count = len(case["runs"]) - len(good(case))
    return [f"{case['name']}: {count} runs ended with an error."] if count else []


def with_failures(figures, parts):
    return parts + [line for case in figures for line in failures(case)]


# Following a robot


def tracking_text(figures):
    rows = []
    for case in figures:
        runs = good(case)
        rows.append(
            [
                case["name"],
                str(len(runs)),
                f"{sum(run['path_m'] for run in runs):.0f}",
                f"{1000 * root_mean(runs, 'rmse_all_m'):.1f}",
                f"{1000 * max(run['rmse_all_m'] for run in runs):.1f}",
                f"{mean(runs, 'nees'):.2f}",
                percent(weighed_mean(runs, "tracking")),
                percent(weighed_mean(runs, "lost")),
                percent(weighed_mean(runs, "wrong_tracking"), 2),
                f"{statistics.median(run['filter_ms_per_scan'] for run in runs):.2f}",
            ]
        )
    header = [
        "map",
        "drives>",
        "path [m]>",
        "rmse [mm]>",
        "worst drive [mm]>",
        "NEES>",
        "TRACKING [%]>",
        "LOST [%]>",
        "wrong while TRACKING [%]>",
        "a scan [ms]>",
    ]
    return [table(header, rows)]


def tracking_targets(figures):
    found = []
    for case in figures:
        rmse = root_mean(good(case), "rmse_all_m")
        found.append(
            (
                f"{case['name']}: position rmse, all scans of all drives",
                f"<= {RMSE_M:g} m",
                f"{rmse:.4f} m",
                rmse <= RMSE_M,
            )
        )
    return found


# From anywhere


def starts_of(case):
    """How many drives first said TRACKING at the right place, at a wrong one, never."""
    runs = good(case)
    right = sum(run["first_tracking_right"] is True for run in runs)
    wrong = sum(run["first_tracking_right"] is False for run in runs)
    return right, wrong, len(runs) - right - wrong


def quantile(values, share):
    values = sorted(values)
    return values[min(len(values) - 1, math.ceil(share * len(values)) - 1)]


def global_text(figures):
    rows = []
    for case in figures:
        runs = good(case)
        right, wrong, never = starts_of(case)
        metres = [run["first_tracking_m"] for run in runs if run["first_tracking_m"] is not None]
        times = [run["longest_scan_s"] for run in runs]
        rows.append(
            [
                case["name"],
                f"{mean(runs, 'map_m2'):.0f}",
                str(len(case["runs"])),
                str(right),
                str(wrong),
                str(never),
                f"{sum(m == 0.0 for m in metres)}",
                (
                    " / ".join(f"{quantile(metres, share):.1f}" for share in (0.5, 0.9, 1.0))
                    if metres
                    else "-"
                ),
                percent(weighed_mean(runs, "wrong_tracking"), 2),
                f"{statistics.median(times):.2f}",
                f"{max(times):.2f}",
                f"{statistics.median(run['build_s'] for run in runs):.2f}",
            ]
        )
    header = [
        "map",
        "free area [m2]>",
        "starts>",
        "first TRACKING right>",
        "first TRACKING wrong>",
        "never TRACKING>",
        "TRACKING at the first scan>",
        "path until TRACKING: median / 90 % / most [m]>",
        "scans wrong while TRACKING [%]>",
        "search, median [s]>",
        "search, slowest [s]>",
        "making the map ready [s]>",
    ]
    return [table(header, rows)]


def global_targets(figures):
    found = []
    for case in figures:
        right, wrong, never = starts_of(case)
        decided = right + wrong
        share = right / decided if decided else 0.0
        found.append(
            (
                f"{case['name']}: starts found, of those not reported as ambiguous",
                f">= {percent(START_SHARE, 0)} %",
                f"{right} of {decided}",
                share >= START_SHARE,
            )
        )
        found.append(
            (f"{case['name']}: starts with a wrong TRACKING first", "none", f"{wrong}", wrong == 0)
        )
        if case.get("timed"):
            slowest = max(run["longest_scan_s"] for run in good(case))
            found.append(
                (
                    (
                        f"{case['name']}: the first search and weighing, slowest of"
                        f" {len(good(case))}, CPU time on one core"
                    ),
                    f"<= {SEARCH_S:g} s",
                    f"{slowest:.2f} s",
                    slowest <= SEARCH_S,
                )
            )
    return found


# Places that look alike


def ambiguous_text(figures):
    rows = []
    for case in figures:
        runs = good(case)
        rows.append(
            [
                case["name"],
                str(len(case["runs"])),
                str(sum(run["scans"] for run in runs)),
                percent(weighed_mean(runs, "right")),
                percent(weighed_mean(runs, "tracking")),
                percent(weighed_mean(runs, "wrong_tracking"), 3),
                str(sum(run["wrong_tracking"] > 0 for run in runs)),
                percent(weighed_mean(runs, "lost")),
            ]
        )
    return [
        table(
            [
                "place",
                "drives>",
                "scans>",
                "right [%]>",
                "TRACKING [%]>",
                "wrong while TRACKING [%]>",
                "drives with such>",
                "LOST [%]>",
            ],
            rows,
        )
    ]


def ambiguous_targets(figures):
    found = []
    for case in figures:
        wrong = sum(round(run["wrong_tracking"] * run["scans"]) for run in good(case))
        found.append(
            (f"{case['name']}: scans wrong while TRACKING", "none", str(wrong), wrong == 0)
        )
    return found


# Kidnapping


def recoveries(case):
    """Path until TRACKING at the right place, for every robot that was carried far enough;
    infinite: not in the drive."""
    return [
        recovered if recovered >= 0.0 else math.inf
        for run in good(case)
        for recovered, carried in zip(run["recovered_m"], run["carried_m"], strict=True)
        if carried >= CARRIED_M
    ]


def kidnap_text(figures):
    rows = []
    everything = {"name": "all", "runs": [run for case in figures for run in case["runs"]]}
    for case in [*figures, everything]:
        metres = recoveries(case)
        text = [f"{quantile(metres, share):.1f}" for share in (0.5, 0.9, 0.95, 1.0)]
        runs = good(case)
        rows.append(
            [
                case["name"],
                str(len(metres)),
                *[
                    percent(sum(m <= limit for m in metres) / len(metres), 0)
                    for limit in (1.0, 2.0, RECOVERY_M, 10.0)
                ],
                " / ".join(text).replace("inf", "never"),
                percent(weighed_mean(runs, "wrong_tracking"), 2),
            ]
        )
    return [
        table(
            [
                "map",
                "kidnappings>",
                "within 1 m [%]>",
                "2 m [%]>",
                "5 m [%]>",
                "10 m [%]>",
                "path until found: median / 90 % / 95 % / most [m]>",
                "scans wrong while TRACKING [%]>",
            ],
            rows,
        )
    ]


def kidnap_targets(figures):
    metres = [m for case in figures for m in recoveries(case)]
    share = sum(m <= RECOVERY_M for m in metres) / len(metres)
    return [
        (
            f"kidnapped robots found within {RECOVERY_M:g} m of travel, of {len(metres)}",
            f">= {percent(RECOVERY_SHARE, 0)} %",
            f"{percent(share)} %",
            share >= RECOVERY_SHARE,
        )
    ]


# Changed maps


def changed_text(figures):
    rows = []
    for case in figures:
        runs = good(case)
        rows.append(
            [
                case["name"],
                str(len(runs)),
                f"{1000 * root_mean(runs, 'rmse_all_m'):.1f}",
                percent(weighed_mean(runs, "right")),
                percent(weighed_mean(runs, "tracking")),
                percent(weighed_mean(runs, "lost"), 2),
                percent(weighed_mean(runs, "wrong_tracking"), 2),
            ]
        )
    return [
        table(
            [
                "the office after",
                "drives>",
                "rmse [mm]>",
                "right [%]>",
                "TRACKING [%]>",
                "LOST [%]>",
                "wrong while TRACKING [%]>",
            ],
            rows,
        )
    ]


def changed_targets(figures):
    found = []
    for case in figures:
        lost = sum(round(run["lost"] * run["scans"]) for run in good(case))
        found.append((f"office, {case['name']}: scans LOST", "none", str(lost), lost == 0))
    return found


# Recorded logs


def recorded_text(figures):
    rows = []
    for row in figures:
        first = row["first_tracking_m"]
        rows.append(
            [
                row["title"],
                str(row["seed"]),
                str(row["scans"]),
                f"{row['path_length_m']:.0f}",
                "never" if first is None else f"{first:.1f}",
                *[percent(row[key]) for key in ("tracking_share", "doubtful_share", "lost_share")],
                percent(row["explained_mean"]),
                percent(row["sure"]["explained"]),
                percent(row["sure"]["free"], 2),
                percent(row["elsewhere"]) if "elsewhere" in row else "",
                f"{1000 * row['ate_m']:.1f}" if "ate_m" in row else "",
                f"{1000 * row['max_m']:.0f}" if "ate_m" in row else "",
                f"{row['cpu_s']:.1f}",
            ]
        )
    return [
        table(
            [
                "log",
                "seed>",
                "scans>",
                "path [m]>",
                "first TRACKING [m]>",
                "TRACKING [%]>",
                "DOUBTFUL [%]>",
                "LOST [%]>",
                "explained [%]>",
                "while TRACKING [%]>",
                "on free cells while TRACKING [%]>",
                "elsewhere while TRACKING [%]>",
                "ATE [mm]>",
                "largest [mm]>",
                "CPU [s]>",
            ],
            rows,
        )
    ]


def recorded_targets(figures):
    found = []
    for title in dict.fromkeys(row["title"] for row in figures):
        rows = [row for row in figures if row["title"] == title]
        free = min(row["sure"]["free"] for row in rows)
        explained = min(row["sure"]["explained"] for row in rows)
        found.append(
            (
                f"{title}: poses on free cells while TRACKING, the worst seed",
                f">= {percent(FREE_SHARE, 0)} %",
                f"{percent(free, 2)} %",
                free >= FREE_SHARE,
            )
        )
        if "elsewhere" in rows[0]:
            elsewhere = max(row["elsewhere"] for row in rows)
            found.append(
                (
                    f"{title}: poses elsewhere while TRACKING, the worst seed",
                    "none",
                    f"{percent(elsewhere)} %",
                    elsewhere == 0.0,
                )
            )
        found.append(
            (
                f"{title}: returns on a wall while TRACKING, the worst seed",
                f">= {percent(EXPLAINED_SHARE, 0)} %",
                f"{percent(explained)} %",
                explained >= EXPLAINED_SHARE,
            )
        )
    return found


TEXTS = {
    "tracking": tracking_text,
    "global": global_text,
    "ambiguous": ambiguous_text,
    "kidnap": kidnap_text,
    "changed": changed_text,
    "recorded": recorded_text,
}
TARGETS = {
    "tracking": tracking_targets,
    "global": global_targets,
    "ambiguous": ambiguous_targets,
    "kidnap": kidnap_targets,
    "changed": changed_targets,
    "recorded": recorded_targets,
}


def text_of(name, section):
    figures = section["figures"]
    parts = [tables.provenance(section), "", *TEXTS[name](figures)]
    if name != "recorded":
        parts = with_failures(figures, parts)
    return "\n".join([*parts, "", tables.targets_table(TARGETS[name](figures))])


def targets_of(sections):
    return [
        row
        for name, targets in TARGETS.items()
        if name in sections
        for row in targets(sections[name]["figures"])
    ]
