#!/usr/bin/env bash
# Formats every source. scripts/format.sh [--check]: changes nothing, fails and names the files that differ.
set -euo pipefail
cd "$(dirname "$0")/.."

folders=()
for folder in include src apps tests examples fuzz bench; do
  [[ -d $folder ]] && folders+=("$folder")
done
mapfile -t files < <(find "${folders[@]}" -name '*.cpp' -o -name '*.hpp' | sort)
if [[ ${1:-} == --check ]]; then
  unformatted=$(clang-format --dry-run -Werror --ferror-limit=1 "${files[@]}" 2>&1 | sed -n 's/^\([^: ]*\):[0-9:]* error: .*/\1/p' | sort -u || true)
  if [[ -n $unformatted ]]; then
    printf 'not formatted (make format):\n%s\n' "$unformatted"
    exit 1
  fi
  # clang-format leaves comments as they are.
  if grep -nE '^ *//.*$' "${files[@]}" | awk -F: '{ line = $0; sub(/^[^:]*:[0-9]*:/, "", line); if (length(line) > 100) { print $1 ":" $2; found = 1 } } END { exit !found }'; then
    echo 'comments longer than 100 columns'
    exit 1
  fi
  echo "${#files[@]} files are formatted"
else
  clang-format -i "${files[@]}"
fi
