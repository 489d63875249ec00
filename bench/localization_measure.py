"""What is measured of localisation: each function returns plain figures for one section of the
tables.

Simulated drives are run by measure_localization, one process a drive; recorded logs by `loopstone
localize`.
"""
import csv
import hashlib
import json
import math
import random
import re

from program import Failed, run, say

# Maps of real places, and what the tables call them. Pictures without a YAML have cells of 5 cm,
# Willow Garage's of 10 cm.
MAPS = [
    ("depot.yaml", "depot"),
    ("warehouse.yaml", "warehouse"),
    ("basement_hallways_5cm.png", "basement hallways"),
    ("willow-full.pgm", "Willow Garage, 10 cm cells"),
]
CARRIED_M = 1.0  # a robot that is set down nearer than this was hardly kidnapped


class Drives:
    """Runs measure_localization, and keeps what each run said: an interrupted measurement goes on
    where it was."""

    def __init__(self, program, data, kept, resume):
        self.program, self.data, self.kept = program, data, kept
        self.known = {}
        # What another build of the program said is no figure of this one.
        self.build = hashlib.sha256(program.read_bytes()).hexdigest()[:16]
        if resume and kept.exists():
            for line in kept.read_text().splitlines():
                run_kept = json.loads(line)
                if run_kept["build"] == self.build:
                    self.known[run_kept["key"]] = run_kept["said"]
        else:
            kept.write_text("")

    def one(self, place, **settings):
        words = [f"{key}={value}" for key, value in settings.items()]
        key = " ".join([place, *words])
        if key not in self.known:
            path = self.data / "maps" / place if "." in place else place
            output, cost = run([self.program, path, *words])
            said = json.loads(output)
            said["peak_mb"] = cost["peak_mb"]
            with open(self.kept, "a", encoding="utf-8") as kept:
                kept.write(json.dumps({"build": self.build, "key": key, "said": said}) + "\n")
            self.known[key] = said
        return self.known[key]

    def many(self, place, seeds, **settings):
        runs = []
        for seed in range(1, seeds + 1):
            try:
                runs.append(self.one(place, seed=seed, **settings))
            except Failed as failure:
                say(f"  {place} {seed}: FAILED\n{failure}")
                runs.append({"seed": seed, "failed": True})
        return runs

    def maps(self):
        """(file, title) of the real maps that are there."""
        there = [(name, title) for name, title in MAPS if (self.data / "maps" / name).exists()]
        if len(there) < len(MAPS):
            say(
                f"  {self.data / 'maps'}: {len(MAPS) - len(there)} of {len(MAPS)} maps are not"
                " there, skipped"
            )
        return there


def case_of(name, runs, **more):
    wrong = [run["seed"] for run in runs if run.get("failed") or run["wrong_tracking"] > 0]
    say(
        f"  {name}: {len(runs)} runs"
        + (f", wrong while TRACKING (or failed) in seeds {wrong}" if wrong else "")
    )
    return {"name": name, "runs": runs, **more}


def tracking(drives, quick):
    seeds, fewer = (2, 1) if quick else (10, 5)
    cases = [
        case_of("office, simulated", drives.many("office", seeds, start="truth", duration_s=120))
    ]
    for place, title in drives.maps():
        cases.append(
            case_of(title, drives.many(place, fewer, start="truth", random_start=1, duration_s=90))
        )
    return cases


def global_start(drives, quick):
    many, fewer = (4, 2) if quick else (100, 25)
    cases = [case_of("office, simulated", drives.many("office", many, random_start=1))]
    for place, title in drives.maps():
        cases.append(case_of(title, drives.many(place, fewer, random_start=1)))
    cases.append(
        case_of(
            "campus, simulated, 10,000 m2",
            drives.many("campus", many, random_start=1, duration_s=12),
            timed=True,
        )
    )
    return cases


def ambiguous(drives, quick):
    seeds, fewer = (2, 1) if quick else (30, 10)
    return [
        case_of(
            "rooms that are all alike, from anywhere", drives.many("rooms", seeds, random_start=1)
        ),
        case_of("the same, with a guess that is wrong", drives.many("rooms", seeds, start="wrong")),
        case_of(
            "a corridor of 100 m to its far end and back, from anywhere",
            drives.many("corridor", fewer, duration_s=240),
        ),
        case_of(
            "the same, from a good guess",
            drives.many("corridor", fewer, start="truth", duration_s=240),
        ),
    ]


def kidnapping(drives, quick):
    many, fewer = (2, 1) if quick else (50, 4)
    settings = {"start": "truth", "kidnaps": 2, "duration_s": 90}
    cases = [case_of("office, simulated", drives.many("office", many, **settings))]
    for place, title in drives.maps():
        cases.append(case_of(title, drives.many(place, fewer, **settings)))
    return cases


def changed(drives, quick):
    seeds = 2 if quick else 10
    cases = []
    for clutter, people in [(0, 0), (25, 0), (0, 6), (25, 6), (50, 12)]:
        name = f"{clutter} things gone and {clutter} new, {people} people"
        cases.append(
            case_of(
                name, drives.many("office", seeds, start="truth", clutter=clutter, people=people)
            )
        )
    return cases


def recorded(loopstone, data, work, quick):
    """Wean Hall from anywhere; and a simulator's log whose truth is known and whose odometry we
    spoil."""
    folder = data / "localization"
    if not folder.exists():
        say(f"  {folder}: not there, skipped")
        return []
    seeds = range(1, 2 if quick else 6)
    rows = []
    for name, title in [("wean1", "Wean Hall, 1"), ("wean2", "Wean Hall, 2")]:
        log = folder / "wean" / f"{name}.clf"
        mapped = loopstone.map(log, name)[0] / "trajectory.tum"
        rows += [
            recorded_run(
                loopstone, log, folder / "wean/wean.yaml", title, seed, work, mapped=mapped
            )
            for seed in seeds
        ]
    scaled = at_the_simulators_scale(folder / "sim/meeting.yaml", work)
    for seed in seeds:
        log = work / f"simpath2-spoiled-{seed}.clf"
        spoil(folder / "sim/simpath2.clf", log, seed)
        for occupancy, title in [
            (folder / "sim/meeting.yaml", "simpath2, map as it is"),
            (scaled, "simpath2, map at the simulator's scale"),
        ]:
            rows.append(
                recorded_run(
                    loopstone,
                    log,
                    occupancy,
                    title,
                    seed,
                    work,
                    truth=folder / "sim/simpath2_truth.tum",
                )
            )
    return rows


def recorded_run(loopstone, log, occupancy, title, seed, work, truth=None, mapped=None):
    estimate = work / f"{log.stem}-{occupancy.stem}-{seed}.tum"
    output, cost = run(
        [
            loopstone.program,
            "localize",
            log,
            "--map",
            occupancy,
            "-o",
            estimate,
            "--global",
            "--seed",
            seed,
            "--force",
            "--json",
            "--quiet",
        ]
    )
    summary = json.loads(output)
    row = {
        "title": title,
        "seed": seed,
        "cpu_s": cost["cpu_s"],
        **{
            key: summary[key]
            for key in [
                "scans",
                "poses",
                "path_length_m",
                "duration_s",
                "tracking_share",
                "doubtful_share",
                "lost_share",
                "first_tracking_m",
                "explained_mean",
                "violations_mean",
                "unexpected_mean",
                "searches",
                "realtime_factor",
            ]
        },
    }
    tracking = estimate.with_name(estimate.stem + "-tracking.tum")
    row["sure"] = keep_sure(estimate, tracking, occupancy)
    if truth is not None and row["sure"]["poses"] > 0:
        # Compared at the stamps of the poses that are TRACKING: between them, across gaps, nothing
        # is claimed.
        judged = loopstone.evaluate("--estimate", truth, "--reference", tracking, "--align", "se2")
        row |= {
            "ate_m": judged["ate_rmse_m"],
            "ate_rad": judged["ate_rmse_rad"],
            "max_m": judged["ate_translation_m"]["max"],
        }
    if mapped is not None:
        row |= consistency(tracking, mapped)
    say(
        f"  {title} {seed}: TRACKING {row['tracking_share']:.3f}, explained"
        f" {row['explained_mean']:.3f}, on free cells {row['sure']['free']:.4f}"
        + (f", ATE {row['ate_m']:.4f} m" if "ate_m" in row else "")
        + (f", elsewhere {row['elsewhere']:.4f}" if "elsewhere" in row else "")
    )
    return row


def at_the_simulators_scale(yaml, work):
    """The simulator stretched the picture: it gave what is black in it, without the white and grey
    about, the size in its world file, so cells are 3.5 % larger than the YAML says."""
    size_m = re.search(
        r"bitmap.*\n\s*size \[([\d.]+) ([\d.]+)", yaml.with_suffix(".world").read_text()
    ).groups()
    columns, rows, _, pixels = read_picture(
        yaml.parent / re.search(r"^image:\s*(\S+)", yaml.read_text(), re.M).group(1)
    )
    black = [i for i in range(columns * rows) if pixels[i] < 128]
    width = max(i % columns for i in black) - min(i % columns for i in black)
    height = (max(black) - min(black)) // columns
    resolution = 0.5 * (float(size_m[0]) / width + float(size_m[1]) / height)
    text = re.sub(
        r"^image:\s*(\S+)",
        lambda found: f"image: {(yaml.parent / found.group(1)).resolve()}",
        yaml.read_text(),
        flags=re.M,
    )
    scaled = work / "meeting-scaled.yaml"
    scaled.write_text(re.sub(r"^resolution:.*", f"resolution: {resolution:.6f}", text, flags=re.M))
    return scaled


def read_tum(path):
    """{stamp: (x, y, yaw)}"""
    poses = {}
    for line in path.read_text().splitlines():
        if line and not line.startswith("#"):
            words = [float(word) for word in line.split()]
            poses[round(words[0], 4)] = (words[1], words[2], 2.0 * math.atan2(words[6], words[7]))
    return poses


APART_M = 1.5


def consistency(tracking, mapped):
    """Where no truth is known: the trajectory of mapping the same log is laid over the estimates so
    that as many as can be agree, and those farther than 1.5 m from it are taken to be elsewhere
    than the robot was."""
    known, found = read_tum(mapped), read_tum(tracking)
    pairs = [(found[stamp], known[stamp]) for stamp in found if stamp in known]
    if not pairs:
        return {"compared": 0, "elsewhere": 0.0}
    best = 0
    for (x, y, yaw), (u, v, phi) in pairs[::10]:
        turn = yaw - phi
        cos, sin = math.cos(turn), math.sin(turn)
        near = sum(
            math.hypot(
                x + cos * (p[0] - u) - sin * (p[1] - v) - e[0],
                y + sin * (p[0] - u) + cos * (p[1] - v) - e[1],
            )
            <= APART_M
            for e, p in pairs
        )
        best = max(best, near)
    return {"compared": len(pairs), "elsewhere": 1.0 - best / len(pairs)}


def keep_sure(estimate, tracking, occupancy):
    """Writes the poses that are TRACKING; tells how many lie on free cells, and what share of the
    returns walls explain."""
    is_free = free_cells(occupancy)
    lines = [
        line for line in estimate.read_text().splitlines() if line and not line.startswith("#")
    ]
    with open(estimate.with_suffix(".csv"), encoding="utf-8") as table:
        rows = list(csv.DictReader(table))
    if len(lines) != len(rows):
        raise Failed(f"{estimate}: as many poses as its table has were expected")
    sure = [
        (line, row) for line, row in zip(lines, rows, strict=True) if row["state"] == "TRACKING"
    ]
    tracking.write_text("".join(line + "\n" for line, _ in sure))
    count = max(1, len(sure))
    return {
        "poses": len(sure),
        "free": sum(is_free(float(row["x_m"]), float(row["y_m"])) for _, row in sure) / count,
        "explained": sum(float(row["explained"]) for _, row in sure) / count,
    }


def read_picture(path):
    """Columns, rows, white, bytes of a PGM."""
    raw = path.read_bytes()
    header = re.match(rb"P5\s+(?:#.*\s+)*(\d+)\s+(?:#.*\s+)*(\d+)\s+(?:#.*\s+)*(\d+)\s", raw)
    return (*[int(word) for word in header.groups()], raw[header.end() :])


def free_cells(yaml):
    """A function that tells whether a point lies on a free cell: read here from the picture, not by
    the program itself."""
    keys = dict(re.findall(r"^(\w+):\s*(.+?)\s*$", yaml.read_text(), re.M))
    columns, rows, white, pixels = read_picture(yaml.parent / keys["image"])
    left, bottom, yaw = (float(word) for word in keys["origin"].strip("[]").split(","))
    if yaw != 0.0 or keys.get("negate", "0") != "0":
        raise Failed(f"{yaml}: a rotated or negated map is not understood here")
    resolution, limit = float(keys["resolution"]), float(keys["free_thresh"])

    def is_free(x, y):
        column, row = math.floor((x - left) / resolution), math.floor((y - bottom) / resolution)
        if not (0 <= column < columns and 0 <= row < rows):
            return False
        return 1.0 - pixels[(rows - 1 - row) * columns + column] / white < limit

    return is_free


# How odometry is spoiled: wheels whose sizes are wrong together and against each other, and slip.
SCALE, VEER_RAD_M = 0.03, 0.03
SLIP_M, SLIP_RAD = (
    0.01,
    0.02,
)  # standard deviations after 1 m of way, and after 1 rad of turning the second


def spoil(source, target, seed):
    """A CARMEN log with worse odometry: every step gets an error of scale, a veer, and noise.
    Deterministic for a seed."""
    rng = random.Random(seed)
    scale = 1.0 + SCALE * rng.choice([-1.0, 1.0])
    veer = VEER_RAD_M * rng.choice([-1.0, 1.0])
    before, spoiled = None, None
    lines = []
    for line in source.read_text().splitlines():
        words = line.split(" ")
        if words[0] == "ODOM":
            pose = tuple(float(word) for word in words[1:4])
            spoiled = (
                pose if before is None else spoiled_step(before, pose, spoiled, scale, veer, rng)
            )
            before = pose
            words[1:4] = [f"{value:.6f}" for value in spoiled]
        elif words[0] == "ROBOTLASER1":
            # The record holds the poses of the laser and of the robot, behind the ranges and
            # remissions.
            at = 9 + int(words[8])
            at += 1 + int(words[at])
            laser = [float(word) for word in words[at : at + 3]]
            robot = tuple(float(word) for word in words[at + 3 : at + 6])
            turn = math.remainder(robot[2] - before[2], 2.0 * math.pi)
            if math.dist(robot[:2], before[:2]) > 1e-6 or abs(turn) > 2e-6:
                raise Failed(f"{source}: a scan's pose is not the odometry's before it")
            ahead = math.hypot(laser[0] - robot[0], laser[1] - robot[1])
            x, y, yaw = spoiled
            words[at : at + 6] = [
                f"{value:.6f}"
                for value in (x + ahead * math.cos(yaw), y + ahead * math.sin(yaw), yaw, x, y, yaw)
            ]
        lines.append(" ".join(words))
    target.write_text("\n".join(lines) + "\n")


def spoiled_step(before, after, spoiled, scale, veer, rng):
    dx, dy = after[0] - before[0], after[1] - before[1]
    ahead = math.cos(before[2]) * dx + math.sin(before[2]) * dy
    aside = -math.sin(before[2]) * dx + math.cos(before[2]) * dy
    turn = math.remainder(after[2] - before[2], 2.0 * math.pi)
    way = math.hypot(dx, dy)
    ahead = scale * ahead + rng.gauss(0.0, SLIP_M * math.sqrt(way))
    turn += veer * way + rng.gauss(0.0, SLIP_RAD * math.sqrt(abs(turn)))
    x, y, yaw = spoiled
    return (
        x + math.cos(yaw) * ahead - math.sin(yaw) * aside,
        y + math.sin(yaw) * ahead + math.cos(yaw) * aside,
        yaw + turn,
    )
