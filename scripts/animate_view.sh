#!/usr/bin/env bash
# Makes docs/images/live_view.gif: the page of the live view while `loopstone view` maps a simulated
# office. Takes two minutes; needs Chromium (scripts/install_viewer.sh) and PyPI's Pillow.
#
#     scripts/animate_view.sh
set -euo pipefail
cd "$(dirname "$0")/.."
source scripts/apt_packages.sh

program=$PWD/build/release/bin/loopstone
work=$PWD/build/animation
frames=36 seconds=1.5 speed=12
[[ -x $program ]] || { echo "first: make build"; exit 1; }
python3 -c 'import ensurepip, venv' 2>/dev/null || install_packages python3-venv
[[ -x $work/venv/bin/pip ]] || python3 -m venv "$work/venv"
"$work/venv/bin/pip" install -q --disable-pip-version-check 'Pillow>=10'
rm -rf "$work/frames" "$work/sim"

"$program" simulate office -o "$work/sim" --seed 1 --beams 361 --quiet >/dev/null
"$program" view "$work/sim" --port 0 --no-open --speed "$speed" 2>"$work/view.log" &
viewer=$!
trap 'kill "$viewer" 2>/dev/null || true' EXIT
until url=$(grep -o 'http://[^ ]*' "$work/view.log" | head -1) && [[ -n $url ]]; do
  kill -0 "$viewer" || { cat "$work/view.log"; exit 1; }
  sleep 0.1
done
(cd viewer && node run.mjs demo/film.ts "$url" "$work/frames" "$frames" "$seconds")

"$work/venv/bin/python" - "$work/frames" docs/images/live_view.gif <<'PYTHON'
"""One palette for all frames, so that what does not change costs nothing."""
import pathlib
import sys

from PIL import Image

frames = [Image.open(path).convert("RGB") for path in sorted(pathlib.Path(sys.argv[1]).glob("*.png"))]
width, height = frames[0].size
sample = Image.new("RGB", (width, height * 3))
for row, frame in enumerate((frames[0], frames[len(frames) // 2], frames[-1])):
    sample.paste(frame, (0, row * height))
palette = sample.quantize(colors=48, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)
small = [frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
durations = [160] * (len(small) - 1) + [2500]
small[0].save(sys.argv[2], save_all=True, append_images=small[1:], duration=durations, loop=0, optimize=True)
print(f"{sys.argv[2]}: {len(small)} pictures, {pathlib.Path(sys.argv[2]).stat().st_size} bytes")
PYTHON
