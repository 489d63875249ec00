#!/usr/bin/env python3
"""Measures the page of the live view in Chromium without a graphics card: how soon it is seen, how
long a picture takes, how much memory it needs. Writes the table of docs/live_view_page.md. Needs
scripts/install_viewer.sh.

  bench/viewer.py            everything (about a minute)
  bench/viewer.py --quick    fewer pictures; prints the table, writes nothing into docs/
"""
import argparse
import json
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "scripts"))

from doc_blocks import table, write_block  # noqa: E402
from provenance import circumstances, git, provenance  # noqa: E402

PAGE, BLOCK = ROOT / "docs/live_view_page.md", "viewer-page"
NAMES = {"demo office": "an office", "large": "a hundred times as much"}


def version():
    text = (ROOT / "include/loopstone/version.hpp").read_text(encoding="utf-8")
    return "loopstone " + re.search(r'kVersion = "([^"]+)"', text).group(1)


def circumstances_here():
    """The page is not among what the program's figures depend on."""
    when = circumstances(version())
    changed = (git("status", "--porcelain", "--", "viewer") or "").splitlines()
    return {**when, "changed": when["changed"] + [line[3:] for line in changed]}


def measure(quick):
    command = ["node", "run.mjs", "bench/measure.ts", *(["--quick"] if quick else [])]
    done = subprocess.run(command, cwd=ROOT / "viewer", stdout=subprocess.PIPE, check=True)
    return json.loads(done.stdout)


def run_rows(runs):
    for run in runs:
        paint = run["first_paint_ms"]
        yield [
            NAMES.get(run["name"], run["name"]),
            f"{run['area_m2']:,.0f}",
            str(run["tiles"]),
            f"{run['nodes']:,}",
            f"{run['closures']:,}",
            f"{paint['median']:.0f}",
            f"{paint['slow']:.0f}",
            f"{run['loaded_ms']:.0f}",
            f"{run['heap_mb']:.1f}",
        ]


def frame_rows(runs):
    for run in runs:
        for frames in run["frames"]:
            yield [
                NAMES.get(run["name"], run["name"]),
                frames["view"],
                f"{frames['median']:.0f}",
                f"{frames['slow']:.0f}",
            ]


def text_of(figures, when):
    runs = figures["runs"]
    sizes = (
        f"The page has {figures['page_bytes'] / 1000:.0f} kB,"
        f" {figures['page_gzip_bytes'] / 1000:.0f} kB when packed."
        f" {figures['browser']}, 1280 x 800 pixels, drawn by the processor."
    )
    loading = table(
        [
            "run",
            "tiles' area [m2]>",
            "tiles>",
            "nodes>",
            "closures>",
            "first paint [ms]>",
            "95 % below [ms]>",
            "all shown [ms]>",
            "heap [MB]>",
        ],
        list(run_rows(runs)),
    )
    frames = table(
        ["run", "what is seen", "a picture [ms]>", "95 % below [ms]>"], list(frame_rows(runs))
    )
    return "\n\n".join([sizes, loading, frames, provenance(when)])


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--quick", action="store_true")
    arguments = parser.parse_args()
    when = circumstances_here()
    text = text_of(measure(arguments.quick), when)
    print(text)
    if not arguments.quick:
        write_block(PAGE, BLOCK, text)


if __name__ == "__main__":
    main()
