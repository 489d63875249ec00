#!/usr/bin/env bash
# Formats every source: C++ by clang-format, Python by black, the viewer by prettier.
#
#     scripts/format.sh            changes files
#     scripts/format.sh --check    changes nothing, fails and names the files that differ
set -euo pipefail
cd "$(dirname "$0")/.."

folders=()
for folder in include src apps python tests examples fuzz bench scripts .ci; do
  [[ -d $folder ]] && folders+=("$folder")
done
find_files() { find "${folders[@]}" -type f \( "$@" \) -not -path '*/__pycache__/*' | sort; }
mapfile -t cpp < <(find_files -name '*.cpp' -o -name '*.hpp')
mapfile -t python < <(find_files -name '*.py')
mapfile -t shell < <(find_files -name '*.sh' -o -path .ci/run)

for tool in clang-format black; do
  command -v "$tool" >/dev/null || { echo "$tool not found: make deps-all" >&2; exit 1; }
done
prettier=viewer/node_modules/.bin/prettier
[[ -x $prettier ]] || { echo "$prettier not found: make deps-all" >&2; exit 1; }
if [[ ${1:-} != --check ]]; then
  clang-format -i "${cpp[@]}"
  black --quiet "${python[@]}"
  (cd viewer && node_modules/.bin/prettier --write --log-level warn .)
  exit 0
fi

faults=0
say_fault() {
  printf '%s\n' "$@"
  faults=$((faults + 1))
}
# too_long PATTERN FILE...: the lines that hold it and are longer than 100 columns.
too_long() {
  local pattern=$1
  shift
  awk -v pattern="$pattern" 'length($0) > 100 && $0 ~ pattern { print FILENAME ":" FNR }' "$@"
}

unformatted=$(clang-format --dry-run -Werror --ferror-limit=1 "${cpp[@]}" 2>&1 |
  sed -n 's/^\([^: ]*\):[0-9:]* error: .*/\1/p' | sort -u || true)
[[ -z $unformatted ]] || say_fault 'not formatted (make format):' "$unformatted"
unformatted=$(black --check "${python[@]}" 2>&1 |
  sed -n 's/^would reformat //p; s/^error: cannot format //p' || true)
[[ -z $unformatted ]] || say_fault 'Python that is not formatted (make format):' "$unformatted"
unformatted=$(cd viewer && node_modules/.bin/prettier --list-different . | sed 's,^,viewer/,' || true)
[[ -z $unformatted ]] || say_fault 'of the viewer not formatted (make format):' "$unformatted"
# clang-format leaves comments as they are, black comments and texts.
long=$(too_long '^ *//' "${cpp[@]}")
[[ -z $long ]] || say_fault 'comments longer than 100 columns:' "$long"
long=$(too_long '' "${python[@]}")
[[ -z $long ]] || say_fault 'lines of Python longer than 100 columns:' "$long"
long=$(too_long '^ *#' "${shell[@]}")
[[ -z $long ]] || say_fault 'comments of shell scripts longer than 100 columns:' "$long"

[[ $faults -eq 0 ]] || exit 1
echo "$((${#cpp[@]} + ${#python[@]})) files are formatted"
