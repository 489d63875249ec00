#!/usr/bin/env python3
"""Measures localisation beside nav2's AMCL and MRPT's pf-localization, on the same logs and on the
maps that `loopstone map` drew of them, and writes the tables of docs/accuracy.md.

Recorded logs are looked for in $LOOPSTONE_DATA, else in ../shared/data; the others are simulated.
AMCL is built by bench/peers/install_localization.sh; pf-localization is Debian's (mrpt-apps):
`scripts/install_oracles.sh --localization` brings both. A peer that is not there is left out. Every
run of a peer is a process of its own. What was measured is kept in
build/bench/localization_peers.json, run by run.

  bench/localization_peers.py                 everything (about half an hour on one core)
  bench/localization_peers.py --quick         two drives, one run each; to look at, writes nothing
  bench/localization_peers.py --only intel    some drives; the others stay as they were measured
  bench/localization_peers.py --resume        goes on where it was interrupted
  bench/localization_peers.py --write         no measurement: the tables from what is kept
"""
import argparse
import concurrent.futures
import json
import os
import pathlib
import subprocess
import sys
import threading

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "scripts"))

import localization_peers_tables as tables  # noqa: E402
from doc_blocks import write_block  # noqa: E402
from localization_peers_measure import DRIVES, SEEDS, SLOW, SYSTEMS, PeersBeside  # noqa: E402
from peers import amcl_localization, mrpt_localization  # noqa: E402
from program import Failed, Loopstone, say  # noqa: E402
from provenance import circumstances  # noqa: E402
from recorded import data_folder  # noqa: E402

PAGE, BLOCK = ROOT / "docs/accuracy.md", "localization-peers"
QUICK = ["csail", "office-poses"]


def install():
    subprocess.run(["bash", str(ROOT / "bench/peers/install_localization.sh")], check=False)
    missing = [
        name
        for name, peer in (("AMCL", amcl_localization), ("pf-localization", mrpt_localization))
        if not peer.is_here()
    ]
    if missing:
        say(f"peers not installed: {', '.join(missing)}; going on without")
        say("  `scripts/install_oracles.sh --localization` brings them")


def measured(arguments, kept_at, drives, seeds):
    """Adds to what is kept, run by run: by drive its runs, each with its circumstances. Returns
    that, and the drives that failed."""
    work = arguments.work / "localization_peers"
    work.mkdir(parents=True, exist_ok=True)
    loopstone = Loopstone(arguments.program, work)
    kept = json.loads(kept_at.read_text()) if kept_at.exists() else {}
    if not arguments.resume:
        kept = {name: each for name, each in kept.items() if name not in drives}
    beside = PeersBeside(loopstone, arguments.data)
    when = circumstances(loopstone.version())
    guard, failed = threading.Lock(), set()

    def drive(name, systems, seeds):
        try:
            for runs in beside.runs(name, systems, seeds, kept.get(name, []), when):
                with guard:
                    kept[name] = runs
                    kept_at.write_text(json.dumps(kept, indent=1))
        except (Failed, OSError, RuntimeError, KeyError, ValueError) as failure:
            say(f"  {name}: FAILED {failure!r}")
            failed.add(name)

    quick_ones = [system for system in SYSTEMS if system not in SLOW]
    with concurrent.futures.ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:
        for systems, some in [(quick_ones, seeds), *((SLOW, [seed]) for seed in seeds)]:
            list(pool.map(lambda name: drive(name, systems, some), drives))
    return kept, failed


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--program", default=ROOT / "build/release/bin/loopstone")
    parser.add_argument("--work", type=pathlib.Path, default=ROOT / "build/bench")
    parser.add_argument("--data", type=pathlib.Path, default=data_folder(ROOT))
    parser.add_argument("--only", nargs="+", choices=list(DRIVES))
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--resume", action="store_true")
    parser.add_argument("--write", action="store_true")
    arguments = parser.parse_args()
    kept_at = arguments.work / f"localization_peers{'-quick' if arguments.quick else ''}.json"
    failed = set()
    if arguments.write:
        kept = json.loads(kept_at.read_text())
    else:
        install()
        drives = arguments.only or (QUICK if arguments.quick else list(DRIVES))
        kept, failed = measured(arguments, kept_at, drives, SEEDS[:1] if arguments.quick else SEEDS)
    if arguments.quick:
        print(tables.text_of(kept))
    elif kept:
        write_block(PAGE, BLOCK, tables.text_of(kept))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
