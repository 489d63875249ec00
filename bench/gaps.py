#!/usr/bin/env python3
"""Takes the scans of some seconds out of a log, keeps its odometry, and maps what is left: gaps of
1 to 60 s at 20 places of simulated and recorded logs. Writes a table of docs/robustness.md: how far
the motion across the gap is off beside odometry's own, how far the whole path is, and what the
verdict said.

The reference of a simulated log is its truth; of a recorded log, the map of the whole log.

  bench/gaps.py                     everything (about half an hour)
  bench/gaps.py --only office       some logs
  bench/gaps.py --quick             fewer gaps; to look at, writes nothing into docs/
"""
import bisect
import concurrent.futures
import math
import os
import pathlib
import shutil
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "scripts"))

from doc_blocks import table, write_block  # noqa: E402
from program import Loopstone, say  # noqa: E402
from sections import measure_sections, section_parser  # noqa: E402
from provenance import provenance  # noqa: E402

PAGE = ROOT / "docs/robustness.md"
SIMULATED = {"office": [], "warehouse": [], "campus": []}
RECORDED = {"intel": "Intel Research Lab", "aces": "ACES building"}
GAPS_S = [1, 3, 5, 10, 20, 60]
PLACES = 20
ROBOT = ["--format", "carmen", "--beams", "181", "--fov", "180"]
# A motion across a gap may be off by so much more than odometry's: what scans a few metres apart
# are off by on a good map.
REST_M = {"simulated": 0.02, "recorded": 0.05}
ODOMETRY_SHARE = 1.5


def read_tum(path):
    """Stamps and poses (x, y, yaw)."""
    stamps, poses = [], []
    for line in pathlib.Path(path).read_text().splitlines():
        if not line or line.startswith("#"):
            continue
        t, x, y, _, _, _, qz, qw = map(float, line.split())
        stamps.append(t)
        poses.append((x, y, 2.0 * math.atan2(qz, qw)))
    return stamps, poses


def pose_at(trajectory, stamp):
    stamps, poses = trajectory
    return poses[bisect.bisect_left(stamps, stamp - 1e-4)]


def relation(trajectory, t0, t1):
    """Motion between the poses at two stamps, or None where either is missing."""
    stamps, poses = trajectory
    found = []
    for t in (t0, t1):
        i = bisect.bisect_left(stamps, t - 1e-4)
        if i == len(stamps) or abs(stamps[i] - t) > 1e-3:
            return None
        found.append(poses[i])
    (x0, y0, a), (x1, y1, b) = found
    dx, dy = x1 - x0, y1 - y0
    return (math.cos(a) * dx + math.sin(a) * dy, -math.sin(a) * dx + math.cos(a) * dy, b - a)


def apart_m(a, b):
    return math.hypot(a[0] - b[0], a[1] - b[1])


def scan_stamp(line):
    return float(line.rsplit(None, 3)[1])


def without_scans(lines, stamps, start_s, length_s):
    """The log's lines less the scans of some seconds; the stamps of the scans on either side."""
    begin, end = stamps[0] + start_s, stamps[0] + start_s + length_s
    kept = [
        line
        for line in lines
        if not line.startswith("FLASER") or not begin <= scan_stamp(line) < end
    ]
    left = [t for t in stamps if t < begin]
    right = [t for t in stamps if t >= end]
    return kept, (left[-1] if left else None), (right[0] if right else None)


def map_once(loopstone, log, name):
    """Trajectory, odometry and what the run said of itself."""
    out, summary, _ = loopstone.map(log, name, ["--threads", "1"])
    kept = {
        "trajectory": read_tum(out / "trajectory.tum"),
        "odometry": read_tum(out / "odometry.tum"),
        "verdict": summary["quality"]["verdict"],
        "warnings": summary["warnings"],
        "breaks": len(summary["path_breaks"]),
        "tum": out / "trajectory.tum",
    }
    return kept


def compose(a, b):
    return (
        a[0] + math.cos(a[2]) * b[0] - math.sin(a[2]) * b[1],
        a[1] + math.sin(a[2]) * b[0] + math.cos(a[2]) * b[1],
        a[2] + b[2],
    )


def tum_line(stamp, pose):
    x, y, yaw = pose
    return f"{stamp:.9f} {x:.9f} {y:.9f} 0 0 0 {math.sin(yaw / 2):.12f} {math.cos(yaw / 2):.12f}\n"


def write_seen(path, trajectory, left, right):
    """The trajectory without what lies between two stamps."""
    kept = [tum_line(*one) for one in zip(*trajectory) if not left + 1e-4 < one[0] < right - 1e-4]
    path.write_text("".join(kept))


def write_torn(path, trajectory, right, left_pose, motion):
    """The trajectory as it would be if all that is known across the gap were this motion."""
    stamps, poses = trajectory
    at_right = pose_at(trajectory, right)
    with open(path, "w", encoding="utf-8") as file:
        for stamp, pose in zip(stamps, poses):
            if stamp >= right - 1e-4:
                since = (
                    relation(([right, stamp], [at_right, pose]), right, stamp)
                    if stamp > right + 2e-3
                    else (0, 0, 0)
                )
                pose = compose(compose(left_pose, motion), since)
            file.write(tum_line(stamp, pose))


def ate_m(loopstone, trajectory, reference):
    return loopstone.evaluate("--estimate", trajectory, "--reference", reference, "--align", "se2")[
        "ate_rmse_m"
    ]


def measure_gap(
    loopstone, name, lines, stamps, start_s, length_s, clean, reference, rest_m, clean_ate_m
):
    kept, left, right = without_scans(lines, stamps, start_s, length_s)
    if left is None or right is None:
        return None
    tag = f"gaps-{name}-{start_s:.0f}-{length_s}"
    log = loopstone.work / f"{tag}.clf"
    log.write_text("".join(kept))
    result = map_once(loopstone, log, tag)
    # The scans that are left are judged: between them nobody asked where the robot was.
    seen = log.with_suffix(".reference.tum")
    write_seen(seen, reference["trajectory"], left, right)
    whole_m = ate_m(loopstone, result["tum"], seen)
    truth = relation(reference["trajectory"], left, right)
    estimate = relation(result["trajectory"], left, right)
    odometry = relation(clean["odometry"], left, right)
    before = relation(clean["trajectory"], left, right)
    if None in (truth, estimate, odometry, before):
        return None
    torn = log.with_suffix(".tum")
    write_torn(torn, clean["trajectory"], right, pose_at(clean["trajectory"], left), odometry)
    torn_m = ate_m(loopstone, torn, seen)
    for path in (torn, seen, log):
        path.unlink()
    shutil.rmtree(result["tum"].parent)
    odometry_m = apart_m(odometry, truth)
    bound_m = ODOMETRY_SHARE * odometry_m + max(rest_m, apart_m(before, truth))
    path_bound_m = ODOMETRY_SHARE * torn_m + max(rest_m, clean_ate_m)
    off_m = apart_m(estimate, truth)
    row = {
        "start_s": start_s,
        "gap_s": length_s,
        "true_m": math.hypot(truth[0], truth[1]),
        "odometry_m": odometry_m,
        "torn_m": torn_m,
        "off_m": off_m,
        "ate_m": whole_m,
        "bound_m": bound_m,
        "path_bound_m": path_bound_m,
        "within": off_m <= bound_m and whole_m <= path_bound_m,
        "verdict": result["verdict"],
        "warned": result["breaks"] > 0,
    }
    if not row["within"]:
        say(
            f"    {name} {start_s:.0f} s + {length_s} s: {row['true_m']:.1f} m, off {off_m:.3f},"
            f" odometry {odometry_m:.3f}, path {whole_m:.3f} (bounds {bound_m:.3f},"
            f" {path_bound_m:.3f}), {row['verdict']}, {result['warnings'][:3]}"
        )
    return row


def measure_log(loopstone, name, log, truth, rest_m, quick):
    lines = log.read_text().splitlines(keepends=True)
    stamps = sorted(scan_stamp(line) for line in lines if line.startswith("FLASER"))
    clean = map_once(loopstone, log, f"gaps-{name}-clean")
    reference = {"trajectory": read_tum(truth), "tum": truth} if truth else clean
    clean_ate_m = ate_m(loopstone, clean["tum"], reference["tum"])
    length_s = stamps[-1] - stamps[0]
    places = PLACES if not quick else 5
    jobs = [
        (length_s * (place + 0.5) / places, gap)
        for gap in (GAPS_S if not quick else [5, 20])
        for place in range(places)
    ]
    with concurrent.futures.ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:
        rows = pool.map(
            lambda job: measure_gap(
                loopstone, name, lines, stamps, *job, clean, reference, rest_m, clean_ate_m
            ),
            jobs,
        )
        rows = [row for row in rows if row]
    summary = {"clean_ate_m": clean_ate_m, "clean_verdict": clean["verdict"], "rows": rows}
    wrong = [row for row in rows if not row["within"]]
    say(
        f"  {name}: {len(wrong)} of {len(rows)} worse than the bound, "
        f"{sum(row['verdict'] == 'good' for row in wrong)} of them called good"
    )
    return summary


def measure(name, loopstone, data, quick):
    if name in SIMULATED:
        runs = {}
        for seed in (1,):
            folder = loopstone.simulate(name, seed, [*ROBOT, *SIMULATED[name]])
            runs[f"{name} {seed}"] = measure_log(
                loopstone,
                f"{name}-{seed}",
                folder / "log.clf",
                folder / "truth.tum",
                REST_M["simulated"],
                quick,
            )
        return runs
    log = data / f"carmen/{name}.clf"
    if not log.exists():
        say(f"  {log}: not there")
        return None
    return {RECORDED[name]: measure_log(loopstone, name, log, None, REST_M["recorded"], quick)}


def worst(rows, figure):
    return f"{max(row[figure] for row in rows):.3f}" if rows else ""


def text_of(sections):
    cells = []
    for section in sections.values():
        for log, figures in section["figures"].items():
            for gap in sorted({row["gap_s"] for row in figures["rows"]}):
                rows = [row for row in figures["rows"] if row["gap_s"] == gap]
                wrong = [row for row in rows if not row["within"]]
                cells.append(
                    [
                        log,
                        str(gap),
                        str(len(rows)),
                        worst(rows, "odometry_m"),
                        worst(rows, "off_m"),
                        worst(rows, "torn_m"),
                        worst(rows, "ate_m"),
                        f"{figures['clean_ate_m']:.3f}",
                        str(len(wrong)),
                        str(sum(row["verdict"] == "good" for row in wrong)),
                        str(sum(row["verdict"] == "good" for row in rows)),
                    ]
                )
    return (
        provenance(*sections.values())
        + "\n\n"
        + table(
            [
                "log",
                "gap [s]>",
                "places>",
                "odometry across the gap, worst [m]>",
                "map across the gap, worst [m]>",
                "ATE with odometry across, worst [m]>",
                "ATE, worst [m]>",
                "ATE without a gap [m]>",
                "worse than the bound>",
                "of them called good>",
                "called good>",
            ],
            cells,
        )
    )


def main():
    names = [*SIMULATED, *RECORDED]
    parser = section_parser(__doc__, names, ROOT)
    arguments = parser.parse_args()
    arguments.work.mkdir(parents=True, exist_ok=True)
    loopstone = Loopstone(arguments.programs / "loopstone", arguments.work)
    sections, failed = measure_sections(
        "gaps",
        arguments,
        loopstone,
        lambda name: measure(name, loopstone, arguments.data, arguments.quick),
        leave_out=lambda name, kept: arguments.resume and name in kept,
    )
    if sections:
        text = text_of({name: sections[name] for name in names if name in sections})
        if arguments.quick:
            print(text)
        else:
            write_block(PAGE, "robustness-gaps", text)
    raise SystemExit(1 if failed else 0)


if __name__ == "__main__":
    main()
