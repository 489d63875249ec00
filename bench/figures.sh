#!/usr/bin/env bash
# Measures everything and writes the tables of docs/ and README.md; each script tells on its own
# what it measures. Some hours; a table whose script fails stays as it was, and the last line names
# the script. BENCH_QUICK=1: a short look, docs/ stay as they are.
set -uo pipefail
cd "$(dirname "$0")/.."

quick=${BENCH_QUICK:+--quick}
data=${LOOPSTONE_DATA:-../shared/data}
failed=()

measure() {
  printf '\n== %s\n' "$*"
  python3 "$@" || failed+=("$1")
}

# What is measured beside us, in build/: wheels and sources from PyPI, Debian's packages, unpacked.
# What can't be had is left out, and said. MRPT's programs are Debian's, installed by
# `scripts/install_oracles.sh --localization`, since they bring 430 MB.
if [[ -z $quick ]]; then
  bench/peers/install.sh
  scripts/install_oracles.sh || failed+=(scripts/install_oracles.sh)
fi

# What is timed first, while nothing else has warmed or filled the machine.
measure bench/figures.py $quick
measure bench/pose_graphs.py $quick
measure bench/registration.py $quick
measure bench/localization_speed.py $quick
measure bench/ray_cast.py $quick
measure bench/recordings.py $quick
measure bench/file_readers.py $quick
measure bench/texture.py $quick
if [[ -x build/oracles/venv/bin/python && -d $data/rgbd ]]; then
  measure bench/real_floor.py $quick
else
  echo "bench/real_floor.py: skipped, it needs scripts/install_oracles.sh and recorded frames" >&2
fi
if [[ -x viewer/node_modules/.bin/esbuild ]] && command -v chromium >/dev/null; then
  measure bench/viewer.py $quick
else
  echo "bench/viewer.py: skipped, it needs scripts/install_viewer.sh" >&2
fi
if [[ -x build/python/venv/bin/loopstone && -f $data/carmen/intel.clf ]]; then
  measure bench/python_overhead.py $quick
else
  echo "bench/python_overhead.py: skipped, it needs scripts/test_python.sh and recorded logs" >&2
fi
if [[ -x build/fleet/venv/bin/loopstone-fleet ]]; then
  measure bench/fleet.py $quick
else
  echo "bench/fleet.py: skipped, it needs scripts/test_fleet.sh" >&2
fi
measure bench/session.py $quick
measure bench/continued.py $quick
if [[ -x build/oracles/venv/bin/python ]]; then
  measure bench/plans.py $quick
else
  echo "bench/plans.py: skipped, it needs scripts/install_oracles.sh" >&2
fi
measure bench/editing.py $quick
measure bench/live.py $quick
measure bench/localization.py $quick
if [[ -z $quick ]]; then
  measure bench/own_maps.py
fi
measure bench/hard_days.py $quick
measure bench/localization_peers.py $quick
measure bench/confidence.py measure $quick
measure bench/landmarks.py $quick
measure bench/outliers.py $quick
measure bench/loops.py $quick
measure bench/gaps.py $quick
measure bench/robustness.py $quick
measure bench/drives.py $quick
measure bench/realism.py $quick
measure bench/calibration.py $quick
measure bench/residuals.py $quick
measure bench/covariances.py $quick
measure bench/quality.py $quick
measure bench/sites.py $quick
# Alone more than an hour: a day at 20 times its pace.
measure bench/soak.py $quick
if [[ -z $quick ]]; then
  measure scripts/matching_examples.py
  measure scripts/ros_examples.py
  if [[ -d $data/ucsd ]]; then
    if python3 -c 'import numpy' 2>/dev/null; then
      measure bench/compare_ucsd_odometry.py --write docs/accuracy.md
    else
      echo "bench/compare_ucsd_odometry.py: skipped, it needs python3-numpy" >&2
    fi
  fi
fi

if [[ ${#failed[@]} -gt 0 ]]; then
  echo "failed: ${failed[*]}" >&2
  exit 1
fi
