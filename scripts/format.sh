#!/usr/bin/env bash
# Formats every source. scripts/format.sh [--check]: changes nothing, fails on the first difference, names the files.
set -euo pipefail
cd "$(dirname "$0")/.."

folders=()
for folder in include src apps tests examples fuzz bench; do
  [[ -d $folder ]] && folders+=("$folder")
done
mapfile -t files < <(find "${folders[@]}" -name '*.cpp' -o -name '*.hpp' | sort)
if [[ ${1:-} == --check ]]; then
  clang-format --dry-run -Werror "${files[@]}"
  echo "${#files[@]} files are formatted"
else
  clang-format -i "${files[@]}"
fi
