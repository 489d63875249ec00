#!/usr/bin/env bash
# examples/two_floors.sh, with drives of a minute, leaves what it promises.
#
#     tests/examples/check_two_floors.sh PROGRAM FOLDER     FOLDER is made anew
set -euo pipefail
program=$1
folder=$2
rm -rf "$folder"
LOOPSTONE=$program DURATION_S=60 "$(dirname "$0")/../../examples/two_floors.sh" "$folder"

fail() {
  echo "$0: $*" >&2
  exit 1
}
declare -A joined=([ground]=3 [upper]=4)
for floor in ground upper; do
  shown=$("$program" site show "$folder/$floor/floor.site" --json)
  [[ $shown == *"\"joined\": ${joined[$floor]},"* ]] || fail "$floor floor: not every drive is joined"
  [[ $shown == *'"kind": "wall"'* ]] || fail "$floor floor: the pane of glass is missing"
  [[ $shown != *'"pending"'* ]] || fail "$floor floor: somebody waits beside it"
  for file in plan.pdf plan.svg floor.mcap map/map.png map/coverage.png map/graph.g2o map/sessions.csv; do
    [[ -s $folder/$floor/$file ]] || fail "$floor floor: $file is missing"
  done
done
