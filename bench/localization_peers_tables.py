"""The tables of localisation beside its peers."""
import statistics

from doc_blocks import table
from localization_peers_measure import (
    CERTAIN,
    DRIVES,
    LESS_CERTAIN,
    STARTS,
    SYSTEMS,
    TUNED,
    TUNED_ON,
)
from peers import mrpt_localization
from provenance import provenance

GROUPS = {"recorded": "recorded logs", "simulated": "simulated drives"}
FROM = {"known": "from a guess", "nowhere": "from nowhere"}
COLUMNS = [
    "drives and start",
    "system",
    "right [%]>",
    "in the worst run [%]>",
    "error, median [m]>",
    "95 % [m]>",
    "certain [%]>",
    "certain and wrong [%]>",
    f"certain to {LESS_CERTAIN:g} and wrong [%]>",
    "CPU [ms a scan]>",
    "times Loopstone's>",
    "peak memory [MB]>",
]


def runs_of(drive, start, system):
    return [one for one in drive if (one["start"], one["system"]) == (start, system)]


def middle(runs, key):
    return statistics.median(one[key] for one in runs)


def summary(drives, start, system):
    """Of the drives of a group: the median of a drive's runs, each drive counting the same."""
    drives = [drive for drive in drives if runs_of(drive, start, system)]
    if not drives:
        return None
    runs = [runs_of(drive, start, system) for drive in drives]
    ours = [runs_of(drive, start, "loopstone") for drive in drives]
    mean = lambda key: statistics.mean(middle(each, key) for each in runs)  # noqa: E731
    median = lambda key: statistics.median(middle(each, key) for each in runs)  # noqa: E731
    ratios = [middle(a, "ms_per_scan") / middle(b, "ms_per_scan") for a, b in zip(runs, ours)]
    return {
        "right": mean("right"),
        "worst": min(one["right"] for each in runs for one in each),
        "median_m": median("median_m"),
        "most_m": median("most_m"),
        "certain": mean("certain"),
        "wrong": mean("wrong"),
        "less_wrong": mean("less_wrong"),
        "ms_per_scan": median("ms_per_scan"),
        "ratio": statistics.median(ratios),
        "peak_mb": max(one["peak_mb"] for each in runs for one in each),
    }


def line_of(title, system, f):
    return [
        title,
        SYSTEMS[system],
        f"{100 * f['right']:.2f}",
        f"{100 * f['worst']:.2f}",
        f"{f['median_m']:.3f}",
        f"{f['most_m']:.3f}",
        f"{100 * f['certain']:.2f}",
        f"{100 * f['wrong']:.3f}",
        f"{100 * f['less_wrong']:.3f}",
        f"{f['ms_per_scan']:.2f}",
        f"{f['ratio']:.1f}",
        f"{f['peak_mb']:.0f}",
    ]


def summary_lines(kept):
    for group, title in GROUPS.items():
        drives = [kept[name] for name in DRIVES if DRIVES[name] == group and name in kept]
        for start in STARTS:
            for system in SYSTEMS:
                if found := summary(drives, start, system):
                    yield line_of(f"{len(drives)} {title}, {FROM[start]}", system, found)


def drive_lines(kept):
    """The share of scans right of each drive: the median of the runs, and the least and most."""
    for name in DRIVES:
        for start in STARTS if name in kept else []:
            cells = []
            for system in SYSTEMS:
                shares = [100 * one["right"] for one in runs_of(kept[name], start, system)]
                spread = f" ({min(shares):.1f} to {max(shares):.1f})" if shares[1:] else ""
                cells.append(f"{statistics.median(shares):.1f}{spread}" if shares else "-")
            yield [f"{name}, {FROM[start]}", *cells]


def runs_told(drives):
    """How many runs of each system a start has: 3, or 1 to 3 where drives differ."""
    told = []
    for system, title in SYSTEMS.items():
        counts = {len(runs_of(one, start, system)) for one in drives for start in STARTS}
        least, most = min(counts), max(counts)
        told.append(f"{title} {most}" if least == most else f"{title} {least} to {most}")
    return "; ".join(told)


def settings_told():
    return "; ".join(
        f"{SYSTEMS[system]}: `{' '.join(f'{key}={value}' for key, value in settings.items())}`"
        for system, settings in TUNED.items()
    )


def text_of(kept):
    drives = [kept[name] for name in DRIVES if name in kept]
    weighed = mrpt_localization.LIKELIHOOD
    return "\n\n".join(
        [
            provenance(*(one["when"] for drive in drives for one in drive)),
            f"Medians of runs, so many of each start: {runs_told(drives)}. A peer is certain"
            " where the square root of the trace of its covariance [m, m, rad] is at most"
            f" {CERTAIN:g} (one column: {LESS_CERTAIN:g}), Loopstone where it is TRACKING."
            f" AMCL was tuned on {TUNED_ON}:"
            f" {settings_told()}; all else as nav2's defaults. pf-localization:"
            f" {mrpt_localization.PARTICLES} particles at the start, every"
            f" {weighed['decimation']}th point of a scan, sigma {weighed['std_hit_m']:g} m.",
            table(COLUMNS, list(summary_lines(kept))),
            "Scans right [%], by drive (least and most of the runs):",
            table(
                ["drive and start", *(f"{title}>" for title in SYSTEMS.values())],
                list(drive_lines(kept)),
            ),
        ]
    )
