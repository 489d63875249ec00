"""Simulated drives through localisation whose truth is known, for its probability: which there are,
and what came of them."""
import concurrent.futures
import dataclasses
import itertools
import os
import pathlib

from program import Failed, run, say

# Maps of $LOOPSTONE_DATA that drives are simulated on, beside the built-in worlds.
MAPS = ["depot.yaml", "warehouse.yaml", "basement_hallways_5cm.png", "willow-full.pgm"]
BEAMS = [180, 1081]
DURATION_S = 60
# One line of the trace that measure_localization writes.
COLUMNS = [
    *"right error_m error_rad tracking lost probability".split(),
    *"explained violations unexpected mass precision spread_m spread_rad innovation".split(),
    *"travelled_m followed_m known silent unproven".split(),
    *[
        f"{way}_{share}"
        for way in ("lately", "along")
        for share in ("explained", "violations", "unexpected", "known", "silent")
    ],
]


@dataclasses.dataclass
class Kind:
    title: str
    places: list
    maps: bool  # on the recorded maps, too
    variants: list  # keys of measure_localization, taken in turn
    repeats: int = 1  # few places, more drives in each
    weight: float = 1.0  # of a drive when the probability is fitted


# A robot is given the map of another building far more seldom than an old map of its own; scans
# explain both badly, so the weight of the former decides how much is believed of the latter.
KINDS = {
    "normal": Kind(
        "normal",
        ["office", "campus", "warehouse"],
        True,
        [
            {"start": "global", "people": 0},
            {"start": "truth", "people": 2},
            {"start": "global", "people": 4},
            {"start": "truth", "people": 0},
        ],
    ),
    "changed": Kind(
        "changed map",
        ["office", "campus", "warehouse"],
        True,
        [
            {"start": "truth", "clutter": 40, "people": 4},
            {"start": "global", "clutter": 20, "people": 8},
            {"start": "truth", "clutter": 20, "people": 8},
            {"start": "global", "clutter": 10, "people": 4},
        ],
    ),
    "kidnapped": Kind(
        "kidnapped",
        ["office", "campus", "warehouse"],
        True,
        [
            {"start": "truth", "kidnaps": 2},
            {"start": "global", "kidnaps": 2, "people": 4},
            {"start": "truth", "kidnaps": 2, "clutter": 10},
            {"start": "global", "kidnaps": 1, "people": 2, "clutter": 20},
        ],
    ),
    "wrong_start": Kind(
        "wrong start",
        ["office", "campus", "warehouse", "rooms", "corridor"],
        True,
        [
            {"start": "wrong"},
            {"start": "wrong", "people": 4},
            {"start": "wrong", "clutter": 20, "people": 2},
            {"start": "wrong", "clutter": 10},
        ],
    ),
    "rough": Kind(
        "rough map",
        ["office", "campus", "warehouse"],
        True,
        [
            {"start": "truth", "rough": 1, "people": 2},
            {"start": "global", "rough": 1},
            {"start": "truth", "rough": 1, "clutter": 10},
            {"start": "global", "rough": 1, "kidnaps": 1},
        ],
    ),
    "another_map": Kind(
        "another building's map",
        ["office", "campus", "warehouse"],
        False,
        [
            {"start": "global", "map_seed": 50001},
            {"start": "wrong", "map_seed": 50002, "people": 2},
        ],
        weight=0.15,
    ),
    "alike": Kind(
        "look-alike places",
        ["rooms", "corridor"],
        False,
        [
            {"start": "global"},
            {"start": "truth", "people": 2},
            {"start": "global", "clutter": 10, "people": 2},
            {"start": "truth", "kidnaps": 1},
            {"start": "global", "kidnaps": 1},
            {"start": "wrong", "people": 2},
            {"start": "truth", "clutter": 20},
            {"start": "wrong", "clutter": 10},
        ],
        repeats=3,
    ),
}


@dataclasses.dataclass
class Drive:
    kind: str
    place: str
    keys: dict
    rows: list  # one a scan, a dictionary by COLUMNS

    @property
    def name(self):
        return " ".join([self.place, *[f"{key}={value}" for key, value in self.keys.items()]])


def planned(data, first_seed, seeds):
    """Drives of every kind in every place. Recorded maps that are missing are left out."""
    drives = []
    for kind, what in KINDS.items():
        maps = [data / "maps" / name for name in MAPS] if what.maps else []
        places = what.places + [str(path) for path in maps if path.exists()]
        for index, (i, place) in itertools.product(range(seeds * what.repeats), enumerate(places)):
            seed = first_seed + len(drives)
            # A corridor's drives begin at its end: from the middle of it they would lead nowhere.
            keys = {
                "seed": seed,
                "duration_s": DURATION_S,
                "beams": BEAMS[(index + i) % 2],
                "random_start": 0 if place == "corridor" else 1,
                **what.variants[(index + i) % len(what.variants)],
            }
            drives.append(Drive(kind, place, keys, []))
    return drives


def drive_through(program, drives, work):
    """Fills in the rows of the drives, side by side; returns those that had any."""

    def fill(numbered):
        number, drive = numbered
        if number % 20 == 0:
            say(f"  drive {number + 1} of {len(drives)}")
        trace = work / f"confidence-{number}.trace"
        keys = [f"{key}={value}" for key, value in drive.keys.items()]
        try:
            run([program, drive.place, *keys, f"trace={trace}"])
        except Failed as failure:
            say(f"  FAILED: {failure}")
            return
        for line in trace.read_text().splitlines():
            drive.rows.append(dict(zip(COLUMNS, map(float, line.split()), strict=True)))
        trace.unlink()

    with concurrent.futures.ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:
        list(pool.map(fill, enumerate(drives)))
    return [drive for drive in drives if drive.rows]


def place_title(place):
    """Of a built-in world or a map's file."""
    return pathlib.Path(place).name
