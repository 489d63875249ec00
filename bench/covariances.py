#!/usr/bin/env python3
"""Whether the covariances of a map's path are true: simulated drives are mapped, and the error of
key scans to one another is held against the covariance that the map gives it. Writes a table of
docs/accuracy.md.

  bench/covariances.py                  everything (some minutes)
  bench/covariances.py --quick          a minute of each drive; writes nothing into docs/
"""
import json
import pathlib
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "scripts"))

from doc_blocks import table, write_block  # noqa: E402
from program import Failed, Loopstone, log_of, run, say  # noqa: E402
from provenance import circumstances, provenance  # noqa: E402
from sections import plain_parser  # noqa: E402

PAGE = ROOT / "docs/accuracy.md"
WORLDS = ["office", "rooms", "warehouse", "loops", "wings", "aisles", "outdoors"]
# As in bench/unkind.py.
ROBOTS = {
    "gyro, 541 beams": ["--beams", "541"],
    "poses, 181 beams": "--format carmen --beams 181 --fov 180".split(),
    "poses, 360 beams around": (
        "--format carmen --beams 360 --fov 359 --max-range 12 --range-noise 0.02".split()
    ),
}
EFFECTS = {"clean": [], "range, wheels, moved": ["--realism", "range,wheels,moved"]}
SEED = 21


def measured(arguments):
    rows = []
    folder = arguments.work / "sim-covariances"
    for world in WORLDS:
        for robot, words in ROBOTS.items():
            for effects, flags in EFFECTS.items():
                simulate = [arguments.programs / "loopstone", "simulate", world, "-o", folder]
                run(
                    [*simulate, "--seed", SEED, "--duration", 60 if arguments.quick else 240]
                    + [*words, *flags, "--force", "--quiet"]
                )
                name = f"{world}, {robot}, {effects}"
                program = arguments.programs / "measure_covariances"
                try:
                    kinds = json.loads(run([program, log_of(folder), folder / "truth.tum", 1])[0])
                except Failed as failure:
                    say(f"  {name}: {failure}")
                    continue
                for kind in kinds:
                    rows.append({"world": world, "robot": robot, "effects": effects, **kind})
                say(f"  {name}: " + ", ".join(f"{k['kind']} {k['nees']:.2f}" for k in kinds))
                shutil.rmtree(folder)
    return rows


def summed(rows):
    """Rows of the same kind as one: means weighted by pairs, root mean squares likewise."""
    pairs = sum(row["pairs"] for row in rows)

    def mean(name, power=1):
        return (sum(row["pairs"] * row[name] ** power for row in rows) / pairs) ** (1 / power)

    return [
        str(pairs),
        f"{mean('nees'):.2f}",
        f"{mean('nees_position'):.2f}",
        f"{mean('nees_heading'):.2f}",
        f"{100 * mean('inside_share'):.1f}",
        f"{1000 * mean('error_m', 2):.1f}",
        f"{1000 * mean('sigma_m', 2):.1f}",
        f"{57.29578 * mean('error_rad', 2):.3f}",
        f"{57.29578 * mean('sigma_rad', 2):.3f}",
    ]


HEADER = [
    "pairs>",
    "NEES>",
    "of position>",
    "of heading>",
    "inside 95 % [%]>",
    "error [mm]>",
    "sigma [mm]>",
    "error [deg]>",
    "sigma [deg]>",
]


def grouped(rows, *names):
    groups = {}
    for row in rows:
        groups.setdefault(tuple(row[name] for name in names), []).append(row)
    return table(
        [*("pairs of key scans" if name == "kind" else name for name in names), *HEADER],
        [[*group, *summed(of_group)] for group, of_group in groups.items()],
    )


def main():
    arguments = plain_parser(__doc__, ROOT).parse_args()
    arguments.work.mkdir(parents=True, exist_ok=True)
    loopstone = Loopstone(arguments.programs / "loopstone", arguments.work)
    kept = arguments.work / f"covariances{'-quick' if arguments.quick else ''}.json"
    when = circumstances(loopstone.version())
    rows = measured(arguments)
    kept.write_text(json.dumps({**when, "figures": rows}, indent=1))
    of_maps = [row for row in rows if not row["kind"].startswith("drift")]
    text = "\n\n".join(
        [
            provenance(when),
            grouped(rows, "kind"),
            grouped(of_maps, "world", "effects"),
            grouped(of_maps, "robot", "effects"),
        ]
    )
    print(text)
    if not arguments.quick:
        write_block(PAGE, "covariances", text)


if __name__ == "__main__":
    try:
        main()
    except subprocess.SubprocessError as failure:
        sys.exit(str(failure))
