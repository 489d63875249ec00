#!/usr/bin/env bash
# Is this tree slower than BASE? Builds the program of both and runs them in turn: the front end, a
# match, the solution of a graph (bench/compare_speed.py). Ends with 1 when one of them takes more
# than 1.25 times as long.
#
#     scripts/compare_speed.sh [BASE]      a commit; else the first parent of HEAD
set -euo pipefail
cd "$(dirname "$0")/.."

base=$(git rev-parse --verify "${1:-HEAD^1}^{commit}")
tree=build/compare/base
mkdir -p build/compare
if [[ -e $tree/.git ]]; then
  git -C "$tree" checkout --quiet --detach "$base"
else
  git worktree prune
  git worktree add --quiet --force --detach "$tree" "$base"
fi
echo "base: $(git log -1 --format='%h %s' "$base")"
scripts/build.sh release loopstone_program
# The base builds itself, so that its own flags count. It stays there, and the next comparison
# compiles only what differs.
"$tree/scripts/build.sh" release loopstone_program
python3 bench/compare_speed.py "$tree/build/release/bin/loopstone" build/release/bin/loopstone
