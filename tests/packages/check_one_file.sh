#!/usr/bin/env bash
# Runs the program of one file where there is nothing else, no library, no /proc and no /dev, as a
# user without rights: simulates a drive, maps it, finds its robot on the map, and holds the map
# against the truth. What it writes is, byte for byte, what the ordinary program writes.
#
#     tests/packages/check_one_file.sh [ROOT]   in ROOT, some system's, in place of an empty folder
set -euo pipefail
cd "$(dirname "$0")/../.."

program=build/release/one_file/loopstone
[[ -x $program ]] || { echo "there is no $program: scripts/one_file.sh makes it" >&2; exit 1; }
if ldd "$program" 2>/dev/null | grep -q '=>'; then
  echo "it asks for libraries:" >&2
  ldd "$program" >&2
  exit 1
fi

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
root=${1:-$work/root}
mkdir -p "$root/one_file_test"
cp "$program" "$root/one_file_test/loopstone"
chmod 777 "$root/one_file_test"
as_root=()
[[ $(id -u) -eq 0 ]] || as_root=(sudo)

drive() { # FOLDER PROGRAM...: the results in FOLDER
  local out=$1
  shift
  "$@" simulate office -o "$out/sim" --duration 40 --quiet
  "$@" map "$out/sim" -o "$out/map" --quiet
  "$@" localize "$out/sim" --map "$out/map" --global -o "$out/where.tum" --quiet
  "$@" evaluate --estimate "$out/map/trajectory.tum" --reference "$out/sim/truth.tum" --json
}
"${as_root[@]}" rm -rf "$root/one_file_test/out"
mkdir -m 777 "$root/one_file_test/out" "$work/ordinary"
drive /one_file_test/out "${as_root[@]}" chroot --userspec=65534:65534 "$root" /one_file_test/loopstone >"$work/one_file.json" 2>"$work/told"
drive "$work/ordinary" build/release/bin/loopstone >"$work/ordinary.json" 2>"$work/told_ordinary"

# Times, memory and the command line are each run's own.
for name in sim map where.tum where.csv; do
  diff -r --exclude=summary.json --exclude=report.html --exclude=world.json \
    "$root/one_file_test/out/$name" "$work/ordinary/$name"
done
cmp "$work/told" "$work/told_ordinary"
rmse() { grep -m1 -o '"ate_rmse_m": [0-9.e-]*' "$1"; }
[[ -n $(rmse "$work/one_file.json") && $(rmse "$work/one_file.json") == "$(rmse "$work/ordinary.json")" ]]
"${as_root[@]}" rm -rf "$root/one_file_test"
echo "one file of $(stat -c %s "$program") bytes runs without anything else: $(rmse "$work/one_file.json")"
