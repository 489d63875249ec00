#!/usr/bin/env python3
"""Measures registration beside its peers and writes the tables of docs/benchmarks.md and
docs/accuracy.md.

The programs are built by `make bench` (-DLOOPSTONE_BENCH=ON). Peers (small_gicp, PCL, Open3D) are
compared when they are in build/bench/peers; bench/peers/install.sh puts them there, and nothing
into the system. Recorded logs and clouds are looked for in $LOOPSTONE_DATA, else in ../shared/data.
What was measured is kept in build/bench/registration.json.

  bench/registration.py                     everything, with the peers that are there (about a
                                            quarter of an hour)
  bench/registration.py --peers             the same, after installing the peers
  bench/registration.py --quick             a tenth of the pairs; to look at, writes nothing into
                                            docs/
  bench/registration.py --only pairs nees   some sections
  bench/registration.py --resume            the sections that have no figures yet
  bench/registration.py --only              no measurement: writes the tables from registration.json
                                            again
"""
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "scripts"))

import registration_measure as measure  # noqa: E402
import registration_tables as tables  # noqa: E402
from doc_blocks import write_block  # noqa: E402
from program import Loopstone, say  # noqa: E402
from sections import measure_sections, section_parser  # noqa: E402

SECTIONS = ["tracking", "correlative", "pairs", "nees", "clouds", "map_match", "real"]


def measure_section(name, arguments, loopstone, peers):
    programs, work, quick = arguments.programs, arguments.work / "registration", arguments.quick
    if name == "pairs":
        return measure.synthetic(programs, work, peers, quick)
    if name == "nees":
        return measure.consistency(programs, work, peers, quick)
    if name == "real":
        return measure.recorded(programs, work, peers, quick, loopstone, arguments.data)
    if name == "tracking":
        return measure.tracking(programs, quick)
    if name == "map_match":
        return measure.map_match(programs, work, quick)
    if name == "correlative":
        return measure.correlative(programs, work, quick)
    return measure.clouds(programs, work, arguments.work / "peers", arguments.data, quick)


def main():
    parser = section_parser(__doc__, SECTIONS, ROOT)
    parser.add_argument(
        "--peers", action="store_true", help="install the peers into build/bench/peers first"
    )
    arguments = parser.parse_args()

    (arguments.work / "registration").mkdir(parents=True, exist_ok=True)
    if arguments.peers:
        subprocess.run(["bash", str(ROOT / "bench/peers/install.sh")], check=False)
    peers, versions, missing = measure.peer_matchers(arguments.work / "peers")
    if missing:
        say(f"peers not installed: {', '.join(missing)} (bench/peers/install.sh); going on without")
    loopstone = Loopstone(arguments.programs / "loopstone", arguments.work)
    sections, failed = measure_sections(
        "registration",
        arguments,
        loopstone,
        lambda name: measure_section(name, arguments, loopstone, peers),
        extra={"peers": versions, "missing": missing},
        leave_out=lambda name, sections: arguments.resume and name in sections,
    )

    for name, page, block, text in tables.blocks_of(sections):
        if arguments.quick:
            if name in arguments.only:
                print(f"\n{page}: {block}\n{text}")
        else:
            write_block(ROOT / page, block, text)
    print(tables.summary(sections))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
