"""From measured figures of registration to Markdown. Nothing is measured here, and no figure is
typed here but the targets."""
import tables
from doc_blocks import table
from registration_measure import BINS
from sections import verdicts

SHARE = 0.999
ERROR_MM, ERROR_DEG = 1.4, 0.016
TIME_MS = {1081: 0.5, 180: 0.1}
TRACK_MS = 0.1
MAP_SHARE, MAP_MS = 0.998, 1000.0
CLOUD_FACTOR = 5.0
# Windows of bench_correlative (half side [cm], half angle [deg]) and the time that they may take.
CORRELATIVE_MS = {("50", "20"): 2.0, ("400", "90"): 20.0}


def provenance(section, with_peers=True):
    text = tables.provenance(section)
    if with_peers and section["peers"]:
        text += f" Peers in the same run: {', '.join(section['peers'])}."
    if with_peers and section["missing"]:
        text += f" Not installed, so not compared: {', '.join(section['missing'])}."
    return text


def percent(share, digits=1):
    return f"{100 * share:.{digits}f}"


def number(value, digits):
    return "-" if value is None else f"{value:.{digits}f}"


def series(bins, key, digits):
    return " / ".join(number(figures[key], digits) for figures in bins)


def pairs_tables(section):
    parts = [provenance(section)]
    for sensor in section["figures"]:
        shares, errors = [], []
        for row in sensor["rows"]:
            bins = row["bins"]
            shares.append(
                [
                    row["title"],
                    str(bins[0]["pairs"]),
                    *[percent(figures["share"]) for figures in bins],
                    number(bins[0]["median_ms"], 2),
                    number(bins[-1]["median_ms"], 2),
                ]
            )
            errors.append(
                [
                    row["title"],
                    series(bins, "median_mm", 1),
                    series(bins, "p95_mm", 1),
                    series(bins, "median_deg", 3),
                    series(bins, "p95_deg", 3),
                    series(bins, "median_ms", 2),
                ]
            )
        parts += [
            "",
            (
                f"**{sensor['title']}**: share converged [%] of poses that differ by up to so much,"
                " and the median CPU time of a call in the first and in the last bin."
            ),
            "",
            table(
                [
                    "matcher",
                    "pairs a bin>",
                    *[name + ">" for name in BINS],
                    "first [ms]>",
                    "last [ms]>",
                ],
                shares,
            ),
            "",
            "Errors of those that converged, bin by bin, and the median times.",
            "",
            table(
                ["matcher", "median [mm]", "95 % [mm]", "median [deg]", "95 % [deg]", "time [ms]"],
                errors,
            ),
        ]
    parts += ["", tables.targets_table(targets_of_pairs(section["figures"]))]
    return "\n".join(parts)


def targets_of_pairs(sensors):
    rows = []
    for sensor in sensors:
        ours = [row for row in sensor["rows"] if row["name"] == "match_scans"]
        if not ours:
            continue
        bins, beams = ours[0]["bins"], sensor["beams"]
        share = min(figures["share"] for figures in bins)
        mm = max(figures["median_mm"] or float("inf") for figures in bins)
        degrees = max(figures["median_deg"] or float("inf") for figures in bins)
        ms = max(figures["median_ms"] for figures in bins)
        name = f"match_scans, {beams} beams, worst bin"
        rows += [
            (
                f"{name}: share converged",
                f">= {percent(SHARE)} %",
                f"{percent(share, 2)} %",
                share >= SHARE,
            ),
            (f"{name}: median error", f"<= {ERROR_MM} mm", f"{mm:.2f} mm", mm <= ERROR_MM),
            (
                f"{name}: median turn",
                f"<= {ERROR_DEG} deg",
                f"{degrees:.3f} deg",
                degrees <= ERROR_DEG,
            ),
            (
                f"{name}: median time",
                f"<= {TIME_MS[beams]} ms",
                f"{ms:.3f} ms",
                ms <= TIME_MS[beams],
            ),
        ]
    return rows


MEDIAN_CHI_SQUARED = 2.366  # 3 degrees of freedom


def nees_table(section):
    rows = [
        [
            row["title"],
            row["sensor"],
            row["bin"],
            str(row["pairs"]),
            number(row["mean"] / 3.0, 2),
            number(row["median"] / MEDIAN_CHI_SQUARED, 2),
            percent(row["inside_95"]),
            str(row["called"]),
        ]
        for row in section["figures"]
    ]
    header = [
        "matcher",
        "scanner",
        "poses differ by up to",
        "pairs>",
        "mean>",
        "median>",
        "inside 95 % [%]>",
        "of>",
    ]
    return "\n".join(
        [
            provenance(section, with_peers=False),
            "",
            (
                "Mean: of the normalised error squared, e^T C^-1 e / 3 (3 degrees of freedom, so 1"
                " is ideal and more is overconfident), over the matches within 3 cm and 0.5 deg."
                " Median: the same over the median of chi squared; ideal is 1. Inside: the share,"
                " of all matches that are called converged, wrong ones too, in the 95 % ellipsoid."
            ),
            "",
            table(header, rows),
        ]
    )


def differences(figures):
    return (
        f"{number(figures['median_mm'], 1)} mm, {number(figures['median_deg'], 2)} deg, "
        f"{number(figures['median_ms'], 2)} ms"
    )


def real_tables(section):
    parts = [provenance(section)]
    for log in section["figures"]:
        names = list(
            dict.fromkeys(figures["title"] for row in log["rows"] for figures in row["matchers"])
        )
        shares, medians = [], []
        for row in log["rows"]:
            of = {figures["title"]: figures for figures in row["matchers"]}
            head = [row["case"], row["guess"]]
            motion = f"{row['motion_m']:.2f} m, {row['motion_deg']:.1f} deg"
            shares.append(
                [
                    *head,
                    row["reference"],
                    str(row["pairs"]),
                    motion,
                    *[percent(of[name]["share"]) if name in of else "" for name in names],
                ]
            )
            if len(of) > 1:
                medians.append([*head, *[differences(of[name]) for name in names[1:]]])
        parts += [
            "",
            f"**{log['title']}**: share that agrees [%].",
            "",
            table(
                [
                    "scans",
                    "guess",
                    "reference",
                    "pairs>",
                    "median motion",
                    *[name + ">" for name in names],
                ],
                shares,
            ),
            "",
            "Median difference from the reference of those that agree, and median time.",
            "",
            table(["scans", "guess", *names[1:]], medians),
        ]
    return "\n".join(parts)


def tracking_table(section):
    figures = section["figures"]
    rows = [
        [name, number(figures[key]["median"], digits), number(figures[key]["p95"], digits)]
        for name, key, digits in [
            ("match_to_grid [ms]", "match_ms", 3),
            ("surfaces of the scan [ms]", "surfaces_ms", 3),
            ("error [mm]", "error_mm", 2),
            ("error [deg]", "error_deg", 3),
        ]
    ]
    return "\n".join(
        [
            provenance(section, with_peers=False),
            "",
            f"{figures['scans']} scans of {figures['beams']} beams.",
            "",
            table(["", "median>", "95 %>"], rows),
            "",
            tables.targets_table(targets_of_tracking(figures)),
        ]
    )


def targets_of_tracking(figures):
    ms = figures["match_ms"]["median"]
    return [
        (
            "tracking on a submap's grid, 1081 beams: median CPU time",
            f"<= {TRACK_MS} ms",
            f"{ms:.3f} ms",
            ms <= TRACK_MS,
        )
    ]


def map_match_table(section):
    rows = [
        [
            row["name"],
            str(row["trials"]),
            percent(row["best_correct_share"]),
            percent(row["sure_share"]),
            percent(row["wrong_called_sure"]),
            number(row["median_ms"], 1),
            number(row["max_ms"], 1),
            number(row["area_m2"], 0),
            number(row["build_ms"], 0),
            number(row["memory_mb"], 1),
        ]
        for row in section["figures"]
    ]
    header = [
        "",
        "trials>",
        "best is right [%]>",
        "called sure [%]>",
        "wrong and called sure [%]>",
        "median [ms]>",
        "longest [ms]>",
        "floor [m2]>",
        "preparing the map [ms]>",
        "memory [MB]>",
    ]
    return "\n".join(
        [
            provenance(section, with_peers=False),
            "",
            table(header, rows),
            "",
            tables.targets_table(targets_of_map_match(section["figures"])),
        ]
    )


def targets_of_map_match(rows):
    found = []
    for row in rows:
        if row["name"].startswith("campus"):  # the map of 10,000 m2
            share, ms = row["best_correct_share"], row["max_ms"]
            found += [
                (
                    f"{row['name']}: best is right",
                    f">= {percent(MAP_SHARE)} %",
                    f"{percent(share, 2)} %",
                    share >= MAP_SHARE,
                ),
                (
                    f"{row['name']}: longest time on one core",
                    f"<= {MAP_MS:.0f} ms",
                    f"{ms:.0f} ms",
                    ms <= MAP_MS,
                ),
            ]
    return found


def correlative_title(name):
    """What a benchmark of bench_correlative.cpp measures."""
    words = name.split("/")
    if len(words) != 4:
        return f"`{name}`"
    spacing = f"points {int(words[3]) / 10:g} cm apart" if int(words[3]) else "all 1081 points"
    grid = ", building the grid included" if "with_grid" in words[0] else ""
    return f"search, {int(words[1]) / 100:g} m and {words[2]} deg, {spacing}{grid}"


def correlative_table(section):
    rows = [[correlative_title(row["name"]), number(row["ms"], 3)] for row in section["figures"]]
    return "\n".join(
        [
            provenance(section, with_peers=False),
            "",
            table(["", "CPU time [ms]>"], rows),
            "",
            tables.targets_table(targets_of_correlative(section["figures"])),
        ]
    )


def targets_of_correlative(rows):
    found = []
    for row in rows:
        limit_ms = CORRELATIVE_MS.get(tuple(row["name"].split("/")[1:3]))
        if limit_ms is not None:
            found.append(
                (
                    f"correlative {correlative_title(row['name'])}",
                    f"<= {limit_ms:.0f} ms",
                    f"{row['ms']:.2f} ms",
                    row["ms"] <= limit_ms,
                )
            )
    return found


def clouds_table(section):
    ours, peers = section["figures"]["rows"], section["figures"]["peers"]
    names = list(dict.fromkeys(row["peer"] for row in peers))
    of = {(row["name"], row["peer"]): row for row in peers}
    rows = []
    for row in ours:
        cells = [
            row["name"],
            number(row["reference_mm"], 3),
            number(row["rmse_mm"], 3),
            f"{row['worst_rmse_mm']:.3f} of {row['seeds']}",
            f"{row['agreeing']} of {row['finalists']}",
            number(row["ms"], 0),
        ]
        for name in names:
            peer = of.get((row["name"], name))
            cells.append(
                f"{peer['rmse_mm']:.3f} ({peer['near_best']} of {peer['starts']};"
                f" {peer['ms']:.0f} ms)"
                if peer
                else ""
            )
        rows.append(cells)
    header = [
        "cloud",
        "reference [mm]>",
        "Loopstone [mm]>",
        "worst of the seeds [mm]>",
        "starts that agree>",
        "time [ms]>",
    ]
    return "\n".join(
        [
            provenance(section),
            "",
            table(header + [name + " [mm]>" for name in names], rows),
            "",
            tables.targets_table(targets_of_clouds(section["figures"])),
        ]
    )


def targets_of_clouds(figures):
    found = []
    for row in figures["rows"]:
        worst, limit = (
            row["worst_rmse_mm"],
            row["reference_mm"],
        )  # the limit was written down with three digits
        found.append(
            (
                f"{row['name']}: rmse, worst of {row['seeds']} seeds",
                f"<= {limit:.3f} mm",
                f"{worst:.3f} mm",
                round(worst, 3) <= limit,
            )
        )
    peers_ms = {
        row["name"]: row["ms"] for row in figures["peers"] if row["peer"] == "small_gicp GICP"
    }
    if peers_ms:
        factor = sum(peers_ms.values()) / sum(
            row["ms"] for row in figures["rows"] if row["name"] in peers_ms
        )
        found.append(
            (
                "all clouds: how many times as long small_gicp's starts take",
                f">= {CLOUD_FACTOR:.0f}",
                f"{factor:.1f}",
                factor >= CLOUD_FACTOR,
            )
        )
    return found


BLOCKS = {
    "pairs": ("docs/benchmarks.md", "registration-pairs", pairs_tables),
    "nees": ("docs/accuracy.md", "registration-nees", nees_table),
    "real": ("docs/accuracy.md", "registration-real", real_tables),
    "tracking": ("docs/benchmarks.md", "registration-tracking", tracking_table),
    "map_match": ("docs/benchmarks.md", "registration-map", map_match_table),
    "correlative": ("docs/benchmarks.md", "registration-correlative", correlative_table),
    "clouds": ("docs/benchmarks.md", "registration-clouds", clouds_table),
}
TARGETS = {
    "pairs": targets_of_pairs,
    "tracking": targets_of_tracking,
    "map_match": targets_of_map_match,
    "correlative": targets_of_correlative,
    "clouds": targets_of_clouds,
}


def blocks_of(sections):
    """(section, page, block, text) of everything that was measured."""
    return [
        (name, page, block, write(sections[name]))
        for name, (page, block, write) in BLOCKS.items()
        if name in sections
    ]


def summary(sections):
    rows = [
        row
        for name, of_section in TARGETS.items()
        if name in sections
        for row in of_section(sections[name]["figures"])
    ]
    return verdicts(rows)
