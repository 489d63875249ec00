#!/usr/bin/env python3
"""Judges loop closures where the truth is known and writes the table of docs/accuracy.md.

What a false one is, and a revisit: bench/closures.py. What was measured is kept in
build/bench/loops.json.

  bench/loops.py                                   everything (about half an hour)
  bench/loops.py --only rooms --seeds 100
  bench/loops.py --only                            no measurement: writes the table from loops.json
                                                   again
"""
import pathlib
import shutil
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "scripts"))

import targets  # noqa: E402
from closures import PRECISION, judge, total  # noqa: E402
from doc_blocks import table, write_block  # noqa: E402
from measure import SICK  # noqa: E402
from program import Failed, Loopstone, say  # noqa: E402
from sections import measure_sections, section_parser, verdicts  # noqa: E402
from provenance import provenance  # noqa: E402

PAGE, BLOCK = ROOT / "docs/accuracy.md", "accuracy-loops"
CASES = {  # world, flags of simulate, seeds, seeds with --quick
    "rooms": ("rooms", [], 100, 3),
    "rooms, 180 beams": ("rooms", SICK, 20, 2),
    "office": ("office", [], 10, 2),
    "office, 180 beams": ("office", SICK, 10, 2),
    "warehouse": ("warehouse", [], 10, 1),
    "corridor": ("corridor", [], 10, 1),
    "campus": ("campus", [], 3, 1),
}


def measure_case(name, arguments, loopstone):
    world, flags, seeds, few = CASES[name]
    seeds = arguments.seeds or (few if arguments.quick else seeds)
    runs = []
    for seed in range(1, seeds + 1):
        sim = loopstone.simulate(world, seed, flags)
        try:
            folder, _, _ = loopstone.map(sim, "loops")
            runs.append({"seed": seed, **judge(folder, sim)})
        except Failed as failure:
            say(f"  {name} {seed}: FAILED {failure}")
            runs.append({"seed": seed, "failed": True})
        if seed > 10:
            shutil.rmtree(sim)
        if runs[-1].get("false"):
            say(f"  {name} {seed}: {runs[-1]}")
    return {
        "name": name,
        "command": " ".join(["loopstone simulate", world, *flags, "--seed N"]),
        "runs": runs,
    }


def targets_of(cases):
    found = []
    accepted = sum(total(case["runs"], "accepted") for case in cases)
    false = sum(total(case["runs"], "false") for case in cases)
    if accepted:
        precision = 1.0 - false / accepted
        found.append(
            (
                "loop closures that are true, all worlds",
                f">= {100 * PRECISION:.1f} %",
                f"{100 * precision:.2f} %",
                precision >= PRECISION,
            )
        )
    for case in cases:
        if case["name"] == "rooms":
            false = total(case["runs"], "false")
            found.append(
                (
                    f"rooms: false loop closures in {len(case['runs'])} seeds",
                    "0",
                    str(false),
                    false == 0,
                )
            )
    return found


def text_of(sections):
    parts = [provenance(*sections.values()), ""]
    cases = [section["figures"] for section in sections.values()]
    rows = []
    for case in cases:
        runs = case["runs"]
        accepted, revisits = total(runs, "accepted"), total(runs, "revisits")
        rows.append(
            [
                case["name"],
                str(len(runs)),
                str(accepted),
                str(total(runs, "false")),
                f"{100 * (1 - total(runs, 'false') / max(1, accepted)):.2f} %",
                str(total(runs, "rejected")),
                str(total(runs, "wrongly_rejected")),
                str(revisits),
                f"{100 * total(runs, 'recognised') / max(1, revisits):.1f} %",
            ]
        )
    parts += [
        table(
            [
                "world",
                "seeds>",
                "accepted>",
                "of them false>",
                "precision>",
                "turned down>",
                "of them true>",
                "metres of revisits>",
                "recognised>",
            ],
            rows,
        ),
        "",
        table(
            ["figure", "target", "measured", ""],
            [
                [name, target, measured, targets.verdict(met)]
                for name, target, measured, met in targets_of(cases)
            ],
        ),
    ]
    return "\n".join(parts)


def main():
    parser = section_parser(__doc__, list(CASES), ROOT)
    parser.add_argument(
        "--seeds", type=int, default=0, help="of each world, in place of its own number"
    )
    arguments = parser.parse_args()
    arguments.work.mkdir(parents=True, exist_ok=True)
    loopstone = Loopstone(arguments.programs / "loopstone", arguments.work)
    sections, failed = measure_sections(
        "loops",
        arguments,
        loopstone,
        lambda name: measure_case(name, arguments, loopstone),
        leave_out=lambda name, sections: arguments.resume and name in sections,
    )
    if not sections:
        return 1
    if arguments.quick:
        print(text_of(sections))
    else:
        write_block(PAGE, BLOCK, text_of(sections))
    print(verdicts(targets_of([section["figures"] for section in sections.values()])))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
