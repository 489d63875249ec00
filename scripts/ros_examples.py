#!/usr/bin/env python3
"""Runs the commands of docs/ros.md and writes what they printed into the page.

  scripts/ros_examples.py [--program build/release/bin/loopstone]
"""
import argparse
import pathlib
import shlex
import subprocess
import tempfile

from doc_blocks import write_block
from provenance import circumstances, provenance

ROOT = pathlib.Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs/ros.md"

# A robot as ROS drives most: it publishes poses, and keeps its wheels to itself.
EXAMPLES = {
    "ros_info": [
        "loopstone simulate office -o sim --duration 120 --format bag --set odometry_poses=true"
        " --quiet",
        "loopstone info sim/log.bag",
    ],
    "ros_map": [
        "loopstone map sim/log.bag -o out",
        "loopstone evaluate --estimate out/trajectory.tum --reference sim/truth.tum",
    ],
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
        for block, commands in EXAMPLES.items():
            text = ""
            for command in commands:
                done = subprocess.run(
                    [program, *shlex.split(command)[1:]],
                    cwd=folder,
                    check=True,
                    stdout=subprocess.PIPE,
                    stderr=subprocess.PIPE,
                )
                if "--quiet" in command:
                    text += f"$ {command}\n"
                    continue
                lines = (done.stderr + done.stdout).decode().rstrip().splitlines()
                if "laser" in lines:  # what it says of any log follows
                    lines[lines.index("laser") :] = ["..."]
                said = "\n".join(line.rstrip() for line in lines)
                text += f"$ {command}\n{said}\n\n"
            write_block(PAGE, block, f"```text\n{text.rstrip()}\n```\n\n{when}")


if __name__ == "__main__":
    main()
