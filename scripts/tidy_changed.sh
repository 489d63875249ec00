#!/usr/bin/env bash
# clang-tidy on the sources that changed, and on the sources that include a header that changed.
#
#     scripts/tidy_changed.sh [BASE]         against BASE, else $LOOPSTONE_TIDY_BASE, else origin/main when this is a branch
#                                            of it, else the first parent of HEAD; nothing known: src/ and apps/
#     scripts/tidy_changed.sh --everything   all sources, tests too
#
# At most LOOPSTONE_TIDY_MAX files (60) are read, those of src/ and apps/ first, so that CI stays within its time.
set -euo pipefail
cd "$(dirname "$0")/.."

limit=${LOOPSTONE_TIDY_MAX:-60}
base=${1:-${LOOPSTONE_TIDY_BASE:-}}

# Every source of the compilation database, the program first and the tests last.
all_sources() {
  local folder
  for folder in src apps examples fuzz bench tests; do
    [[ -d $folder ]] && find "$folder" -name '*.cpp' -not -path 'tests/install/*' -not -path 'bench/peers/*' | sort
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
  limit=100000
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
if [[ $count -gt $limit ]]; then
  echo "$count files; reading the first $limit (LOOPSTONE_TIDY_MAX)"
  files=$(head -n "$limit" <<<"$files")
  count=$limit
fi
cmake --preset tidy >/dev/null
log=build/tidy/clang-tidy.log
status=0
tr '\n' '\0' <<<"$files" |
  xargs -0 -r -n 1 -P "${JOBS:-$(nproc)}" clang-tidy -quiet -p build/tidy >"$log" 2>&1 || status=$?
grep -vE '^[0-9]+ warnings? (generated|treated)|^Suppressed |^Use -header-filter' "$log" || true
echo "$count files read"
exit "$status"
