#!/usr/bin/env python3
"""Maps logs of `loopstone simulate --realism`, where the world is less kind than a clean
simulation: worlds x effects x seeds, each beside the same log without the effect. Prints a table of
the error against the truth and of the verdict; a full run writes it into docs/robustness.md.

A map is wrong when it is off by more than 0.5 m or 1 degree anywhere (bench/largest_error.py); the
table counts those of them that the verdict still calls good, and how many of the right ones it
does.

  bench/realism.py                       every effect, three worlds, two robots (half an hour)
  bench/realism.py --quick               one robot, 150 s of each drive
  bench/realism.py --worlds office,loops --effects blocked,follower --seeds 3
  bench/realism.py --effects usual+blocked --first-seed 10       effects together, other seeds
  bench/realism.py --sim "--set realism.blocked.at_s=60" --map "--odometry ignore"
  bench/realism.py --write               the tables again, of what the last full run measured

What a full run measured is kept in build/bench/realism.json, of any other in realism-some.json;
with --resume a run leaves out what stands there. --keep leaves the logs and maps in build/bench.
"""
import json
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "scripts"))

import unkind  # noqa: E402
from doc_blocks import table, write_block  # noqa: E402
from largest_error import RIGHT_DEG, RIGHT_M  # noqa: E402
from program import Loopstone, median  # noqa: E402
from provenance import provenance  # noqa: E402
from unkind import CLEAN, USUAL, Drive, is_good, is_wrong  # noqa: E402

PAGE = ROOT / "docs/robustness.md"
BLOCK = "robustness-realism"
WORLDS = ["office", "loops", "wings"]


def centimetres(values):
    return f"{100 * values:.1f}"


def counted(words):
    """ "good 3, doubtful 1" """
    return ", ".join(f"{word} {words.count(word)}" for word in sorted(set(words)))


def row_of(name, runs, clean):
    mapped = [each for each in runs if not each.get("failed")]
    of_clean = [each["ate_m"] for each in clean if not each.get("failed")]
    said = {name for each in mapped for name in each["laser_faults"] + each["odometry_faults"]}
    wrong = [each for each in runs if is_wrong(each)]
    right = [each for each in runs if not is_wrong(each)]
    errors = ["failed"] * 4
    if mapped:
        errors = [
            centimetres(median([each["ate_m"] for each in mapped])),
            centimetres(max(each["ate_m"] for each in mapped)),
            f"{max(each['worst_m'] for each in mapped):.2f}",
            f"{max(each['worst_deg'] for each in mapped):.1f}",
        ]
    return [
        *name,
        str(len(runs)),
        centimetres(median(of_clean)) if of_clean else "",
        *errors,
        counted([each.get("verdict", "failed") for each in runs]),
        str(len(wrong)),
        str(sum(map(is_good, wrong))),
        str(len(right)),
        str(sum(map(is_good, right))),
        ", ".join(sorted(said)),
    ]


HEADER = [
    "logs>",
    "ATE without, median [cm]>",
    "ATE, median [cm]>",
    "largest [cm]>",
    "worst place [m]>",
    "worst heading [deg]>",
    "verdict",
    "wrong>",
    "wrong, called good>",
    "right>",
    "right, called good>",
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
    wrong = [each for each in runs if is_wrong(each)]
    right = [each for each in runs if not is_wrong(each)]
    order = list(dict.fromkeys(each["effect"] for each in runs))
    runs = sorted(runs, key=lambda each: order.index(each["effect"]))
    sentence = (
        f"{len(runs)} logs: {len(wrong)} maps wrong (off by more than {RIGHT_M} m or"
        f" {RIGHT_DEG:.0f} degree somewhere), {sum(map(is_good, wrong))} of them called good;"
        f" {len(right)} right, {sum(map(is_good, right))} of them called good."
    )
    places = [each for each in runs if each["effect"] in (CLEAN, USUAL)]
    parts = [sentence, grouped_table(runs, ["effect"])]
    if places:
        parts.append(grouped_table(places, ["robot", "world", "effect"]))
    return "\n\n".join(parts)


def drives_of(loopstone, options):
    effects = options.effects or [*unkind.effects_of(loopstone), USUAL]
    return [
        Drive(robot, world, effect, seed)
        for robot in options.robots
        for world in options.worlds
        for effect in dict.fromkeys([CLEAN, *effects])
        for seed in range(options.first_seed, options.first_seed + options.seeds)
    ]


def main():
    options = unkind.parser_of(__doc__).parse_args()
    loopstone = Loopstone(options.program, options.work)
    options.work.mkdir(parents=True, exist_ok=True)
    is_whole = not unkind.is_part(options)
    path = options.work / f"realism{'' if is_whole else '-some'}.json"
    robots = ["gyro"] if options.quick else ["gyro", "around"]
    unkind.set_defaults(options, worlds=WORLDS, robots=robots, seeds=1, first_seed=1)
    if options.write:
        kept = json.loads(path.read_text())
    else:
        kept = unkind.measure(loopstone, drives_of(loopstone, options), options, path)
    runs = list(kept["figures"].values())
    if is_whole or options.write:
        text = provenance(*kept["sessions"]) + "\n\n" + realism_tables(runs)
        write_block(PAGE, BLOCK, text)
    print(realism_tables(runs))
    if not is_whole:
        print("\n" + grouped_table(runs, ["robot", "world", "effect"]))


if __name__ == "__main__":
    main()
