#!/usr/bin/env bash
# From nothing to a map: simulates a robot in an office, maps its log, and compares the result with
# the truth.
#
#     scripts/demo.sh [WORLD [SEED]]      WORLD: office (default), campus, corridor, rooms,
#                                         warehouse, or a map.yaml
set -euo pipefail
cd "$(dirname "$0")/.."

loopstone=build/release/bin/loopstone
world=${1:-office}
seed=${2:-1}
out=build/demo/$(basename "$world" .yaml)

say() { printf '\n\033[1m== %s\033[0m\n' "$*"; }
show() { printf '$ %s\n' "$*"; "$@"; }

rm -rf "$out"
mkdir -p "$(dirname "$out")"

say "A robot drives through the $world"
show "$loopstone" simulate "$world" -o "$out/log" --seed "$seed"

say "Its log becomes a map"
show "$loopstone" map "$out/log" -o "$out/map"

say "How far is the trajectory from the truth?"
printf 'wheels and gyro alone:\n'
show "$loopstone" evaluate --estimate "$out/map/odometry.tum" --reference "$out/log/truth.tum" --align se2
printf 'loopstone:\n'
show "$loopstone" evaluate --estimate "$out/map/trajectory.tum" --reference "$out/log/truth.tum" --align se2

say "Done"
printf 'map:     %s\n' "$PWD/$out/map/map.png"
printf 'report:  %s\n' "$PWD/$out/map/report.html"
