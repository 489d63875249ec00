#!/usr/bin/env python3
"""Runs the commands of docs/matching.md and writes what they printed into the page.

  scripts/matching_examples.py [--program build/release/bin/loopstone]
"""
import argparse
import pathlib
import shlex
import subprocess
import tempfile

from doc_blocks import write_block
from provenance import circumstances, provenance
from recorded import data_folder

ROOT = pathlib.Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs/matching.md"
WARM_UP = data_folder(ROOT) / "ucsd/icp_warm_up/drill"

EXAMPLES = {
    "log": ["loopstone simulate office -o sim --seed 1 --duration 40 --quiet"],
    "relative": ["loopstone match sim#120 sim#119 --target-pose 5.0207,3.8116,-1.2953"],
    "wrong_guess": [
        "loopstone match sim#120 sim/map.yaml --initial 4,3,0 --search-xy 5 --search-yaw 3.15"
    ],
    "align": ["loopstone match sim#120 sim/map.yaml --global --png global.png"],
    "clouds": ["loopstone match drill/0.npy drill/model.mat --target-scale 0.001 --global"],
}


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--program", default=str(ROOT / "build/release/bin/loopstone"))
    arguments = parser.parse_args()
    program = str(pathlib.Path(arguments.program).resolve())
    version = (
        subprocess.run([program, "--version"], check=True, stdout=subprocess.PIPE)
        .stdout.decode()
        .strip()
    )
    when = provenance(circumstances(version))
    with tempfile.TemporaryDirectory() as folder:
        if WARM_UP.exists():
            pathlib.Path(folder, "drill").symlink_to(WARM_UP)
        for block, commands in EXAMPLES.items():
            if block == "clouds" and not WARM_UP.exists():
                print("the warm-up clouds are not here: block 'clouds' stays as it is")
                continue
            text = ""
            for command in commands:
                done = subprocess.run(
                    [program, *shlex.split(command)[1:]],
                    cwd=folder,
                    check=True,
                    stdout=subprocess.PIPE,
                )
                text += f"$ {command}\n{done.stdout.decode()}"
            write_block(PAGE, f"match_{block}", f"```text\n{text.rstrip()}\n```\n\n{when}")
        picture = pathlib.Path(folder, "global.png").read_bytes()
        (ROOT / "docs/images/match_global.png").write_bytes(picture)


if __name__ == "__main__":
    main()
