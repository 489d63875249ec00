#!/usr/bin/env bash
# Runs each libFuzzer target for FUZZ_SECONDS (20), two at a time, from its seeds in
# fuzz/corpus/<name>/. New inputs stay in build/asan/corpus/<name>/; a crash leaves its input in
# build/asan/crashes/.
set -euo pipefail
cd "$(dirname "$0")/.."

seconds=${FUZZ_SECONDS:-20}
scripts/build.sh asan
mkdir -p build/asan/crashes build/asan/logs
shopt -s nullglob

run_target() {
  local program=$1 seconds=$2 name
  name=$(basename "$program")
  name=${name#fuzz_}
  mkdir -p "build/asan/corpus/$name"
  local seeds=()
  [[ -d fuzz/corpus/$name ]] && seeds=("fuzz/corpus/$name")
  if "$program" -max_total_time="$seconds" -timeout=10 -rss_limit_mb=2048 -max_len=65536 -print_final_stats=1 \
    -artifact_prefix="build/asan/crashes/$name-" "build/asan/corpus/$name" "${seeds[@]}" \
    >"build/asan/logs/$name.log" 2>&1; then
    printf '%-24s %s runs\n' "$name" "$(sed -n 's/^stat::number_of_executed_units: *//p' "build/asan/logs/$name.log")"
  else
    printf '%-24s FAILED\n' "$name"
    tail -60 "build/asan/logs/$name.log"
    return 1
  fi
}
export -f run_target

programs=(build/asan/bin/fuzz_*)
if [[ ${#programs[@]} -eq 0 ]]; then
  echo "no fuzz targets"
  exit 0
fi
export ASAN_OPTIONS=detect_leaks=1:allocator_may_return_null=1
printf '%s\n' "${programs[@]}" | xargs -P "${JOBS:-2}" -I{} bash -c 'run_target {} '"$seconds"
