#!/usr/bin/env bash
# Makes the Debian packages of the release build, loopstone and libloopstone-dev, in
# build/release/packages. The same commit and compiler give the same bytes.
#
#     scripts/package.sh            builds, and packs what `cmake --install` would install
#     scripts/package.sh --install  and installs them on this machine
set -euo pipefail
cd "$(dirname "$0")/.."
source scripts/apt_packages.sh
umask 022  # folders of the packages have the rights that are usual here

install=
case ${1:-} in
  '') ;;
  --install) install=yes ;;
  *)
    sed -n '2,/^[^#]/s/^# \?//p' "$0"
    exit 2
    ;;
esac

command -v dpkg-shlibdeps >/dev/null || install_packages dpkg-dev
targets=(loopstone loopstone_program loopstone_pages)
if grep -qs '^LOOPSTONE_ROS2:BOOL=ON' build/release/CMakeCache.txt; then
  targets+=(loopstone_ros2_program)
fi
scripts/build.sh release "${targets[@]}"
# What is older than the commit was made of it.
SOURCE_DATE_EPOCH=${SOURCE_DATE_EPOCH:-$(git log -1 --format=%ct 2>/dev/null || echo 0)}
export SOURCE_DATE_EPOCH
python3 -B scripts/write_sbom.py build/release/bin/loopstone build/release/loopstone.spdx.json
folder=build/release/packages
rm -rf "$folder"
cpack --config build/release/CPackConfig.cmake >"build/release/cpack.log" 2>&1 || { cat build/release/cpack.log; exit 1; }
rm -rf "$folder/_CPack_Packages"
ls -l "$folder"/*.deb | awk '{ print $NF, $5, "bytes" }'
if [[ -n $install ]]; then
  install_packages "./$folder"/*.deb
fi
