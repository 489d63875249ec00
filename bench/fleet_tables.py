"""From what bench/fleet.py measured to Markdown, with what a million logs would take by it. No
figure is typed here but what is asked for."""
import math

import targets
from doc_blocks import table
from provenance import provenance

SPEED_UP = 1.8  # from one worker to two
# On paper: a fleet, and the machines that are to map it in a day.
MANY_LOGS, MANY_SITES, PROCESSORS, DAY_S = 1_000_000, 10_000, 16, 86_400.0
LONG_LOG_S = 1800.0
INODE_BYTES = 16_384  # of disk for each file that ext4 has room for, as it is made


def costs_of(figures):
    """What one log costs, of two at a time."""
    two = figures["runs"][-1]
    logs = figures["logs"]
    mapped = two["statuses"]["done"]
    return {
        "cpu_s": two["process_cpu_s"] / logs,
        "cpu_s_per_recorded_s": two["process_cpu_s"] / two["recorded_s"],
        "recorded_s": two["recorded_s"] / mapped,
        "log_bytes": two["log_bytes"] / mapped,
        "result_bytes": two["result_bytes"] / mapped,
        "result_files": two["result_files"] / mapped,
        "row_bytes": two["row_bytes"] / logs,
        "table_bytes": two["table_bytes"] / logs,
        "again_s": max(0.0, figures["again_s"] / figures["more_logs"]),
        "report_s": max(0.0, figures["report_s"] / figures["more_logs"]),
        # What is not spent in the program: by whoever gives logs out, and to begin a process.
        "beside_s": max(0.0, 2 * (two["wall_s"] - two["join_wall_s"] / 2) - two["process_wall_s"])
        / logs,
        "line_bytes": figures["line_bytes"],
        "join_s": two["join_wall_s"] / two["joins"] if two["joins"] else None,
        "used": speed_up(figures) / 2,
    }


def speed_up(figures):
    one, two, _ = figures["runs"]
    return one["wall_s"] / two["wall_s"]


def targets_of(figures):
    asked = sum(run["logs"] for run in figures["runs"])
    whole = sum(run["one_row"] for run in figures["runs"])
    return [
        (
            "logs that ended with exactly one row, in all runs",
            f"{asked:,}",
            f"{whole:,}",
            whole == asked,
        ),
        (
            "speed of two workers / one",
            f">= {SPEED_UP:g}",
            f"{speed_up(figures):.2f}",
            speed_up(figures) >= SPEED_UP,
        ),
    ]


def runs_table(figures):
    rows = [
        [
            str(run["workers"]),
            ", ".join(f"{count:,} {status}" for status, count in sorted(run["statuses"].items())),
            f"{run['wall_s']:.0f}",
            f"{run['logs'] / run['wall_s']:.2f}",
            f"{run['process_cpu_s']:.0f}",
            f"{run['peak_mb']:.0f}",
            f"{run['coordinator_peak_mb']:.0f}",
        ]
        for run in figures["runs"]
    ]
    header = ["workers>", "logs", "wall [s]>", "logs a second>", "CPU of programs [s]>"]
    header += ["most memory of a log [MB]>", "of loopstone-fleet [MB]>"]
    return table(header, rows)


def costs_table(costs):
    join = "not measured: no `site add`" if costs["join_s"] is None else f"{costs['join_s']:.2f} s"
    rows = [
        ["processor, mapping", f"{costs['cpu_s']:.2f} s"],
        ["the same, for a recorded second", f"{1e3 * costs['cpu_s_per_recorded_s']:.2f} ms"],
        ["beside the program, a worker's time", f"{1e3 * costs['beside_s']:.0f} ms"],
        ["to find that it is done already", f"{1e3 * costs['again_s']:.1f} ms"],
        ["for table and page", f"{1e3 * costs['report_s']:.1f} ms"],
        ["its size", f"{costs['log_bytes'] / 1e6:.2f} MB"],
        [
            "its result",
            f"{costs['result_bytes'] / 1e6:.2f} MB in {costs['result_files']:.0f} files",
        ],
        ["its row", f"{costs['row_bytes'] / 1e3:.1f} kB, {costs['table_bytes']:.0f} B as Parquet"],
        ["its line, in memory of loopstone-fleet", f"{costs['line_bytes']:.0f} B"],
        ["joining it to its site", join],
    ]
    return table([f"a log of {costs['recorded_s']:.0f} s costs", ">"], rows)


def million(costs, recorded_s):
    """What MANY_LOGS take if each has so many recorded seconds: everything in proportion."""
    times = recorded_s / costs["recorded_s"]
    cpu_s = costs["cpu_s"] * times
    machines = max(1, math.ceil(MANY_LOGS * cpu_s / (PROCESSORS * costs["used"] * DAY_S)))
    log_bytes = costs["log_bytes"] * times
    return {
        "recorded_s": recorded_s,
        "cpu_days": MANY_LOGS * cpu_s / DAY_S,
        "machines": machines,
        "fetch_mbit_s": 8e-6 * MANY_LOGS * log_bytes / DAY_S / machines,
        "log_tb": MANY_LOGS * log_bytes / 1e12,
        # Maps and pictures grow with what was seen and not with time, so this is the least.
        "result_tb": MANY_LOGS * costs["result_bytes"] / 1e12,
        "join_days": None
        if costs["join_s"] is None
        else MANY_LOGS * costs["join_s"] * times / (PROCESSORS * machines * DAY_S),
        "site_hours": None
        if costs["join_s"] is None
        else MANY_LOGS / MANY_SITES * costs["join_s"] * times / 3600,
    }


def million_table(costs):
    cases = [million(costs, seconds) for seconds in (costs["recorded_s"], LONG_LOG_S)]

    def line(name, form):
        return [name, *(form(case) for case in cases)]

    def if_known(case, key, digits):
        return "not measured" if case[key] is None else f"{case[key]:.{digits}f}"

    rows = [
        line("processors' days", lambda case: f"{case['cpu_days']:,.1f}"),
        line(
            f"machines of {PROCESSORS} processors, for all in a day",
            lambda case: f"{case['machines']:,}",
        ),
        line("fetching, each machine [Mbit/s]", lambda case: f"{case['fetch_mbit_s']:,.0f}"),
        line("logs [TB]", lambda case: f"{case['log_tb']:,.1f}"),
        line("results, at least [TB]", lambda case: f"{case['result_tb']:,.1f}"),
        line(
            f"joining to {MANY_SITES:,} sites, these machines [days]",
            lambda case: if_known(case, "join_days", 2),
        ),
        line(
            "of it one site, which has one worker [h]", lambda case: if_known(case, "site_hours", 1)
        ),
    ]
    header = [f"{MANY_LOGS:,} logs of>", *(f"{case['recorded_s']:,.0f} s>" for case in cases)]
    return table(header, rows)


def breaks_table(costs):
    """What one machine that gives out all logs would need, the first to give way first."""
    files = MANY_LOGS * costs["result_files"]
    hours = MANY_LOGS / 3600
    rows = [
        [
            "files of results",
            f"{files / 1e6:,.0f} million",
            f"{files * INODE_BYTES / 1e12:.2f} TB of ext4 before its inodes are used up",
        ],
        [
            "rows as files",
            f"{MANY_LOGS * costs['row_bytes'] / 1e9:,.1f} GB",
            f"{hours * costs['report_s']:.1f} h to make table and page of them",
        ],
        [
            "asking what is done",
            f"{hours * costs['again_s']:.1f} h",
            "for each run without --shard, on local disks",
        ],
        [
            "memory of one loopstone-fleet",
            f"{MANY_LOGS * costs['line_bytes'] / 1e9:.1f} GB",
            "for the manifest; each shard reads all of it",
        ],
    ]
    return table(["of a million logs in one OUT", "", ""], rows)


def text_of(section):
    figures = section["figures"]
    costs = costs_of(figures)
    parts = [
        provenance(section, *([section["speed"]] if "speed" in section else [])),
        f"{figures['logs']:,} simulated drives, of which some are no logs at all.",
        runs_table(figures),
        table(
            ["figure", "target", "measured", ""],
            [
                [name, target, measured, targets.verdict(met)]
                for name, target, measured, met in targets_of(figures)
            ],
        ),
        costs_table(costs),
        "On paper, from these costs: processors' days = logs x processor seconds a log / 86,400;"
        f" machines = processors' days / ({PROCESSORS} x {costs['used']:.2f}), rounded up, where"
        f" {costs['used']:.2f} is the share of a second worker that came to use; a longer log costs"
        " in proportion to its recorded time; a site's logs are joined one after the other.",
        million_table(costs),
        breaks_table(costs),
    ]
    return "\n\n".join(parts)
