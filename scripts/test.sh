#!/usr/bin/env bash
# Runs the tests of a preset that is built and ends with what was skipped, and why:
# scripts/test.sh PRESET [CTEST_ARGUMENT...]
set -euo pipefail
cd "$(dirname "$0")/.."

preset=$1
shift
export LOOPSTONE_SKIPPED_TESTS=$PWD/build/$preset/skipped_tests.tsv
rm -f "$LOOPSTONE_SKIPPED_TESTS"
status=0
ctest --preset "$preset" "$@" || status=$?
scripts/skipped_tests.py "$LOOPSTONE_SKIPPED_TESTS"
exit "$status"
