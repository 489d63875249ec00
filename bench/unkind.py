"""Drives through worlds less kind than a clean simulation (`loopstone simulate --realism`), mapped
and held against their truth: what bench/realism.py and bench/drives.py share."""
import argparse
import concurrent.futures
import json
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import typing

from largest_error import is_foretold, is_right, largest_error, stated_error
from program import Failed, log_of, run, say
from provenance import circumstances

ROOT = pathlib.Path(__file__).resolve().parent.parent
USUAL = "usual"
CLEAN = "none"
# What each robot logs.
ROBOTS = {
    # Counts of the wheels and a gyro.
    "gyro": ["--beams", "541"],
    # Dead reckoning and half a circle, as SICK scanners see it.
    "poses": "--format carmen --beams 181 --fov 180 --scan-rate 5".split(),
    # A turning lidar, and dead reckoning.
    "around": "--format carmen --beams 360 --fov 359 --max-range 12 --range-noise 0.02".split(),
    # A cheap one, which sees less far and less often.
    "small": "--format carmen --beams 360 --fov 359 --max-range 8 --scan-rate 6".split(),
}
DURATION_S = 240
QUICK_S = 150


class Drive(typing.NamedTuple):
    robot: str
    world: str
    effect: str  # with + between several
    seed: int

    def key(self):
        return "/".join(map(str, self))

    def clean(self):
        return self._replace(effect=CLEAN)


def effects_of(loopstone):
    """The effects by name, as the program's own help lists them."""
    text = run([loopstone.program, "simulate", "--help"])[0]
    listed = re.search(r"--realism takes\s([^.]*)\.", text)
    if not listed:
        raise SystemExit("`loopstone simulate --help` lists no effects of realism")
    return re.findall(r"\w+", listed.group(1))


def simulation(drive, duration):
    """The words that ask for it, without the program and the folder."""
    words = ["simulate", drive.world, "--seed", str(drive.seed)]
    words += ["--realism", drive.effect.replace("+", ",")]
    return [*words, "--duration", f"{duration:g}", *ROBOTS[drive.robot]]


def map_and_judge(loopstone, sim, name, options, flags=()):
    """A log mapped and compared with its truth: the folder, and figures."""
    flags = [*flags, *shlex.split(options.map), "--threads", "1"]
    folder, summary, cost = loopstone.map(log_of(sim), name, flags, pinned=False)
    path, truth = folder / "trajectory.tum", sim / "truth.tum"
    error = loopstone.evaluate("--estimate", path, "--reference", truth, "--align", "se2")
    worst_m, worst_deg = largest_error(path, truth)
    stated_m, stated_deg = stated_error(folder / "trajectory.csv")
    return folder, {
        "ate_m": error["ate_rmse_m"],
        "worst_m": worst_m,
        "worst_deg": worst_deg,
        "stated_m": stated_m,
        "stated_deg": stated_deg,
        "poses_missing": error["poses_missing"],
        "verdict": summary["quality"]["verdict"],
        "breaks": len(summary["path_breaks"]),
        "laser_faults": sorted({fault["fault"] for fault in summary["laser_faults"]}),
        "odometry_faults": sorted({fault["fault"] for fault in summary["odometry_faults"]}),
        "path_m": summary["path_length_m"],
        "cpu_s": cost["cpu_s"],
    }


def measured(loopstone, drive, options, more):
    """Figures of a drive; `more(drive, sim, folder)`, from the simulation and the map of it, gives
    those that only one script asks for."""
    name = drive.key().replace("/", "-")
    sim = loopstone.work / f"sim-{name}"
    figures = drive._asdict()
    try:
        words = [loopstone.program, *simulation(drive, options.duration), *shlex.split(options.sim)]
        run([*words, "-o", sim, "--force", "--quiet"])
        folder, found = map_and_judge(loopstone, sim, name, options)
        figures |= {**found, **more(drive, sim, folder)}
        if not options.keep:
            shutil.rmtree(folder)
    except (Failed, OSError, subprocess.SubprocessError, KeyError, ValueError) as failure:
        figures["failed"] = str(failure).strip().splitlines()[-1:]
    if not options.keep:
        shutil.rmtree(sim, ignore_errors=True)
    return figures


def is_wrong(figures):
    return bool(figures.get("failed")) or not is_right(figures["worst_m"], figures["worst_deg"])


def is_unforetold(figures):
    """Whether a map is wrong by more than its own covariances allow."""
    if figures.get("failed"):
        return True
    worst = figures["worst_m"], figures["worst_deg"]
    return not is_foretold(worst, (figures["stated_m"], figures["stated_deg"]))


def is_good(figures):
    """Whether it is called so."""
    return figures.get("verdict") == "good"


def worst_of(figures):
    return f"{figures['worst_m']:.2f} m, {figures['worst_deg']:.1f} deg"


def told(figures):
    """A line for who watches."""
    if figures.get("failed"):
        return f"FAILED {figures['failed']}"
    words = [f"ATE {figures['ate_m']:.3f} m", f"worst {worst_of(figures)}", figures["verdict"]]
    words += figures["laser_faults"] + figures["odometry_faults"]
    if figures["breaks"]:
        words.append(f"{figures['breaks']} breaks")
    if is_wrong(figures):
        words.append("A WRONG MAP CALLED GOOD" if is_good(figures) else "a wrong map")
    return ", ".join(words)


def measure(loopstone, drives, options, path, more=lambda *_: {}):
    """Measures drives, side by side, and keeps them in a file; what stands there already is left
    out where options.resume says so. Returns what is kept: sessions, and figures by drive."""
    asked = [options.duration, options.sim, options.map]
    kept = {"sessions": [], "asked": asked, "figures": {}}
    if options.resume and path.exists():
        kept = json.loads(path.read_text())
        if kept["asked"] != asked:
            raise SystemExit(f"{path} was measured with other --duration, --sim or --map")
    figures = kept["figures"]
    missing = [
        drive
        for drive in dict.fromkeys(drives)
        if figures.get(drive.key(), {"failed": True}).get("failed")
    ]
    if missing:
        kept["sessions"].append(circumstances(loopstone.version()))
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        runs = {pool.submit(measured, loopstone, one, options, more): one for one in missing}
        for count, done in enumerate(concurrent.futures.as_completed(runs), 1):
            drive = runs[done]
            figures[drive.key()] = done.result()
            path.write_text(json.dumps(kept, indent=1))
            say(f"  {count}/{len(runs)} {' '.join(map(str, drive))}: {told(done.result())}")
    # In the order of the plan, whichever ended first: tables then differ by their figures alone.
    kept["figures"] = {drive.key(): figures[drive.key()] for drive in drives} | figures
    path.write_text(json.dumps(kept, indent=1))
    return kept


def parser_of(doc):
    """The flags that both scripts have."""
    parser = argparse.ArgumentParser(
        description=doc, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    words = lambda text: [word for word in text.split(",") if word]  # noqa: E731
    parser.add_argument("--program", default=str(ROOT / "build/release/bin/loopstone"))
    parser.add_argument("--work", type=pathlib.Path, default=ROOT / "build/bench")
    parser.add_argument("--worlds", type=words, default=None)
    parser.add_argument(
        "--effects", type=words, default=None, help="with + between several at once"
    )
    parser.add_argument("--robots", type=words, default=None, help=", ".join(ROBOTS))
    parser.add_argument("--seeds", type=int, default=None, help="how many of each")
    parser.add_argument("--first-seed", type=int, default=None)
    parser.add_argument("--duration", type=float, default=None, help="of each drive; 0: whole")
    parser.add_argument("--sim", default="", help="more flags of `loopstone simulate`")
    parser.add_argument("--map", default="", help="more flags of `loopstone map`")
    parser.add_argument("--jobs", type=int, default=len(os.sched_getaffinity(0)))
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--keep", action="store_true", help="leave logs and maps in build/bench")
    parser.add_argument("--resume", action="store_true", help="leave out what has been measured")
    parser.add_argument(
        "--write", action="store_true", help="no measurement, docs from what is kept"
    )
    return parser


def is_part(options):
    """Whether less, or something else, is asked for than what the tables of docs/ are made of."""
    names = "quick worlds effects robots seeds first_seed duration sim map".split()
    return any(getattr(options, name) not in (None, False, "") for name in names)


def set_defaults(options, **defaults):
    """Of what was not asked for."""
    defaults["duration"] = QUICK_S if options.quick else DURATION_S
    for name, value in defaults.items():
        if getattr(options, name) is None:
            setattr(options, name, value)
