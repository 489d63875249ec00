#!/usr/bin/env bash
# Measures whole runs and writes the tables of docs/ and README.md (see bench/figures.py). BENCH_QUICK=1: a short look,
# docs/ stay as they are.
set -euo pipefail
cd "$(dirname "$0")/.."

python3 bench/figures.py ${BENCH_QUICK:+--quick}
if [[ -z ${BENCH_QUICK:-} && -e bench/compare_ucsd_odometry.py && -d ${LOOPSTONE_DATA:-../shared/data}/ucsd ]]; then
  if python3 -c 'import numpy' 2>/dev/null; then
    python3 bench/compare_ucsd_odometry.py --data "${LOOPSTONE_DATA:-../shared/data}" --write docs/accuracy.md
  else
    echo "bench/compare_ucsd_odometry.py: skipped, it needs python3-numpy" >&2
  fi
fi
python3 bench/registration.py ${BENCH_QUICK:+--quick}
python3 bench/localization_speed.py ${BENCH_QUICK:+--quick}
python3 bench/localization.py ${BENCH_QUICK:+--quick}
python3 bench/ray_cast.py ${BENCH_QUICK:+--quick}
python3 bench/loops.py ${BENCH_QUICK:+--quick}
python3 bench/robustness.py ${BENCH_QUICK:+--quick}
python3 bench/quality.py ${BENCH_QUICK:+--quick}
