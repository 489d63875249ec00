#!/usr/bin/env bash
# Builds what the last commit has twice, as two people would on machines with the same packages:
# in folders of other names, with another language, time zone, umask and number of jobs, without
# ccache. Library, program and Debian packages must be the same bytes.
#
#     tests/packages/check_reproducible.sh              all of it compiles twice: an hour on 2 cores
#     tests/packages/check_reproducible.sh --part grid  the library up to one part, which is quicker
set -euo pipefail
cd "$(dirname "$0")/../.."

part=
case ${1:-} in
  '') ;;
  --part) part=${2:?a part, as cmake/Parts.cmake lists them} ;;
  *)
    sed -n '2,/^[^#]/s/^# \?//p' "$0"
    exit 2
    ;;
esac

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
SOURCE_DATE_EPOCH=$(git log -1 --format=%ct)
export SOURCE_DATE_EPOCH
jobs=${JOBS:-$(nproc)}
flags="-DCMAKE_CXX_COMPILER_LAUNCHER= -DLOOPSTONE_TESTS=OFF -DLOOPSTONE_EXAMPLES=OFF"
if [[ -n $part ]]; then
  flags+=" -DLOOPSTONE_LAST_PART=$part"
fi

# build_in FOLDER UMASK JOBS [NAME=VALUE]...
build_in() {
  local folder=$1 mask=$2 number=$3 make=scripts/package.sh
  shift 3
  [[ -z $part ]] || make='scripts/build.sh release loopstone'
  mkdir -p "$folder" "$folder.home"
  # The two check out at other times and with other rights, too.
  (umask "$mask" && git archive HEAD | tar -x --touch --no-same-permissions -C "$folder")
  echo "-- $folder: umask $mask, $number jobs, $*"
  (cd "$folder" && umask "$mask" &&
    env HOME="$folder.home" JOBS="$number" CMAKE_ARGS="$flags" "$@" $make >"$folder.log" 2>&1) || { tail -20 "$folder.log"; exit 1; }
}
first=$work/first
second=$work/somewhere/else_and_deeper/second
build_in "$first" 022 "$jobs" LC_ALL=C TZ=UTC
build_in "$second" 077 $((jobs + 1)) LC_ALL=C.UTF-8 LANG=de_DE.UTF-8 TZ=Asia/Kathmandu

different=0
compare() {
  local name=$1 a b
  a=$(sha256sum <"$first/build/release/$name")
  b=$(sha256sum <"$second/build/release/$name")
  if [[ $a == "$b" ]]; then
    echo "same: ${a%% *} $name"
    return
  fi
  different=1
  echo "DIFFERENT: $name"
  # What is in it that differs.
  case $name in
    *.a) diff <(objects "$first/build/release/$name") <(objects "$second/build/release/$name") | sed -n 's/^> /   /p' ;;
    *.deb) diff <(dpkg-deb -c "$first/build/release/$name") <(dpkg-deb -c "$second/build/release/$name") | head -20 ;;
  esac
}
objects() {
  ar t "$1" | while read -r object; do echo "$object $(ar p "$1" "$object" | sha256sum)"; done
}
compare lib/libloopstone.a
if [[ -z $part ]]; then
  compare bin/loopstone
  while read -r deb; do
    compare "packages/$deb"
  done < <(cd "$first/build/release/packages" && ls)
fi
# Names of the folders would be a difference; where both are equally long they need not be seen.
if grep -qF "$first" "$first/build/release/lib/libloopstone.a"; then
  echo "the library names the folder that it was built in"
  different=1
fi
exit "$different"
