#!/usr/bin/env bash
# clang-tidy on the sources that changed, and on the sources that include a header that changed.
#
#     scripts/tidy_changed.sh [BASE]         against BASE, else $LOOPSTONE_TIDY_BASE, else
#                                            origin/main when this is a branch of it, else the first
#                                            parent of HEAD; nothing known: src/ and apps/
#     scripts/tidy_changed.sh --everything   all sources, tests too
#
# It stops after LOOPSTONE_TIDY_SECONDS (120), so that CI stays within its time: src/ comes first,
# then apps/.
set -euo pipefail
cd "$(dirname "$0")/.."

seconds=${LOOPSTONE_TIDY_SECONDS:-120}
base=${1:-${LOOPSTONE_TIDY_BASE:-}}

# Every source of the compilation database, the program first and the tests last; loopstone-ros2 is
# in it where it is built.
all_sources() {
  local folder left_out=()
  grep -qs apps/loopstone_ros2 build/tidy/compile_commands.json || left_out=(-not -path 'apps/loopstone_ros2/*')
  for folder in src apps examples fuzz bench tests; do
    [[ -d $folder ]] && find "$folder" -name '*.cpp' -not -path 'tests/install/*' -not -path 'bench/peers/*' "${left_out[@]}" | sort
  done
  return 0
}

find_base() {
  if [[ -n $base ]]; then
    git rev-parse -q --verify "$base^{commit}"
  elif main=$(git rev-parse -q --verify origin/main^{commit}) && [[ $main != $(git rev-parse HEAD) ]]; then
    git merge-base "$main" HEAD
  else
    git rev-parse -q --verify 'HEAD^1^{commit}'
  fi
}

# Sources among the changed files, and sources that name a changed header in an include.
affected_by() {
  local changed=$1 header
  {
    grep -E '\.cpp$' <<<"$changed" || true
    while read -r header; do
      [[ $header == *.hpp ]] || continue
      header=${header#include/}
      header=${header#src/}
      header=${header#tests/}
      all_sources | xargs -r grep -lF "\"$header\"" || true
    done <<<"$changed"
  } | sort -u
}

if [[ $base == --everything ]]; then
  seconds=1000000
  files=$(all_sources)
elif from=$(find_base 2>/dev/null) && [[ -n $from ]]; then
  changed=$(git diff --name-only --diff-filter=d "$from" -- '*.cpp' '*.hpp'; git ls-files --others --exclude-standard -- '*.cpp' '*.hpp')
  if git diff --name-only "$from" -- .clang-tidy | grep -q .; then
    changed=$(all_sources)
  fi
  files=$(all_sources | grep -Fxf <(affected_by "$changed") || true)
  echo "changed since $(git log -1 --format='%h %s' "$from")"
else
  echo "no base commit known: reading src/ and apps/"
  files=$(all_sources | grep -E '^(src|apps)/' || true)
fi

count=$(grep -c . <<<"$files" || true)
if [[ $count -eq 0 ]]; then
  echo "nothing to read"
  exit 0
fi
cmake --preset tidy >/dev/null
log=build/tidy/clang-tidy.log

read_one() {
  if [[ $(date +%s) -lt $1 ]]; then
    clang-tidy -quiet -p build/tidy "$2"
  else
    echo "not read, out of time: $2"
  fi
}
export -f read_one
status=0
tr '\n' '\0' <<<"$files" |
  xargs -0 -r -n 1 -P "${JOBS:-$(nproc)}" bash -c "read_one $(($(date +%s) + seconds)) \"\$0\"" >"$log" 2>&1 || status=$?
grep -vE '^[0-9]+ warnings? (generated|treated)|^Suppressed |^Use -header-filter' "$log" || true
echo "$count files, $(grep -c '^not read' "$log" || true) of them not read"
exit "$status"
