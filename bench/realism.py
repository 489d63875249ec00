#!/usr/bin/env python3
"""Maps logs of `loopstone simulate --realism`, where the world is less kind than a clean
simulation: worlds x effects x seeds, each beside the same log without the effect. Prints a table of
the error against the truth and of the verdict; a full run writes it into docs/robustness.md.

A map is wrong when its path is off by more than 0.2 m rms or 1 m at the worst place; the table
counts those of them that the verdict still calls good.

  bench/realism.py                       every effect, three worlds, two robots (half an hour)
  bench/realism.py --quick               one robot, 150 s of each drive
  bench/realism.py --worlds office,loops --effects blocked,follower --seeds 3
  bench/realism.py --effects usual+blocked --first-seed 10       effects together, other seeds
  bench/realism.py --sim "--set realism.blocked.at_s=60" --map "--odometry ignore"
  bench/realism.py --write               the tables again, of what the last full run measured

What a full run measured is kept in build/bench/realism.json, of any other in realism-some.json;
with --resume a run leaves out what stands there. --keep leaves the logs and maps in build/bench.
"""
import argparse
import concurrent.futures
import json
import pathlib
import re
import shlex
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "scripts"))

from doc_blocks import table, write_block  # noqa: E402
from program import Failed, Loopstone, median, run, say  # noqa: E402
from provenance import circumstances, provenance  # noqa: E402

PAGE = ROOT / "docs/robustness.md"
BLOCK = "robustness-realism"
USUAL = "usual"
CLEAN = "none"
WORLDS = ["office", "loops", "wings"]
# What each robot logs: counts, gyro and 541 beams; or dead reckoning and half a circle.
ROBOTS = {
    "gyro": ["--beams", "541"],
    "poses": ["--format", "carmen", "--beams", "181", "--fov", "180"],
    # A small turning lidar, and dead reckoning.
    "around": "--format carmen --beams 360 --fov 359 --max-range 12 --range-noise 0.02".split(),
}
DURATION_S = 240
QUICK_S = 150
# The largest of these errors is what a user would see first; an rms hides one torn corner.
BOUND_M = 0.2
WORST_M = 1.0


def effects_of(loopstone):
    """The effects by name, as the program's own help lists them."""
    text = run([loopstone.program, "simulate", "--help"])[0]
    listed = re.search(r"--realism takes\s([^.]*)\.", text)
    if not listed:
        raise SystemExit("`loopstone simulate --help` lists no effects of realism")
    return re.findall(r"\w+", listed.group(1))


def log_of(folder):
    log = folder / "log.clf"
    return log if log.exists() else folder


def measured(loopstone, robot, world, effect, seed, options):
    """One log, mapped and compared with its truth."""
    name = f"realism-{robot}-{world}-{effect}-{seed}"
    folder = loopstone.work / f"sim-{name}"
    words = [loopstone.program, "simulate", world, "-o", folder, "--seed", seed]
    words += ["--realism", effect.replace("+", ","), "--duration", options.duration]
    words += [*ROBOTS[robot], *shlex.split(options.sim), "--force", "--quiet"]
    figures = {"world": world, "effect": effect, "seed": seed, "robot": robot}
    try:
        run(words)
        out, summary, cost = loopstone.map(
            log_of(folder), name, [*shlex.split(options.map), "--threads", "1"]
        )
        error = loopstone.evaluate(
            "--estimate",
            out / "trajectory.tum",
            "--reference",
            folder / "truth.tum",
            "--align",
            "se2",
        )
        figures |= {
            "ate_m": error["ate_rmse_m"],
            "worst_m": error["ate_translation_m"]["max"],
            "heading_deg": error["ate_rotation_deg"]["rmse"],
            "poses": error["poses"],
            "poses_missing": error["poses_missing"],
            "verdict": summary["quality"]["verdict"],
            "breaks": len(summary["path_breaks"]),
            "laser_faults": sorted({fault["fault"] for fault in summary["laser_faults"]}),
            "odometry_faults": sorted({fault["fault"] for fault in summary["odometry_faults"]}),
            "closures": summary["loop_closures_accepted"],
            "path_m": summary["path_length_m"],
            "cpu_s": cost["cpu_s"],
        }
        if not options.keep:
            shutil.rmtree(out)
    except (Failed, OSError, subprocess.SubprocessError, KeyError, ValueError) as failure:
        figures["failed"] = str(failure).strip().splitlines()[-1:]
    if not options.keep:
        shutil.rmtree(folder, ignore_errors=True)
    return figures


def is_wrong(figures):
    if figures.get("failed"):
        return True
    return figures["ate_m"] > BOUND_M or figures["worst_m"] > WORST_M


def is_silent(figures):
    return is_wrong(figures) and figures.get("verdict") == "good"


def told(figures):
    """A line for who watches."""
    if figures.get("failed"):
        return f"FAILED {figures['failed']}"
    words = [f"{figures['ate_m']:.3f} m, worst {figures['worst_m']:.2f} m", figures["verdict"]]
    words += figures["laser_faults"] + figures["odometry_faults"]
    if figures["breaks"]:
        words.append(f"{figures['breaks']} breaks")
    if is_silent(figures):
        words.append("WRONG AND CALLED GOOD")
    return ", ".join(words)


def key_of(figures):
    return "/".join(str(figures[name]) for name in ("robot", "world", "effect", "seed"))


def measure(loopstone, options, kept):
    cases = [
        (robot, world, effect, seed)
        for robot in options.robots
        for world in options.worlds
        for effect in dict.fromkeys([CLEAN, *options.effects])
        for seed in range(options.first_seed, options.first_seed + options.seeds)
    ]
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        runs = {
            pool.submit(measured, loopstone, *case, options): case
            for case in cases
            if not (options.resume and "/".join(map(str, case)) in kept)
        }
        for done in concurrent.futures.as_completed(runs):
            figures = done.result()
            kept[key_of(figures)] = figures
            say(f"  {' '.join(map(str, runs[done]))}: {told(figures)}")
            yield figures


def centimetres(values):
    return f"{100 * values:.1f}"


def counted(words):
    """ "good 3, doubtful 1" """
    return ", ".join(f"{word} {words.count(word)}" for word in sorted(set(words)))


def row_of(name, runs, clean):
    good = [each for each in runs if not each.get("failed")]
    of_clean = [each["ate_m"] for each in clean if not each.get("failed")]
    said = {name for each in good for name in each["laser_faults"] + each["odometry_faults"]}
    return [
        *name,
        str(len(runs)),
        centimetres(median(of_clean)) if of_clean else "",
        centimetres(median([each["ate_m"] for each in good])) if good else "failed",
        centimetres(max(each["ate_m"] for each in good)) if good else "failed",
        f"{max(each['worst_m'] for each in good):.2f}" if good else "failed",
        counted([each["verdict"] for each in good] + ["failed"] * (len(runs) - len(good))),
        str(sum(map(is_wrong, runs))),
        str(sum(map(is_silent, runs))),
        ", ".join(sorted(said)),
    ]


HEADER = [
    "logs>",
    "ATE without, median [cm]>",
    "ATE, median [cm]>",
    "largest [cm]>",
    "worst place [m]>",
    "verdict",
    "wrong>",
    "of them called good>",
    "said",
]


def grouped_table(runs, names):
    """A row for each combination of what `names` names; beside it what the same logs without the
    effect are."""
    clean = {
        tuple(each[name] for name in ("robot", "world", "seed")): each
        for each in runs
        if each["effect"] == CLEAN
    }
    groups = {}
    for each in runs:
        groups.setdefault(tuple(each[name] for name in names), []).append(each)
    rows = []
    for name, group in groups.items():
        places = {tuple(each[part] for part in ("robot", "world", "seed")) for each in group}
        rows.append(row_of(name, group, [clean[place] for place in places if place in clean]))
    return table([*names, *HEADER], rows)


def realism_tables(runs):
    """By effect; then the clean and the usual world by place and robot."""
    wrong = sum(map(is_wrong, runs))
    silent = sum(map(is_silent, runs))
    order = list(dict.fromkeys(each["effect"] for each in runs))
    runs = sorted(runs, key=lambda each: order.index(each["effect"]))
    sentence = (
        f"{len(runs)} logs: {wrong} maps wrong (more than {100 * BOUND_M:.0f} cm rms or"
        f" {WORST_M:.0f} m at the worst place), {silent} of them called good."
    )
    places = [each for each in runs if each["effect"] in (CLEAN, USUAL)]
    parts = [sentence, grouped_table(runs, ["effect"])]
    if places:
        parts.append(grouped_table(places, ["robot", "world", "effect"]))
    return "\n\n".join(parts)


def parsed():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    words = lambda text: [word for word in text.split(",") if word]  # noqa: E731
    parser.add_argument("--program", default=str(ROOT / "build/release/bin/loopstone"))
    parser.add_argument("--work", type=pathlib.Path, default=ROOT / "build/bench")
    parser.add_argument("--worlds", type=words, default=None)
    parser.add_argument(
        "--effects", type=words, default=None, help="with + between several at once"
    )
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--first-seed", type=int, default=1)
    parser.add_argument("--robots", type=words, default=None, help=", ".join(ROBOTS))
    parser.add_argument("--duration", type=float, default=None, help="of each drive; 0: whole")
    parser.add_argument("--sim", default="", help="more flags of `loopstone simulate`")
    parser.add_argument("--map", default="", help="more flags of `loopstone map`")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--keep", action="store_true")
    parser.add_argument("--resume", action="store_true", help="leave out what has been measured")
    parser.add_argument(
        "--write", action="store_true", help="no measurement, docs from what is kept"
    )
    return parser.parse_args()


def main():
    options = parsed()
    loopstone = Loopstone(options.program, options.work)
    options.work.mkdir(parents=True, exist_ok=True)
    is_whole = not any(
        [options.quick, options.worlds, options.effects, options.robots, options.sim, options.map]
    )
    path = options.work / f"realism{'' if is_whole else '-some'}.json"
    section = json.loads(path.read_text()) if path.exists() else {"figures": {}}
    if options.write:
        runs = list(section["figures"].values())
        write_block(PAGE, BLOCK, provenance(section) + "\n\n" + realism_tables(runs))
        return
    options.worlds = options.worlds or WORLDS
    options.effects = options.effects or [*effects_of(loopstone), USUAL]
    options.robots = options.robots or (["gyro"] if options.quick else ["gyro", "around"])
    if options.duration is None:
        options.duration = QUICK_S if options.quick else DURATION_S
    when = circumstances(loopstone.version())
    kept = section["figures"] if options.resume else {}
    runs = []
    for figures in measure(loopstone, options, kept):
        runs.append(figures)
        path.write_text(json.dumps({**when, "figures": kept}, indent=1))
    if is_whole:
        runs = list(kept.values())
        write_block(PAGE, BLOCK, provenance(when) + "\n\n" + realism_tables(runs))
    print(realism_tables(runs))
    if not is_whole:
        print("\n" + grouped_table(runs, ["robot", "world", "effect"]))


if __name__ == "__main__":
    main()
