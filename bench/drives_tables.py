"""The tables of bench/drives.py: from what was measured to Markdown."""
import math

import tables
from closures import PRECISION, total
from doc_blocks import table
from largest_error import RIGHT_DEG, RIGHT_M, SIGMAS
from program import median
from provenance import provenance
from unkind import CLEAN, USUAL, Drive, is_good, is_unforetold, is_wrong, simulation, worst_of

VERDICTS = ["good", "doubtful", "bad", "unknown"]
# What the clean form of a drive may be exceeded by.
CLEAN_TIMES = 3.0
FAULTS = (
    "Drives with a false loop closure, with a wrong map that is called good, or with a map that is"
    " worse for closing loops:"
)
# Worse for closing loops: by so much, and not by hundredths of what was wrong before.
WORSE_M, WORSE_TIMES = 0.01, 1.1


def drive_of(run):
    return Drive(*(run[name] for name in Drive._fields))


def is_mapped(run):
    return not run.get("failed")


def is_worse(run):
    return run["ate_m"] > WORSE_TIMES * run["without"]["ate_m"] + WORSE_M


def with_without(runs):
    return [run for run in runs if is_mapped(run) and "without" in run]


def join_clean(figures):
    """The drives, each with the ATE of its clean form."""
    runs = []
    for run in figures.values():
        clean = figures.get(drive_of(run).clean().key(), {})
        if run["effect"] != CLEAN:
            runs.append({**run, "clean_m": clean.get("ate_m")})
    return runs


def times_clean(runs):
    """ATE over that of the clean form; of a drive that could not be mapped, infinite."""
    return [
        run["ate_m"] / run["clean_m"] if is_mapped(run) else math.inf
        for run in runs
        if run["clean_m"]
    ]


def spread(values, factor, digits):
    """Median, what nine of ten keep to, and the largest."""
    if not values:
        return ""
    values = sorted(factor * value for value in values)
    tenth = values[math.ceil(0.9 * len(values)) - 1]
    return " / ".join(f"{value:.{digits}f}" for value in (median(values), tenth, values[-1]))


def judged(runs):
    """Runs as closures.total counts them."""
    return [run.get("closures", {"failed": True}) for run in runs]


def confusion(runs):
    foretold = f"by {SIGMAS:.0f} standard deviations of its own at most"
    kinds = {
        f"right: off by {RIGHT_M} m and {RIGHT_DEG:.0f} degree at most, anywhere": (
            lambda run: not is_wrong(run)
        ),
        f"wrong, {foretold}": lambda run: is_wrong(run) and not is_unforetold(run),
        "wrong, by more": is_unforetold,
    }
    said = [*VERDICTS[:-1], "nothing", "not mapped"]
    rows = []
    for title, is_of_kind in kinds.items():
        some = [run.get("verdict", "not mapped") for run in runs if is_of_kind(run)]
        some = ["nothing" if verdict == VERDICTS[-1] else verdict for verdict in some]
        rows.append([title, str(len(some)), *(str(some.count(word)) for word in said)])
    header = [f"said {word}>" for word in said[:-1]] + [f"{said[-1]}>"]
    return table(["truth", "drives>", *header], rows)


def targets_of(runs):
    """(figure, target, measured, met)"""
    silent = sum(is_wrong(run) and is_good(run) for run in runs)
    times = times_clean(runs)
    far = sum(ratio > CLEAN_TIMES for ratio in times)
    accepted = total(judged(runs), "accepted")
    precision = 1.0 - total(judged(runs), "false") / max(1, accepted)
    both = with_without(runs)
    worse = sum(map(is_worse, both))
    return [
        ("wrong maps that are called good", "none", str(silent), silent == 0),
        (
            f"ATE more than {CLEAN_TIMES:.0f} times that of the same drive in its clean form",
            "none",
            f"{far} of {len(times)}",
            far == 0,
        ),
        (
            f"loop closures that are true, of {accepted}",
            f">= {100 * PRECISION:.1f} %",
            f"{100 * precision:.2f} %",
            precision >= PRECISION,
        ),
        (
            f"ATE worse for closing loops, by {100 * WORSE_M:.0f} cm and"
            f" {100 * (WORSE_TIMES - 1):.0f} %",
            "none",
            f"{worse} of {len(both)}",
            worse == 0,
        ),
    ]


def row_of(name, runs):
    right = [run for run in runs if not is_wrong(run)]
    wrong = [run for run in runs if is_wrong(run)]
    mapped = [run for run in runs if is_mapped(run)]
    clean = [run["clean_m"] for run in runs if run["clean_m"]]
    found, revisits = (total(judged(runs), key) for key in ("recognised", "revisits"))
    return [
        name,
        str(len(runs)),
        str(len(right)),
        str(sum(map(is_good, right))),
        str(len(wrong)),
        str(sum(map(is_good, wrong))),
        str(sum(map(is_unforetold, wrong))),
        f"{100 * median(clean):.1f}" if clean else "",
        spread([run["ate_m"] for run in mapped], 100, 1),
        spread(times_clean(runs), 1, 1),
        spread([run["worst_m"] for run in mapped], 1, 2),
        spread([run["worst_deg"] for run in mapped], 1, 1),
        str(total(judged(runs), "accepted")),
        str(total(judged(runs), "false")),
        f"{revisits}",
        f"{100 * found / revisits:.1f} %" if revisits else "",
    ]


def grouped(runs, name):
    last = [row_of("all", runs)] if name == "effect" else []
    groups = {}
    for run in runs:
        groups.setdefault(run[name], []).append(run)
    return table(
        [
            name,
            "drives>",
            "right>",
            "right, called good>",
            "wrong>",
            "wrong, called good>",
            "wrong beyond its covariance>",
            "ATE when clean, median [cm]>",
            "ATE [cm]>",
            "ATE over clean>",
            "worst place [m]>",
            "worst heading [deg]>",
            "loop closures>",
            "of them false>",
            "metres of revisits>",
            "recognised>",
        ],
        [row_of(group, some) for group, some in groups.items()] + last,
    )


def without_table(runs):
    groups = {}
    for run in with_without(runs):
        groups.setdefault(run["robot"], []).append(run)
    rows = []
    for name, some in [*groups.items(), ("all", with_without(runs))]:
        right = [(not is_wrong(run["without"]), not is_wrong(run)) for run in some]
        rows.append(
            [
                name,
                str(len(some)),
                str(sum(before for before, _ in right)),
                str(sum(after for _, after in right)),
                str(right.count((True, False))),
                spread([run["without"]["ate_m"] for run in some], 100, 1),
                spread([run["ate_m"] for run in some], 100, 1),
                str(sum(map(is_worse, some))),
            ]
        )
    return table(
        [
            "robot",
            "drives>",
            "right without closing loops>",
            "right with>",
            "wrong by it alone>",
            "ATE without [cm]>",
            "ATE [cm]>",
            "worse>",
        ],
        rows,
    )


def faults_of(run):
    if not is_mapped(run):
        yield "not mapped"
        return
    if is_wrong(run) and is_good(run):
        yield "wrong and called good"
    closures = run["closures"]
    if closures["false"]:
        most = f"{closures['false_m']:.2f} m, {closures['false_deg']:.1f} deg"
        yield f"false loop closures: {closures['false']}, up to {most} off"
    if "without" in run and is_worse(run):
        yield f"ATE {run['ate_m']:.2f} m, without closing loops {run['without']['ate_m']:.2f} m"


def faults_table(runs, duration):
    rows = [
        [
            "; ".join(faults),
            worst_of(run) if is_mapped(run) else "",
            f"`loopstone {' '.join(simulation(drive_of(run), duration))} -o sim`",
        ]
        for run in runs
        if (faults := list(faults_of(run)))
    ]
    return table(["what is wrong", "map off by", "the drive"], rows)


def text_of(kept):
    runs = join_clean(kept["figures"])
    duration = kept["asked"][0]
    order = ["world", "robot", "seed"]
    runs.sort(key=lambda run: (run["effect"] != USUAL, run["effect"], *(run[k] for k in order)))
    wrong = [run for run in runs if is_wrong(run)]
    right = len(runs) - len(wrong)
    sentence = (
        f"{len(runs)} drives of {duration:g} s: {right} maps are right, {len(wrong)} wrong;"
        f" {sum(is_good(run) and not is_wrong(run) for run in runs)} right ones and"
        f" {sum(map(is_good, wrong))} wrong ones are called good."
    )
    parts = [
        provenance(*kept["sessions"]),
        sentence,
        confusion(runs),
        tables.targets_table(targets_of(runs)),
        "Three figures are the median, what nine of ten keep to, and the most.",
        *(grouped(runs, name) for name in ("effect", "world", "robot")),
    ]
    if with_without(runs):
        parts += [f"Loop closing and none, on drives that are `{USUAL}`:", without_table(runs)]
    if any(True for run in runs for _ in faults_of(run)):
        parts += [FAULTS, faults_table(runs, duration)]
    return "\n\n".join(parts)
