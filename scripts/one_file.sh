#!/usr/bin/env bash
# Leaves the program as one file, build/release/one_file/loopstone: it needs no library of the
# machine that it is copied to. Safe to run again.
#
#     scripts/one_file.sh
set -euo pipefail
cd "$(dirname "$0")/.."

scripts/static_libraries.sh
CMAKE_ARGS="${CMAKE_ARGS:-} -DLOOPSTONE_STATIC_LIBRARIES=$PWD/build/static/installed" scripts/build.sh release loopstone_one_file
strip -o build/release/one_file/loopstone.new build/release/one_file/loopstone
mv build/release/one_file/loopstone.new build/release/one_file/loopstone
