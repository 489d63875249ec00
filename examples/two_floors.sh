#!/usr/bin/env bash
# Three robots with different lasers drive through two floors of an office. Each floor becomes a
# site: one map of all drives, a plan, pictures, and a recording for Foxglove.
#
#     examples/two_floors.sh [FOLDER]      about a minute; FOLDER must be new
#
# LOOPSTONE names the program where it is not in PATH, DURATION_S how long each drive lasts.
set -euo pipefail
loopstone=${LOOPSTONE:-loopstone}
folder=${1:-two_floors}
duration_s=${DURATION_S:-90}
mkdir "$folder" "$folder"/{logs,ground,upper}

# What the robots see with.
courier=(--beams 1081 --fov 270 --scan-rate 10 --max-range 30)
cleaner=(--beams 181 --fov 180 --scan-rate 5 --max-range 20)
guard=(--beams 720 --fov 360 --scan-rate 7 --max-range 12)
# Each floor is a world of its own.
declare -A seed=([ground]=3 [upper]=8)

# A drive: DAY ROBOT FLOOR PLACE, the last of which is where it begins. No site is told.
drive() {
  local -n laser=$2
  "$loopstone" simulate office -o "$folder/logs/$1_$2" --seed "${seed[$3]}" \
    --drive-seed "${1//-/}" --start-place "$4" --duration "$duration_s" "${laser[@]}" \
    --quiet >/dev/null
}
add() { # FLOOR LOG DAY
  "$loopstone" site add "$folder/$1/floor.site" "$folder/logs/$2" --date "$3" --quiet
}

while read -r day robot floor place; do
  drive "$day" "$robot" "$floor" "$place"
  add "$floor" "${day}_$robot" "$day"
done <<'DRIVES'
2026-11-02 courier ground 1
2026-11-02 guard   upper  1
2026-11-03 cleaner ground 2
2026-11-03 courier upper  3
2026-11-04 guard   ground 3
2026-11-04 cleaner upper  2
DRIVES

# Nobody noted where this one drove. The floor that knows it joins it, on the other one it waits.
drive 2026-11-05 cleaner upper 1
for floor in ground upper; do
  add "$floor" 2026-11-05_cleaner 2026-11-05
  "$loopstone" site prune "$folder/$floor/floor.site" --pending --quiet >/dev/null
done

for floor in ground upper; do
  site=$folder/$floor/floor.site
  # A pane of glass that no laser sees, a metre from where the floor's first drive began.
  "$loopstone" site edit "$site" --wall "-1.5,-1.0 -0.5,-1.0 -0.5,-0.9 -1.5,-0.9" --quiet >/dev/null
  "$loopstone" site map "$site" -o "$folder/$floor/map" --mcap "$folder/$floor/floor.mcap" \
    --quiet >/dev/null
  "$loopstone" export "$site" --pdf "$folder/$floor/plan.pdf" --svg "$folder/$floor/plan.svg" \
    --title "Office, $floor floor" --straighten --quiet >/dev/null
  echo "$floor floor: $folder/$floor/plan.pdf, $folder/$floor/map/report.html"
  "$loopstone" site show "$site"
done
