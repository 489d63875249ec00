#!/usr/bin/env python3
"""Fits the probability that localisation gives to its pose to simulated drives whose truth is
known, and measures on other drives how far it can be believed.

The program is built by `make bench` (-DLOOPSTONE_BENCH=ON). Recorded maps are looked for in
$LOOPSTONE_DATA, else in ../shared/data; without them the built-in worlds must do. What was driven
is kept in build/bench/confidence-*.json.

  bench/confidence.py fit        training drives, and those of bench/own_maps.py with other seeds;
                                 writes src/localization/confidence_weights.hpp: build anew after it
  bench/confidence.py measure    held-out drives; writes the tables and the picture of
                                 docs/localization.md
  ... --seeds N                  drives of each kind in each place (default 4)
  ... --quick                    one of each; to look at, writes nothing
  ... --again                    no drives: from what was kept
  fit --only FEATURE...          the other weights stay as they are
"""
import argparse
import json
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "scripts"))

import confidence_fit as model  # noqa: E402
import confidence_tables as report  # noqa: E402
from confidence_drives import KINDS, Drive, drive_through, planned  # noqa: E402
from doc_blocks import write_block  # noqa: E402
from own_maps_measure import Drive as OwnMapDrive  # noqa: E402
from own_maps_measure import OwnMaps  # noqa: E402
from program import Loopstone, say  # noqa: E402
from provenance import circumstances  # noqa: E402
from recorded import data_folder  # noqa: E402

PAGE, BLOCK = ROOT / "docs/localization.md", "localization-confidence"
PICTURE = ROOT / "docs/images/localization_reliability.svg"
# No drive is in both sets. Seeds: of a kind of drive in a place.
FIRST_SEED = {"fit": 1, "measure": 100001}
SEEDS, QUICK_SEEDS = 4, 1
OWN_MAPS_SEED = 301  # bench/own_maps.py measures others
# A log of another building is rare, and there are as many pairs of them as one likes.
OWN_MAPS_WEIGHTS = {"own": 1.0, "day": 1.0, "published": 1.0, "bare": 1.0, "other": 0.5}
# Neighbouring scans say the same: so many of a drive teach, evenly spread.
SCANS_OF_A_DRIVE = 150


def drives_of(arguments):
    """What was driven, and where and with what."""
    kept = arguments.work / f"confidence-{arguments.what}{'-quick' if arguments.quick else ''}.json"
    if arguments.again:
        section = json.loads(kept.read_text())
        return [Drive(**drive) for drive in section.pop("drives")], section
    seeds = QUICK_SEEDS if arguments.quick else arguments.seeds
    section = circumstances(Loopstone(arguments.programs / "loopstone", arguments.work).version())
    drives = planned(arguments.data, FIRST_SEED[arguments.what], seeds)
    drives = drive_through(arguments.programs / "measure_localization", drives, arguments.work)
    kept.write_text(json.dumps({**section, "drives": [vars(drive) for drive in drives]}))
    return drives, section


def own_map_drives(arguments):
    """On maps that the mapper drew, of recorded and of unkind simulated logs."""
    if arguments.quick:
        return []
    kept = arguments.work / "confidence-own-maps.json"
    if arguments.again:
        return [OwnMapDrive(**drive) for drive in json.loads(kept.read_text())]
    work = arguments.work / "own_maps"
    work.mkdir(parents=True, exist_ok=True)
    loopstone = Loopstone(arguments.programs / "loopstone", work)
    drives = list(OwnMaps(loopstone, arguments.data, OWN_MAPS_SEED).drives())
    kept.write_text(json.dumps([drive.as_json() for drive in drives]))
    return drives


def fit(arguments):
    drives, _ = drives_of(arguments)
    drives += own_map_drives(arguments)
    weights = {**{kind: what.weight for kind, what in KINDS.items()}, **OWN_MAPS_WEIGHTS}
    samples = model.samples_of(drives, SCANS_OF_A_DRIVE, lambda drive: weights[drive.kind])
    before = model.read_weights(ROOT)
    weights, likelihood = model.fit(samples, before, arguments.only)
    say(
        "log-likelihood of a drive:"
        f" {model.log_likelihood(before, samples) / len(drives):.4f} before,"
        f" {likelihood / len(drives):.4f} after"
    )
    for weight, (name, _) in zip(weights, model.FEATURES):
        print(f"{name:12} {weight:9.4f}")
    if not arguments.quick:
        scans = sum(len(drive.rows) for drive in drives)
        model.write_weights(ROOT, weights, len(drives), scans, arguments.only)


def measure(arguments):
    drives, section = drives_of(arguments)
    model.check(drives, model.read_weights(ROOT))
    figures = report.figures_of(drives)
    text = report.text_of(section, figures)
    if arguments.quick:
        print(text)
        return
    PICTURE.write_text(report.picture_of(figures), encoding="utf-8")
    write_block(PAGE, BLOCK, text)


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("what", choices=["fit", "measure"])
    parser.add_argument("--programs", type=pathlib.Path, default=ROOT / "build/release/bin")
    parser.add_argument("--data", type=pathlib.Path, default=data_folder(ROOT))
    parser.add_argument("--work", type=pathlib.Path, default=ROOT / "build/bench")
    parser.add_argument("--seeds", type=int, default=SEEDS)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--again", action="store_true")
    parser.add_argument("--only", nargs="+", default=(), choices=[n for n, _ in model.FEATURES])
    arguments = parser.parse_args()
    arguments.work.mkdir(parents=True, exist_ok=True)
    return fit(arguments) if arguments.what == "fit" else measure(arguments)


if __name__ == "__main__":
    main()
