#!/usr/bin/env python3
"""Measures sites: simulated buildings that two kinds of robots drive through on many days, whose
sessions are joined without a guess; recorded logs in halves; and a thousand days of one building.
Writes the tables of docs/sites.md.

Of each session it is known from the truth how much of its way lies where sessions before it were. A
session is joined falsely where its map is off by more than 0.5 m or 3 degrees on average, once the
most sessions that agree are laid on the truth. Its furniture moves between its visits, people walk
about, and all that `--realism usual` names is wrong with its sensors. Sessions of another building
of the same kind are added, too, which must not be joined.

  bench/sites.py                     all (about half an hour on two processors)
  bench/sites.py --only joining halves
  bench/sites.py --quick             to look at; writes nothing into docs/
"""
import json
import math
import pathlib
import shutil
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "scripts"))

import sites_tables  # noqa: E402
from continued import joined_trajectory  # noqa: E402
from doc_blocks import write_block  # noqa: E402
from program import Loopstone, run, say  # noqa: E402
from sections import measure_sections, section_parser, verdicts  # noqa: E402

PAGE = "docs/sites.md"
SECTIONS = ["joining", "halves", "days"]
LOGS = [("Intel", "intel"), ("ACES", "aces")]

# World, seed, sessions, places where they begin, seconds of each.
BUILDINGS = [
    ("office", 41, 12, [1, 4, 8, 12, 16, 19], 150),
    ("office", 42, 12, [1, 4, 8, 12, 16, 19], 150),
    ("campus", 41, 10, [1, 8, 15, 22, 29], 240),
    ("warehouse", 41, 8, [1, 4, 7, 10], 150),
    ("wings", 41, 8, [1, 5, 9, 13], 180),
    ("rooms", 41, 8, [1, 5, 9, 13], 150),
]
STRANGERS = 2
ROBOTS = [
    ["--beams", "1081", "--fov", "270", "--max-range", "30"],
    ["--beams", "180", "--fov", "180", "--max-range", "25"],
]
NEAR_M = 2.0
FALSE_M, FALSE_DEG = 0.5, 3.0


def read_tum(path):
    """Stamps and poses in the plane."""
    poses = []
    for line in path.read_text(encoding="utf-8").splitlines():
        if not line or line[0] == "#":
            continue
        t, x, y, _, _, _, qz, qw = map(float, line.split())
        poses.append((t, x, y, 2.0 * math.atan2(qz, qw)))
    return poses


def paired(estimate, truth):
    """Poses of the same moment, to 20 ms."""
    pairs, at = [], 0
    for pose in estimate:
        while at + 1 < len(truth) and abs(truth[at + 1][0] - pose[0]) <= abs(
            truth[at][0] - pose[0]
        ):
            at += 1
        if abs(truth[at][0] - pose[0]) < 0.02:
            pairs.append((pose, truth[at]))
    return pairs


def alignment(pairs):
    """truth_T_map of least squares: Umeyama 1991, in the plane."""
    n = len(pairs)
    mean = [sum(p[i][k] for p in pairs) / n for i in (0, 1) for k in (1, 2)]
    cross = dot = 0.0
    for estimate, truth in pairs:
        ax, ay = estimate[1] - mean[0], estimate[2] - mean[1]
        bx, by = truth[1] - mean[2], truth[2] - mean[3]
        dot += ax * bx + ay * by
        cross += ax * by - ay * bx
    yaw = math.atan2(cross, dot)
    c, s = math.cos(yaw), math.sin(yaw)
    return (mean[2] - c * mean[0] + s * mean[1], mean[3] - s * mean[0] - c * mean[1], yaw)


def errors(pairs, frame):
    """Rms of positions [m], and how far the session is turned as a whole [deg]."""
    x, y, yaw = frame
    c, s = math.cos(yaw), math.sin(yaw)
    squares = sine = cosine = 0.0
    for estimate, truth in pairs:
        dx = x + c * estimate[1] - s * estimate[2] - truth[1]
        dy = y + s * estimate[1] + c * estimate[2] - truth[2]
        squares += dx * dx + dy * dy
        off = yaw + estimate[3] - truth[3]
        sine += math.sin(off)
        cosine += math.cos(off)
    return math.sqrt(squares / len(pairs)), math.degrees(math.atan2(sine, cosine))


def frame_of_most(sessions):
    """That of the most sessions that are right in one frame; of each session: pairs of poses."""

    def right(frame):
        return [pairs for pairs in sessions if not is_false(*errors(pairs, frame))]

    most = max((right(alignment(pairs)) for pairs in sessions), key=len)
    return alignment([pair for pairs in most or sessions for pair in pairs])


def is_false(meters, degrees):
    return meters > FALSE_M or abs(degrees) > FALSE_DEG


def squares_of(truth):
    return {(int(p[1] // NEAR_M), int(p[2] // NEAR_M)) for p in truth}


def overlap(truth, before):
    """Share of a session's way that lies where somebody was before."""
    near = [
        any(
            (int(p[1] // NEAR_M) + i, int(p[2] // NEAR_M) + j) in before
            for i in (-1, 0, 1)
            for j in (-1, 0, 1)
        )
        for p in truth
    ]
    return sum(near) / len(near)


def add(loopstone, site, log, day, flags=()):
    text, _ = run(
        [
            loopstone.program,
            "site",
            "add",
            site,
            log,
            "--date",
            f"2026-{1 + day // 28:02}-{1 + day % 28:02}",
            "--json",
            "--quiet",
            *flags,
        ]
    )
    return json.loads(text)["sessions"][0]


def session_flags(number, places, seconds):
    return [
        "--drive-seed",
        str(1000 + number),
        "--start-place",
        str(places[number % len(places)]),
        "--duration",
        str(seconds),
        *ROBOTS[number % len(ROBOTS)],
        "--format",
        "mcap",
        "--realism",
        "usual",
        "--people",
        "2",
    ]


def simulated(loopstone, world, seed, flags):
    folder = loopstone.simulate(world, seed, flags)
    return folder / "log.mcap", read_tum(folder / "truth.tum")


def building(loopstone, world, seed, count, places, seconds):
    name = f"{world}-{seed}"
    site = loopstone.work / f"sites-{name}.site"
    for end in ("", "-wal", "-shm"):
        pathlib.Path(f"{site}{end}").unlink(missing_ok=True)
    sessions, seen = [], set()
    for number in range(count):
        log, truth = simulated(loopstone, world, seed, session_flags(number, places, seconds))
        row = add(loopstone, site, log, number)
        sessions.append(
            {
                "id": row["id"],
                "overlap": overlap(truth, seen) if number else 1.0,
                "own": row["verdict"],
                "join_s": row["join_s"],
                "truth": truth,
            }
        )
        if row["status"] == "joined":
            seen |= squares_of(truth)
        shutil.rmtree(log.parent)
    strangers = []
    for number in range(STRANGERS):
        flags = session_flags(100 + number, places, seconds)
        log, _ = simulated(loopstone, world, seed + 50, flags)
        strangers.append(add(loopstone, site, log, count + number)["id"])
        shutil.rmtree(log.parent)
    return measured(loopstone, site, name, world, seed, sessions, strangers)


def measured(loopstone, site, name, world, seed, sessions, strangers):
    shown = json.loads(run([loopstone.program, "site", "show", site, "--json", "--quiet"])[0])
    status = {row["id"]: row["status"] for row in shown["sessions"]}
    out = loopstone.work / f"sites-map-{name}"
    shutil.rmtree(out, ignore_errors=True)
    _, cost = run([loopstone.program, "site", "map", site, "-o", out, "--force", "--quiet"])
    joined = [s for s in sessions if status[s["id"]] == "joined"]
    drives = sorted(out.glob("trajectory_drive_*.tum"), key=lambda p: int(p.stem.split("_")[-1]))
    # Strangers that were joined come after, and have no truth here.
    pairs = [paired(read_tum(path), s["truth"]) for path, s in zip(drives, joined)]
    frame = frame_of_most(pairs)
    found = [errors(session, frame) for session in pairs]
    false = sum(is_false(*error) for error in found)
    usable = [s for s in sessions if status[s["id"]] != "refused" and s["overlap"] >= 0.2]
    everything = sum(m * m * len(p) for (m, _), p in zip(found, pairs))
    return {
        "world": world,
        "seed": seed,
        "sessions": len(sessions),
        "refused": sum(status[s["id"]] == "refused" for s in sessions),
        "usable": len(usable),
        "joined": sum(status[s["id"]] == "joined" for s in usable),
        "false": false,
        "strangers": len(strangers),
        "strangers_joined": sum(status[i] == "joined" for i in strangers),
        "ate_m": math.sqrt(everything / sum(map(len, pairs))),
        "join_s": sorted(s["join_s"] for s in sessions)[len(sessions) // 2],
        "map_s": cost["wall_s"],
        "bytes": shown["bytes"],
        "verdict": json.loads((out / "summary.json").read_text())["quality"]["verdict"],
        **long_drive(loopstone, world, seed),
    }


def long_drive(loopstone, world, seed):
    """The whole route at once, by the better robot."""
    flags = ["--drive-seed", "2000", *ROBOTS[0], "--format", "mcap", "--realism", "usual"]
    log, truth = simulated(loopstone, world, seed, [*flags, "--people", "2"])
    folder, _, _ = loopstone.map(log, f"sites-long-{world}-{seed}")
    pairs = paired(read_tum(folder / "trajectory.tum"), truth)
    shutil.rmtree(log.parent)
    return {"long_m": errors(pairs, alignment(pairs))[0]}


def joining(loopstone, arguments):
    rows = []
    chosen = [b for b in BUILDINGS if not arguments.worlds or b[0] in arguments.worlds]
    for world, seed, count, places, seconds in chosen[: 1 if arguments.quick else None]:
        count = 3 if arguments.quick else count
        rows.append(building(loopstone, world, seed, count, places, seconds))
        row = rows[-1]
        say(
            f"  {world} {seed}: {row['joined']} of {row['usable']} joined, {row['false']} falsely, "
            f"{row['strangers_joined']} of {row['strangers']} strangers; {row['ate_m']:.3f} m, "
            f"one long drive {row['long_m']:.3f} m"
        )
    return rows


def halves(loopstone, arguments):
    rows = []
    for title, name in LOGS[: 1 if arguments.quick else None]:
        log = arguments.data / "carmen" / f"{name}.clf"
        if not log.exists():
            say(f"  {log}: not there, skipped")
            continue
        relations = log.with_suffix(".relations")
        whole, summary, _ = loopstone.map(log, f"sites-whole-{name}")
        site = loopstone.work / f"sites-{name}.site"
        for end in ("", "-wal", "-shm"):
            pathlib.Path(f"{site}{end}").unlink(missing_ok=True)
        half = f"{summary['duration_s'] / 2:.1f}"
        add(loopstone, site, log, 0, ["--duration", half])
        second = add(loopstone, site, log, 1, ["--start", half])
        out = loopstone.work / f"sites-map-{name}"
        run([loopstone.program, "site", "map", site, "-o", out, "--force", "--quiet"])
        at_once = loopstone.evaluate(
            "--estimate", whole / "trajectory.tum", "--relations", relations
        )
        joined = loopstone.evaluate("--estimate", joined_trajectory(out), "--relations", relations)
        rows.append(
            {
                "title": title,
                "status": second["status"],
                "closures": second["closures"],
                "whole_m": at_once["translation_error_m"]["mean"],
                "site_m": joined["translation_error_m"]["mean"],
                "whole_deg": at_once["rotation_error_deg"]["mean"],
                "site_deg": joined["rotation_error_deg"]["mean"],
            }
        )
        say(f"  {title}: {second['status']}, {rows[-1]['site_m']:.4f} m")
    return rows


def days(loopstone, arguments):
    count = 30 if arguments.quick else 1000
    site = loopstone.work / "sites-days.site"
    for end in ("", "-wal", "-shm"):
        pathlib.Path(f"{site}{end}").unlink(missing_ok=True)
    maps = loopstone.work / "sites-days"
    words = [site, count, count // 2, 40, maps]
    text, _ = run([arguments.programs / "measure_site", *words])
    figures = json.loads(text)
    figures["days"], figures["moved_on"] = count, count // 2
    judged = loopstone.evaluate("--map", maps / "site.yaml", "--true-map", maps / "true.yaml")
    figures["map"] = judged["map"]
    return figures


def main():
    parser = section_parser(__doc__, SECTIONS, ROOT)
    parser.add_argument("--worlds", nargs="*", help="buildings of these alone")
    arguments = parser.parse_args()
    arguments.work.mkdir(parents=True, exist_ok=True)
    loopstone = Loopstone(arguments.programs / "loopstone", arguments.work)
    measures = {"joining": joining, "halves": halves, "days": days}
    sections, failed = measure_sections(
        "sites",
        arguments,
        loopstone,
        lambda name: measures[name](loopstone, arguments),
        leave_out=lambda name, kept: arguments.resume and name in kept,
    )
    for name in SECTIONS:
        if name not in sections:
            continue
        text = sites_tables.TABLES[name](sections[name])
        if arguments.quick:
            print(text)
        elif name in arguments.only and write_block(ROOT / PAGE, f"sites-{name}", text):
            say(f"wrote {PAGE}: sites-{name}")
    print(verdicts(sites_tables.all_targets(sections)))
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
