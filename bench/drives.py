#!/usr/bin/env python3
"""Maps 200 drives of robots in worlds less kind than a clean simulation, and holds them against the
truth: which maps are right, what the verdict says of them, how far they are from the map of the
same drive in its clean form, which loop closures are false, and whether a map is worse for closing
loops. Writes the tables that docs/accuracy.md begins with.

Ten worlds x four robots x five drives, each with a seed of its own: two with what every robot has
(`usual`), three with one thing more that spoils them, in turn. Those that are `usual` are mapped
without loop closing, too.

  bench/drives.py                             all (half an hour on two processors)
  bench/drives.py --resume                    what is missing of them
  bench/drives.py --quick                     one of each world and robot, 150 s of it
  bench/drives.py --worlds office,loops --robots gyro --effects usual+glass,usual+crowd --seeds 3
  bench/drives.py --first-seed 3000           other drives
  bench/drives.py --drives gyro/office/usual+blocked/1080 --keep       one, as the output names it
  bench/drives.py --write                     no measurement, the tables again

What a full run measured is kept in build/bench/drives.json, of any other in drives-some.json.
Tables of that go into docs/ with --write alone.
"""
import json
import pathlib
import shutil
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "scripts"))

import drives_tables  # noqa: E402
import unkind  # noqa: E402
from closures import judge  # noqa: E402
from doc_blocks import write_block  # noqa: E402
from program import Loopstone  # noqa: E402
from unkind import CLEAN, ROBOTS, USUAL, Drive  # noqa: E402

WORLDS = "office loops wings aisles warehouse rooms hall outdoors corridor campus".split()
SPOILS = (
    "blocked dirty follower ahead crowd carried carried_blind upside_down glass mirrors".split()
)
PLACES = [(world, robot) for world in WORLDS for robot in ROBOTS]
# Of each place; those with the usual effects alone come first.
DRIVES, USUAL_DRIVES = 5, 2
# Limits were chosen on small seeds.
FIRST_SEED = 1000


def effect_of(number, place):
    """Of the drive with this number at a place: all spoils come equally often, in each world and
    with each robot."""
    lap, slot = divmod(number, DRIVES)
    if slot < USUAL_DRIVES:
        return USUAL
    spoils = DRIVES - USUAL_DRIVES
    world, robot = divmod(place, len(ROBOTS))
    spoil = spoils * (lap + robot) + world + slot - USUAL_DRIVES
    return f"{USUAL}+{SPOILS[spoil % len(SPOILS)]}"


def drives_of(options):
    if options.drives:
        names = [name.split("/") for name in options.drives]
        return [Drive(*words, int(seed)) for *words, seed in names]
    return [
        Drive(robot, world, effect, options.first_seed + number * len(PLACES) + place)
        for number in range(options.seeds)
        for place, (world, robot) in enumerate(PLACES)
        if world in options.worlds and robot in options.robots
        for effect in options.effects or [effect_of(number, place)]
    ]


def closures_and_without(loopstone, options):
    """What is asked of a drive beside the usual figures."""

    def more(drive, sim, folder):
        if drive.effect == CLEAN:
            return {}
        figures = {"closures": judge(folder, sim)}
        if drive.effect == USUAL:
            name = f"{folder.name}-without"
            flags = ["--no-loop-closure"]
            out, without = unkind.map_and_judge(loopstone, sim, name, options, flags)
            figures["without"] = without
            if not options.keep:
                shutil.rmtree(out)
        return figures

    return more


def main():
    parser = unkind.parser_of(__doc__)
    parser.add_argument("--drives", type=lambda text: text.split(","), help="by name, only these")
    options = parser.parse_args()
    loopstone = Loopstone(options.program, options.work)
    options.work.mkdir(parents=True, exist_ok=True)
    is_whole = not (unkind.is_part(options) or options.drives)
    path = options.work / f"drives{'' if is_whole else '-some'}.json"
    unkind.set_defaults(
        options,
        worlds=WORLDS,
        robots=list(ROBOTS),
        seeds=1 if options.quick else DRIVES,
        first_seed=FIRST_SEED,
    )
    if options.write:
        kept = json.loads(path.read_text())
    else:
        drives = drives_of(options)
        drives = [form for drive in drives for form in (drive.clean(), drive)]
        more = closures_and_without(loopstone, options)
        kept = unkind.measure(loopstone, drives, options, path, more)
    text = drives_tables.text_of(kept)
    if is_whole or options.write:
        write_block(ROOT / "docs/accuracy.md", "accuracy-drives", text)
    print(text)


if __name__ == "__main__":
    main()
