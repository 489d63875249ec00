"""From planted loop closures to Markdown: what was thrown out, and how far the maps are off.
Nothing is measured here."""
import statistics

import tables
from doc_blocks import table
from sections import verdicts

KERNELS = {"none": "no kernel", "huber": "Huber", "cauchy": "Cauchy", "dcs": "DCS"}
# Of the clean optimum's error where the truth is known, else of what odometry alone is off.
WITHIN = 0.01
# Up to here every seed has to come back.
HOLDS_UP_TO_PERCENT = 60


def came_back(figures, run):
    if figures["truth_m"] is not None:
        return run["truth_m"] <= figures["truth_m"] * (1 + WITHIN)
    return run["off_m"] <= figures["odometry_m"] * WITHIN


def by_percent(figures):
    """percent -> its runs"""
    found = {}
    for run in figures["runs"]:
        found.setdefault(run["percent"], []).append(run)
    return found


def precision(runs):
    """Of the closures thrown out, the share that had been planted."""
    false_out = sum(run["false_out"] for run in runs)
    out = false_out + sum(run["genuine_out"] for run in runs)
    return false_out / out if out else 1.0


def recall(runs):
    """Of the planted closures, the share that was thrown out."""
    planted = sum(run["planted"] for run in runs)
    return sum(run["false_out"] for run in runs) / planted if planted else 1.0


def length_text(length_m):
    return f"{1e3 * length_m:.1f} mm" if length_m < 0.1 else f"{length_m:.2f} m"


def time_text(seconds):
    return f"{1e3 * seconds:.0f} ms" if seconds < 1 else f"{seconds:.1f} s"


def criterion(figures):
    if figures["truth_m"] is not None:
        return (
            f"the error against the truth is at most {1 + WITHIN:g} times that of the clean"
            f" optimum, {length_text(figures['truth_m'])}"
        )
    return (
        f"at most {100 * WITHIN:g} % of what odometry alone is off the clean optimum is left: "
        f"{length_text(WITHIN * figures['odometry_m'])} of {length_text(figures['odometry_m'])}"
    )


def kernel_cells(kernel_runs, percent):
    runs = [run for run in kernel_runs if run["percent"] == percent]
    if not runs:
        return [""] * len(KERNELS)
    return [
        length_text(statistics.median(run["off_m"][kernel] for run in runs)) for kernel in KERNELS
    ]


def graph_table(figures, kernel_runs):
    rows = []
    for percent, runs in sorted(by_percent(figures).items()):
        planted = runs[0]["planted"]
        off = [run["off_m"] for run in runs]
        rows.append(
            [
                f"{percent} %",
                str(planted),
                f"{100 * planted / (planted + figures['closures']):.0f} %",
                f"{sum(came_back(figures, run) for run in runs)} of {len(runs)}",
                f"{100 * precision(runs):.2f} %",
                f"{100 * recall(runs):.2f} %",
                time_text(statistics.median(run["cpu_s"] for run in runs)),
                length_text(statistics.median(off)),
                length_text(max(off)),
                *kernel_cells(kernel_runs, percent),
            ]
        )
    header = [
        "added>",
        "number>",
        "of all closures>",
        "came back>",
        "precision>",
        "recall>",
        "CPU time>",
        "gnc off by>",
        "at most>",
        *[f"{name}>" for name in KERNELS.values()],
    ]
    seeds = f"seeds 0 to {figures['seeds'] - 1}"
    if kernel_runs:
        last = max(run["seed"] for run in kernel_runs)
        seeds += f", the other kernels {f'0 to {last}' if last else '0'}"
    return "\n".join(
        [
            (
                f"**{figures['name']}**: {figures['poses']:,} poses,"
                f" {figures['closures']:,} closures, {figures['extent_m']:.0f} m; {seeds}. Came"
                f" back: {criterion(figures)}."
            ),
            "",
            table(header, rows),
            *lost_seeds(figures),
        ]
    )


def lost_seeds(figures):
    """What the solutions that did not come back have to say for themselves: a false closure that
    fits costs little."""
    lost = [run for run in figures["runs"] if not came_back(figures, run)]
    if not lost:
        return []
    words = []
    for seed in sorted({run["seed"] for run in lost}):
        runs = [run for run in lost if run["seed"] == seed]
        kept = sorted({run["planted"] - run["false_out"] for run in runs})
        dearer = [run["cost"] - figures["cost"] for run in runs]
        words.append(
            f"seed {seed} at {', '.join(str(run['percent']) for run in runs)} %:"
            f" {' or '.join(map(str, kept))} kept, cost "
            + " to ".join(dict.fromkeys(f"{value:+.1f}" for value in (min(dearer), max(dearer))))
        )
    return [
        "",
        "Did not come back (false closures kept, and the cost beside the clean optimum's"
        f" {figures['cost']:.1f}): " + "; ".join(words) + ".",
    ]


def figures_of(sections, name, part):
    section = sections.get(f"{name}-{part}")
    return section["figures"] if section else None


def text_of(names, sections):
    measured = [name for name in names if f"{name}-gnc" in sections]
    if not measured:
        return ""
    parts = [
        tables.provenance(*(sections[key] for key in sections if key.split("-")[0] in measured))
    ]
    for name in measured:
        kernels = figures_of(sections, name, "kernels")
        parts += [
            "",
            graph_table(figures_of(sections, name, "gnc"), kernels["runs"] if kernels else []),
        ]
    return "\n".join([*parts, "", tables.targets_table(targets_of(names, sections))])


def progress(figures):
    for percent, runs in sorted(by_percent(figures).items()):
        failed = [run["seed"] for run in runs if not came_back(figures, run)]
        yield (
            f"{figures['name']} {percent} %: precision {precision(runs):.4f}, recall"
            f" {recall(runs):.4f}, median CPU"
            f" {statistics.median(run['cpu_s'] for run in runs):.3f} s"
            + (f", FAILED seeds {' '.join(map(str, failed))}" if failed else "")
        )


def targets_of(names, sections):
    found = []
    for figures in filter(None, (figures_of(sections, name, "gnc") for name in names)):
        runs = [run for run in figures["runs"] if run["percent"] <= HOLDS_UP_TO_PERCENT]
        if not runs:
            continue
        good = sum(came_back(figures, run) for run in runs)
        found.append(
            (
                f"{figures['name']}: seeds that come back, up to {HOLDS_UP_TO_PERCENT} % added",
                f"all {len(runs)}",
                str(good),
                good == len(runs),
            )
        )
    return found


def summary(names, sections):
    return verdicts(targets_of(names, sections))
