#!/usr/bin/env bash
# Builds and runs the benchmark programs, then the scripts of bench/ that write the tables of docs/.
# scripts/bench.sh [REGEX]   runs only benchmarks that match
set -euo pipefail
cd "$(dirname "$0")/.."

CMAKE_ARGS="${CMAKE_ARGS:-} -DLOOPSTONE_BENCH=ON" scripts/build.sh release
mkdir -p build/bench
shopt -s nullglob
for program in build/release/bin/bench_*; do
  [[ -x $program ]] || continue
  name=$(basename "$program")
  case $name in bench_map_match | bench_cloud_match) continue ;; esac # bench/registration.py runs them
  printf '\n== %s\n' "$name"
  "$program" --benchmark_filter="${1:-.}" --benchmark_out="build/bench/$name.json" --benchmark_out_format=json
done
[[ $# -eq 0 ]] || exit 0 # with a REGEX only the inner loops
for script in bench/*.sh; do
  printf '\n== %s\n' "$script"
  bash "$script"
done
