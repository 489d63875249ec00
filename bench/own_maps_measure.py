"""Localisation on maps that the mapper itself drew: which drives there are, and what came of each.

Truth is the trajectory of mapping the same log, on whose map the drive is followed: where the first
half is the map, it is laid over the first half's own trajectory. Of simulated drives on maps that
were drawn by others, it is the simulator's."""
import concurrent.futures
import csv
import dataclasses
import math
import os
import pathlib
import threading
from functools import partial

from largest_error import wrap
from map_cells import FREE, cells_of
from program import Failed, log_of, run, say
from unkind import ROBOTS

RIGHT_M, RIGHT_RAD = 0.2, math.radians(5.0)
RECORDED = [
    ("intel", "Intel", "carmen/intel.clf", 2691.0),
    ("aces", "ACES", "carmen/aces.clf", 1365.0),
    ("csail", "CSAIL", "carmen/mit-csail.clf", 424.0),
    ("office", "office, recorded", "rawlog/driving_in_office.rawlog", 115.0),
    ("trace0", "trace0", "bags/trace0.bag", 96.0),
    ("wean2", "Wean Hall, 2", "localization/wean/wean2.clf", 400.0),
]
SEEDS = [1, 2, 3]
MANY_SEEDS = ["intel", "aces", "csail"]
# The second half of these sees places of the first.
HALVES = ["intel", "csail"]
WORLDS = ["office", "warehouse", "campus", "rooms", "wings"]
LAPS = ["office", "warehouse", "wings"]  # short enough to be driven round twice
PUBLISHED = ["depot.yaml", "warehouse.yaml"]
# Where the laser tells the robot's place along its way only now and then.
BARE = ["corridor", "loops"]
USUAL = "usual"
# Without what turns or bends the world: the map is as it was drawn.
ON_PUBLISHED = "range,mixed,dropouts,steps,sweep,mount,stamps,loss,wheels,gyro,uneven,walkers"
DURATION_S = 240.0
OTHER_S = 400.0  # of a log on another building's map


@dataclasses.dataclass
class Drive:
    kind: str  # own, day, published, bare or other
    name: str
    building: str
    rows: list  # one a scan: right, error_m, error_rad, known, and the columns of the table
    cpu_s: float = 0.0

    def as_json(self):
        return dataclasses.asdict(self)


def key_of(stamp):
    """Stamps of two files as one text: to a tenth of a millisecond."""
    whole, _, rest = stamp.partition(".")
    return f"{whole}.{rest[:4]:0<4}"


def read_poses(path):
    poses = {}
    for line in path.read_text().splitlines():
        if line and not line.startswith("#"):
            words = line.split()
            x, y, qz, qw = (float(words[i]) for i in (1, 2, 6, 7))
            poses[key_of(words[0])] = (x, y, 2.0 * math.atan2(qz, qw))
    return poses


def laid_over(whole, part):
    """The poses of `whole`, moved so that those that `part` has too agree best (Umeyama 1991)."""
    both = [key for key in part if key in whole]
    if len(both) < 2:
        raise Failed("two trajectories of one log share no stamps")
    centre = lambda poses: [
        sum(poses[k][i] for k in both) / len(both) for i in (0, 1)
    ]  # noqa: E731
    a, b = centre(whole), centre(part)
    sine = cosine = 0.0
    for k in both:
        x, y = whole[k][0] - a[0], whole[k][1] - a[1]
        u, v = part[k][0] - b[0], part[k][1] - b[1]
        cosine += x * u + y * v
        sine += x * v - y * u
    turn = math.atan2(sine, cosine)
    c, s = math.cos(turn), math.sin(turn)
    return {
        k: (
            b[0] + c * (x - a[0]) - s * (y - a[1]),
            b[1] + s * (x - a[0]) + c * (y - a[1]),
            wrap(yaw + turn),
        )
        for k, (x, y, yaw) in whole.items()
    }


def knows_place(folder):
    """Whether a map knows a place: the robot's cell is free, and so are three fifths of the circle
    of half a metre around it."""
    cells = cells_of(folder)

    def is_free(x, y):
        column = math.floor((x - cells.x_m) / cells.resolution_m)
        row = math.floor((y - cells.y_m) / cells.resolution_m)
        inside = 0 <= column < cells.width and 0 <= row < cells.height
        return inside and cells.states[row * cells.width + column] == FREE

    def known(x, y):
        angles = [math.pi * i / 8.0 for i in range(16)]
        around = [is_free(x + 0.5 * math.cos(a), y + 0.5 * math.sin(a)) for a in angles]
        return is_free(x, y) and sum(around) >= 0.6 * len(around)

    return known


def rows_of(table, truth, known=lambda x, y: True):
    """The table of a run beside its truth: a dictionary by stamp; None: wrong everywhere."""
    rows = []
    with open(table, encoding="utf-8") as lines:
        for line in csv.DictReader(lines):
            pose = truth.get(key_of(line["t_s"])) if truth is not None else (math.inf, 0.0, 0.0)
            if pose is None:
                continue
            row = {k: float(v) if v else 99.0 for k, v in line.items() if k not in ("t_s", "state")}
            off = (row["x_m"] - pose[0], row["y_m"] - pose[1], wrap(row["yaw_rad"] - pose[2]))
            row["state"] = line["state"]
            row["error_m"], row["error_rad"] = math.hypot(*off[:2]), abs(off[2])
            row["right"] = float(row["error_m"] <= RIGHT_M and row["error_rad"] <= RIGHT_RAD)
            row["place_known"] = truth is not None and known(pose[0], pose[1])
            row["nees_xy"], row["nees_yaw"] = nees(row, off) if row["right"] else (None, None)
            rows.append(row)
    return rows


def nees(row, off):
    """By degree of freedom: of position, of heading."""
    a, b, c = row["xx_m2"], row["xy_m2"], row["yy_m2"]
    x, y, yaw = off
    determinant = max(a * c - b * b, 1e-30)
    return 0.5 * (c * x * x - 2.0 * b * x * y + a * y * y) / determinant, yaw * yaw / max(
        row["yawyaw_rad2"], 1e-15
    )


class OwnMaps:
    """Runs the program; maps and simulations are kept between calls."""

    def __init__(self, loopstone, data, first_seed):
        self.loopstone, self.data, self.first_seed = loopstone, data, first_seed
        self.work = loopstone.work
        self.locks = {}  # of what is made once

    def lock(self, name):
        return self.locks.setdefault(name, threading.Lock())

    def logs(self):
        return [
            (name, title, self.data / path, seconds)
            for name, title, path, seconds in RECORDED
            if (self.data / path).exists()
        ]

    def mapped(self, log, name, flags=()):
        folder = self.work / f"map-{name}"
        with self.lock(folder):
            if not (folder / "map.yaml").exists():
                self.loopstone.map(log, name, ["--threads", "1", *flags], pinned=False)
        return folder

    def simulated(self, world, robot, seed, effects=USUAL, laps=1):
        """Of one lap the first minutes; of more the whole."""
        words = ["--realism", effects, "--laps", laps]
        words += ["--duration", f"{DURATION_S:g}"] if laps == 1 else []
        name = f"{pathlib.Path(world).stem}-{robot}-{seed}-{laps}"
        folder = self.work / f"sim-{name}"
        with self.lock(folder):
            if not (folder / "truth.tum").exists():
                command = [self.loopstone.program, "simulate", world, "-o", folder, "--seed", seed]
                run([*command, *words, *ROBOTS[robot], "--force", "--quiet"])
        return name, log_of(folder)

    def localized(self, log, chart, name, flags=(), start=("--global",)):
        path = self.work / f"where-{name}.tum"
        command = [self.loopstone.program, "localize", log, "--map", chart, "-o", path, *start]
        _, cost = run([*command, "--threads", "1", "--force", "--quiet", *flags])
        return path.with_suffix(".csv"), cost["cpu_s"]

    def own(self, log, name, title, building, seed=1):
        folder = self.mapped(log, name)
        table, cpu_s = self.localized(log, folder, f"own-{name}-{seed}", ["--seed", seed])
        return Drive(
            "own", title, building, rows_of(table, read_poses(folder / "trajectory.tum")), cpu_s
        )

    def day(self, log, name, title, building, half_s):
        """The second half on the map of the first."""
        whole, half = self.mapped(log, name), self.mapped(
            log, f"{name}-half", ["--duration", half_s]
        )
        poses = laid_over(*(read_poses(f / "trajectory.tum") for f in (whole, half)))
        table, cpu_s = self.localized(log, half, f"day-{name}", ["--start", half_s])
        return Drive("day", title, building, rows_of(table, poses, knows_place(half)), cpu_s)

    def other(self, log, name, chart, its_log):
        """On the map of another building, which is there or is made of its log."""
        folder = self.mapped(its_log, chart)
        flags = ["--duration", f"{OTHER_S:g}"]
        table, cpu_s = self.localized(log, folder, f"other-{name}-{chart}", flags)
        return Drive("other", f"{name} on {chart}", name, rows_of(table, None), cpu_s)

    def published(self, world, robot, seed):
        name, log = self.simulated(world, robot, seed, ON_PUBLISHED)
        folder = log if log.is_dir() else log.parent
        # The map as it was given, with walls where it knows nothing: there the simulated ones are.
        table, cpu_s = self.localized(log, folder / "map.yaml", f"published-{name}")
        title = f"{world.stem}, {robot}"
        return Drive(
            "published", title, world.stem, rows_of(table, read_poses(folder / "truth.tum")), cpu_s
        )

    def bare(self, world, robot, seed):
        """From a known start: along a bare corridor no search tells where."""
        name, log = self.simulated(world, robot, seed)
        folder = log if log.is_dir() else log.parent
        truth = read_poses(folder / "truth.tum")
        first = truth[min(truth, key=float)]
        start = ["--initial", ",".join(f"{value:.4f}" for value in first)]
        table, cpu_s = self.localized(log, folder / "map.yaml", f"bare-{name}", start=start)
        return Drive("bare", f"{world}, {robot}", world, rows_of(table, truth), cpu_s)

    def planned(self):
        """Every drive as a function that drives it, and what to call it."""
        yield from self.planned_recorded()
        yield from self.planned_simulated()

    def planned_recorded(self):
        logs = self.logs()
        for name, title, log, seconds in logs:
            for seed in SEEDS if name in MANY_SEEDS else SEEDS[:1]:
                yield f"own {name} {seed}", partial(self.own, log, name, title, name, seed)
            if name in HALVES:
                yield f"day {name}", partial(self.day, log, name, title, name, 0.5 * seconds)
            for chart, _, its_log, _ in logs:
                if chart != name:
                    yield f"other {name} {chart}", partial(self.other, log, name, chart, its_log)

    def planned_simulated(self):
        robots = list(ROBOTS)
        for i, world in enumerate(WORLDS):
            seed = self.first_seed + i
            for j, robot in enumerate(robots):
                yield f"own {world} {robot}", partial(self.own_world, world, robot, seed)
                chart = WORLDS[(i + 1 + j) % len(WORLDS)]
                yield f"other {world} {robot} {chart}", partial(
                    self.other_world, world, robot, seed, chart
                )
            if world in LAPS:
                robot = robots[i % len(robots)]
                yield f"day {world}", partial(self.day_world, world, robot, seed + 50)
        for i, name in enumerate(PUBLISHED):
            world = self.data / "maps" / name
            for robot in robots if world.exists() else []:
                yield f"published {name} {robot}", partial(
                    self.published, world, robot, self.first_seed + i
                )

        for i, world in enumerate(BARE):
            for robot in robots:
                seed = self.first_seed + len(WORLDS) + i
                yield f"bare {world} {robot}", partial(self.bare, world, robot, seed)

    def own_world(self, world, robot, seed):
        name, log = self.simulated(world, robot, seed)
        return self.own(log, name, f"{world}, {robot}", world)

    def day_world(self, world, robot, seed):
        """Furniture has moved between the laps."""
        name, log = self.simulated(world, robot, seed, laps=2)
        folder = log if log.is_dir() else log.parent
        stamps = [float(key) for key in read_poses(folder / "truth.tum")]
        half_s = 0.5 * (max(stamps) - min(stamps))
        return self.day(log, name, f"{world}, {robot}", world, half_s)

    def other_world(self, world, robot, seed, chart):
        name, log = self.simulated(world, robot, seed)
        its_seed = self.first_seed + WORLDS.index(chart)
        return self.other(log, name, *self.simulated(chart, "poses", its_seed))

    def drives(self, kinds=None):
        """Those of some kinds, side by side; those that failed are left out."""
        planned = [one for one in self.planned() if not kinds or one[0].split()[0] in kinds]

        def drive(one):
            name, run_it = one
            try:
                return name, run_it()
            except (Failed, OSError, KeyError) as failure:
                say(f"  {name}: FAILED {str(failure).splitlines()[-1:]}")
                return name, None

        with concurrent.futures.ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:
            for count, (name, done) in enumerate(pool.map(drive, planned), 1):
                if done is None or not done.rows:
                    continue
                say(f"  {count} of {len(planned)} {name}: {told(done)}")
                yield done


def figures_of(drive):
    rows = drive.rows
    tracking = [row["state"] == "TRACKING" for row in rows]
    known = [t for t, row in zip(tracking, rows) if row["place_known"]]
    right = [row for row in rows if row["right"]]
    way = rows[-1]["travelled_m"]
    share = lambda part: sum(part) / len(rows)  # noqa: E731
    changes = sum(a["state"] != b["state"] for a, b in zip(rows, rows[1:]))
    middle = (
        lambda name: sum(row[name] for row in right) / len(right) if right else None
    )  # noqa: E731
    return {
        "scans": len(rows),
        "right": share(row["right"] for row in rows),
        "tracking": share(tracking),
        "wrong": share(t and not row["right"] for t, row in zip(tracking, rows)),
        "lost": share(row["state"] == "LOST" for row in rows),
        "known": len(known) / len(rows),
        "tracking_known": sum(known) / len(known) if known else None,
        "changes_100m": 100.0 * changes / way if way > 1.0 else 0.0,
        "nees_xy": middle("nees_xy"),
        "nees_yaw": middle("nees_yaw"),
        "ms_per_scan": 1e3 * drive.cpu_s / len(rows),
    }


def told(drive):
    f = figures_of(drive)
    return (
        f"right {100 * f['right']:.2f} %, TRACKING {100 * f['tracking']:.2f} %, and wrong"
        f" {100 * f['wrong']:.3f} %, {f['changes_100m']:.1f} changes of state in 100 m"
    )
