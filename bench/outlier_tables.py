"""From planted loop closures to Markdown: what was thrown out, and how far the maps are off. Nothing is measured here."""
import statistics

import tables
from doc_blocks import table
from sections import verdicts

KERNELS = {"gnc": "gnc", "none": "no kernel", "huber": "Huber", "cauchy": "Cauchy", "dcs": "DCS"}
# Of the clean optimum's error where the truth is known, else of what odometry alone is off.
WITHIN = 0.01
# Up to here every seed has to come back.
HOLDS_UP_TO_PERCENT = 60


def came_back(figures, run):
    if figures["truth_m"] is not None:
        return run["truth_m"] <= figures["truth_m"] * (1 + WITHIN)
    return run["off_m"]["gnc"] <= figures["odometry_m"] * WITHIN


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
        return (f"the error against the truth is at most {1 + WITHIN:g} times that of the clean optimum, "
                f"{length_text(figures['truth_m'])}")
    return (f"at most {100 * WITHIN:g} % of what odometry alone is off the clean optimum is left: "
            f"{length_text(WITHIN * figures['odometry_m'])} of {length_text(figures['odometry_m'])}")


def graph_table(section):
    figures = section["figures"]
    rows = []
    for percent, runs in sorted(by_percent(figures).items()):
        planted = runs[0]["planted"]
        off = {kernel: [run["off_m"][kernel] for run in runs] for kernel in KERNELS}
        rows.append([f"{percent} %", str(planted), f"{100 * planted / (planted + figures['closures']):.0f} %",
                     f"{sum(came_back(figures, run) for run in runs)} of {len(runs)}", f"{100 * precision(runs):.2f} %",
                     f"{100 * recall(runs):.2f} %", time_text(statistics.median(run["cpu_s"] for run in runs)),
                     length_text(statistics.median(off["gnc"])), length_text(max(off["gnc"])),
                     *[length_text(statistics.median(off[kernel])) for kernel in KERNELS if kernel != "gnc"]])
    header = ["added>", "number>", "of all closures>", "came back>", "precision>", "recall>", "CPU time>", "gnc off by>",
              "at most>", *[f"{name}>" for kernel, name in KERNELS.items() if kernel != "gnc"]]
    return "\n".join([
        f"**{figures['name']}**: {figures['poses']:,} poses, {figures['closures']:,} closures, {figures['extent_m']:.0f} m;"
        f" seeds 0 to {figures['seeds'] - 1}. Came back: {criterion(figures)}.", "", table(header, rows)])


def text_of(sections):
    parts = [] if not sections else [tables.provenance(sections[0])]
    for section in sections:
        parts += ["", graph_table(section)]
    figures = [section["figures"] for section in sections]
    if figures:
        parts += ["", tables.targets_table(targets_of(figures))]
    return "\n".join(parts)


def progress(figures):
    for percent, runs in sorted(by_percent(figures).items()):
        failed = [run["seed"] for run in runs if not came_back(figures, run)]
        yield (f"{figures['name']} {percent} %: precision {precision(runs):.4f}, recall {recall(runs):.4f}, median CPU "
               f"{statistics.median(run['cpu_s'] for run in runs):.3f} s"
               + (f", FAILED seeds {' '.join(map(str, failed))}" if failed else ""))


def targets_of(all_figures):
    found = []
    for figures in all_figures:
        runs = [run for run in figures["runs"] if run["percent"] <= HOLDS_UP_TO_PERCENT]
        if not runs:
            continue
        good = sum(came_back(figures, run) for run in runs)
        found.append((f"{figures['name']}: seeds that come back, up to {HOLDS_UP_TO_PERCENT} % added", f"all {len(runs)}",
                      str(good), good == len(runs)))
    return found


def summary(all_figures):
    return verdicts(targets_of(all_figures))
