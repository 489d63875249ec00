#!/usr/bin/env bash
# Configures and builds one preset. scripts/build.sh PRESET [TARGET...]
# CMAKE_ARGS adds cache variables, such as CMAKE_ARGS=-DLOOPSTONE_WERROR=OFF; JOBS is the number of
# parallel jobs.
set -euo pipefail
cd "$(dirname "$0")/.."

preset=$1
shift
# shellcheck disable=SC2086  # CMAKE_ARGS is a list
cmake --preset "$preset" ${CMAKE_ARGS:-} >"/tmp/loopstone-configure.$$.log" 2>&1 || {
  cat "/tmp/loopstone-configure.$$.log"
  rm -f "/tmp/loopstone-configure.$$.log"
  exit 1
}
rm -f "/tmp/loopstone-configure.$$.log"
cmake --build --preset "$preset" --parallel "${JOBS:-$(nproc)}" ${1:+--target "$@"}
