"""The figures that were asked for, and whether the measured ones reach them."""

INTEL_M, ACES_M = 0.10, 0.08
OFFICE_M, CAMPUS_M = 0.03, 0.15
INTEL_WALL_S, INTEL_PEAK_MB = 9.0, 200.0


def verdict(met):
    return "met" if met else "**not met**"


def of_real(logs):
    """(figure, target, measured, met) of each relations target."""
    found = []
    for name, limit in [("intel", INTEL_M), ("aces", ACES_M)]:
        for log in logs:
            if log["name"] == name:
                mean = log["rows"][-1]["translation_m"]["mean"]
                found.append((f"{log['title']}: mean translation error of the relations", f"<= {limit:.2f} m",
                              f"{mean:.3f} m", mean <= limit))
    return found


def of_simulated(cases):
    found = []
    for name, limit in [("office", OFFICE_M), ("campus", CAMPUS_M)]:
        for case in cases:
            if case["name"] == name:
                worst = max(run.get("ate_m", float("inf")) for run in case["runs"])
                found.append((f"{name}: largest ATE rmse over {len(case['runs'])} seeds", f"<= {limit:.2f} m",
                              f"{worst:.4f} m", worst <= limit))
    return found


def of_speed(speed):
    if not speed:
        return []
    run = speed["variants"][0]
    return [("Intel: wall time of the whole run", f"<= {INTEL_WALL_S:.0f} s on 2 processors", f"{run['wall_s']:.1f} s",
             run["wall_s"] <= INTEL_WALL_S),
            ("Intel: peak memory", f"<= {INTEL_PEAK_MB:.0f} MB", f"{run['peak_mb']:.0f} MB",
             run["peak_mb"] <= INTEL_PEAK_MB)]
