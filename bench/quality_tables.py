"""The tables of docs/quality.md: what the verdict said against how wrong the map was."""
from doc_blocks import table
from largest_error import RIGHT_DEG, RIGHT_M, is_right
from program import median
from provenance import provenance

VERDICTS = ["good", "doubtful", "bad", "unknown"]
MEASURES = [
    ("wall_thickness_m", "wall thickness"),
    ("entropy_gain_nats", "mean map entropy"),
    ("free_space_violations", "free-space violations"),
    ("held_out_agreement", "held-out scans"),
    ("contradicted_wall_m", "contradictions of visits"),
    ("reduced_chi2", "chi-square of the loops"),
    ("certified_shift_m", "certified"),
    ("loose_part_m", "loose parts"),
    ("degenerate_travel_share", "degenerate travel"),
    ("break_tie_m", "breaks of the path"),
    ("sensor_faults", "sensors"),
]


def truth(run):
    return "right" if is_right(run["max_m"], run["max_deg"]) else "wrong"


def of_seeds(record, seeds):
    return [run for run in record["runs"] if run["seed"] in seeds]


def confusion(runs):
    names = {
        "right": f"right: off by {RIGHT_M} m and {RIGHT_DEG:.0f} degree at most, anywhere",
        "wrong": "wrong",
    }
    rows = []
    for actual, title in names.items():
        cells = [
            sum(truth(run) == actual and run["quality"]["verdict"] == said for run in runs)
            for said in VERDICTS
        ]
        rows.append([title, *map(str, cells)])
    header = ["truth", *(f"said {said}>" for said in VERDICTS[:-1]), "said nothing>"]
    return table(header, rows)


def per_measure(runs):
    """How each measure does alone, on the runs that it speaks about."""
    rows = []
    for key, title in MEASURES:
        said = [(truth(run), run["quality"]["measures"][key]["verdict"]) for run in runs]
        counts = [
            sum(pair == (actual, verdict) for pair in said)
            for actual, verdict in [
                ("right", "good"),
                ("right", "doubtful"),
                ("right", "bad"),
                ("wrong", "good"),
                ("wrong", "doubtful"),
                ("wrong", "bad"),
            ]
        ]
        silent = sum(verdict == "unknown" for _, verdict in said)
        rows.append([title, *map(str, counts), str(silent)])
    return table(
        [
            "measure",
            "right maps: good>",
            "doubtful>",
            "bad>",
            "wrong maps: good>",
            "doubtful>",
            "bad>",
            "silent>",
        ],
        rows,
    )


def figure(run, key):
    return run["quality"]["measures"][key]["value"]


def spread(values, factor, digits):
    known = sorted(value * factor for value in values if value is not None)
    if not known:
        return ""
    return f"{known[0]:.{digits}f} / {median(known):.{digits}f} / {known[-1]:.{digits}f}"


def figures_table(runs):
    rows = []
    for actual in ["right", "wrong"]:
        some = [run for run in runs if truth(run) == actual]
        doubled = [
            run["quality"]["doubled_share"] if figure(run, "wall_thickness_m") is not None else None
            for run in some
        ]
        held = [figure(run, "held_out_agreement") for run in some]
        rows.append(
            [
                actual,
                str(len(some)),
                spread(doubled, 100, 1),
                spread([figure(run, "entropy_gain_nats") for run in some], 1, 2),
                spread([figure(run, "free_space_violations") for run in some], 100, 1),
                spread([None if value is None else 1 - value for value in held], 100, 1),
                spread([figure(run, "reduced_chi2") for run in some], 1, 2),
            ]
        )
    return table(
        [
            "truth",
            "runs>",
            "walls drawn twice [%]>",
            "entropy gain [nats]>",
            "beams through walls [%]>",
            "returns not foretold [%]>",
            "chi-square a degree of freedom>",
        ],
        rows,
    )


def runs_table(runs):
    rows = []
    for run in sorted(runs, key=lambda run: (run["world"], run["spoil"], run["seed"])):
        said = run["quality"]
        blamed = [
            title for key, title in MEASURES if said["measures"][key]["verdict"] == said["verdict"]
        ]
        rows.append(
            [
                run["world"],
                run["spoil"],
                str(run["seed"]),
                f"{run['ate_m']:.3f}",
                f"{run['max_m']:.2f}",
                f"{run['max_deg']:.1f}",
                f"{run['f1']:.2f}",
                said["verdict"],
                ", ".join(blamed) if said["verdict"] in ("doubtful", "bad") else "",
            ]
        )
    return table(
        [
            "world",
            "spoiled by",
            "seed>",
            "ATE [m]>",
            "largest error [m]>",
            "of heading [deg]>",
            "map F1>",
            "verdict",
            "because of",
        ],
        rows,
    )


def recorded_table(runs):
    def percent(value):
        return "" if value is None else f"{100 * value:.1f}"

    rows = []
    for run in runs:
        q = run["quality"]
        rows.append(
            [
                run["log"],
                run["spoil"],
                f"{100 * q['wall_offset_m']:.1f}",
                percent(q["doubled_share"]),
                f"{figure(run, 'entropy_gain_nats'):.2f}",
                percent(figure(run, "free_space_violations")),
                percent(1 - figure(run, "held_out_agreement")),
                percent(figure(run, "degenerate_travel_share")),
                q["verdict"],
            ]
        )
    return table(
        [
            "log",
            "",
            "wall in two visits [cm]>",
            "drawn twice [%]>",
            "entropy gain [nats]>",
            "beams through walls [%]>",
            "not foretold [%]>",
            "degenerate travel [%]>",
            "verdict",
        ],
        rows,
    )


def cost_line(runs):
    some = [run for run in runs if run["spoil"] == "as it is"]
    shares = [run["judging_s"] / run["wall_s"] for run in some]
    return (
        f"Judging took {100 * median(shares):.0f} % of the time of a run with default options in"
        f" the median, {100 * max(shares):.0f} % at most (one thread)."
    )


def blocks_of(record, chosen_on, checked_on):
    chosen, checked = of_seeds(record, chosen_on), of_seeds(record, checked_on)
    when = provenance(*record["sessions"]) + "\n\n"
    result = when + "\n".join(
        [
            f"Seeds that no limit was chosen on ({len(checked)} runs):",
            "",
            confusion(checked),
            "",
            f"Seeds that the limits were chosen on ({len(chosen)} runs):",
            "",
            confusion(chosen),
            "",
            "Each measure by itself, on the seeds checked on:",
            "",
            per_measure(checked),
            "",
            cost_line(record["runs"]),
        ]
    )
    figures = when + "\n".join(
        ["Least, median and largest value, on the seeds chosen on:", "", figures_table(chosen)]
    )
    return [
        ("quality-confusion", result),
        ("quality-figures", figures),
        ("quality-runs", when + runs_table(checked)),
        *(
            [("quality-recorded", when + recorded_table(record["recorded"]))]
            if record.get("recorded")
            else []
        ),
    ]


def headline(record, checked_on):
    runs = of_seeds(record, checked_on)
    missed = sum(truth(run) == "wrong" and run["quality"]["verdict"] == "good" for run in runs)
    right = [run for run in runs if truth(run) == "right"]
    called = sum(run["quality"]["verdict"] == "good" for run in right)
    return (
        f"{len(runs)} runs checked: {missed} wrong maps called good,"
        f" {called} of {len(right)} right maps called good"
    )
