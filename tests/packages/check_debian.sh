#!/usr/bin/env bash
# Installs the Debian packages on a machine that has nothing (an empty root by debootstrap), and
# uses them there as their users would. Ends with 77, and says why, where that cannot be done.
#
#     tests/packages/check_debian.sh [FOLDER_WITH_DEBS]     build/release/packages
set -euo pipefail
cd "$(dirname "$0")/../.."

debs=$(cd "${1:-build/release/packages}" && pwd)
skip() {
  echo "skipped: $1"
  exit 77
}
[[ $(id -u) -eq 0 ]] || skip "an empty root needs root"
command -v debootstrap >/dev/null || skip "debootstrap is not installed"
version=$(sed -n 's/.*kVersion = "\([0-9.]*\)".*/\1/p' include/loopstone/version.hpp)
release=$(. /etc/os-release && echo "$VERSION_CODENAME")
program=$(echo "$debs"/loopstone_"$version"_*.deb)
library=$(echo "$debs"/libloopstone-dev_"$version"_*.deb)
[[ -f $program && -f $library ]] || { echo "no packages of $version in $debs"; exit 1; }

work=$(mktemp -d)
root=$work/root
cleanup() {
  ! mountpoint -q "$root/proc" || umount "$root/proc"
  rm -rf --one-file-system "$work"
}
trap cleanup EXIT
say() { printf '%s\n' "-- $*"; }

# What is in them.
say "$(basename "$program"), $(basename "$library")"
for deb in "$program" "$library"; do
  name=$(dpkg-deb -f "$deb" Package)
  dpkg-deb -x "$deb" "$work/$name"
  [[ -f $work/$name/usr/share/doc/$name/copyright ]] || { echo "$name has no copyright"; exit 1; }
  if grep -rIl "$PWD" "$work/$name"; then
    echo "$name names the build tree"
    exit 1
  fi
  [[ -z $(find "$work/$name" ! -user root -o -perm /022 ! -type l) ]] || { echo "$name may be written by others"; exit 1; }
done
for file in bin/loopstone share/man/man1/loopstone-map.1 share/bash-completion/completions/loopstone \
  share/zsh/vendor-completions/_loopstone share/doc/loopstone/loopstone.spdx.json share/fish/vendor_completions.d/loopstone.fish; do
  [[ -e $work/loopstone/usr/$file || -e $work/loopstone/usr/$file.gz ]] || { echo "loopstone lacks $file"; exit 1; }
done

# A machine that has nothing but this distribution's base, and the same sources of packages.
say "an empty root of $release"
mirror=$(find /etc/apt -name '*.list' -o -name '*.sources' | xargs -r sed -nE 's/^URIs: *([^ ]+).*/\1/p; s/^deb +(\[[^]]*\] +)?([^ ]+).*/\2/p' | sed -n 1p)
debootstrap --variant=minbase "$release" "$root" "$mirror" >"$work/debootstrap.log" 2>&1 || { tail -5 "$work/debootstrap.log"; exit 1; }
rm -f "$root/etc/apt/sources.list"
cp -r /etc/apt/sources.list* /etc/apt/apt.conf.d /etc/apt/trusted.gpg.d "$root/etc/apt/"
cp -r /usr/share/keyrings "$root/usr/share/"
cp /etc/resolv.conf /etc/hosts "$root/etc/"
mkdir -p "$root/debs"
cp "$program" "$root/debs/"
mount -t proc proc "$root/proc"
inside() { chroot "$root" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive "$@"; }

say "apt install ./$(basename "$program")"
inside apt-get update -q >"$work/apt.log" 2>&1
inside apt-get install -y -q --no-install-recommends "/debs/$(basename "$program")" >>"$work/apt.log" 2>&1 || { tail -20 "$work/apt.log"; exit 1; }

say "as a user without rights: simulate, map, evaluate"
inside useradd --create-home robot
as_user() { inside env HOME=/home/robot setpriv --reuid robot --regid robot --init-groups bash -euc "cd /home/robot && $1"; }
[[ $(as_user 'loopstone --version') == *"$version"* ]] || { echo "another version"; exit 1; }
as_user 'loopstone simulate office -o sim --seed 1 --duration 60 --quiet >/dev/null &&
  loopstone map sim -o out --quiet >/dev/null &&
  loopstone evaluate --estimate out/trajectory.tum --reference sim/truth.tum --require "ate_rmse_m<=0.05" >/dev/null'
as_user 'test -s out/map.pgm && test -s out/report.html && test -s out/map.png'
as_user 'source /usr/share/bash-completion/completions/loopstone; COMP_WORDS=(loopstone loc); COMP_CWORD=1; _loopstone; test "${COMPREPLY[0]}" = localize'

say "apt remove"
inside apt-get purge -y -q loopstone >>"$work/apt.log" 2>&1
left=$(find "$root/usr" -name '*loopstone*' | head -3)
[[ -z $left ]] || { echo "left behind: $left"; exit 1; }

# The library, by both ways to find it, with the compiler of this machine.
say "a program that links the library, by CMake and by pkg-config"
prefix=$work/libloopstone-dev/usr
cp -r tests/install/outside "$work/outside"
cmake -S "$work/outside" -B "$work/build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_PREFIX_PATH="$prefix" >"$work/cmake.log" 2>&1 &&
  cmake --build "$work/build" >>"$work/cmake.log" 2>&1 || { tail -20 "$work/cmake.log"; exit 1; }
"$work/build/outside" >"$work/by_cmake"
PKG_CONFIG_PATH=$(dirname "$(find "$prefix" -name loopstone.pc)")
export PKG_CONFIG_PATH
# shellcheck disable=SC2046  # lists of flags
c++ -std=c++20 -O1 $(pkg-config --cflags loopstone) "$work"/outside/*.cpp -o "$work/by_pkg_config_program" $(pkg-config --static --libs loopstone)
"$work/by_pkg_config_program" >"$work/by_pkg_config"
cmp "$work/by_cmake" "$work/by_pkg_config"
echo "packages are right"
