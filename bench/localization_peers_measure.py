"""Localisation beside AMCL and pf-localization: which drives, starts and systems there are, and
what came of each run."""
import csv
import dataclasses
import itertools
import math
import random
import statistics
from functools import partial

from largest_error import wrap
from own_maps_measure import RIGHT_M, RIGHT_RAD, OwnMaps, key_of, read_poses
from peers import amcl_localization, mrpt_localization
from peers.localization_feed import Feed
from program import run, say

# Of other seeds than the drives that AMCL was tuned on (TUNED_ON), and than those of own_maps.py.
FIRST_SEED = 501
TUNED_ON = "office-poses 301, office-gyro 301, warehouse-around 302, ACES, Intel, CSAIL"
RECORDED = ["intel", "aces", "csail"]
RECORDED_S = 400.0  # of each; its map is of the whole log
WORLDS = ["office", "warehouse"]
ROBOTS = {"office": ["poses", "around"], "warehouse": ["small", "gyro"]}
DRIVES = {
    **{name: "recorded" for name in RECORDED},
    **{f"{world}-{robot}": "simulated" for world in WORLDS for robot in ROBOTS[world]},
}
SEEDS = [1, 2, 3]
STARTS = ["known", "nowhere"]
SIGMA_M, SIGMA_RAD = 0.5, 0.26  # of a start that is known: what `loopstone localize` and nav2 take
# A peer claims to be certain where the square root of its covariance's trace [m, m, rad] is less.
CERTAIN, LESS_CERTAIN = RIGHT_M, 0.5

# No tuning was the best on all of these; one for each of nav2's two likelihood fields.
TUNED = {
    "amcl_field": {
        "laser_model_type": "likelihood_field",
        "z_hit": 0.95,
        "z_rand": 0.05,
        "sigma_hit": 0.1,
        "max_beams": 180,
        "max_particles": 20000,
        "update_min_d": 0.1,
        "update_min_a": 0.1,
        "recovery_alpha_slow": 0.001,
        "recovery_alpha_fast": 0.1,
    },
    "amcl_tuned": {
        "laser_model_type": "likelihood_field_prob",
        "z_hit": 0.95,
        "z_rand": 0.05,
        "max_beams": 30,
        "max_particles": 20000,
        "update_min_d": 0.2,
    },
}
SYSTEMS = {
    "loopstone": "Loopstone",
    "amcl": "AMCL, nav2's defaults",
    "amcl_field": "AMCL, tuned",
    "amcl_tuned": "AMCL, tuned, likelihood_field_prob",
    "mrpt": "pf-localization",
}
# The slow one comes last, so that all else is there when a run is cut off.
SLOW = ["mrpt"]


def duration_of(name):
    return RECORDED_S if DRIVES[name] == "recorded" else math.inf


def start_near(pose, seed):
    """A guess as good as it says: (x, y, yaw, sigma_m, sigma_rad)."""
    draw = random.Random(seed)
    return (
        pose[0] + draw.gauss(0.0, SIGMA_M),
        pose[1] + draw.gauss(0.0, SIGMA_M),
        wrap(pose[2] + draw.gauss(0.0, SIGMA_RAD)),
        SIGMA_M,
        SIGMA_RAD,
    )


def figures_of(rows, cost, truth):
    """Of rows (stamp, x, y, yaw, spread), of those with one stamp the last. A scan without a pose
    is a wrong one, and nobody claimed it; its error is not counted."""
    errors, right, certain, wrong, less_wrong = [], 0, 0, 0, 0
    for key, (x, y, yaw, spread) in {key_of(row[0]): row[1:] for row in rows}.items():
        pose = truth.get(key)
        if pose is None:
            continue
        off_m, off_rad = math.hypot(x - pose[0], y - pose[1]), abs(wrap(yaw - pose[2]))
        is_right = off_m <= RIGHT_M and off_rad <= RIGHT_RAD
        errors.append(off_m)
        right += is_right
        certain += spread <= CERTAIN
        wrong += spread <= CERTAIN and not is_right
        less_wrong += spread <= LESS_CERTAIN and not is_right
    errors.sort()
    scans = len(truth)
    return {
        "scans": scans,
        "right": right / scans,
        "median_m": statistics.median(errors),
        "most_m": errors[math.ceil(0.95 * len(errors)) - 1],
        "certain": certain / scans,
        "wrong": wrong / scans,
        "less_wrong": less_wrong / scans,
        "ms_per_scan": 1e3 * cost["cpu_s"] / scans,
        "peak_mb": cost["peak_mb"],
    }


@dataclasses.dataclass
class Prepared:
    truth: dict  # by stamp
    first: tuple  # of it
    runners: dict  # what localises, by system: functions of start and seed


class PeersBeside:
    """Maps each drive once, then follows it with the systems that are here."""

    def __init__(self, loopstone, data):
        self.loopstone = loopstone
        self.maps = OwnMaps(loopstone, data, FIRST_SEED)
        self.prepared = {}

    def log_of(self, name):
        """None: a recording that is not here."""
        if DRIVES[name] == "recorded":
            found = [log for each, _, log, _ in self.maps.logs() if each == name]
            return found[0] if found else None
        world, robot = name.split("-")
        return self.maps.simulated(world, robot, FIRST_SEED + WORLDS.index(world))[1]

    def ours(self, name, log, chart, start, seed):
        path = self.loopstone.work / f"where-{name}.tum"
        words = [self.loopstone.program, "localize", log, "--map", chart, "-o", path]
        if math.isfinite(duration_of(name)):
            words += ["--duration", duration_of(name)]
        words += ["--seed", seed, "--threads", "1", "--force", "--quiet"]
        if start:
            words += [f"--initial={','.join(f'{value:.6f}' for value in start[:3])}"]
            words += [f"--initial-sigma={SIGMA_M},{SIGMA_RAD}"]
        _, cost = run([*words, *([] if start else ["--global"])])
        with open(path.with_suffix(".csv"), encoding="utf-8") as lines:
            rows = [
                (line["t_s"], *(float(line[key]) for key in ("x_m", "y_m", "yaw_rad")), spread)
                for line in csv.DictReader(lines)
                for spread in [0.0 if line["state"] == "TRACKING" else math.inf]
            ]
        return rows, cost

    def runners(self, name, log, chart, feed):
        yield "loopstone", lambda start, seed: self.ours(name, log, chart, start, seed)
        if amcl_localization.is_here():
            amcl = amcl_localization.Amcl(feed)
            for system, settings in {"amcl": {}, **TUNED}.items():
                yield system, partial(amcl.localize, run, settings)
        if mrpt_localization.is_here():
            mrpt = mrpt_localization.PfLocalization(feed)
            yield "mrpt", lambda start, seed: mrpt.localize(run, start)

    def prepare(self, name):
        """None: the log is not here."""
        log = self.log_of(name)
        if log is None:
            say(f"  {name}: not there, skipped")
            return None
        chart = self.maps.mapped(log, name)
        work, program = self.loopstone.work / f"feed-{name}", self.loopstone.program
        feed = Feed(run, program, log, chart, work, duration_of(name))
        poses = read_poses(chart / "trajectory.tum")
        keys = [key for key in (key_of(scan.stamp) for scan in feed.scans) if key in poses]
        truth = {key: poses[key] for key in keys}
        return Prepared(truth, truth[keys[0]], dict(self.runners(name, log, chart, feed)))

    def runs(self, name, systems, seeds, before, when):
        """Figures of each run with its system, start, seed and circumstances, those before
        included; told again after each."""
        if name not in self.prepared:
            self.prepared[name] = self.prepare(name)
        drive = self.prepared[name]
        done = {(one["system"], one["start"], one["seed"]) for one in before}
        for seed, start, system in itertools.product(seeds, STARTS, systems):
            if drive is None or system not in drive.runners or (system, start, seed) in done:
                continue
            guess = start_near(drive.first, seed) if start == "known" else None
            figures = figures_of(*drive.runners[system](guess, seed), drive.truth)
            of_run = {"system": system, "start": start, "seed": seed, "when": when}
            before = [*before, {**of_run, **figures}]
            say(
                f"  {name}, {start} {seed}, {SYSTEMS[system]}: right"
                f" {100 * figures['right']:.1f} %, {figures['ms_per_scan']:.2f} ms a scan"
            )
            yield before
