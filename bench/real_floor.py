#!/usr/bin/env python3
"""Puts the floor of five recorded RGB-D frames on a map, and writes the table of docs/texture.md.

The frames (shared/data/rgbd: registered pictures of a living room by a camera in the hand, with its
poses) become a recording as a robot would make it, by the reference library that
scripts/install_oracles.sh brings: CompressedImage (PNG), Image (16UC1), CameraInfo, and tf in which
the camera moves on the robot; only the floor's plane in the frame of the poses is fitted there.
Then `loopstone texture` does the rest. The picture goes to docs/images.

  bench/real_floor.py                        measures and writes
  bench/real_floor.py --quick                writes nothing into docs/
"""
import json
import pathlib
import shutil
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "scripts"))

from doc_blocks import table, write_block  # noqa: E402
from program import Loopstone, run, say  # noqa: E402
from provenance import circumstances, provenance  # noqa: E402
from sections import plain_parser  # noqa: E402

PYTHON = ROOT / "build/oracles/venv/bin/python"
HELPER = ROOT / "bench/real_floor_recording.py"
FRAMES = 5
LEAST_CORRELATION = 0.3


def texture(arguments, folder, *flags):
    out = folder / "out"
    command = [arguments.programs / "loopstone", "texture", folder / "recording", "--quiet"]
    run([*command, "--trajectory", folder / "trajectory.tum", "-o", out, "--force", *flags])
    return json.loads((out / "summary.json").read_text())


def measure(arguments):
    work = arguments.work / "real_floor"
    work.mkdir(parents=True, exist_ok=True)
    run([PYTHON, HELPER, "make", arguments.data / "rgbd", work])
    whole = texture(arguments, work)
    singles = []
    for i in range(FRAMES):
        singles.append(work / f"frame{i}")
        singles[i].mkdir(exist_ok=True)
        run([PYTHON, HELPER, "make", arguments.data / "rgbd", singles[i], i])
        texture(arguments, singles[i], "--set", "texture.max_blur_m=0.03")
    seams = json.loads(run([PYTHON, HELPER, "seams", *(single / "out" for single in singles)])[0])
    return {"summary": whole, "seams": seams, "picture": str(work / "out/texture.png")}


def text_of(stamp, figures):
    summary = figures["summary"]
    rows = [
        [
            f"{seam['frames'][0] + 1} and {seam['frames'][1] + 1}",
            f"{100 * seam['shift_m']:.0f}",
            f"{seam['correlation']:.2f}",
        ]
        for seam in figures["seams"]
        if seam["correlation"] > LEAST_CORRELATION
    ]
    return "\n".join(
        [
            provenance(stamp),
            "",
            table(["frames", "apart [cm]", "correlation there"], rows),
            "",
            f"{summary['frames_used']} of {summary['frames']} frames used, "
            f"{summary['seen_area_m2']:.1f} m2 of floor seen.",
        ]
    )


def main():
    parser = plain_parser(__doc__, ROOT)
    arguments = parser.parse_args()
    if not PYTHON.exists():
        sys.exit(f"{PYTHON} is missing: scripts/install_oracles.sh")
    stamp = circumstances(Loopstone(arguments.programs / "loopstone", arguments.work).version())
    figures = measure(arguments)
    text = text_of(stamp, figures)
    if arguments.quick:
        print(text)
        return 0
    shutil.copy(figures["picture"], ROOT / "docs/images/texture_real.png")
    if write_block(ROOT / "docs/texture.md", "texture-real", text):
        say("wrote texture.md: texture-real")
    return 0


if __name__ == "__main__":
    sys.exit(main())
