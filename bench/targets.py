"""The figures that were asked for, and whether the measured ones reach them."""

# Mean errors of relations that Hess et al. 2016 publish for Cartographer, configured for each log.
RELATIONS = [("intel", 0.0229, 0.453), ("aces", 0.0375, 0.373)]  # log, m, deg
OFFICE_M, CAMPUS_M = 0.010, 0.05
INTEL_WALL_S, INTEL_PEAK_MB = 2.7, 120.0
FRONT_END_MS = 0.1  # a scan, on one processor
FAST, FAST_TIMES = "office, 40 scans a second", 200.0


LAPS_TIMES = 1.2  # the memory of one lap
LONG_DRIVE_S = [(15000.0, 60.0), (1000.0, 3.0)]  # from so many metres on
LONG_DRIVE_MB = 1000.0
LATENCY_MS = 20.0


def verdict(met):
    return "met" if met else "**not met**"


def of_real(logs):
    """(figure, target, measured, met) of each relations target."""
    found = []
    for name, limit_m, limit_deg in RELATIONS:
        for log in logs:
            if log["name"] == name:
                mean_m = log["rows"][-1]["translation_m"]["mean"]
                mean_deg = log["rows"][-1]["rotation_deg"]["mean"]
                found.append(
                    (
                        f"{log['title']}: mean translation error of the relations",
                        f"<= {limit_m:.4f} m",
                        f"{mean_m:.4f} m",
                        mean_m <= limit_m,
                    )
                )
                found.append(
                    (
                        f"{log['title']}: mean rotation error of the relations",
                        f"<= {limit_deg:.3f} deg",
                        f"{mean_deg:.3f} deg",
                        mean_deg <= limit_deg,
                    )
                )
    return found


def of_simulated(cases):
    found = []
    for name, limit in [("office", OFFICE_M), ("campus", CAMPUS_M)]:
        for case in cases:
            if case["name"] == name:
                worst = max(run.get("ate_m", float("inf")) for run in case["runs"])
                found.append(
                    (
                        f"{name}: largest ATE rmse over {len(case['runs'])} seeds",
                        f"<= {limit:.3f} m",
                        f"{worst:.4f} m",
                        worst <= limit,
                    )
                )
    for case in cases:
        if case["name"] == FAST:
            slowest = min(
                run["duration_s"] / run["wall_s"] for run in case["runs"] if not run.get("failed")
            )
            found.append(
                (
                    f"{FAST} of 1081 beams: times faster than real time",
                    f">= {FAST_TIMES:.0f}",
                    f"{slowest:.0f}",
                    slowest >= FAST_TIMES,
                )
            )
        if case["name"] == "corridor":
            worst = max(
                run.get("ate_m", float("inf")) / run.get("odometry_m", 1.0) for run in case["runs"]
            )
            found.append(
                (
                    "corridor: largest ATE rmse over that of odometry",
                    "<= 1",
                    f"{worst:.2f}",
                    worst <= 1.0,
                )
            )
    return found


def of_speed(speed):
    if not speed:
        return []
    run, alone = speed["variants"][0], speed["variants"][-1]
    front_end_ms = 1e3 * alone["fastest_stages"]["front_end_wall_s"] / alone["scans"]
    return [
        (
            "Intel: wall time of the whole run",
            f"<= {INTEL_WALL_S:.1f} s on 2 processors",
            f"{run['wall_s']:.1f} s",
            run["wall_s"] <= INTEL_WALL_S,
        ),
        (
            "Intel: peak memory",
            f"<= {INTEL_PEAK_MB:.0f} MB",
            f"{run['peak_mb']:.0f} MB",
            run["peak_mb"] <= INTEL_PEAK_MB,
        ),
        (
            "Intel: front end, one thread",
            f"<= {FRONT_END_MS:.1f} ms a scan",
            f"{front_end_ms:.3f} ms",
            front_end_ms <= FRONT_END_MS,
        ),
    ]


def of_laps(rows):
    one, *_, many = [row for row in rows if "laps" in row]
    times = many["peak_mb"] / one["peak_mb"]
    return [
        (
            f"{many['laps']} laps of an office: peak memory over that of one",
            f"<= {LAPS_TIMES:.1f}",
            f"{times:.2f}",
            times <= LAPS_TIMES,
        ),
        *(target for row in rows for target in of_long_drive(row)),
    ]


def of_long_drive(row):
    """By its length; nothing of a short one."""
    for least_m, most_s in LONG_DRIVE_S:
        if "laps" not in row and row["path_m"] >= least_m:
            yield (
                f"{row['drive']}: {row['path_m'] / 1000.0:.1f} km",
                f"<= {most_s:.0f} s",
                f"{row['wall_s']:.1f} s",
                row["wall_s"] <= most_s,
            )
            yield (
                f"{row['drive']}: peak memory",
                f"<= {LONG_DRIVE_MB:.0f} MB",
                f"{row['peak_mb']:.0f} MB",
                row["peak_mb"] <= LONG_DRIVE_MB,
            )
            return


def of_online(rows):
    worst_ms = 1e3 * max(row["worst_computing_s"] for row in rows)
    return [
        (
            "in real time: longest wait for a pose beyond that for odometry",
            f"<= {LATENCY_MS:.0f} ms",
            f"{worst_ms:.1f} ms",
            worst_ms <= LATENCY_MS,
        )
    ]


# By section of figures.json.
OF_SECTION = {
    "real": of_real,
    "simulated": of_simulated,
    "speed": of_speed,
    "laps": of_laps,
    "online": of_online,
}


def of_sections(sections, names):
    """The rows of those sections that were measured."""
    return [
        row
        for name in names
        if name in sections
        for row in OF_SECTION[name](sections[name]["figures"])
    ]
